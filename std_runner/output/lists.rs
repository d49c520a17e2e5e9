//! Lists of different kinds in one archive.

use super::OutputError;
use super::npz::write_npz;
use std::path::Path;

/// An array of a result.
pub(crate) struct List<'a> {
    pub name: &'static str,
    pub shape: Vec<usize>,
    pub values: Values<'a>,
}

/// Its values.
pub(crate) enum Values<'a> {
    Reals(&'a [f64]),
    Whole(&'a [i64]),
    Flags(&'a [bool]),
}

/// Writes lists into the archive `path`.
pub(crate) fn write_lists(path: &Path, lists: &[List<'_>]) -> Result<(), OutputError> {
    write_npz(path, |npz| {
        lists.iter().try_for_each(|list| {
            let (kind, bytes) = list.values.encoded();
            npz.begin(list.name, kind, &list.shape)?;
            npz.put(|file| file.write_all(&bytes))
        })
    })
}

impl Values<'_> {
    /// Their type as NumPy names it, and their bytes.
    fn encoded(&self) -> (&'static str, Vec<u8>) {
        match self {
            Self::Reals(values) => (
                "<f8",
                values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            ),
            Self::Whole(values) => (
                "<i8",
                values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            ),
            Self::Flags(values) => ("|b1", values.iter().map(|&value| value.into()).collect()),
        }
    }
}
