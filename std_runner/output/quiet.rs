//! A file for a library that talks.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};

/// A file whose first failure is its last: what comes after that goes nowhere. The library of archives tries once more to end a file that it
/// could not end, and prints what it thinks of a second failure.
pub(super) struct Quiet<'a> {
    file: &'a mut BufWriter<File>,
    failed: bool,
}

impl<'a> Quiet<'a> {
    /// One that has not failed.
    pub fn new(file: &'a mut BufWriter<File>) -> Self {
        Self { file, failed: false }
    }

    /// What `call` says of the file, or `otherwise` where it has failed.
    fn unless_failed<R>(
        &mut self,
        otherwise: R,
        call: impl FnOnce(&mut BufWriter<File>) -> io::Result<R>,
    ) -> io::Result<R> {
        if self.failed {
            return Ok(otherwise);
        }
        let answer = call(self.file);
        self.failed = answer
            .as_ref()
            .is_err_and(|error| error.kind() != io::ErrorKind::Interrupted);
        answer
    }
}

impl Write for Quiet<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.unless_failed(bytes.len(), |file| file.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.unless_failed((), Write::flush)
    }
}

impl Seek for Quiet<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.unless_failed(0, |file| file.seek(to))
    }
}
