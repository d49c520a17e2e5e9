//! `thurible scene check SCENE`: draws all of a scene before an hour is spent on it.

use crate::console::print;
use crate::destination::refuse_others;
use crate::exit::{DONE, Failure};
use crate::output::write_bytes;
use crate::preview::{cell_volume, findings, layers, sheet, shown};
use crate::progress::{Display, Mode};
use crate::report::number;
use crate::scene::Scene;
use clap::{Args, Subcommand};
use serde_json::json;
use std::path::PathBuf;

/// What a picture begins with.
const PNG: &[u8] = b"\x89PNG\r\n";

/// What is done with a scene without solving it.
#[derive(Debug, Subcommand)]
pub enum SceneCommand {
    /// Draw source, keyframes, solids, masks and emitters into one picture with their masses, and warn of what is probably not meant.
    Check(CheckArguments),
}

/// Arguments of `scene check`.
#[derive(Args, Debug)]
pub struct CheckArguments {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// The picture [default: the scene's name with .check.png, in this folder].
    #[arg(short, long, value_name = "PNG")]
    pub output: Option<PathBuf>,
    /// Override any key of the scene, as in --set time.steps=20.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Print JSON lines.
    #[arg(long)]
    pub json: bool,
}

/// Does it; the answer is the exit code.
pub fn run(command: &SceneCommand) -> Result<u8, Failure> {
    let SceneCommand::Check(arguments) = command;
    let scene = Scene::load_any(&arguments.scene, &arguments.set)?;
    let stem = arguments.scene.file_stem().unwrap_or_default().to_string_lossy();
    let path = arguments
        .output
        .clone()
        .unwrap_or_else(|| format!("{stem}.check.png").into());
    refuse_others(&path, PNG, "PNG")?;
    let mut notes = Vec::new();
    let drawn = layers(&scene, &mut notes)?;
    let canvas = scene.canvas();
    let png = sheet(&canvas, &drawn, &path)?;
    write_bytes(&path, &png)?;
    let display = Display::new(if arguments.json { Mode::Json } else { Mode::Human }, 0);
    if !arguments.json {
        print(&format!(
            "{}: {}",
            arguments.scene.display(),
            canvas.size_in_words()
        ));
    }
    let cell = cell_volume(&canvas);
    for layer in &drawn {
        let (mass, title) = (layer.sum() * cell, layer.title());
        display.event("layer", json!({ "key": layer.key, "title": title, "mass": mass }));
        if !arguments.json {
            print(&format!("{:>12}  {title}", number(mass)));
        }
    }
    for note in &notes {
        display.file_note(note);
    }
    for sentence in findings(&scene, &drawn) {
        display.warning(&sentence);
    }
    if scene.keyframes.is_empty() {
        display.note(
            "there is no keyframe: `thurible simulate` takes this scene, and `thurible solve` needs one",
        );
    }
    display.close();
    display.event("picture", json!({ "file": path.display().to_string() }));
    if !arguments.json {
        let (some, all) = (shown(&drawn).len(), drawn.len());
        let left_out = if some < all {
            format!("; of {all} layers {some}, all but some steps in the middle")
        } else {
            String::new()
        };
        print(&format!("drawn in {}{left_out}", path.display()));
    }
    Ok(DONE)
}
