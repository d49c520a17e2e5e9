//! Stable Fluids: the search for what carries smoke through keyframes by it, and the flow that was found.

mod body;
mod calls;
mod config;
mod read;
mod save;
mod search;
mod searched;

pub use body::{AnyFluids, Planned, ThuribleFluids, made};
pub use calls::{
    thurible_fluids_close, thurible_fluids_explain, thurible_fluids_init, thurible_fluids_message,
    thurible_fluids_plan, thurible_fluids_set_initial_velocity, thurible_fluids_set_keyframe,
    thurible_fluids_set_source,
};
pub use config::{
    THURIBLE_NO_WAY_BACK, ThuribleAdjoint, ThuribleControl, ThuribleFluidsConfig, ThuriblePressure,
    thurible_fluids_defaults,
};
pub use read::{
    thurible_fluids_replay, thurible_fluids_template, thurible_fluids_template_amplitude,
    thurible_fluids_unknowns,
};
pub use save::{thurible_fluids_restore, thurible_fluids_save, thurible_fluids_saved_bytes};
pub use search::{thurible_fluids_solve, thurible_fluids_step};
pub use searched::ThuribleSearched;
