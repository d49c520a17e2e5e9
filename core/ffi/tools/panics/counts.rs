//! Counts of places by file and by what is checked, and their table.

use crate::Failure;
use crate::parts::{PARTS, Part};
use std::collections::BTreeMap;

/// Distinct places, by file and by what is checked there.
pub struct Counts(pub BTreeMap<String, BTreeMap<&'static str, usize>>);

impl Counts {
    pub fn sum(&self) -> usize {
        self.0.values().flat_map(BTreeMap::values).sum()
    }

    /// The files of a part, each with its counts.
    fn of<'a>(
        &'a self,
        part: &'a Part,
    ) -> impl Iterator<Item = (&'a String, &'a BTreeMap<&'static str, usize>)> {
        self.0.iter().filter(|(file, _)| part.has(file))
    }
}

/// What is checked, with the sums of all parts; then each part with its reason and its files; then the sum.
pub fn table(counts: &Counts) -> Result<String, Failure> {
    if let Some(file) = counts
        .0
        .keys()
        .find(|file| !PARTS.iter().any(|part| part.has(file)))
    {
        return Err(
            format!("{file} may panic and is in no part of PARTS, which says why it does not").into(),
        );
    }
    let mut kinds = BTreeMap::new();
    counts
        .0
        .values()
        .flatten()
        .for_each(|(kind, count)| *kinds.entry(kind).or_insert(0) += count);
    let mut text: String = kinds
        .iter()
        .map(|(kind, count)| format!("{count:5}  {kind}: {}\n", meaning(kind)))
        .collect();
    for part in &PARTS {
        let sum: usize = counts.of(part).flat_map(|(_, kinds)| kinds.values()).sum();
        text += &format!("\n{sum:5}  {}: {}\n", part.name, part.holds);
        for (file, kinds) in counts.of(part) {
            let kinds: Vec<String> = kinds
                .iter()
                .map(|(kind, count)| format!("{kind} {count}"))
                .collect();
            text += &format!("         {file}: {}\n", kinds.join(", "));
        }
    }
    Ok(text + &format!("\n{:5}  places in all\n", counts.sum()))
}

/// Functions of the language that panic, by a part of their names, what calls them, and what is asked there.
const KINDS: [(&str, &str, &str); 10] = [
    (
        "slice_index_fail",
        "range",
        "a slice has the elements from here to there",
    ),
    (
        "panic_bounds_check",
        "index",
        "a slice has an element of this index",
    ),
    ("len_mismatch_fail", "copy", "two slices have the same length"),
    ("div_by_zero", "division", "a count is not 0"),
    ("rem_by_zero", "division", "a count is not 0"),
    ("assert_failed", "assertion", "what is asserted holds"),
    ("expect_failed", "value", "there is a value"),
    ("9panicking5panic", "assertion", "what is asserted holds"),
    (
        "9panicking",
        "split",
        "a slice is long enough to be split there, or chunks are not empty",
    ),
    ("", "unknown", "no call was found that belongs to it"),
];

fn meaning(kind: &str) -> &'static str {
    KINDS
        .iter()
        .find(|(_, name, _)| *name == kind)
        .map_or("", |(_, _, meaning)| meaning)
}

/// What is checked before a function of the language is called that panics.
pub fn kind(function: &str) -> Option<&'static str> {
    KINDS
        .iter()
        .find(|(part, ..)| !part.is_empty() && function.contains(part))
        .map(|(_, kind, _)| *kind)
}
