//! `result.npz` and `report.json` of a reconstruction.

use super::frames::Frame;
use super::plan::Plan;
use super::views::Views;
use crate::distance::relative_l2;
use crate::output::{OutputError, Plain, write_arrays, write_bytes};
use crate::report;
use crate::run::command_line;
use serde_json::{Value, json};
use std::path::Path;
use thurible_core::{Named, Real};

/// What a run came to.
pub(super) struct Outcome<'a, T> {
    pub views: &'a Views,
    pub frames: Vec<Frame<T>>,
    pub interrupted: bool,
    pub plan: &'a Plan,
    /// Bytes that the block took.
    pub used: usize,
    pub seconds: f64,
}

/// What of the pictures may be left unexplained, in parts of their norm, before it is said.
const UNLIKELY: f64 = 0.5;

impl<T: Real> Outcome<'_, T> {
    /// How it ended, in a word.
    pub fn status(&self) -> &'static str {
        if self.interrupted {
            "cancelled"
        } else {
            "converged"
        }
    }

    /// The mean of the frames' errors, where the truth is known.
    pub fn rms_error(&self) -> Option<f64> {
        let errors: Vec<f64> = self.frames.iter().filter_map(|frame| frame.rms_error).collect();
        (!errors.is_empty()).then(|| errors.iter().sum::<f64>() / errors.len() as f64)
    }

    /// What is said beside its numbers: of the pictures, and of what came of them.
    fn remarks(&self) -> Vec<String> {
        let notes = self.views.notes.iter().cloned();
        notes.chain(self.doubts()).collect()
    }

    /// What is odd about its frames, of each in a sentence.
    pub fn doubts(&self) -> Vec<String> {
        let doubt = |(number, frame): (usize, &Frame<T>)| {
            let number = self.views.first + number;
            if frame.is_empty() {
                return Some(format!(
                    "frame {number} holds no smoke: there is no cell in which all cameras see some, or none that is worth what `tomography` charges; check where the \
                     cameras stand and look, and then `gamma`, `sigma`, `eps` and `budget`"
                ));
            }
            (frame.residual_relative > UNLIKELY).then(|| {
                format!(
                    "frame {number} leaves {:.0} % of its pictures unexplained: the cameras contradict each other, or had too few mutations; check where they stand and look, `scale`, `box.length`, \
                     which way their images go, and `budget`",
                    100.0 * frame.residual_relative
                )
            })
        };
        // The frame that an interrupt cut short says nothing of the cameras.
        let whole = self.frames.len().saturating_sub(usize::from(self.interrupted));
        self.frames
            .iter()
            .take(whole)
            .enumerate()
            .filter_map(doubt)
            .collect()
    }

    fn settings(&self) -> Value {
        let settings = self.views.settings;
        json!({
            "method": settings.method.name(),
            "prior": settings.prior.name(),
            "gamma": settings.gamma,
            "nonnegative": settings.nonnegative,
            "volume": settings.keeps_cells(),
            "sigma": settings.sigma,
            "length": settings.length,
            "budget": settings.budget,
            "eps": settings.eps,
            "accept": settings.accept,
            "tolerance": settings.tolerance,
            "walk": settings.rule.name(),
            "hull_threshold": settings.hull_threshold,
            "seed": settings.seed,
            "warm": settings.warm,
            "warm_budget": settings.warm_budget,
            "sweeps": settings.sweeps,
            "relax": settings.relax,
        })
    }

    /// RMS distance of novel view `number` from the pictures that were taken there, in parts of theirs.
    pub fn novel_error(&self, number: usize) -> Option<f64> {
        let view = self.views.novel.get(number)?;
        let mut pairs = Vec::new();
        for (index, frame) in self.frames.iter().enumerate() {
            let seen = self.views.compared(view, index)?;
            let shown = frame.novel.get(number)?;
            pairs.extend(shown.iter().zip(seen).map(|(shown, seen)| [shown.to_f64(), seen]));
        }
        let seen = pairs.iter().any(|[_, seen]| *seen != 0.0);
        seen.then(|| relative_l2(pairs))
    }

    fn novel(&self) -> Vec<Value> {
        let novel = self.views.novel.iter().enumerate();
        let said = novel.map(|(number, view)| {
            let mut fields = view.optics.fields();
            fields["name"] = view.name.clone().into();
            fields["pixels"] = view.pixels.to_vec().into();
            fields["relative_error"] = self.novel_error(number).into();
            fields
        });
        said.collect()
    }

    fn record(&self) -> Value {
        let views = self.views;
        let cameras = views.cameras.iter().map(|view| {
            let mut fields = view.optics.fields();
            fields["name"] = view.name.clone().into();
            fields["pixels"] = view.pixels.to_vec().into();
            fields
        });
        let ledger = self
            .plan
            .ledger
            .entries()
            .iter()
            .map(|entry| json!({ "name": entry.name, "bytes": entry.bytes, "depth": entry.depth }));
        let history = self.frames.iter().flat_map(|frame| frame.history.iter().cloned());
        let frames = self.frames.iter().enumerate().map(|(number, frame)| {
            json!({
                "frame": views.first + number, "complete": frame.complete,
                "residual_relative": frame.residual_relative, "rms_error": frame.rms_error,
            })
        });
        json!({
            "format": 1,
            "kind": "tomography",
            "cells": views.cells,
            "boundary": vec!["wall"; views.cells.len()],
            "length": views.length,
            "dt": views.dt,
            "steps": self.frames.len().saturating_sub(1),
            "keyframes": Vec::<Value>::new(),
            "precision": T::NAME,
            "threads": self.plan.threads,
            "version": env!("CARGO_PKG_VERSION"),
            "status": self.status(),
            "seconds": self.seconds,
            "memory": {
                "planned_bytes": self.plan.block(),
                "used_bytes": self.used,
                "lanes": self.plan.lanes,
                "result_bytes": self.plan.beside,
                "ledger": ledger.collect::<Vec<_>>(),
            },
            "scene": views.document.text(),
            "overrides": views.document.assignments().collect::<Vec<_>>(),
            "command": command_line(),
            "cameras": cameras.collect::<Vec<_>>(),
            "novel": self.novel(),
            "tomography": self.settings(),
            "frames": frames.collect::<Vec<_>>(),
            "rms_error": self.rms_error(),
            "remarks": self.remarks(),
            "history": history.collect::<Vec<_>>(),
        })
    }
}

