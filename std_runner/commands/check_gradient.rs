//! `thurible check-gradient SCENE`: Taylor's test of the gradient of a scene's simulation, or of its search by Stable Fluids.

use super::options::Options;
use crate::bytes::grouped;
use crate::console::print;
use crate::exit::{DONE, Failure, NOT_FINITE};
use crate::fluids;
use crate::gradient::{self, Kept, Table};
use crate::problem::Precision;
use crate::progress::{Display, Mode};
use crate::scene::{Document, Scene};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `check-gradient`.
#[derive(Args, Debug)]
#[command(mut_arg("precision", |arg| arg.help("Precision of all fields: f64 alone, since rounding errors of f32 drown differences")))]
pub struct CheckGradientArguments {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// The common options.
    #[command(flatten)]
    pub options: Options,
}

/// Checks the gradient; the answer is the exit code: 1 where it is wrong.
pub fn run(arguments: &CheckGradientArguments) -> Result<u8, Failure> {
    let options = &arguments.options;
    if options.resources.precision == Some(Precision::F32) {
        return Err(Failure::Input(
            "--precision f32 says nothing about a gradient: differences of so few digits drown; leave it out"
                .into(),
        ));
    }
    let mut document = Document::read(&arguments.scene)?;
    for assignment in &options.set {
        document.set(assignment)?;
    }
    let scene = if document.table().contains_key("keyframe") {
        Scene::of(document)?
    } else {
        Scene::free_of(document)?
    };
    let table = if scene.method.fluids.chosen {
        fluids::check_gradient(&scene, &options.plan())?
    } else {
        gradient::check(&scene, &options.plan())?
    };
    match options.mode() {
        Mode::Human => show(&table),
        Mode::Json => Display::new(Mode::Json, 0).event("gradient_check", table.fields()),
        Mode::Quiet => {}
    }
    Ok(if table.is_exact() { DONE } else { NOT_FINITE })
}

fn show(table: &Table) {
    print(&format!(
        "J = {:.6e}, its derivative along a random direction {:.6e}",
        table.value, table.slope
    ));
    for (name, part) in table.parts.iter().filter(|(_, part)| *part != 0.0) {
        print(&format!("  by {name:<24}{part:>14.6e}"));
    }
    let Kept {
        bytes,
        slots,
        repeated,
    } = table.kept;
    // No states are kept where everything is that the way back reads.
    let kept = match slots {
        0 => "all steps kept".into(),
        _ => format!("{slots} states kept, {repeated} steps repeated"),
    };
    print(&format!("memory: {} bytes, {kept}", grouped(bytes)));
    print("    step        J(t) - J       remainder   in parts of the derivative");
    for row in &table.rows {
        print(&format!(
            "{:>8.0e}  {:>14.6e}  {:>14.6e}   {:.2e}",
            row.step, row.change, row.remainder, row.relative
        ));
    }
    print(if table.is_exact() {
        "the gradient is exact: its remainder is of second order"
    } else {
        "the gradient is WRONG: its remainder is of first order at the smallest steps"
    });
}
