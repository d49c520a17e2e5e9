//! From names on the command line to the scenes that are to be solved.

use super::Scale;
use super::catalogue::{ENTRIES, Entry, GROUPS, SHEETS, Sheet};
use crate::exit::Failure;
use crate::scene::Document;
use std::path::Path;
use toml::Value;

/// Iterations at most, unless an entry or `--set` says otherwise: the files of the examples are meant for a quick look.
const ITERATIONS: i64 = 60;

/// The sheets that `names` ask for, in the order of the page; Table 2 if there are none.
pub(super) fn sheets(names: &[String]) -> Result<Vec<&'static Sheet>, Failure> {
    let mut wanted = Vec::new();
    for name in names {
        match GROUPS.iter().find(|(group, _)| group == name) {
            Some((_, members)) => wanted.extend_from_slice(members),
            None => wanted.push(
                SHEETS
                    .iter()
                    .find(|sheet| sheet.name == name)
                    .ok_or_else(|| unknown(name))?
                    .name,
            ),
        }
    }
    if names.is_empty() {
        wanted.extend_from_slice(GROUPS[0].1);
    }
    Ok(SHEETS
        .iter()
        .filter(|sheet| wanted.contains(&sheet.name))
        .collect())
}

fn unknown(name: &str) -> Failure {
    let known: Vec<&str> = SHEETS
        .iter()
        .map(|sheet| sheet.name)
        .chain(GROUPS.iter().map(|(group, _)| *group))
        .collect();
    Failure::Input(format!(
        "the paper's list has no \"{name}\", only {}; name one of these, `thurible paper --list` says what they are",
        known.join(", ")
    ))
}

impl Sheet {
    /// Its entries.
    pub fn members(&self) -> impl Iterator<Item = &'static Entry> {
        self.entries
            .iter()
            .filter_map(|name| ENTRIES.iter().find(|entry| entry.name == *name))
    }

    /// The methods that all of its entries are about, if they are not about all.
    pub fn only(&self) -> &'static [&'static str] {
        self.members().next().map_or(&[], |entry| entry.only)
    }
}

impl Entry {
    /// Those of the methods asked for that it is about.
    pub fn methods(&self, asked: &[String]) -> Vec<String> {
        asked
            .iter()
            .filter(|name| self.only.is_empty() || self.only.contains(&name.as_str()))
            .cloned()
            .collect()
    }

    /// Its scene at `scale`, with `sets` from the command line. Its text is that of the whole scene, so that a report says all of it.
    pub fn document(&self, scale: Scale, sets: &[String]) -> Result<Document, Failure> {
        let path = Path::new(self.name);
        let mut document = Document::parse(path, self.text.to_owned())?;
        document.replace(self.name.into(), "method.iterations", ITERATIONS.into())?;
        document.replace(self.name.into(), "output.frames", false.into())?;
        for (key, value) in self.sets {
            document.set(&format!("{key}={value}"))?;
        }
        let cells = document
            .table()
            .get("grid")
            .and_then(|grid| grid.get("cells"))
            .and_then(Value::as_array)
            .map(Vec::as_slice)
            .unwrap_or_default();
        let cells: Vec<usize> = cells
            .iter()
            .filter_map(|count| usize::try_from(count.as_integer()?).ok())
            .collect();
        let cells = scale
            .cells(&cells)
            .into_iter()
            .filter_map(|count| i64::try_from(count).ok())
            .map(Value::from)
            .collect();
        document.replace(
            format!("--scale {}", scale.name()),
            "grid.cells",
            Value::Array(cells),
        )?;
        let text = toml::to_string(document.table()).map_err(|error| {
            Failure::Input(format!(
                "{}: cannot be written as TOML: {error}; this is a fault of thurible, please report it",
                self.name
            ))
        })?;
        let mut document = Document::parse(path, text)?;
        sets.iter().try_for_each(|assignment| document.set(assignment))?;
        Ok(document)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_there_and_unique() {
        for (index, entry) in ENTRIES.iter().enumerate() {
            assert!(
                !ENTRIES[..index].iter().any(|other| other.name == entry.name),
                "{} is there twice",
                entry.name
            );
            assert!(
                SHEETS.iter().any(|sheet| sheet.entries.contains(&entry.name)),
                "{} is in no sheet",
                entry.name
            );
        }
        for sheet in SHEETS {
            assert_eq!(
                sheet.members().count(),
                sheet.entries.len(),
                "an entry of {} is missing",
                sheet.name
            );
            assert!(
                sheet.members().all(|entry| entry.only == sheet.only()),
                "{} mixes methods",
                sheet.name
            );
        }
        for name in GROUPS.iter().flat_map(|(_, members)| members.iter()) {
            assert!(
                SHEETS.iter().any(|sheet| sheet.name == *name),
                "{name} is no sheet"
            );
        }
    }
}