/// The arrays of a result, each with its entries frame by frame.
fn arrays<'a, T: Real>(outcome: &'a Outcome<'_, T>) -> Vec<Plain<'a, T>> {
    let views = outcome.views;
    let array = |name: String, shape: &[usize], part: &dyn Fn(&'a Frame<T>) -> Option<&'a Vec<T>>| {
        let frames = outcome.frames.iter();
        Plain {
            name,
            shape: [&[outcome.frames.len()], shape].concat(),
            parts: frames
                .map(|frame| part(frame).map(Vec::as_slice).unwrap_or_default())
                .collect(),
        }
    };
    let size = |[width, height]: [usize; 2]| {
        if views.cells.len() == 2 {
            vec![width]
        } else {
            vec![height, width]
        }
    };
    let cells: Vec<usize> = views.cells.iter().rev().copied().collect();
    let mut arrays = Vec::new();
    if views.settings.keeps_cells() {
        arrays.push(array("density".into(), &cells, &|frame| Some(&frame.density)));
    }
    for (number, view) in views.cameras.iter().enumerate() {
        let name = format!("reprojection_{number}");
        arrays.push(array(name, &size(view.pixels), &|frame| {
            frame.reprojected.get(number)
        }));
    }
    for (number, view) in views.novel.iter().enumerate() {
        let name = format!("novel_{number}");
        arrays.push(array(name, &size(view.pixels), &|frame| frame.novel.get(number)));
    }
    arrays
}

/// Writes both files into `folder`.
pub(super) fn write<T: Real>(folder: &Path, outcome: &Outcome<'_, T>) -> Result<(), OutputError> {
    write_arrays(&folder.join(report::ARCHIVE), &arrays(outcome))?;
    let path = folder.join("report.json");
    let json = serde_json::to_vec_pretty(&outcome.record()).map_err(OutputError::of(&path))?;
    write_bytes(&path, &json)
}
