//! `mesh = "x.obj"`: a body from its surface, in 3D. Holes, flipped parts and overlaps do not matter: inside is where the surface winds
//! around, by more than half.

mod draw;
mod found;
mod glb;
mod gltf;
mod obj;
mod place;
mod ply;
mod read;
mod scene_graph;
mod stl;
mod surface;
mod voxels;
mod winding;

pub(super) use draw::{Placed, draw};
pub(super) use place::{Fit, FitKey, Up};
pub(crate) use read::files_beside;
pub(super) use voxels::Edge;
