//! The C interface of [`thurible_core`]: `thurible.h`, which cbindgen makes from this crate.
//!
//! An instance lives in memory of the caller; nothing is allocated. Its precision and dimension are chosen when it is made, so it is
//! one of four solvers. Every pointer and size is checked as far as it can be, and what is refused changes nothing.
//!
//! | module | what it holds |
//! |---|---|
//! | [`result`] | what every call returns |
//! | [`config`] | the scene and the choices, as C gives them |
//! | [`host`] | threads and observers of the host |
//! | [`instance`] | the instance in its memory, and how a call enters it |
//! | [`calls`] | make, fill, solve, save |
//! | [`fields`] | what was found: views and copies |
//! | [`text`] | words for codes, written into the caller's buffer |
//! | `trap` | the end of a panic |
#![no_std]

pub mod calls;
pub mod config;
pub mod fields;
pub mod host;
pub mod instance;
pub mod result;
pub mod text;
mod trap;
