//! `thurible compare SCENE`: the same scene by several methods, on one page.

use super::options::{MethodList, Options, Overwriting, longer};
use crate::compare::{self, Comparison, publish, scenes_by_method};
use crate::exit::Failure;
use crate::interrupt::Interrupt;
use crate::run::Outputs;
use crate::scene::{Document, Scene};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

/// The name of the page and of its facts.
const STEM: &str = "compare";

/// Arguments of `compare`.
#[derive(Args, Debug)]
pub struct CompareArguments {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// The methods that solve it.
    #[command(flatten)]
    pub methods: MethodList,
    /// The common options.
    #[command(flatten)]
    pub options: Options,
    /// What becomes of a page and results that are there.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Where the page and a result folder for each method go [default: `output.folder` of the scene with _compare after it].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Solves a scene by several methods and writes the page; the answer is the exit code.
pub fn run(arguments: &CompareArguments) -> Result<u8, Failure> {
    let methods = &arguments.methods.methods;
    let mut document = Document::read(&arguments.scene)?;
    for assignment in &arguments.options.set {
        document.set(assignment)?;
    }
    let scene = Scene::of(document.clone())?;
    let options = arguments.options.run(Outputs {
        arrays: true,
        images: scene.output.frames,
    });
    let lineup = scenes_by_method(|_| Ok(document.clone()), methods, &options)?;
    let folder = arguments
        .output
        .clone()
        .unwrap_or_else(|| longer(&scene.output.folder, "_compare"));
    let earlier = arguments.overwriting.earlier();
    let mut page = publish::prepare(&folder, STEM, earlier)?;
    publish::check_below(
        (&folder, earlier),
        methods,
        &lineup.scenes,
        options.outputs.images,
    )?;
    let interrupt = Interrupt::listen()?;
    let comparison = Comparison::run(lineup, methods, &options, &folder, &interrupt)?;
    let name = arguments
        .scene
        .file_stem()
        .map_or_else(|| "scene".into(), |stem| stem.to_string_lossy());
    let mut facts = comparison.facts();
    facts["format"] = json!(1);
    facts["scene"] = json!(name);
    publish::write(&mut page, STEM, &compare::page(&name, &comparison), &facts)?;
    publish::announce(options.mode, &page, STEM, &compare::summary(&comparison), facts);
    Ok(publish::code(&page, &interrupt, comparison.exit_code()))
}
