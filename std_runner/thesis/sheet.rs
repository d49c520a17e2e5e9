//! What is said of a figure: rows of ours beside the thesis', pictures and curves.

use super::bench::{Halt, Made};
use crate::quoted::NOT_GIVEN;
use crate::report::{Block, Table, bytes, number, seconds};
use serde_json::{Map, Value, json};

/// A row: what was run, what came of it, and what the thesis says of its own.
#[derive(Default)]
pub(crate) struct Row {
    name: String,
    size: String,
    ours: Vec<(&'static str, String, Value)>,
    thesis: Vec<(&'static str, &'static str)>,
    seconds: Option<f64>,
    bytes: Option<usize>,
    failed: Option<String>,
}

impl Row {
    /// A row of a run of `size`.
    pub fn new(name: impl Into<String>, size: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            size: size.into(),
            ..Self::default()
        }
    }

    /// With the seconds and the memory of a run.
    pub fn of(self, made: &Made) -> Self {
        Self {
            seconds: Some(made.seconds),
            bytes: made.bytes(),
            ..self
        }
    }

    /// With a figure of ours. One that is not there, or not finite, fails the row.
    pub fn with(self, column: &'static str, value: Option<f64>) -> Self {
        let finite = value.filter(|value| value.is_finite());
        let said = finite.map_or_else(|| NOT_GIVEN.to_owned(), number);
        let row = self.said(column, said, finite.into());
        if finite.is_none() {
            row.fail(format!("no finite {column}"))
        } else {
            row
        }
    }

    /// With a figure of ours in words.
    pub fn said(mut self, column: &'static str, words: String, value: Value) -> Self {
        self.ours.push((column, words, value));
        self
    }

    /// With a figure of the thesis.
    pub fn thesis(mut self, column: &'static str, words: &'static str) -> Self {
        self.thesis.push((column, words));
        self
    }

    /// Failed, for the first of several reasons.
    pub fn fail(mut self, why: String) -> Self {
        self.failed.get_or_insert(why);
        self
    }

    fn facts(&self) -> Value {
        let ours: Map<String, Value> = self
            .ours
            .iter()
            .map(|(column, _, value)| ((*column).to_owned(), value.clone()))
            .collect();
        let thesis: Map<String, Value> = self
            .thesis
            .iter()
            .map(|(column, words)| ((*column).to_owned(), (*words).into()))
            .collect();
        json!({ "name": self.name, "size": self.size, "ours": ours, "thesis": thesis, "seconds": self.seconds,
                "planned_bytes": self.bytes, "failed": self.failed })
    }

    fn ended(&self) -> String {
        let why = self.failed.as_ref();
        why.map_or_else(|| "done".into(), |why| format!("failed: {why}"))
    }
}

/// What is said of a figure so far.
#[derive(Default)]
pub(crate) struct Sheet {
    rows: Vec<Row>,
    /// Pictures, curves and words below the table.
    pub blocks: Vec<Block>,
}

impl Sheet {
    /// Adds the row of `name`, or one that says why it failed; other halts are handed on.
    pub fn row(&mut self, name: &str, row: Result<Row, Halt>) -> Result<(), Halt> {
        let row = match row {
            Ok(row) => row,
            Err(Halt::Failed(why)) => Row::new(name, "").fail(why),
            Err(other) => return Err(other),
        };
        self.rows.push(row);
        Ok(())
    }

    /// Adds a row that says why nothing more came of the figure.
    pub fn fail(&mut self, why: String) {
        self.rows.push(Row::new("the rest", "").fail(why));
    }

    /// How many rows there are, and how many of them failed.
    pub fn counts(&self) -> [usize; 2] {
        let failed = self.rows.iter().filter(|row| row.failed.is_some());
        [self.rows.len(), failed.count()]
    }

    /// Seconds of all rows, and the largest memory of any.
    pub fn spent(&self) -> (f64, usize) {
        let seconds = self.rows.iter().filter_map(|row| row.seconds).sum();
        let bytes = self.rows.iter().filter_map(|row| row.bytes).max();
        (seconds, bytes.unwrap_or_default())
    }

    /// The rows as JSON.
    pub fn facts(&self) -> Vec<Value> {
        self.rows.iter().map(Row::facts).collect()
    }

    /// The rows: names, what is ours, and what is the thesis'.
    pub fn table(&self) -> Table {
        let (ours, thesis) = (
            self.columns(|row| row.ours.iter().map(|(column, ..)| *column).collect()),
            self.columns(|row| row.thesis.iter().map(|(column, _)| *column).collect()),
        );
        let mut head = vec!["row", "size", "ended"];
        head.extend(&ours);
        head.extend(["seconds", "memory"]);
        let own = head.len();
        head.extend(&thesis);
        let cells = |row: &Row| {
            let mut cells = vec![row.name.clone(), row.size.clone(), row.ended()];
            let found = |column: &&str| row.ours.iter().find(|(name, ..)| name == column);
            let dash = || NOT_GIVEN.to_owned();
            cells.extend(
                ours.iter()
                    .map(|column| found(column).map_or_else(dash, |(_, words, _)| words.clone())),
            );
            cells.push(row.seconds.map_or_else(dash, seconds));
            cells.push(row.bytes.map_or_else(dash, bytes));
            let quoted = |column: &&str| row.thesis.iter().find(|(name, _)| name == column);
            cells.extend(
                thesis
                    .iter()
                    .map(|column| quoted(column).map_or_else(dash, |(_, words)| (*words).to_owned())),
            );
            cells
        };
        Table {
            rows: self.rows.iter().map(cells).collect(),
            names: 2,
            ours: own,
            head,
        }
    }

    /// Columns in the order in which rows name them.
    fn columns(&self, of: impl Fn(&Row) -> Vec<&'static str>) -> Vec<&'static str> {
        let mut all: Vec<&'static str> = Vec::new();
        for column in self.rows.iter().flat_map(of) {
            if !all.contains(&column) {
                all.push(column);
            }
        }
        all
    }
}
