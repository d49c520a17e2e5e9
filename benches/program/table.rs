//! A table that is printed line by line, and written as Markdown when it is complete.

use super::printer::Printer;
use serde::Serialize;
use serde_json::json;
use thurible::report;

/// Space between columns.
const GAP: usize = 2;

/// What a line of a table is made of.
pub(super) trait Line<const N: usize>: Serialize {
    /// Names of the columns.
    const HEAD: [&'static str; N];
    /// Characters of the first columns, which hold names.
    const WIDTHS: &'static [usize];
    /// What stands in them.
    fn texts(&self) -> [String; N];
}

/// The lines so far.
pub(super) struct Table<L, const N: usize> {
    printer: Printer,
    lines: Vec<L>,
}

impl<L: Line<N>, const N: usize> Table<L, N> {
    /// Prints the head.
    pub fn begin(printer: Printer) -> Self {
        printer.for_people(&Self::laid_out(&L::HEAD.map(String::from)));
        Self {
            printer,
            lines: Vec::new(),
        }
    }

    /// Prints a line and keeps it.
    pub fn add(&mut self, line: L) {
        self.printer
            .say(&Self::laid_out(&line.texts()), json!({ "row": line }));
        self.lines.push(line);
    }

    pub fn lines(&self) -> &[L] {
        &self.lines
    }

    /// Names stand left, figures right.
    fn laid_out(texts: &[String; N]) -> String {
        let cell = |(column, text): (usize, &String)| match L::WIDTHS.get(column) {
            Some(&width) => format!("{text:<width$}"),
            None => format!("{text:>width$}", width = L::HEAD[column].len().max(9) + GAP),
        };
        texts
            .iter()
            .enumerate()
            .map(cell)
            .collect::<String>()
            .trim_end()
            .to_owned()
    }

    pub fn markdown(&self) -> String {
        let rows = self.lines.iter().map(|line| line.texts().to_vec()).collect();
        report::Table {
            head: L::HEAD.to_vec(),
            names: L::WIDTHS.len(),
            ours: N,
            rows,
        }
        .markdown()
    }
}

/// A time in three digits or so.
pub(super) fn time(seconds: f64) -> String {
    match seconds {
        seconds if seconds < 0.0995 => format!("{:.2} ms", 1e3 * seconds),
        seconds if seconds < 9.95 => format!("{seconds:.2} s"),
        seconds => format!("{seconds:.0} s"),
    }
}
