//! The simulation as an operator that can be differentiated: densities and velocities by where they begin and by what pushes them, and the
//! exact adjoint of that, in planned memory.
//!
//! ```text
//! rho_{k+1} = A[rho_k, v_k] + s_k,    v_{k+1} + Adv(v_{k+1}) + nu C^T C v_{k+1} + grad p = v_k + u_k + B rho_{k+1} + T_k - K_k v_k,    div v = 0
//! ```
//!
//! for k = 0 .. N - 1 from rho_0 and Q v_0: the step of a simulation (mathematics section 7) with all that a scene may have. Every step is
//! shown when it is there, and forces are asked for when they are needed, so that a long run needs no more memory than a short one. The way
//! back asks for covectors step by step, the last first, and shows the covectors of the forces. The states between are those of binomial
//! checkpointing ([`reversal`](crate::reversal)): how many are kept changes no bit.
//!
//! With z_{k+1} = Q (c - J(v_{k+1})^T z_{k+1}) for the covector c of v_{k+1}, and mu that of rho_{k+1}:
//!
//! ```text
//! u_k gets z,    rho_{k+1} gets B^T z,    b gets <z, B_1 rho_{k+1}>,    rho_k gets A_rho^T mu,    v_k gets (1 - K_k) z + A_v^T mu
//! ```
//!
//! [`Simulator`] is what an [`Operator`] does, and [`Fluids`](crate::Fluids) does it too: by Stable Fluids, with everything at the centres of cells.

mod backward;
mod centers;
mod error;
mod fields;
mod forward;
mod layout;
mod params;
mod plan;
mod setup;
mod simulator;
mod states;

pub use error::{Input, OperatorError};
pub use fields::{Ask, Given, Show, Start, View};
pub use params::OperatorParams;
pub use plan::OperatorPlan;
pub use simulator::Simulator;

use crate::exec::ranks::Alone;
use crate::field::{VectorMut, view};
use crate::grid::levels::Levels;
use crate::grid::{Grid, Space};
use crate::memory::TooSmall;
use crate::objective::script::Lists;
use crate::objective::script::emitted::NUMBERS;
use crate::problem::Problem;
use crate::real::Real;
use crate::reversal::Reversal;
use crate::solver::{FileLayout, InputError, SolverError, block, check_density, check_solids, put_solids};
use core::marker::PhantomData;
use core::mem::MaybeUninit;
use fields::Places;
use setup::Setup;

/// What is known of the last simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Nothing, or it failed.
    Nothing,
    /// All of it: the last step is at hand, before and after.
    Simulated,
    /// Where it began, which is kept.
    Begun,
}

/// A simulation and its adjoint, in one block of memory.
#[derive(Debug)]
pub struct Operator<'m, T, S> {
    setup: Setup,
    levels: Levels<'m, T>,
    lists: Lists<'m>,
    /// The shapes of the emitters.
    shapes: &'m mut [T],
    /// The largest density that there is or that is made: what series are cut by.
    largest: f64,
    /// rho_k and rho_{k+1}.
    rho: &'m mut [T],
    /// v_{k-1}, v_k and v_{k+1}.
    v: [VectorMut<'m, T>; 3],
    /// What pushes v_k.
    force: VectorMut<'m, T>,
    /// The covector of rho.
    mu: &'m mut [T],
    /// The covector of v.
    covector: VectorMut<'m, T>,
    /// z of the last step back and of that before.
    z: [VectorMut<'m, T>; 2],
    /// How many of them are known.
    known: usize,
    of_buoyancy: [f64; 3],
    numbers: &'m mut [f64],
    of_shapes: &'m mut [T],
    sums: &'m mut [f64],
    kept: &'m mut [T],
    reversal: Reversal<'m>,
    phase: Phase,
    repeated: usize,
    region: &'m mut [T],
    space: PhantomData<S>,
}

/// What a scalar function gets by the numbers of an emitter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EmitterGradient {
    /// By its rate or target.
    pub supply: f64,
    /// By the velocity of its smoke; 0 where it has none.
    pub velocity: [f64; 3],
}

impl<'m, T: Real, S: Space> Operator<'m, T, S> {
    /// Carves `memory`, of at least [`OperatorPlan::bytes`]; nothing is allocated afterwards.
    ///
    /// # Errors
    /// [`SolverError`].
    pub fn new(
        problem: &Problem<'_>,
        params: &OperatorParams,
        memory: &'m mut [MaybeUninit<u8>],
    ) -> Result<Self, SolverError> {
        let plan = OperatorPlan::new::<T, S>(problem, params)?;
        let (needed, given) = (plan.bytes(), memory.len());
        let short = SolverError::TooSmall { needed, given };
        let mut arena = block(memory, needed)?;
        let mut operator = Self::bare(problem, params, plan.slots());
        let carved = operator.layout(problem, &mut arena);
        carved.map_err(|TooSmall { .. }| short)?;
        debug_assert_eq!(arena.left(), 0, "planned and carved bytes differ");
        Ok(operator)
    }

