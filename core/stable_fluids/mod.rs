//! Stable Fluids (Stam 1999, 2003) with its exact adjoint, and the search for a flow that carries smoke to keyframes by it: after J. Stam,
//! *Notes on Adjoint Control of Graphical Simulations* (docs/stable_fluids.md has the formulas).
//!
//! A second simulator beside the staggered one: all values at cell centres, stable at any Courant number, dissipative, and not free of
//! divergence. A step is cheap, and what is searched for may be few numbers: a velocity at the start, winds and vortices; or a force in every
//! cell and step.
//!
//! | file | what it holds |
//! |---|---|
//! | `cells`, `plain` | padded fields, their ghosts and the adjoint of them; fields without ghosts |
//! | `skew`, `relax`, `sweeps` | Gauss-Seidel by diagonals; diffusion and its adjoint |
//! | `conjugate`, `project` | conjugate gradients and their exact adjoint; the projection |
//! | `advect`, `advect_back` | semi-Lagrangian advection and its adjoint |
//! | `flow`, `kept`, `march` | a step, forward and backward; what is kept of it; all steps, by a tape or by states that are kept |
//! | `unknowns`, `template`, `script` | what is searched for, winds and vortices, the objective |
//! | `operator` | the simulation by given forces, and its steps taken back, for [`operator`](crate::operator) |
//! | `search`, `steer`, `saved`, `fingerprint` | the objective for L-BFGS, the search, its state as plain bytes, and what its bits follow from |
//! | `params`, `slots`, `plan`, `layout` | what is chosen, and the memory that it takes |

pub mod advect;
pub mod advect_back;
pub mod cells;
pub mod conjugate;
mod diagonal;
pub mod fields;
mod fingerprint;
pub mod flow;
mod given;
mod inputs;
mod kept;
mod layout;
pub mod march;
pub(crate) mod operator;
pub mod params;
mod plain;
mod plan;
pub mod project;
pub mod relax;
pub mod results;
mod saved;
pub mod script;
pub mod search;
pub mod skew;
mod slots;
mod steer;
pub mod sweeps;
pub mod template;
pub mod unknowns;

pub use params::{Adjoint, Control, Controls, FluidsParams, NAME, Pressure};
pub use plan::FluidsPlan;
pub use results::{FoundTemplate, Moment};
pub use slots::Slots;

use crate::field::VectorMut;
use crate::grid::{Grid, Space};
use crate::memory::{Layout, TooSmall};
use crate::optimise::descent::Descent;
use crate::optimise::quasi_newton::fields::Fields;
use crate::problem::{Problem, Units};
use crate::progress::Objective;
use crate::real::Real;
use crate::solver::{SolverError, block};
use core::marker::PhantomData;
use core::mem::MaybeUninit;
use fields::Flow;
use search::Search;
use unknowns::Unknowns;

/// Stable Fluids in one block of memory, and the search for its controls.
#[derive(Debug)]
pub struct Fluids<'m, T, S> {
    params: FluidsParams,
    units: Units,
    length: f64,
    match_mass: bool,
    unknowns: Unknowns,
    /// r and r_v, scaled.
    prices: [f64; 2],
    filters: usize,
    /// Keyframes, and templates.
    keys: usize,
    placed: usize,
    flow: Flow<'m, T>,
    z: &'m mut [T],
    /// The unknowns as rows.
    list: Grid,
    fields: Fields<'m, T>,
    slots: &'m mut [T],
    kept: &'m mut [usize],
    source: &'m mut [T],
    keyframes: &'m mut [T],
    metric: [&'m mut [T]; 2],
    initial: VectorMut<'m, T>,
    /// Steps of keyframes.
    steps: &'m mut [u32],
    /// Weights of keyframes, packed templates, factors of templates.
    numbers: &'m mut [f64],
    taps: &'m mut [T],
    /// The source's.
    mass: f64,
    descent: Descent,
    scale: f64,
    /// Whether the tape is that of the unknowns as they are.
    taped: bool,
    /// Steps that the last gradient repeated.
    repeated: usize,
    /// What the acceleration of buoyancy got by the last product back.
    of_buoyancy: [f64; 3],
    begun: bool,
    iteration: usize,
    objective: Objective,
    fingerprint: u64,
    saved_bytes: usize,
    space: PhantomData<S>,
}

impl<'m, T: Real, S: Space> Fluids<'m, T, S> {
    /// Carves `memory`, of at least [`FluidsPlan::bytes`]; nothing is allocated afterwards.
    ///
    /// # Errors
    /// [`SolverError`].
    pub fn new(
        problem: &Problem<'_>,
        params: &FluidsParams,
        memory: &'m mut [MaybeUninit<u8>],
    ) -> Result<Self, SolverError> {
        let plan = FluidsPlan::new::<T, S>(problem, params)?;
        let (needed, given) = (plan.bytes(), memory.len());
        let short = SolverError::TooSmall { needed, given };
        let mut arena = block(memory, needed)?;
        let mut fluids = Self::bare(problem, params);
        let carved = fluids.layout(&mut Layout::carve(&mut arena));
        carved.map_err(|TooSmall { .. }| short)?;
        debug_assert_eq!(arena.left(), 0, "planned and carved bytes differ");
        fluids.fill(problem);
        fluids.saved_bytes = plan.saved_bytes();
        fluids.fingerprint = fingerprint::fingerprint::<T, S>(problem, params);
        Ok(fluids)
    }

    /// Cells of the box.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.flow.cells.count()
    }

    /// Steps N.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.unknowns.steps
    }

    /// What was chosen.
    #[must_use]
    pub fn params(&self) -> &FluidsParams {
        &self.params
    }

    /// The scene's units in scaled numbers.
    #[must_use]
    pub fn units(&self) -> Units {
        self.units
    }
}
