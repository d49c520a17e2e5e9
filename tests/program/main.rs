//! The program and the runner's library from end to end, in one test program: what they share is compiled once.
#![cfg(feature = "std")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod output_support;
mod support;

mod cases;
mod check_gradient;
#[cfg(unix)]
mod checkpoints;
mod compare;
mod condense;
mod damaged;
mod deblur;
mod effects;
mod export;
mod files;
mod flows;
#[cfg(unix)]
mod interrupts;
mod lines;
mod meshes;
mod methods;
mod output;
mod paper;
mod picture_kinds;
mod pictures;
mod plans;
mod refined;
mod refusals;
mod render;
#[cfg(unix)]
mod result_folder;
mod said;
mod scene_check;
mod scenes;
mod schema;
mod sequences;
mod shape_files;
mod shape_keys;
mod shape_values;
mod shapes;
mod small;
mod stable_fluids;
mod sweeps;
mod templates;
#[cfg(unix)]
mod terminal;
mod thesis;
mod tomography;
mod track;
mod undershoot;
#[cfg(unix)]
mod unfinished;
mod volume_parts;
mod volumes;
#[cfg(unix)]
mod watch;
#[cfg(unix)]
mod windows;
