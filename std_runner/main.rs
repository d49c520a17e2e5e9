//! The program `thurible`; everything it does is in the library's [`thurible::program`].

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(thurible::program::main())
}
