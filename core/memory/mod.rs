//! The one block of memory: the caller's bytes, the plan of every buffer in them, and parts of a buffer used in turn.

pub mod arena;
mod footprint;
pub mod layout;
pub mod ledger;
pub mod part;
pub mod pool;

pub use arena::{Arena, Plain, TooSmall};
pub use footprint::{ALIGN, footprint};
pub use layout::{Layout, Visit};
pub use ledger::{CHECK, Entry, Ledger, MAX_LINES, Sharing};
pub use part::{Held, Part, Parts, Share};
pub use pool::{Pool, measured, pooled};
