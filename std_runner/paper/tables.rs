//! The tables of the page: all figures of this run, and the same columns from this run and from the paper.

use super::catalogue::{Entry, QUOTED, QUOTED_FROM, QUOTED_OF_ADMM};
use super::verdict;
use crate::compare::{self, COLUMNS, Comparison, Figures};
use crate::quoted::{NOT_GIVEN, Scale};
use crate::report::{Table, product};
use thurible_core::{Method, Named};

/// A scene that has been solved.
pub(crate) struct SolvedScene {
    /// Which scene of the catalogue it is.
    pub entry: &'static Entry,
    /// What the methods made of it.
    pub comparison: Comparison,
}

/// A method of a scene, and its figures if it came to any.
struct Row {
    method: String,
    figures: Option<Figures>,
}

impl SolvedScene {
    /// A row for each method: those with a result, then those without.
    fn rows(&self) -> Vec<Row> {
        let solved = self.comparison.figures().into_iter().map(|figures| Row {
            method: figures.method.name().to_owned(),
            figures: Some(figures),
        });
        let failed = self.comparison.failed.iter().map(|lost| Row {
            method: lost.method.clone(),
            figures: None,
        });
        solved.chain(failed).collect()
    }

    /// Scene and size, in its first row alone.
    fn names(&self, index: usize) -> [String; 2] {
        if index == 0 {
            [self.entry.about.to_owned(), size(&self.comparison)]
        } else {
            Default::default()
        }
    }
}

/// One row a scene and method.
pub(crate) fn table(solved: &[SolvedScene]) -> Table {
    let mut head = vec!["scene", "size", "method"];
    head.extend(COLUMNS);
    let rows = solved.iter().flat_map(|scene| {
        let rows = scene.rows().into_iter().enumerate();
        rows.map(|(index, Row { method, figures })| {
            let mut row = scene.names(index).to_vec();
            row.push(method);
            row.push(verdict::ended(scene.entry, figures.as_ref()));
            match figures {
                // Beside how it ended, which is said.
                Some(figures) => row.extend(compare::cells(&figures).into_iter().skip(1)),
                None => row.extend(COLUMNS.iter().skip(1).map(|_| NOT_GIVEN.to_owned())),
            }
            row
        })
    });
    Table {
        rows: rows.collect(),
        names: 3,
        ours: head.len(),
        head,
    }
}

/// Columns of [`beside`] after the names, of this run.
const BRIEF: [&str; 6] = [
    "ended",
    "iterations",
    "s per AO",
    "s per NSO",
    "s in all",
    "memory",
];

/// The same columns from this run and from the paper.
pub(super) fn beside(solved: &[&SolvedScene]) -> Table {
    let mut head = vec!["scene", "size", "method"];
    head.extend(BRIEF);
    let ours = head.len();
    head.extend(QUOTED);
    let rows = solved.iter().flat_map(|scene| {
        let rows = scene.rows();
        let quoted: Vec<_> = (0..rows.len())
            .map(|index| quoted(scene.entry, &rows, index))
            .collect();
        let rows = rows.into_iter().zip(quoted).enumerate();
        rows.map(|(index, (Row { method, figures }, quoted))| {
            let mut row = scene.names(index).to_vec();
            row.push(method);
            row.push(verdict::ended(scene.entry, figures.as_ref()));
            match figures {
                Some(figures) => row.extend(compare::in_brief(&figures)),
                None => row.extend(BRIEF.iter().skip(1).map(|_| NOT_GIVEN.to_owned())),
            }
            row.extend(quoted);
            row
        })
    });
    Table {
        rows: rows.collect(),
        names: 3,
        ours,
        head,
    }
}

fn size(comparison: &Comparison) -> String {
    comparison
        .records()
        .next()
        .map(|record| format!("{}, {} steps", product(&record.cells), record.steps))
        .unwrap_or_default()
}

/// The paper's figures in row `index`: those of a method in its own row, or in the first where it has none.
fn quoted(entry: &Entry, rows: &[Row], index: usize) -> [String; QUOTED.len()] {
    let stands_here = |method: Method| {
        let own = rows.iter().position(|row| row.method == method.name());
        own.unwrap_or(0) == index
    };
    let here = [Method::Admm, Method::Lbfgs].map(stands_here);
    let cells = entry.quoted.map_or([NOT_GIVEN; QUOTED.len()], |row| row.cells());
    let mut cells = cells.into_iter().enumerate();
    core::array::from_fn(|_| match cells.next() {
        Some((column, cell)) if here[usize::from(column >= QUOTED_OF_ADMM)] => cell.to_owned(),
        _ => String::new(),
    })
}

pub(super) fn quoted_from(scale: Scale) -> String {
    if scale.name() == "1" {
        QUOTED_FROM.into()
    } else {
        format!(
            "{QUOTED_FROM} The paper's figures are for the full size, not for the {} of this run.",
            scale.name()
        )
    }
}
