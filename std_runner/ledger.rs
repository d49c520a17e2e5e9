//! What all plans say: their buffers line by line, and why one does not fit.

use crate::bytes::{grouped, rounded};
use crate::console::print;
use crate::exit::Failure;
use crate::region::MARGIN;
use serde_json::{Value, json};
use std::path::Path;
use thurible_core::Entry;

/// A buffer: its name, its bytes, how deep it lies in groups.
pub(crate) type Line<'a> = (&'a str, usize, usize);

/// The line of an entry.
pub(crate) fn line(entry: &Entry) -> Line<'_> {
    (entry.name, entry.bytes, entry.depth)
}

/// Prints the lines, and the bytes of all of them with what `more` says of them.
pub(crate) fn print_ledger<'a>(lines: impl Iterator<Item = Line<'a>>, sum: usize, more: &str) {
    print(&format!("\n{:>18}  buffer", "bytes"));
    for (name, bytes, depth) in lines {
        print(&format!(
            "{:>18}  {:indent$}{name}",
            grouped(bytes),
            "",
            indent = 2 * depth
        ));
    }
    print(&format!("{:>18}  in all ({}){more}", grouped(sum), rounded(sum)));
}

/// Prints the least ceiling under which a block of so many bytes is planned.
pub(crate) fn print_least(block: usize) {
    print(&format!(
        "{:>18}  the least --memory-limit, with what holds the block",
        grouped(block.saturating_add(MARGIN))
    ));
}

/// The line of JSON that says what is planned: the buffers, the bytes of all of them, and what `more` says.
pub(crate) fn plan_event(entries: &[Entry], bytes: usize, mut more: Value) {
    let lines = entries
        .iter()
        .map(|entry| json!({ "name": entry.name, "bytes": entry.bytes }));
    more["planned_bytes"] = bytes.into();
    more["ledger"] = lines.collect();
    more["event"] = "plan".into();
    print(&more.to_string());
}

/// Refuses what needs more bytes than there may be, in a sentence that says how else: by more of them, or in one of `ways`. `given`: by the command line.
pub(crate) fn over(
    scene: &Path,
    what: &str,
    (needed, limit): (usize, usize),
    given: bool,
    ways: &[String],
) -> Failure {
    let whose = if given {
        "--memory-limit allows"
    } else {
        "this machine has"
    };
    let ways: String = ways.iter().map(|way| format!(", or {way}")).collect();
    Failure::Memory(format!(
        "{}: {what} {} bytes ({}), but {whose} {} bytes ({}); raise --memory-limit to {} bytes{ways}",
        scene.display(),
        grouped(needed),
        rounded(needed),
        grouped(limit),
        rounded(limit),
        grouped(needed)
    ))
}
