//! `thurible new NAME`: a commented scene to start from.

use crate::console;
use crate::exit::{DONE, Failure};
use clap::Args;
use std::ffi::OsStr;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The scene that `new` writes.
pub const TEMPLATE: &str = include_str!("template.toml");

/// Arguments of `new`.
#[derive(Args, Debug)]
pub struct NewArguments {
    /// Name of the scene; NAME.toml is written.
    pub name: PathBuf,
    /// Print nothing but errors.
    #[arg(long)]
    pub quiet: bool,
}

/// Writes the scene; the answer is the exit code.
pub fn run(arguments: &NewArguments) -> Result<u8, Failure> {
    let path = scene_path(&arguments.name)?;
    let shown = path.display();
    let name = path
        .file_stem()
        .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let text = TEMPLATE.replace(
        "\"out/NAME\"",
        &toml::Value::String(format!("out/{name}")).to_string(),
    );
    let written = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&path)
        .and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => Failure::File(format!(
            "{shown} is there already and is not overwritten; choose another name"
        )),
        _ => Failure::File(format!(
            "cannot write {shown}: {error}; choose a folder that exists and can be written"
        )),
    })?;
    if !arguments.quiet {
        console::print(&format!("wrote {shown}; solve it with: thurible solve {shown}"));
    }
    Ok(DONE)
}

/// `NAME.toml`, or `name` itself if it ends in `.toml`.
fn scene_path(name: &Path) -> Result<PathBuf, Failure> {
    let Some(file) = name.file_name() else {
        return Err(Failure::Input(format!(
            "\"{}\" is not a name for a scene; write a name such as my_scene",
            name.display()
        )));
    };
    if name.extension() == Some(OsStr::new("toml")) {
        return Ok(name.to_path_buf());
    }
    let mut file = file.to_os_string();
    file.push(".toml");
    Ok(name.with_file_name(file))
}
