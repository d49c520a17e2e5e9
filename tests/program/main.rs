//! The program and the runner's library from end to end, in one test program: what they share is compiled once.
#![cfg(feature = "std")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

#[path = "../output_support/mod.rs"]
mod output_support;
#[path = "../support/mod.rs"]
mod support;

mod compare;
mod files;
#[cfg(unix)]
mod interrupts;
mod methods;
mod output;
mod paper;
mod plans;
mod refusals;
mod said;
mod scenes;
mod shape_files;
mod shape_keys;
mod shapes;
