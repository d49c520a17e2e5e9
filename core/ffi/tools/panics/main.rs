//! Counts the places where a program linked with the library may panic, and holds the count against a committed one.
//!
//! `panics PROGRAM COMMITTED [--write]`. PROGRAM is an ELF file for a 64-bit little-endian machine, linked statically with the
//! library built with `host_panic`, so that every call that panics carries its place in the source: file, line and column, as
//! `core::panic::Location` lies in memory. Distinct places are counted, file by file; copies of a function for other precisions,
//! dimensions and instruction sets count once. The function that a place calls, which `objdump` shows,
//! says what is checked there; `parts` says for each part of the source why the checks hold, and a file in none of them is refused.
//! COMMITTED is all that as a table: the sum of its counts may only fall.

mod counts;
mod parts;
mod places;

use counts::table;
use places::count;
use std::process::ExitCode;

type Failure = Box<dyn core::error::Error>;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let done = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [program, committed] => compare(program, committed),
        [program, committed, "--write"] => {
            count(program).and_then(|counts| Ok(std::fs::write(committed, table(&counts)?)?))
        }
        _ => Err("usage: panics PROGRAM COMMITTED [--write]".into()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("panics: {error}");
            ExitCode::FAILURE
        }
    }
}

fn compare(program: &str, committed: &str) -> Result<(), Failure> {
    let found = count(program)?;
    let now = table(&found)?;
    let text = std::fs::read_to_string(committed)?;
    let last = text
        .lines()
        .last()
        .and_then(|line| line.split_whitespace().next())
        .ok_or("the committed file is empty")?;
    let before = last.parse::<usize>()?;
    println!(
        "{} places where the library may panic; committed: {before}",
        found.sum()
    );
    if found.sum() > before {
        print!("{now}");
        return Err(format!("{} more than committed", found.sum() - before).into());
    }
    if now != text {
        println!("{committed} is not current: run this with --write and commit it");
    }
    Ok(())
}
