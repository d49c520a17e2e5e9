//! The functions of the interface but those that read results: make, fill, solve, save.

mod inputs;
mod make;
mod save;
mod solve;

pub use inputs::{thurible_set_emitter, thurible_set_mask, thurible_set_region, thurible_set_solids};
pub use inputs::{
    thurible_set_initial_velocity, thurible_set_keyframe, thurible_set_reference, thurible_set_source,
};
pub use make::{thurible_close, thurible_explain, thurible_init, thurible_message, thurible_plan};
pub use save::{thurible_restore, thurible_save};
pub use solve::{thurible_finish, thurible_progress, thurible_solve, thurible_step};
