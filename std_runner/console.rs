//! Printing that does not panic when the reader has closed the pipe, and that tells at the end what could not be printed.

use crate::exit::Failure;
use std::io::{self, ErrorKind, Write, stderr, stdout};
use std::path::Path;
use std::sync::OnceLock;

/// Why a line could not be printed, once one could not.
static LOST: OnceLock<String> = OnceLock::new();

/// Prints a line on stdout.
pub fn print(line: &str) {
    remember(writeln!(stdout(), "{line}"));
}

/// Prints a line on stderr.
pub fn error(line: &str) {
    let _ = writeln!(stderr(), "{line}");
}

/// A word of a command line, as a shell takes it.
pub(crate) fn quoted(text: &str) -> String {
    let plain = |letter: char| letter.is_ascii_alphanumeric() || "-_./=:,+".contains(letter);
    if !text.is_empty() && text.chars().all(plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

/// That of a path.
pub(crate) fn quoted_path(path: &Path) -> String {
    quoted(&path.to_string_lossy())
}

/// Remembers why something could not be printed on stdout.
pub(crate) fn remember(printed: io::Result<()>) {
    // A closed pipe (`| head`) is the reader's choice, not an error.
    if let Err(error) = printed
        && error.kind() != ErrorKind::BrokenPipe
    {
        let _ = LOST.set(error.to_string());
    }
}

/// Sees that all that was printed on stdout has arrived.
///
/// # Errors
/// It has not.
pub(crate) fn arrived() -> Result<(), Failure> {
    remember(stdout().flush());
    LOST.get().map_or(Ok(()), |error| {
        Err(Failure::File(format!(
            "what was printed is lost: {error}; print it where there is room"
        )))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_taken_whole_by_a_shell() {
        for (word, shown) in [
            ("out/a_1.toml", "out/a_1.toml"),
            ("two words", "'two words'"),
            ("o'er", r"'o'\''er'"),
            ("", "''"),
        ] {
            assert_eq!(quoted(word), shown);
        }
    }
}
