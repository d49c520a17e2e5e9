//! The program `thurible-bench`; everything it does is in [`thurible_bench::run`].

use clap::Parser;
use std::process::ExitCode;
use thurible::console;
use thurible::exit::{DONE, INPUT};
use thurible_bench::arguments::Arguments;

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version are "errors" of clap that end with 0; a closed pipe is no reason to complain.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { INPUT } else { DONE });
        }
    };
    ExitCode::from(thurible_bench::run(&arguments).unwrap_or_else(|failure| {
        console::error(&format!("thurible-bench: {failure}"));
        failure.code()
    }))
}
