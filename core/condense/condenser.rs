//! The run itself: its block of memory, its state, what can be seen of it.

use super::body::{Body, vector};
use super::error::CondenseError;
use super::layout::Buffers;
use super::mesh::Mesh;
use super::patches::{self, Columns};
use super::plan::CondensePlan;
use super::settings::CondenseParams;
use super::topology::Topology;
use crate::memory::{Layout, TooSmall};
use crate::real::Real;
use crate::solver::block;
use core::mem::MaybeUninit;

/// A deformed body whose energy is minimised step by step, in one block of memory. `D` is the number of its dimensions.
#[derive(Debug)]
pub struct Condenser<'m, T, const D: usize> {
    pub(super) mesh: Mesh<'m>,
    pub(super) topology: Topology<'m>,
    pub(super) params: CondenseParams,
    pub(super) buffers: Buffers<'m, T>,
    /// Acceleration of the step.
    pub(super) gravity: [f64; 3],
    /// What residuals are measured by: V n Y, and dt^2.
    pub(super) scale: f64,
    /// max |g| at the beginning of the step, of a rod.
    pub(super) first: f64,
    /// Steps that are done.
    pub(super) steps: usize,
    /// Builds of the basis or of H0's factor.
    pub(super) builds: usize,
}

impl<'m, T: Real, const D: usize> Condenser<'m, T, D> {
    /// Carves `memory`, of at least [`CondensePlan::bytes`] from a multiple of [`CondensePlan::ALIGN`] on; nothing is allocated. `topology` is that of
    /// `mesh`, made for the radius of `params`.
    ///
    /// # Errors
    /// [`CondenseError`].
    pub fn new(
        mesh: Mesh<'m>,
        topology: Topology<'m>,
        params: CondenseParams,
        memory: &'m mut [MaybeUninit<u8>],
    ) -> Result<Self, CondenseError> {
        let plan = CondensePlan::new::<T>(&mesh, &topology, &params)?;
        if mesh.dims != D || topology.place.len() != mesh.vertices() {
            return Err(CondenseError::Lengths);
        }
        let needed = plan.bytes();
        let short = CondenseError::Memory { needed };
        let mut arena = block(memory, needed).map_err(|_| short)?;
        let mut buffers = Buffers::default();
        let carved = buffers.layout(&mut Layout::carve(&mut arena), &mesh, &topology, &params);
        carved.map_err(|TooSmall { .. }| short)?;
        debug_assert_eq!(arena.left(), 0, "planned and carved bytes differ");
        let time = params.dt.map_or(1.0, |dt| dt * dt);
        let mut condenser = Self {
            scale: mesh.volume() * mesh.vertices() as f64 * mesh.material.young * time,
            mesh,
            topology,
            params,
            buffers,
            gravity: [0.0; 3],
            first: 0.0,
            steps: 0,
            builds: 0,
        };
        condenser.weigh();
        condenser.find_patches();
        Ok(condenser)
    }

    /// Gives each corner of a simplex its part of the mass.
    fn weigh(&mut self) {
        let (mesh, topology) = (&self.mesh, &self.topology);
        let part = mesh.material.density * mesh.material.thickness(D) / (D + 1) as f64;
        for (mass, &vertex) in self.buffers.mass.iter_mut().zip(topology.free_vertices()) {
            let star = topology.star(vertex as usize, D + 1);
            let volume: f64 = star.map(|(element, _)| mesh.element(element).volume).sum();
            *mass = T::from_f64(part * volume);
        }
    }

    fn find_patches(&mut self) {
        let (rows, buffers) = (
            (self.topology.row_begin, self.topology.columns),
            &mut self.buffers,
        );
        if let (Some((radius, _)), true) = (self.topology.patches, self.params.method.keeps_basis()) {
            patches::fill(rows, radius, buffers.marks, buffers.patch_begin, buffers.patches);
        }
    }

