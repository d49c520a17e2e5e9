//! The high-water mark of each phase of a solve, from the ledger.

use thurible_core::{Entry, Sharing};

/// A phase, and the bytes that are in use while it lasts.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Phase {
    /// Its name, after those of the phases that it is part of.
    pub name: String,
    /// Bytes of the buffers that live through the phase, its own included.
    pub bytes: usize,
}

/// The phases of a ledger whose top lines take `total` bytes. Each child of a line whose children live in turn is a phase, unless
/// it has such lines below itself. Buffers that are never shared count in every phase.
pub fn phases(entries: &[Entry], total: usize) -> Vec<Phase> {
    let mut found = Vec::new();
    for index in children(entries, 0, entries.first().map_or(0, |entry| entry.depth)) {
        visit(entries, index, total, "", &mut found);
    }
    if found.is_empty() {
        found.push(Phase {
            name: "all".into(),
            bytes: total,
        });
    }
    found
}

/// Lines of `depth` from `first` on, up to the first line above them.
fn children(entries: &[Entry], first: usize, depth: usize) -> impl Iterator<Item = usize> + '_ {
    entries
        .iter()
        .enumerate()
        .skip(first)
        .take_while(move |(_, entry)| entry.depth >= depth)
        .filter(move |(_, entry)| entry.depth == depth)
        .map(|(i, _)| i)
}

/// Adds the phases at and below line `index`, during which `total` bytes are in use; true if there are any.
fn visit(entries: &[Entry], index: usize, total: usize, path: &str, found: &mut Vec<Phase>) -> bool {
    let line = entries[index];
    let below = children(entries, index + 1, line.depth + 1);
    if line.sharing != Sharing::InTurn {
        return below.fold(false, |any, child| {
            visit(entries, child, total, path, found) | any
        });
    }
    for child in below {
        let (name, bytes) = (entries[child].name, total - line.bytes + entries[child].bytes);
        let name = if path.is_empty() {
            name.to_string()
        } else {
            format!("{path}: {name}")
        };
        if !visit(entries, child, bytes, &name, found) {
            found.push(Phase { name, bytes });
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(depth: usize, name: &'static str, bytes: usize, sharing: Sharing) -> Entry {
        Entry {
            name,
            bytes,
            depth,
            sharing,
        }
    }

    #[test]
    fn what_is_in_turn_counts_in_its_own_phase_alone() {
        use Sharing::{Buffer, InTurn, Together};
        let ledger = [
            line(0, "method", 170, Together),
            line(1, "always", 100, Buffer),
            line(1, "work", 70, InTurn),
            line(2, "search", 70, Together),
            line(3, "pairs", 40, Buffer),
            line(3, "evaluation", 30, InTurn),
            line(4, "forward", 30, Buffer),
            line(4, "back", 20, Buffer),
            line(2, "projection", 10, Buffer),
            line(0, "keyframes", 5, Buffer),
        ];
        let expected = [
            ("search: forward", 175),
            ("search: back", 165),
            ("projection", 115),
        ];
        let found = phases(&ledger, 175);
        assert_eq!(
            found,
            expected.map(|(name, bytes)| Phase {
                name: name.into(),
                bytes
            })
        );
        assert_eq!(
            phases(&ledger[9..], 5),
            [Phase {
                name: "all".into(),
                bytes: 5
            }]
        );
    }
}
