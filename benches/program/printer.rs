//! How results are printed: for people, for programs or not at all.

use crate::arguments::MeasureArguments;
use serde_json::Value;
use thurible::console;

/// How results are told.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Printer {
    quiet: bool,
    json: bool,
}

impl Printer {
    pub fn of(arguments: &MeasureArguments) -> Self {
        Self {
            quiet: arguments.quiet,
            json: arguments.json,
        }
    }

    /// A line for people alone.
    pub fn for_people(self, text: &str) {
        if !self.quiet && !self.json {
            console::print(text);
        }
    }

    /// A line for people, or the same for programs.
    pub fn say(self, text: &str, value: Value) {
        if self.json {
            console::print(&value.to_string());
        }
        self.for_people(text);
    }
}
