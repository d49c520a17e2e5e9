//! The runner of thurible: reads a scene, plans its memory, solves it with [`thurible_core`] and writes the result.
//!
//! The path of the data is the order of the modules: the command line ([`cli`], acted on by [`program`] and [`commands`]) names a [`scene`], its shapes become
//! densities ([`keyframes`]), its values become a [`problem`], whose [`plan`] says how many bytes the one block
//! ([`region`]) must have; [`run`] solves it there on a pool of [`threads`], watched by [`progress`], and
//! [`output`] and [`report`] write the folder. [`compare`] does that for several methods, [`paper`] for the scenes of the paper, and a room of its own, `thesis`, for the figures of
//! Gregson's thesis. The flow
//! behind frames of smoke is found by a room of its own, `track`; elastic bodies are the business of `condense`.
//!
//! Everything here needs the feature `std` (on by default); [`threads`], [`bytes`], [`change`], [`undershoot`] and [`exit`] alone are the feature `embed`. Without
//! either the library only hands on the core.
#![cfg_attr(not(feature = "embed"), no_std)]

pub use thurible_core;

#[cfg(feature = "std")]
pub mod address_space;
#[cfg(feature = "std")]
mod among;
#[cfg(feature = "std")]
pub mod blocks;
#[cfg(feature = "embed")]
pub mod brightness;
#[cfg(feature = "embed")]
pub mod bytes;
#[cfg(feature = "embed")]
pub mod change;
#[cfg(feature = "embed")]
pub mod channels;
#[cfg(feature = "std")]
mod checkpoint;
#[cfg(feature = "std")]
mod choices;
#[cfg(feature = "std")]
pub mod cli;
#[cfg(feature = "std")]
pub mod commands;
#[cfg(feature = "std")]
pub mod compare;
#[cfg(feature = "std")]
mod condense;
#[cfg(feature = "std")]
pub mod console;
#[cfg(feature = "std")]
mod deblur;
#[cfg(feature = "std")]
pub mod destination;
#[cfg(feature = "std")]
mod devices;
#[cfg(feature = "std")]
mod distance;
#[cfg(feature = "embed")]
pub mod exit;
#[cfg(feature = "std")]
pub mod export;
#[cfg(feature = "std")]
mod flows;
#[cfg(feature = "std")]
mod fluids;
#[cfg(feature = "std")]
pub mod gradient;
#[cfg(feature = "std")]
mod guard;
#[cfg(feature = "std")]
mod held;
#[cfg(feature = "std")]
pub mod interrupt;
#[cfg(feature = "std")]
pub mod keyframes;
#[cfg(feature = "std")]
mod ledger;
#[cfg(feature = "std")]
mod live;
#[cfg(feature = "std")]
pub mod output;
#[cfg(feature = "embed")]
pub mod owned;
#[cfg(feature = "std")]
pub mod paper;
#[cfg(feature = "std")]
pub mod phases;
#[cfg(feature = "std")]
pub mod plan;
#[cfg(feature = "std")]
mod preview;
#[cfg(feature = "std")]
pub mod problem;
#[cfg(feature = "std")]
pub mod program;
#[cfg(feature = "std")]
pub mod progress;
#[cfg(feature = "std")]
pub mod quoted;
#[cfg(feature = "std")]
mod refine;
#[cfg(feature = "std")]
pub mod region;
#[cfg(feature = "embed")]
pub mod remarks;
#[cfg(feature = "std")]
pub mod report;
#[cfg(feature = "std")]
mod room;
#[cfg(feature = "std")]
pub mod run;
#[cfg(feature = "std")]
pub mod scene;
#[cfg(feature = "std")]
mod solves;
#[cfg(feature = "embed")]
pub mod stay;
#[cfg(feature = "std")]
mod thesis;
#[cfg(feature = "embed")]
pub mod threads;
#[cfg(feature = "std")]
mod tomography;
#[cfg(feature = "std")]
mod track;
#[cfg(feature = "embed")]
pub mod undershoot;
#[cfg(feature = "std")]
pub mod windows;
