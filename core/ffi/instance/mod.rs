//! Handles, and the instance in its memory.
//!
//! The caller's block holds the place of a handle first, with its header, and behind it a block of its own. The header points
//! into that block, so it must not be moved; its mark holds its address, and a copy elsewhere is not taken for an instance.

mod any;
pub mod asked;
mod body;
mod enter;
mod handle;
mod make;
mod plan;
mod progress;
mod refusal;

pub use any::Any;
pub use body::{AnySolver, Body, Sizes, Thurible};
pub use enter::{close, enter, message};
pub use handle::{ALIGN, Handle};
pub use make::{behind, make, settle};
pub use plan::{Planned, plan};
pub use progress::ThuribleProgress;
pub use refusal::Refusal;

/// Bytes of a handle's place, before the block behind it.
pub const fn place_bytes<H: Handle>() -> usize {
    handle::block::<H>()
}
