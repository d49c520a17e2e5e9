//! The commands, each with its arguments and its body.

pub mod check_gradient;
pub mod compare;
pub mod completions;
pub mod condense;
pub mod deblur;
pub mod export;
pub mod guide;
pub mod new;
pub mod options;
pub mod paper;
pub mod photograph;
pub mod plan;
pub mod readvect;
pub mod remap;
pub mod render;
pub mod resume;
pub mod scene;
pub mod schema;
pub mod simulate;
pub mod solve;
mod studio;
pub mod sweep;
mod takes;
pub mod thesis;
pub mod tomography;
pub mod track;
pub mod upsample;
