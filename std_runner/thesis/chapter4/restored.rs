//! Photographs restored in several ways: a row and a picture each.

use super::super::bench::{Bench, Halt, Made, at};
use super::super::pictures::last;
use super::super::sheet::{Row, Sheet};
use super::shots::{Photograph, restored};
use crate::problem::Precision;
use crate::report::Block;
use std::rc::Rc;
use thurible_core::Named;
use thurible_core::deblur::{ImagePrior, Restorer, Tuning};

/// A way to restore, with its words and what the thesis says of it.
pub(super) struct Way {
    pub name: &'static str,
    pub tuning: Tuning,
    pub thesis: &'static [(&'static str, &'static str)],
}

/// The walk with a prior.
pub(super) fn walk(name: &'static str, prior: ImagePrior, gamma: f64) -> Way {
    Way {
        name,
        tuning: Tuning {
            prior,
            gamma,
            tau: 0.8,
            ..Tuning::default()
        },
        thesis: &[],
    }
}

/// What there was before the walk.
pub(super) fn richardson_lucy() -> Way {
    Way {
        name: "Richardson-Lucy, 30 iterations",
        tuning: Tuning {
            method: Restorer::RichardsonLucy,
            ..Tuning::default()
        },
        thesis: &[],
    }
}

impl Bench<'_> {
    /// Rows and pictures of a photograph, restored in each of the ways; `label` goes before their names.
    pub(super) fn restore(
        &mut self,
        sheet: &mut Sheet,
        (whose, label): (&str, &str),
        photograph: &Photograph,
        ways: &[Way],
    ) -> Result<(), Halt> {
        let precision = self.options.resources.precision.unwrap_or(Precision::F32);
        let mut shots = photograph.shots()?;
        for way in ways {
            let name = format!("{label}{}", way.name);
            let request = photograph.request(way.tuning, precision);
            let (method, prior) = (way.tuning.method.name(), way.tuning.prior.name());
            let made = self.deblur(&format!("{whose}/{method}_{prior}"), request);
            if let Ok(made) = &made {
                shots.push(restored(way.name, made)?);
            }
            sheet.row(&name, made.map(|made| row(&name, photograph, way, &made)))?;
        }
        sheet.blocks.push(Block::Pictures(shots));
        Ok(())
    }
}

/// PSNR, objective and acceptance of a restoration.
fn row(name: &str, photograph: &Photograph, way: &Way, made: &Rc<Made>) -> Row {
    let history = made.history();
    let mut row = Row::new(name, photograph.size())
        .with("PSNR before, dB", made.number("blurred_psnr"))
        .with("PSNR, dB", made.number("psnr"));
    if way.tuning.method == Restorer::Walk {
        row = row
            .with("objective", last(history, "objective"))
            .with("accepted, %", accepted(made));
    }
    let row = row.of(made);
    way.thesis
        .iter()
        .fold(row, |row, (column, words)| row.thesis(column, words))
}

/// How many of a hundred mutations were recorded.
pub(super) fn accepted(made: &Made) -> Option<f64> {
    let end = made.history().last()?;
    Some(100.0 * at(end, "accepted")? / at(end, "mutations")?)
}
