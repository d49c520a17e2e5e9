//! One scene by several methods, one after the other in this process.

use super::figures::{Figures, ends};
use crate::console;
use crate::exit::{DONE, FILE, Failure, NOT_FINITE};
use crate::interrupt::Interrupt;
use crate::plan;
use crate::progress::{Clock, Mode};
use crate::report::RunRecord;
use crate::run::{Outcome, Request, RunOptions};
use crate::scene::{Document, Scene};
use serde_json::{Value, json};
use std::path::Path;

/// The same scene once for each method. Each is checked and planned here, so that nothing is refused after hours of solving.
pub(crate) fn scenes_by_method(
    document: &Document,
    methods: &[String],
    options: &RunOptions,
) -> Result<Vec<Scene>, Failure> {
    if let Some(twice) = methods
        .iter()
        .enumerate()
        .find(|(index, name)| methods[..*index].contains(name))
    {
        return Err(Failure::Input(format!(
            "--methods {}: \"{}\" is named twice; name each method once",
            methods.join(","),
            twice.1
        )));
    }
    let scene = |name: &String| {
        let mut document = document.clone();
        document.replace(format!("--methods {name}"), "method.name", name.as_str().into())?;
        let scene = Scene::of(document)?;
        plan::choose(&scene, &options.plan)?;
        Ok(scene)
    };
    methods.iter().map(scene).collect()
}

/// What the methods made of a scene.
#[derive(Default)]
pub(crate) struct Comparison {
    /// Methods with a result, in order.
    pub solved: Vec<Outcome>,
    /// Methods without a result, and the reason.
    pub failed: Vec<(String, String)>,
}

impl Comparison {
    /// Solves each scene into a folder below `folder` that has its method's name; stops when the user interrupts it.
    pub fn run(
        scenes: Vec<Scene>,
        methods: &[String],
        options: &RunOptions,
        folder: &Path,
        interrupt: &Interrupt,
    ) -> Result<Self, Failure> {
        let mut comparison = Self::default();
        for (scene, method) in scenes.into_iter().zip(methods) {
            if interrupt.asked() {
                break;
            }
            let request = Request {
                interrupt: Some(interrupt.clone()),
                ..Request::new(scene, folder.join(method), Clock::start())
            };
            match options.solve(request) {
                Ok(outcome) => comparison.solved.push(outcome),
                Err(Failure::NotFinite(why)) => {
                    if options.mode != Mode::Quiet {
                        console::error(&format!("thurible: {method}: {why}"));
                    }
                    comparison.failed.push((method.clone(), why));
                }
                Err(other) => return Err(other),
            }
        }
        Ok(comparison)
    }

    /// The records of the results.
    pub fn records(&self) -> impl Iterator<Item = &RunRecord> {
        self.solved.iter().map(|solved| &solved.record)
    }

    /// The rows of the table.
    pub fn figures(&self) -> Vec<Figures> {
        let ends = ends(self.records());
        self.records().map(|record| Figures::of(record, ends)).collect()
    }

    /// The comparison as JSON: the least objective, the rows of the table, and what failed.
    pub fn facts(&self) -> Value {
        let failed: Value = self
            .failed
            .iter()
            .map(|(method, why)| json!({ "method": method, "why": why }))
            .collect();
        json!({ "best": ends(self.records()).0, "rows": self.figures(), "failed": failed })
    }

    /// The exit code of a comparison that was not interrupted.
    pub fn exit_code(&self) -> u8 {
        if !self.failed.is_empty() {
            NOT_FINITE
        } else if self.solved.iter().any(|outcome| outcome.diverted) {
            FILE
        } else {
            DONE
        }
    }
}