    /// What the basis' columns reach.
    pub(super) fn columns(&self) -> Columns<'_> {
        Columns {
            begin: &*self.buffers.patch_begin,
            members: &*self.buffers.patches,
            free: self.topology.free(),
        }
    }

    /// The state with `free` as the displacements of free vertices.
    pub(super) fn body<'a>(&'a self, free: &'a [T]) -> Body<'a, T> {
        Body {
            mesh: &self.mesh,
            topology: &self.topology,
            free,
            held: &*self.buffers.held,
            mass: &*self.buffers.mass,
            target: self.params.dt.map(|_| &*self.buffers.target),
            weight: self.params.dt.map_or(1.0, |dt| dt * dt),
            gravity: self.gravity,
        }
    }

    /// The displacement of vertex `vertex` from rest, 0 beyond the last dimension.
    #[must_use]
    pub fn displacement(&self, vertex: usize) -> [f64; 3] {
        self.body(self.buffers.displacement).moved(vertex)
    }

    /// Where vertex `vertex` is.
    #[must_use]
    pub fn position(&self, vertex: usize) -> [f64; 3] {
        let (place, moved) = (self.mesh.place(vertex), self.displacement(vertex));
        core::array::from_fn(|k| place[k] + moved[k])
    }

    /// Adds `shift`, `D` numbers to each vertex, to their displacements.
    ///
    /// # Errors
    /// [`CondenseError::Values`]; nothing has changed then. An empty shift changes nothing.
    pub fn shift(&mut self, shift: &[f64]) -> Result<(), CondenseError> {
        self.check_shift(shift)?;
        self.add(shift);
        Ok(())
    }

    pub(super) fn check_shift(&self, shift: &[f64]) -> Result<(), CondenseError> {
        let right = shift.is_empty() || shift.len() == self.mesh.vertices() * D;
        if right && shift.iter().all(|x| x.is_finite()) {
            Ok(())
        } else {
            Err(CondenseError::Values)
        }
    }

    /// Adds a shift that was checked.
    pub(super) fn add(&mut self, shift: &[f64]) {
        let free = self.topology.free();
        for (row, &number) in shift.chunks_exact(D).zip(self.topology.place) {
            let number = number as usize;
            let (list, number) = match number.checked_sub(free) {
                None => (&mut *self.buffers.displacement, number),
                Some(number) => (&mut *self.buffers.held, number),
            };
            let to = list.get_mut(number * D..(number + 1) * D).unwrap_or(&mut []);
            for (to, from) in to.iter_mut().zip(row) {
                *to = T::from_f64(to.to_f64() + from);
            }
        }
    }

    /// Gives free vertices a velocity, `D` numbers to each vertex, before an implicit step.
    ///
    /// # Errors
    /// [`CondenseError::Values`], also where steps are not implicit.
    pub fn set_velocity(&mut self, velocity: &[f64]) -> Result<(), CondenseError> {
        let wrong = velocity.len() != self.mesh.vertices() * D || velocity.iter().any(|x| !x.is_finite());
        let Some(dt) = self.params.dt.filter(|_| !wrong) else {
            return Err(CondenseError::Values);
        };
        let vertices = self.topology.free_vertices().iter();
        let buffers = &mut self.buffers;
        let now = buffers.displacement.chunks_exact(D);
        for ((before, now), &vertex) in buffers.before.chunks_exact_mut(D).zip(now).zip(vertices) {
            let velocity = velocity.iter().skip(vertex as usize * D);
            for ((before, now), velocity) in before.iter_mut().zip(now).zip(velocity) {
                *before = T::from_f64(now.to_f64() - dt * velocity);
            }
        }
        Ok(())
    }

    /// The mass of vertex `vertex`, 0 of a held one.
    #[must_use]
    pub fn mass(&self, vertex: usize) -> f64 {
        let number = self.topology.place.get(vertex).copied().unwrap_or(u32::MAX);
        self.buffers
            .mass
            .get(number as usize)
            .map_or(0.0, |mass| mass.to_f64())
    }

    /// What the gradient was by the displacement of vertex `vertex` when it was made last; 0 of a held one.
    #[must_use]
    pub fn gradient(&self, vertex: usize) -> [f64; 3] {
        self.of_free(self.buffers.gradient, vertex)
    }

    /// How far vertex `vertex` goes along the direction that was found last; 0 of a held one.
    #[must_use]
    pub fn direction(&self, vertex: usize) -> [f64; 3] {
        self.of_free(self.buffers.direction, vertex)
    }

    fn of_free(&self, list: &[T], vertex: usize) -> [f64; 3] {
        let number = self.topology.place.get(vertex).copied().unwrap_or(u32::MAX) as usize;
        if number < self.topology.free() {
            vector(list, number, D)
        } else {
            [0.0; 3]
        }
    }

    /// Vertices of the mesh.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.mesh.vertices()
    }

    /// Steps that are done.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Builds of the basis, or of H0's factor, so far.
    #[must_use]
    pub fn builds(&self) -> usize {
        self.builds
    }
}
