//! States of a solve on the disc, from which it goes on bit for bit.
//!
//! They are in a folder beside the result, `DIR.checkpoint`, the last two of them: `state.0` and `state.1`, each in one file that is written
//! under another name, synced and renamed. A file has blocks, each a count of bytes and the bytes: the [`Solve`] as JSON, what the
//! runner remembers as [`Words`]; then the core's saved state and the fields of windows follow as they are. Where ranks share a solve each writes its part
//! of the core's into a file of its own ([`PartFiles`]).

mod every;
mod inputs;
mod keeper;
mod needs;
mod open;
mod parts;
mod sealed;
mod solve;
mod words;

pub(crate) use every::{Every, parse};
pub(crate) use inputs::inputs_of;
pub(crate) use keeper::{Begin, Inputs, Keeper};
pub(crate) use needs::Needs;
pub(crate) use open::{Found, damaged, is_there, open, read, refuse_states, sums_of};
pub(crate) use parts::{PartFiles, Place, Saving};
pub(crate) use sealed::{Sealed, Unsealed};
pub(crate) use solve::{Cut, Earlier, Options, Solve, report_sum, unlike_ranks};
pub(crate) use words::Words;

use crate::destination::{place_of, shown};
use crate::held::LOCK;
use std::path::{Path, PathBuf};

/// The states of a folder: the later one takes the place of the one before the last.
const SLOTS: [&str; 2] = ["state.0", "state.1"];

/// What the name of a folder of states ends with.
const ENDING: &str = ".checkpoint";

/// Where a state grows.
const PART: &str = "state.part";

/// Whether a file of a folder of states is a state, or the lock of all: what is neither belongs to what grows.
pub(crate) fn is_state_or_lock(name: &str) -> bool {
    name.starts_with("state.") || name == LOCK
}

/// The folder of the states of a solve whose result goes to `folder`: beside where that leads, as the user reads it best.
fn beside(folder: &Path) -> PathBuf {
    let named = |folder: &Path| {
        let mut name = folder.file_name().unwrap_or("out".as_ref()).to_owned();
        name.push(ENDING);
        folder.with_file_name(name)
    };
    shown(&named(folder), &named(&place_of(folder)))
}

/// The result folder beside which the folder of states `place` lies, where its name says so.
fn result_of(place: &Path) -> Option<PathBuf> {
    let name = place.file_name()?.to_str()?.strip_suffix(ENDING)?;
    (!name.is_empty()).then(|| place.with_file_name(name))
}

/// Whether there is a state in a folder of states.
fn has_states(place: &Path) -> bool {
    SLOTS.iter().any(|slot| place.join(slot).is_file())
}
