//! A file for a library that talks.

use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Seek, SeekFrom, Write};

/// A file whose first failure is its last: what comes after that goes nowhere, as if it were written. The library of archives tries once more
/// to end a file that it could not end, and prints what it thinks of a second failure.
pub(super) struct Quiet<'a> {
    file: &'a mut BufWriter<File>,
    failed: bool,
    /// Where the next byte goes, and where the last one ends.
    at: u64,
    end: u64,
}

impl<'a> Quiet<'a> {
    /// An empty one that has not failed.
    pub fn new(file: &'a mut BufWriter<File>) -> Self {
        Self {
            file,
            failed: false,
            at: 0,
            end: 0,
        }
    }

    fn seen<R>(&mut self, answer: io::Result<R>) -> io::Result<R> {
        let is_over = |error: &io::Error| error.kind() != ErrorKind::Interrupted;
        self.failed = answer.as_ref().is_err_and(is_over);
        answer
    }
}

impl Write for Quiet<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = if self.failed {
            bytes.len()
        } else {
            let written = self.file.write(bytes);
            self.seen(written)?
        };
        self.at += count as u64;
        self.end = self.end.max(self.at);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.failed {
            return Ok(());
        }
        let flushed = self.file.flush();
        self.seen(flushed)
    }
}

impl Seek for Quiet<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        // Asked where it is, a file that has failed is at its end: what is made of it later must not come before what was.
        self.at = if self.failed {
            self.end
        } else {
            let found = self.file.seek(to);
            self.seen(found)?
        };
        Ok(self.at)
    }
}
