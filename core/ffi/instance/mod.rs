//! Handles, and the instance in its memory.
//!
//! The caller's block holds the place of a handle first, with its header, and behind it a block of its own. The header points
//! into that block, so it must not be moved; its mark holds its address, and a copy elsewhere is not taken for an instance.

mod any;
pub mod asked;
mod body;
mod enter;
mod handle;
mod keep;
mod make;
mod plan;
mod progress;
mod refusal;
mod saved;

pub use any::Any;
pub use body::{AnySolver, Body, Sizes, Thurible};
pub use enter::{close, enter, message};
pub use handle::{ALIGN, Handle, with_place};
pub use keep::{keep, kept_bytes};
pub use make::{behind, make, settle};
pub use plan::{Planned, plan};
pub use progress::ThuribleProgress;
pub use refusal::Refusal;
pub use saved::{restore, save};
