//! `thurible schema`: the JSON schema of a scene, for editors.

use crate::console::print;
use crate::destination::refuse_others;
use crate::exit::{DONE, Failure};
use crate::output::write_bytes;
use crate::scene::schema;
use clap::Args;
use std::path::{Path, PathBuf};

/// What a schema begins with.
const BEGIN: &[u8] = b"{\n  \"$schema\"";
/// The file that the first line of a new scene names.
const BESIDE: &str = "thurible.schema.json";

/// Arguments of `schema`.
#[derive(Args, Debug)]
pub struct SchemaArguments {
    /// The file to write [default: it is printed].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Prints or writes it; the answer is the exit code.
pub fn run(arguments: &SchemaArguments) -> Result<u8, Failure> {
    match &arguments.output {
        None => print(&text()),
        Some(path) => {
            refuse_others(path, BEGIN, "JSON schema")?;
            write(path)?;
        }
    }
    Ok(DONE)
}

/// Writes it beside `scene` and says where, unless a file that is no schema has its name.
pub(super) fn write_beside(scene: &Path) -> Result<Option<PathBuf>, Failure> {
    let path = scene.with_file_name(BESIDE);
    if refuse_others(&path, BEGIN, "JSON schema").is_err() {
        return Ok(None);
    }
    write(&path)?;
    Ok(Some(path))
}

fn text() -> String {
    format!("{:#}", schema())
}

fn write(path: &Path) -> Result<(), Failure> {
    Ok(write_bytes(path, (text() + "\n").as_bytes())?)
}
