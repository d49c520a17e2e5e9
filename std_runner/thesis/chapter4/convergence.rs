//! Figure 4.8: how far the walk comes, beside the convex optimum.

use super::super::bench::{Bench, Halt, at};
use super::super::pictures::{chart, last};
use super::super::sheet::{Row, Sheet};
use super::images::shapes;
use super::shots::restored;
use crate::problem::Precision;
use crate::report::Block;
use serde_json::Value;
use thurible_core::Named;
use thurible_core::deblur::{ImagePrior, Restorer, Tuning};

/// Pixels along a side.
const SIDE: usize = 128;
/// Mutations a pixel.
const BUDGET: f64 = 300.0;

/// The objective of the walk, and of the primal-dual method, on the same data.
pub(super) fn figure_8(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let side = bench.cells(&[SIDE]).first().copied().unwrap_or(SIDE).max(32);
    let photograph = bench.blur("convergence", (side, 1), "motion:11,30".into(), (&shapes, 1.0))?;
    let precision = bench.options.resources.precision.unwrap_or(Precision::F64);
    let tuning = Tuning {
        prior: ImagePrior::Atv,
        gamma: 1e-3,
        ..Tuning::default()
    };
    let ways = [
        (
            "walk",
            "26.42",
            Tuning {
                budget: BUDGET,
                eps_min: 4e-9,
                ..tuning
            },
        ),
        (
            "primal-dual",
            "26.69",
            Tuning {
                method: Restorer::PrimalDual,
                iterations: 1000,
                ..tuning
            },
        ),
    ];
    let (mut shots, mut all) = (photograph.shots()?, Vec::new());
    for (name, thesis, tuning) in ways {
        let request = photograph.request(tuning, precision);
        let made = bench.deblur(&format!("convergence/{}", tuning.method.name()), request);
        if let Ok(made) = &made {
            shots.push(restored(name, made)?);
            all.push((name, made.clone()));
        }
        let row = made.map(|made| {
            let history = made.history();
            let row = Row::new(name, photograph.size())
                .with("objective", last(history, "objective"))
                .with("PSNR, dB", made.number("psnr"))
                .of(&made)
                .thesis("thesis: objective", thesis);
            match late(history, &tuning) {
                Some(change) => row
                    .with("change after 50 a pixel, %", Some(change))
                    .thesis("thesis: change, %", "0.08"),
                None => row,
            }
        });
        sheet.row(name, row)?;
    }
    sheet.blocks.push(Block::Pictures(shots));
    let runs: Vec<_> = all.iter().map(|(name, made)| (*name, made.history())).collect();
    let across = ("chains of as many mutations as pixels, or iterations", "chain");
    let note = "Data and prior. The walk's step falls to 4e-9.";
    sheet.blocks.push(Block::Charts(
        chart("Objective", note, across, "objective", &runs)
            .into_iter()
            .collect(),
    ));
    Ok(())
}

/// By how many percent the walk lowers the objective after 50 mutations a pixel.
fn late(history: &[Value], tuning: &Tuning) -> Option<f64> {
    let walks = tuning.method == Restorer::Walk;
    let then = history
        .iter()
        .find(|entry| at(entry, "chain").is_some_and(|chain| chain >= 50.0));
    let (then, end) = (at(then?, "objective")?, last(history, "objective")?);
    walks.then(|| 100.0 * (then - end) / end)
}
