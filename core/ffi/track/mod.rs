//! The flow behind frames of smoke: frames in, one by one, and after each the flow that carried the one before to it.

mod body;
mod calls;
mod config;
mod step;

pub use body::{ThuriblePair, ThuribleTracker};
pub use calls::{
    thurible_track_close, thurible_track_explain, thurible_track_faces, thurible_track_give,
    thurible_track_init, thurible_track_message, thurible_track_plan, thurible_track_set_initial_velocity,
};
pub use config::{
    ThuribleMinimiser, ThuriblePrediction, ThuribleTrackConfig, ThuribleWarping, thurible_track_defaults,
};
pub use step::{ThuribleFaces, thurible_track_density, thurible_track_step};
