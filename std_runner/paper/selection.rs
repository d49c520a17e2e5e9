//! From names on the command line to the scenes that are to be solved.

use super::catalogue::{ENTRIES, Entry};
use super::sections::{GROUPS, SECTIONS, Section};
use crate::compare::{Lineup, listed, scenes_by_method};
use crate::exit::Failure;
use crate::quoted::{Names, Scale};
use crate::run::RunOptions;
use crate::scene::Document;
use std::path::{Path, PathBuf};
use thurible_core::{Method, Named};
use toml::{Table, Value};

/// Iterations at most, unless an entry or `--set` says otherwise: the files of the examples have what suits each for a look.
const ITERATIONS: i64 = 60;
/// The same of LBFGS, which in the paper takes up to 212.
const LBFGS_ITERATIONS: i64 = 500;
/// The paper's LBFGS ends where no density changes by more than this part of the largest between two iterations, as its ADMM does;
const STILL: f64 = 0.01;
/// so that what an iteration gains ends it only where that is next to nothing.
const LBFGS_TOLERANCE: f64 = 1e-12;

/// What the command line says of the scenes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Selection<'a> {
    /// Sections and groups of them; Table 2 if there are none.
    pub names: &'a [String],
    /// The methods, in the order in which they run.
    pub methods: &'a [String],
    /// The scale of the grids.
    pub scale: Scale,
    /// Assignments to keys of every scene.
    pub sets: &'a [String],
}

/// A scene that is going to be solved.
pub(crate) struct PlannedScene {
    /// Which scene of the catalogue it is.
    pub entry: &'static Entry,
    /// The methods that solve it.
    pub methods: Vec<String>,
    /// The checked scene, once for each method.
    pub lineup: Lineup,
    /// Where the results go.
    pub folder: PathBuf,
}

impl Selection<'_> {
    /// The sections that are named, in the order of the page.
    pub fn sections(&self) -> Result<Vec<&'static Section>, Failure> {
        let sections = sections(self.names)?;
        self.refuse_unfit(&sections).map(|()| sections)
    }

    /// A section that was named must have a method that it is about.
    fn refuse_unfit(&self, sections: &[&Section]) -> Result<(), Failure> {
        let unfit = |section: &&&Section| {
            self.names.iter().any(|name| name == section.name)
                && section
                    .members()
                    .all(|entry| entry.methods(self.methods).is_empty())
        };
        sections.iter().find(unfit).map_or(Ok(()), |section| {
            let only = section.only();
            Err(Failure::Input(format!(
                "--methods {}: {} is about {} alone; add it, as in --methods {}",
                self.methods.join(","),
                section.name,
                listed(only),
                only.join(",")
            )))
        })
    }

    /// Every scene of `sections` once, checked and planned with each of its methods, to be solved in folders below `folder`.
    pub fn scenes(
        &self,
        sections: &[&Section],
        folder: &Path,
        options: &RunOptions,
    ) -> Result<Vec<PlannedScene>, Failure> {
        let mut all: Vec<PlannedScene> = Vec::new();
        for entry in sections.iter().flat_map(|section| section.members()) {
            let methods = entry.methods(self.methods);
            if methods.is_empty() || all.iter().any(|other| other.entry.name == entry.name) {
                continue;
            }
            let lineup = self.by_method(entry, &methods, options)?;
            all.push(PlannedScene {
                entry,
                methods,
                lineup,
                folder: folder.join(entry.name),
            });
        }
        Ok(all)
    }

    /// The scene of `entry` once for each of `methods`.
    fn by_method(&self, entry: &Entry, methods: &[String], options: &RunOptions) -> Result<Lineup, Failure> {
        let document = |method: &str| entry.document(self.scale, self.sets, method);
        let mut lineup = scenes_by_method(document, methods, options)?;
        lineup.settled = Some((Method::Lbfgs, STILL));
        Ok(lineup)
    }
}

/// The sections that `names` ask for, in the order of the page; Table 2 if there are none.
fn sections(names: &[String]) -> Result<Vec<&'static Section>, Failure> {
    let chosen = known().chosen(names)?;
    let is_chosen = |section: &&Section| chosen.contains(&section.name);
    Ok(SECTIONS.iter().filter(is_chosen).collect())
}

/// The names of sections and groups.
pub(crate) fn known() -> Names {
    Names {
        command: "paper",
        parts: SECTIONS.iter().map(|section| section.name).collect(),
        groups: &GROUPS,
    }
}

impl Section {
    /// The scenes of the section.
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
    /// Those of the methods `asked` that it is about.
    pub fn methods(&self, asked: &[String]) -> Vec<String> {
        asked
            .iter()
            .filter(|name| self.only.is_empty() || self.only.contains(&name.as_str()))
            .cloned()
            .collect()
    }

    /// Its scene at `scale` for `method`, with `sets` from the command line. Its text is that of the whole scene, so that a report says all of it.
    pub fn document(&self, scale: Scale, sets: &[String], method: &str) -> Result<Document, Failure> {
        let path = Path::new(self.name);
        let mut document = Document::parse(path, self.text.to_owned())?;
        if method == Method::Lbfgs.name() {
            document.replace(self.name.into(), "method.iterations", LBFGS_ITERATIONS.into())?;
            document.replace(self.name.into(), "method.lbfgs.tolerance", LBFGS_TOLERANCE.into())?;
        } else {
            document.replace(self.name.into(), "method.iterations", ITERATIONS.into())?;
        }
        // All rows of a method are by the same choices, whatever suits an example.
        document.replace(self.name.into(), "method.direct", Value::Table(Table::new()))?;
        document.replace(self.name.into(), "output.frames", false.into())?;
        // The paper's transport, with which goes the paper's price of the force.
        document.replace(self.name.into(), "advection.scheme", "quick".into())?;
        for (key, value) in self.sets {
            document.set(&format!("{key}={value}"))?;
        }
        let cells = document
            .table()
            .get("grid")
            .and_then(|grid| grid.get("cells"))
            .and_then(Value::as_array)
            .map_or(&[][..], Vec::as_slice);
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
                SECTIONS
                    .iter()
                    .any(|section| section.entries.contains(&entry.name)),
                "{} is in no section",
                entry.name
            );
        }
        for section in SECTIONS {
            assert_eq!(
                section.members().count(),
                section.entries.len(),
                "an entry of {} is missing",
                section.name
            );
            assert!(
                section.members().all(|entry| entry.only == section.only()),
                "{} mixes methods",
                section.name
            );
        }
        for name in GROUPS.iter().flat_map(|(_, members)| members.iter()) {
            assert!(
                SECTIONS.iter().any(|section| section.name == *name),
                "{name} is no section"
            );
        }
    }
}
