//! The instance in its memory.
//!
//! The caller's block holds the instance first, with the solver's header, and behind it the solver's own block. The instance points
//! into that block, so it must not be moved; its mark holds its address, and a copy elsewhere is not taken for an instance.

mod body;
mod enter;
mod handle;
mod make;
mod plan;
mod progress;
mod refusal;

pub use body::{AnySolver, Body, Sizes};
pub use enter::{close, enter, message};
pub use handle::{ALIGN, Thurible};
pub use make::make;
pub use plan::{Planned, plan};
pub use progress::ThuribleProgress;
pub use refusal::Refusal;
