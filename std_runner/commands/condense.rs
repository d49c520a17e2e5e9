//! `thurible condense PRESET|SCENE.toml`: an elastic body by coordinate condensation, Newton's method, and others.

use super::options::{Options, Overwriting, longer};
use crate::condense::{self, Request, document, presets};
use crate::console;
use crate::exit::{DONE, Failure};
use crate::plan::PlanOptions;
use crate::problem::Precision;
use clap::Args;
use std::path::{Path, PathBuf};
use toml::Value;

/// Arguments of `condense`.
#[derive(Args, Debug)]
#[command(mut_arg("precision", |arg| arg.help("Precision of all numbers [default: f64]")))]
pub struct CondenseArguments {
    /// A preset, or a scene file that ends in .toml. --list shows the presets.
    #[arg(value_name = "PRESET|SCENE.toml", required_unless_present = "list")]
    pub scene: Option<String>,
    /// Print the presets and what they are, and run nothing.
    #[arg(long)]
    pub list: bool,
    /// The methods, in the order in which they run: newton, plain, jgs2, jgs2_local, cc, projected, chord, warped.
    #[arg(long, value_name = "M,M", value_delimiter = ',')]
    pub methods: Option<Vec<String>>,
    /// The bases that methods with one are run with: fixed, rebuilt, corotated, corotated_rebuilt, adaptive, corotated_adaptive.
    #[arg(long, value_name = "B,B", value_delimiter = ',')]
    pub basis: Option<Vec<String>>,
    /// Keep a basis within so many edges.
    #[arg(long, value_name = "W")]
    pub radius: Option<u32>,
    /// The common options.
    #[command(flatten)]
    pub options: Options,
    /// What becomes of a page and results that are there.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Where the page and the result folders go [default: out/ with the name of the scene, and _condense after it].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Print the memory that it takes, to the byte, and do nothing.
    #[arg(long)]
    pub plan: bool,
}

/// Solves the scene and writes its page; the answer is the exit code.
pub fn run(arguments: &CondenseArguments) -> Result<u8, Failure> {
    let Some(scene) = arguments.scene.as_ref().filter(|_| !arguments.list) else {
        for preset in presets() {
            console::print(&format!("{:<15}{}", preset.name, preset.words()));
        }
        return Ok(DONE);
    };
    let resources = &arguments.options.resources;
    let request = Request {
        document: document(scene, &changes(arguments), &arguments.options.set)?,
        folder: arguments.output.clone().unwrap_or_else(|| folder_of(scene)),
        earlier: arguments.overwriting.earlier(),
        options: PlanOptions {
            precision: resources.precision.unwrap_or(Precision::F64),
            ..arguments.options.plan()
        },
        mode: resources.mode(),
    };
    if arguments.plan {
        condense::plan(&request)
    } else {
        condense::run(&request)
    }
}

/// The folder of a scene or preset by its name.
fn folder_of(scene: &str) -> PathBuf {
    let name = Path::new(scene).file_stem().unwrap_or_default();
    longer(&Path::new("out").join(name), "_condense")
}

/// What options change of the scene: the option, the key, the value.
fn changes(arguments: &CondenseArguments) -> Vec<(String, String, Value)> {
    let words =
        |words: &[String]| Value::Array(words.iter().map(|word| Value::String(word.clone())).collect());
    let mut changes = Vec::new();
    let mut list = |option: &str, key: &str, found: &Option<Vec<String>>| {
        if let Some(found) = found {
            changes.push((
                format!("--{option} {}", found.join(",")),
                format!("solver.{key}"),
                words(found),
            ));
        }
    };
    list("methods", "methods", &arguments.methods);
    list("basis", "basis", &arguments.basis);
    if let Some(radius) = arguments.radius {
        changes.push((
            format!("--radius {radius}"),
            "solver.radius".into(),
            Value::Integer(radius.into()),
        ));
    }
    changes
}
