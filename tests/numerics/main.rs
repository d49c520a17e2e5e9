//! The core by its parts, in one program: what they share is compiled once.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod fields;

mod adjoint_control;
mod adjoints;
mod admm;
mod admm_statuses;
mod allocations;
mod baseline;
#[cfg(target_os = "linux")]
mod ceiling;
mod checkpoint;
mod checkpoint_refusals;
mod choices;
mod condense;
mod deblur;
mod descent;
mod determinism;
mod direct;
mod direct_starts;
mod driven;
mod effects;
mod exec;
mod free_flow;
mod geometry;
mod gradients;
mod grid;
mod guide;
mod halves;
mod inputs;
mod limited;
mod memory;
mod metric;
mod not_finite;
#[allow(dead_code, reason = "the program's tests write arrays too")]
#[path = "../program/support/npz.rs"]
mod npz;
mod nso_cases;
mod nso_residual;
mod objective_gradients;
mod open;
mod operator;
mod operator_agrees;
mod operator_runs;
mod optical_flow;
mod paper_bound;
mod price;
mod projection;

mod quasi_newton;
mod ranks;
mod recursion;
mod refined;
mod reversal;
mod smoother;
mod stable_fluids;
mod steps;
mod stfas;
mod stfas_solves;
mod sticking;
mod templates;
mod tomography;
mod track;
mod transforms;
mod transport;
mod transport_refusals;
mod turbulence;
mod walk;
mod words;
mod yielding;
