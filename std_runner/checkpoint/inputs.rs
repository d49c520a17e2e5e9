//! The files that a scene names: what they are when a state is kept, and whether they still are.

use crate::exit::Failure;
use crate::scene::{Document, files_of};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use thurible_core::checkpoint::Mix;
use toml::Value;

/// Bytes that are mixed together.
const PIECE: usize = 1 << 16;

/// A file, by which it is known again.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Input {
    /// Where it is, absolute.
    path: PathBuf,
    bytes: u64,
    digest: u64,
}

impl Input {
    /// The file at `path` as it is now.
    fn now(path: &Path) -> io::Result<Self> {
        let (mut file, mut piece, mut sum, mut bytes) = (File::open(path)?, vec![0; PIECE], Mix::new(), 0);
        loop {
            let mut filled = 0;
            while filled < PIECE {
                match file.read(piece.get_mut(filled..).unwrap_or(&mut []))? {
                    0 => break,
                    count => filled += count,
                }
            }
            bytes += filled as u64;
            sum.bytes(piece.get(..filled).unwrap_or(&[]));
            if filled < PIECE {
                break;
            }
        }
        Ok(Self {
            path: std::path::absolute(path)?,
            bytes,
            digest: sum.finish(),
        })
    }

    /// Refuses a file that is not what it was.
    pub fn check(&self) -> Result<(), Failure> {
        let shown = self.path.display();
        let remedy = "put it back as it was, or solve anew";
        match Self::now(&self.path) {
            Ok(now) if now == *self => Ok(()),
            Ok(_) => Err(Failure::Input(format!(
                "{shown} was changed since the solve began, which read it; {remedy}"
            ))),
            Err(error) => Err(Failure::File(format!(
                "cannot read {shown}, which the solve began with: {error}; {remedy}"
            ))),
        }
    }
}

/// The files that the scene of `document` names, and `others`, as they are now.
pub(crate) fn inputs_of(document: &Document, others: &[PathBuf]) -> io::Result<Vec<Input>> {
    let mut paths: BTreeSet<PathBuf> = others.iter().cloned().collect();
    for (section, value) in document.table() {
        // Where a result goes is no input.
        if section != "output" {
            gather(document, section, value, &mut paths);
        }
    }
    paths.iter().map(|path| Input::now(path)).collect()
}

/// Every text below `value` that is the name of a file, or a pattern that some fit. So keys that name files need no list of their own.
fn gather(document: &Document, key: &str, value: &Value, paths: &mut BTreeSet<PathBuf>) {
    match value {
        Value::String(text) if text.contains('*') => {
            paths.extend(files_of(document, key, text).unwrap_or_default());
        }
        Value::String(text) if !text.is_empty() => {
            let path = document.folder().join(text);
            if path.is_file() {
                paths.insert(path);
            }
        }
        Value::Array(values) => values
            .iter()
            .for_each(|value| gather(document, key, value, paths)),
        Value::Table(table) => table
            .iter()
            .for_each(|(_, value)| gather(document, key, value, paths)),
        _ => {}
    }
}
