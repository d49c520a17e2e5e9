//! Printing that does not panic when the reader has closed the pipe.

use std::io::{Write, stderr, stdout};

/// Prints a line on stdout.
pub fn print(line: &str) {
    // A closed pipe (`| head`) is the reader's choice, not an error.
    let _ = writeln!(stdout(), "{line}");
}

/// Prints a line on stderr.
pub fn error(line: &str) {
    let _ = writeln!(stderr(), "{line}");
}
