//! `thurible schema`: the JSON schema of a scene, for editors.

use crate::console::print;
use crate::exit::{DONE, Failure};
use crate::output::write_bytes;
use crate::scene::schema;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `schema`.
#[derive(Args, Debug)]
pub struct SchemaArguments {
    /// The file to write [default: it is printed].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Prints or writes it; the answer is the exit code.
pub fn run(arguments: &SchemaArguments) -> Result<u8, Failure> {
    let text = format!("{:#}", schema());
    match &arguments.output {
        None => print(&text),
        Some(path) => write_bytes(path, format!("{text}\n").as_bytes())
            .map_err(|error| Failure::File(error.to_string()))?,
    }
    Ok(DONE)
}
