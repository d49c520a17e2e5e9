//! The C interface of [`thurible_core`]: `thurible.h`, which cbindgen makes from this crate.
//!
//! An instance lives in memory of the caller; nothing is allocated. Its precision and dimension are chosen when it is made, so it holds
//! one of four types of solver. Every pointer and size is checked as far as it can be, and a call that is refused changes nothing.
//! A module imports only from those before it.
//!
//! | module | what it holds |
//! |---|---|
//! | [`result`] | what every call returns |
//! | `pointer` | pointers of the caller, checked |
//! | [`text`] | text into the caller's buffer |
//! | [`config`] | the scene and the choices, as C gives them |
//! | [`host`] | threads and observers of the host |
//! | [`instance`] | the instance in its memory, and how a call enters it |
//! | [`calls`] | plan, make, fill, solve, save |
//! | [`outputs`] | what the method gives, by number: names, views, copies |
//! | [`facts`] | what the method reports of an iteration, by number |
//! | [`templates`] | the templates of a result, by number |
//! | [`track`] | the flow behind frames of smoke |
//! | [`tomography`] | density from what cameras see of it |
//! | [`steps`] | fields of every step, from arrays of the caller's or into them |
//! | [`fluids`] | Stable Fluids, and the search for what moves it |
//! | [`operator`] | a simulation that can be differentiated |
//! | [`condense`] | an elastic body whose energy is minimised |
//! | [`fields`] | results by a code: views and copies |
//! | `trap` | the end of a panic |
#![no_std]

pub mod calls;
pub mod condense;
pub mod config;
pub mod facts;
pub mod fields;
pub mod fluids;
pub mod host;
pub mod instance;
pub mod operator;
pub mod outputs;
mod pointer;
pub mod result;
pub mod steps;
pub mod templates;
pub mod text;
pub mod tomography;
pub mod track;
mod trap;
