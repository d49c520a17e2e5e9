//! Searches of flows by the direct method on a graphics card, through [wgpu](https://wgpu.rs): WGSL kernels for what
//! `docs/operators.md` lists, and nothing of the descent, which is the core's.
//!
//! | file | what it holds |
//! |---|---|
//! | `adapters` | the devices that there are, and how one is opened |
//! | `kernels`, `kernels/*.wgsl` | the kernels |
//! | `memory` | fields on a device, planned to the byte |
//! | `machine` | a device that is open: what is run on it, and what comes back |
//! | `state` | what a search has there, and its sums |
//! | `spectral` | projection and metric |
//! | `transport` | densities along the flow, forward and back |
//! | `search` | the verbs of the direct method |

mod adapters;
mod kernels;
mod machine;
mod memory;
mod search;
mod spectral;
mod state;
mod transport;

pub use adapters::{Gpu, Named, adapters};
pub use machine::Bounds;
pub use memory::Taken;