    /// The grid.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.levels.finest
    }

    /// Steps N: states are 0 .. N, forces 0 .. N - 1.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.setup.steps
    }

    /// States that are kept.
    #[must_use]
    pub fn slots(&self) -> usize {
        self.setup.slots
    }

    /// Cells of a density.
    #[must_use]
    pub fn cells(&self) -> usize {
        FileLayout::of_cells(self.grid()).len()
    }

    /// Numbers of component `axis` of a velocity or force in the layout of a file: one more than cells along an axis between walls.
    #[must_use]
    pub fn faces_len(&self, axis: usize) -> usize {
        FileLayout::new(self.grid(), axis).len()
    }

    /// Sets which cells are solid, before anything is simulated: one flag for each cell, x fastest.
    ///
    /// # Errors
    /// [`InputError::Length`]; [`InputError::NoFluid`] where all cells are solid; [`InputError::Index`] where the problem has no solid cells.
    pub fn set_solids(&mut self, solid: &[bool]) -> Result<(), InputError> {
        check_solids(&self.levels, solid)?;
        if solid.iter().all(|&solid| solid) {
            return Err(InputError::NoFluid);
        }
        put_solids(&Alone, &mut self.levels, solid);
        self.phase = Phase::Nothing;
        for index in 0..self.setup.emitters {
            self.clear_shape(index);
        }
        Ok(())
    }

    /// Sets the shape of emitter `index`: where it adds smoke, and how much of its rate or target there.
    ///
    /// # Errors
    /// [`InputError`]: no such emitter, wrong length, a value that is negative or not finite.
    pub fn set_emitter(&mut self, index: usize, shape: &[T]) -> Result<(), InputError> {
        let (count, cells) = (self.setup.emitters, self.grid().cells());
        if index >= count {
            return Err(InputError::Index { given: index, count });
        }
        check_density(shape, self.cells())?;
        let grid = self.levels.finest;
        if let Some(field) = self.shapes.get_mut(index * cells..(index + 1) * cells) {
            FileLayout::of_cells(&grid).write(shape, T::ONE, field);
        }
        self.clear_shape(index);
        self.phase = Phase::Nothing;
        Ok(())
    }

    /// Sets a shape to 0 in solid cells.
    fn clear_shape(&mut self, index: usize) {
        let (n, cells) = (self.grid().n[0], self.grid().cells());
        if let Some(field) = self.shapes.get_mut(index * cells..(index + 1) * cells) {
            self.levels.solids(0).clear_cells(n, field);
        }
    }

    /// Steps that the last simulation and its last gradient ran again, beside the one for each step that was taken back.
    #[must_use]
    pub fn repeated(&self) -> usize {
        self.repeated
    }

    /// The gradient by rho_0 and by v_0 as it was given, after [`Self::vjp`].
    #[must_use]
    pub fn gradient(&self) -> View<'_, T> {
        View {
            places: Places::Faces(self.grid()),
            density: self.mu,
            vector: view(&self.covector),
            unit: 1.0 / self.setup.velocity_unit,
        }
    }

    /// The gradient by the acceleration of buoyancy along each axis, after [`Self::vjp`].
    #[must_use]
    pub fn buoyancy_gradient(&self) -> [f64; 3] {
        self.of_buoyancy.map(|gradient| gradient / self.setup.force_unit)
    }

    /// The gradient by the numbers of emitter `index`, after [`Self::vjp`].
    #[must_use]
    pub fn emitter_gradient(&self, index: usize) -> EmitterGradient {
        match self.numbers.as_chunks::<NUMBERS>().0.get(index) {
            Some(&[supply, velocity @ ..]) => EmitterGradient {
                supply,
                velocity: velocity.map(|gradient| gradient / self.setup.velocity_unit),
            },
            None => EmitterGradient::default(),
        }
    }

    /// The gradient by the shape of emitter `index`, after [`Self::vjp`]: the field of cells of a view.
    #[must_use]
    pub fn shape_gradient(&self, index: usize) -> View<'_, T> {
        let cells = self.grid().cells();
        View {
            places: Places::Faces(self.grid()),
            density: self
                .of_shapes
                .get(index * cells..(index + 1) * cells)
                .unwrap_or(&[]),
            vector: Default::default(),
            unit: 1.0,
        }
    }
}
