//! The buffers of a run, said once.

use super::body::PARTS;
use super::mesh::Mesh;
use super::settings::CondenseParams;
use super::topology::Topology;
use crate::memory::{Layout, TooSmall};
use crate::real::Real;

/// Every buffer.
#[derive(Debug, Default)]
pub struct Buffers<'m, T> {
    /// Displacements of the free vertices, in their order,
    pub displacement: &'m mut [T],
    pub gradient: &'m mut [T],
    pub direction: &'m mut [T],
    pub trial: &'m mut [T],
    /// and of held ones.
    pub held: &'m mut [T],
    pub mass: &'m mut [T],
    /// x~ and x_{t-1} of implicit steps.
    pub target: &'m mut [T],
    pub before: &'m mut [T],
    pub hessian: &'m mut [T],
    pub basis: &'m mut [T],
    pub patch_begin: &'m mut [u32],
    pub patches: &'m mut [u32],
    pub marks: &'m mut [u32],
    pub factor: &'m mut [T],
    /// R_j R0_j^T, and R0_j.
    pub turns: &'m mut [T],
    pub built: &'m mut [T],
    pub blocks: &'m mut [T],
    pub sums: &'m mut [f64],
}

impl<'m, T: Real> Buffers<'m, T> {
    /// Every buffer, in order.
    pub fn layout(
        &mut self,
        layout: &mut Layout<'_, 'm, T>,
        mesh: &Mesh<'_>,
        topology: &Topology<'_>,
        params: &CondenseParams,
    ) -> Result<(), TooSmall> {
        let (dims, free) = (mesh.dims, topology.free());
        let (size, square) = (free.saturating_mul(dims), dims * dims);
        layout.work("displacement", &mut self.displacement, size)?;
        layout.work("gradient", &mut self.gradient, size)?;
        layout.work("direction", &mut self.direction, size)?;
        layout.work("trial", &mut self.trial, size)?;
        layout.work(
            "displacement of held vertices",
            &mut self.held,
            (mesh.vertices() - free) * dims,
        )?;
        layout.work("masses", &mut self.mass, free)?;
        if params.dt.is_some() {
            layout.work("where inertia leads", &mut self.target, size)?;
            layout.work("displacement before", &mut self.before, size)?;
        }
        layout.work(
            "Hessian",
            &mut self.hessian,
            topology.blocks().saturating_mul(square),
        )?;
        if params.method.keeps_basis() {
            self.layout_basis(layout, topology, (size, square))?;
        }
        if params.factors() {
            let width = topology.band(dims) + 1;
            layout.work("factor", &mut self.factor, size.saturating_mul(width))?;
        }
        if params.turns() {
            layout.work("rotations", &mut self.turns, free.saturating_mul(square))?;
            layout.work(
                "rotations at the build",
                &mut self.built,
                free.saturating_mul(square),
            )?;
        }
        if params.method.keeps_basis() {
            let members = topology.patches.map_or(free, |(_, counted)| counted.largest);
            let block = members.saturating_mul(2 * dims * params.size(dims));
            layout.work(
                "blocks of threads",
                &mut self.blocks,
                block.saturating_mul(params.threads),
            )?;
        }
        layout.work("sums", &mut self.sums, PARTS)
    }

    fn layout_basis(
        &mut self,
        layout: &mut Layout<'_, 'm, T>,
        topology: &Topology<'_>,
        (size, square): (usize, usize),
    ) -> Result<(), TooSmall> {
        let Some((_, counted)) = topology.patches else {
            return layout.work("basis", &mut self.basis, size.saturating_mul(size));
        };
        layout.work("basis", &mut self.basis, counted.total.saturating_mul(square))?;
        layout.work("where patches begin", &mut self.patch_begin, topology.free() + 1)?;
        layout.work("patches", &mut self.patches, counted.total)?;
        layout.work("marks", &mut self.marks, topology.free())
    }
}
