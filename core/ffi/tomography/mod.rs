//! Density from what cameras see of it: pictures in, frame by frame, and a density and novel views out.

mod body;
mod calls;
mod camera;
mod config;
mod read;

pub use body::ThuribleTomography;
pub use calls::{
    thurible_tomography_begin, thurible_tomography_close, thurible_tomography_explain,
    thurible_tomography_init, thurible_tomography_measure, thurible_tomography_message,
    thurible_tomography_plan,
};
pub use camera::{THURIBLE_MOST_CAMERAS, ThuribleCamera, ThuribleLens};
pub use config::{
    ThuriblePrior, ThuribleReconstructor, ThuribleTomographyConfig, ThuribleWalk,
    thurible_tomography_defaults,
};
pub use read::{
    ThuribleWalked, thurible_tomography_advance, thurible_tomography_density, thurible_tomography_novel,
    thurible_tomography_picture,
};
