//! `thurible completions SHELL` and `thurible man DIR`: what shells and `man` are told of the commands.

use crate::console;
use crate::exit::{DONE, Failure};
use clap::{Args, Command};
use clap_complete::{Shell, generate};
use std::fs;
use std::path::PathBuf;

/// The name of the program.
const NAME: &str = "thurible";

/// Arguments of `completions`.
#[derive(Args, Debug)]
pub struct CompletionsArguments {
    /// The shell that they are for.
    pub shell: Shell,
}

/// Arguments of `man`.
#[derive(Args, Debug)]
pub struct ManArguments {
    /// The folder that the pages are written into, one for each command.
    pub folder: PathBuf,
}

/// Prints a script that completes commands and options of `program`; the answer is the exit code.
pub fn run(arguments: &CompletionsArguments, mut program: Command) -> Result<u8, Failure> {
    // Written to stdout by the library, a closed pipe would be a panic.
    let mut script = Vec::new();
    generate(arguments.shell, &mut program, NAME, &mut script);
    console::print(String::from_utf8_lossy(&script).trim_end());
    Ok(DONE)
}

/// Writes a manual page for `program` and for each of its commands; the answer is the exit code.
pub fn man(arguments: &ManArguments, program: Command) -> Result<u8, Failure> {
    let folder = &arguments.folder;
    let refused = |error: std::io::Error| {
        let shown = folder.display();
        Failure::File(format!(
            "cannot write manual pages to {shown}: {error}; choose another folder"
        ))
    };
    fs::create_dir_all(folder).map_err(refused)?;
    clap_mangen::generate_to(program, folder).map_err(refused)?;
    Ok(DONE)
}
