//! The program: reads the command line, runs the command, says in one sentence what went wrong.

use crate::cli::{Cli, Command};
use crate::commands::{
    check_gradient, compare, completions, condense, deblur, devices, export, guide, new, paper, photograph,
    plan, readvect, remap, render, resume, scene, schema, simulate, solve, sweep, thesis, tomography, track,
    upsample,
};
use crate::console;
use crate::exit::{DONE, Failure, INPUT};
use crate::interrupt::let_long_files_fail;
use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Command as Parsed, CommandFactory, FromArgMatches};
use core::time::Duration;
use std::thread;
use thurible_core::exec::Ranks;

/// How long a rank lets the first one speak.
const HEARD: Duration = Duration::from_secs(3);

/// Runs the program and returns its exit code; errors are one sentence on stderr.
pub fn main() -> u8 {
    let_long_files_fail();
    let cli = match given() {
        Ok(cli) => cli,
        Err(error) => {
            return helped(&error).unwrap_or_else(|failure| refused(&failure));
        }
    };
    run(&cli).unwrap_or_else(|failure| refused(&failure))
}

/// What the command line asks for.
fn given() -> Result<Cli, clap::Error> {
    let mut command = with_negative_numbers(Cli::command());
    let matches = command.try_get_matches_from_mut(std::env::args_os())?;
    let mut cli = Cli::from_arg_matches(&matches).map_err(|error| error.format(&mut command))?;
    if let (Command::Deblur(arguments), Some((name, of))) = (&mut cli.command, matches.subcommand()) {
        arguments.chosen = chosen(command.find_subcommand(name), of);
    }
    Ok(cli)
}

/// The long names of the options of `command` that are written on the command line.
fn chosen(command: Option<&Parsed>, matches: &ArgMatches) -> Vec<String> {
    let written = |arg: &&Arg| matches.value_source(arg.get_id().as_str()) == Some(ValueSource::CommandLine);
    let options = command
        .into_iter()
        .flat_map(Parsed::get_arguments)
        .filter(written);
    options
        .filter_map(|arg| arg.get_long().map(str::to_owned))
        .collect()
}

/// A number below 0 behind an option is its value, and refused as that where it is not allowed.
fn with_negative_numbers(command: Parsed) -> Parsed {
    let taken = |arg: Arg| match arg.get_action().takes_values() {
        true => arg.allow_negative_numbers(true),
        false => arg,
    };
    command.mut_args(taken).mut_subcommands(with_negative_numbers)
}

/// Says why a command could not do what it was asked; the exit code.
fn refused(failure: &Failure) -> u8 {
    console::error(&format!("thurible: {failure}"));
    failure.code()
}

/// Prints what clap says instead of a command: help and version too, with which the program ends well.
fn helped(error: &clap::Error) -> Result<u8, Failure> {
    let printed = error.print();
    if error.use_stderr() {
        return Ok(INPUT);
    }
    console::remember(printed);
    console::arrived().map(|()| DONE)
}

/// As [`main`], for one of several programs that share a scene, of which the first one speaks. The answer is the exit code, or one by which all
/// of them are to be ended, since one could not do its part.
///
/// # Errors
/// That exit code.
pub fn main_shared(ranks: &'static dyn Ranks) -> Result<u8, u8> {
    if ranks.count() == 1 {
        return Ok(main());
    }
    let_long_files_fail();
    let first = ranks.rank() == 0;
    let cli = match given() {
        Ok(cli) => cli,
        Err(error) => {
            let of_all = if error.use_stderr() { INPUT } else { DONE };
            return if first {
                helped(&error).map_err(|failure| refused(&failure))
            } else {
                Ok(of_all)
            };
        }
    };
    share(cli, ranks).map_err(|failure| {
        if first {
            return refused(&failure);
        }
        // What the first one refuses too, it says.
        thread::sleep(HEARD);
        console::error(&format!("thurible: rank {}: {failure}", ranks.rank()));
        failure.code()
    })
}

fn share(mut cli: Cli, ranks: &'static dyn Ranks) -> Result<u8, Failure> {
    match &mut cli.command {
        Command::Solve(arguments) => arguments.common.options.resources.running.ranks = Some(ranks),
        Command::Simulate(arguments) => arguments.options.resources.running.ranks = Some(ranks),
        Command::Resume(arguments) => arguments.running.ranks = Some(ranks),
        Command::Export(arguments) => arguments.ranks = Some(ranks),
        _ => {
            return Err(Failure::Input(
                "ranks share `simulate`, `solve`, `resume` and `export` alone yet; run the other commands by `thurible`, or by one rank"
                    .into(),
            ));
        }
    }
    run(&cli)
}

/// Runs a command; its exit code, if what it printed has arrived.
fn run(cli: &Cli) -> Result<u8, Failure> {
    let code = command(cli)?;
    if code == DONE {
        console::arrived()?;
    }
    Ok(code)
}

fn command(cli: &Cli) -> Result<u8, Failure> {
    match &cli.command {
        Command::Solve(arguments) => solve::run(arguments),
        Command::Resume(arguments) => resume::run(arguments),
        Command::Simulate(arguments) => simulate::run(arguments),
        Command::Guide(arguments) => guide::run(arguments),
        Command::Readvect(arguments) => readvect::run(arguments),
        Command::Upsample(arguments) => upsample::run(arguments),
        Command::Remap(arguments) => remap::run(arguments),
        Command::Track(arguments) => track::run(arguments),
        Command::Plan(arguments) => plan::run(arguments),
        Command::Devices(arguments) => devices::run(arguments),
        Command::CheckGradient(arguments) => check_gradient::run(arguments),
        Command::Scene(command) => scene::run(command),
        Command::Compare(arguments) => compare::run(arguments),
        Command::Sweep(arguments) => sweep::run(arguments),
        Command::Paper(arguments) => paper::run(arguments),
        Command::Thesis(arguments) => thesis::run(arguments),
        Command::Export(arguments) => export::run(arguments),
        Command::Render(arguments) => render::run(arguments),
        Command::Tomography(arguments) => tomography::run(arguments),
        Command::Photograph(arguments) => photograph::run(arguments),
        Command::Deblur(arguments) => deblur::run(arguments),
        Command::Condense(arguments) => condense::run(arguments),
        Command::Schema(arguments) => schema::run(arguments),
        Command::New(arguments) => new::run(arguments),
        Command::Completions(arguments) => completions::run(arguments, Cli::command()),
        Command::Man(arguments) => completions::man(arguments, Cli::command()),
    }
}
