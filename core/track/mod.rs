//! A sequence of frames: the flow between each and the next, predicted from the one before (Gregson et al. 2014, mathematics section 10).
//!
//! ```text
//! P_0 = Q v_init,   P_k = the implicit step from v_{k-1}
//! v_k = P_k + the flow that carries phi_k to phi_{k+1} pulled back by P_k
//! ```
//!
//! The memory is that of three frames and one solve, however long the sequence is: frames are given one by one, and every pair hands out
//! its results.

mod force;
mod layout;
mod pair;
mod params;
mod plan;
mod predict;

pub use pair::{Faces, Pair, Part, Sink};
pub use params::{Capture, FULL, Prediction, TrackParams};
pub use plan::TrackPlan;

use crate::exec::Exec;
use crate::field::VectorMut;
use crate::flow::pyramid::Pyramid;
use crate::grid::levels::Levels;
use crate::grid::{Grid, Space};
use crate::memory::{Layout, TooSmall};
use crate::observe::Silent;
use crate::real::Real;
use crate::solver::{FileLayout, InputError, SolverError, block, finite};
use core::marker::PhantomData;
use core::mem::MaybeUninit;

/// Tracks the flow through frames, in one block of memory.
#[derive(Debug)]
pub struct Tracker<'m, T, S> {
    params: TrackParams,
    density_scale: f64,
    /// The acceleration in cells and frames where the scaled density is 1.
    lift: [f64; 3],
    /// Velocities of the capture in one of a cell a frame.
    unit: f64,
    /// Time between frames.
    dt: f64,
    /// The grids of the pyramid, finest first, between which nothing is passed by tables.
    levels: Levels<'m, T>,
    /// phi_k and phi_{k+1}, scaled, and what is made of the second.
    frames: [&'m mut [T]; 3],
    /// Where smoke is made: phi_{k+1} with it, scaled. The second frame lacks it.
    whole: &'m mut [T],
    emission: bool,
    /// v_{k-1}, then P_k, then v_k, in cells a frame.
    v: VectorMut<'m, T>,
    /// v_{k-1} while v_k is looked for, where forces are asked for.
    before: VectorMut<'m, T>,
    pyramid: Pyramid<'m, T>,
    /// The first frame carried by the flow, as it was given, and the last but one.
    carried: [&'m mut [T]; 2],
    sums: &'m mut [f64],
    region: &'m mut [T],
    /// Frames that were given.
    given: usize,
    /// Pairs that are done.
    pairs: usize,
    space: PhantomData<S>,
}

impl<'m, T: Real, S: Space> Tracker<'m, T, S> {
    /// Carves `memory`, of at least [`TrackPlan::bytes`]; nothing is allocated afterwards.
    ///
    /// # Errors
    /// [`SolverError`].
    pub fn new(
        capture: &Capture<'_>,
        params: &TrackParams,
        memory: &'m mut [MaybeUninit<u8>],
    ) -> Result<Self, SolverError> {
        let plan = TrackPlan::new::<T, S>(capture, params)?;
        let (needed, given) = (plan.bytes(), memory.len());
        let short = SolverError::TooSmall { needed, given };
        let mut arena = block(memory, needed)?;
        let mut tracker = Self::bare(capture, params);
        let carved = tracker.layout(&mut Layout::carve(&mut arena));
        carved.map_err(|TooSmall { .. }| short)?;
        debug_assert_eq!(arena.left(), 0, "planned and carved bytes differ");
        Ok(tracker)
    }

    /// The grid.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.levels.finest
    }

    /// Cells of the grid.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.grid().cells()
    }

    /// Numbers of component `axis` of a flow in the layout of a file: one more than cells along a wall axis.
    #[must_use]
    pub fn faces_len(&self, axis: usize) -> usize {
        FileLayout::new(self.grid(), axis).len()
    }

    /// The grids of the pyramid, finest first.
    pub fn grids(&self) -> impl Iterator<Item = &Grid> {
        self.levels.grids.iter()
    }

    /// Pairs that are done.
    #[must_use]
    pub fn pairs(&self) -> usize {
        self.pairs
    }

    /// Gives component `axis` of the flow of the first pair, in the capture's units and the layout of a file, before any frame.
    ///
    /// # Errors
    /// [`InputError`].
    pub fn set_initial_velocity(&mut self, axis: usize, faces: &[T]) -> Result<(), InputError> {
        let (unit, grid) = (self.unit, *self.grid());
        if axis >= grid.dims {
            let (given, count) = (axis, grid.dims);
            return Err(InputError::Index { given, count });
        }
        FileLayout::new(&grid, axis).take(faces, 1.0 / unit, self.v[axis], [1, 0])
    }

    /// Gives the next frame, one density a cell, x fastest. Densities may be negative.
    ///
    /// # Errors
    /// [`InputError`] when it has another length or is not finite; nothing has changed then.
    pub fn give(&mut self, exec: &dyn Exec, frame: &[T]) -> Result<(), InputError> {
        self.check(frame)?;
        self.take(exec, frame, None);
        Ok(())
    }

    /// As [`Self::give`], with what was made of it since the frame before, which no flow carried there: that is taken off before the flow is
    /// looked for. Of the first frame it does not matter.
    ///
    /// # Errors
    /// As [`Self::give`]; [`InputError::Negative`] where smoke was taken away, [`InputError::NoEmission`] where none was planned for.
    pub fn give_with_emission(
        &mut self,
        exec: &dyn Exec,
        frame: &[T],
        emission: &[T],
    ) -> Result<(), InputError> {
        if !self.emission {
            return Err(InputError::NoEmission);
        }
        self.check(frame)?;
        self.check(emission)?;
        if let Some(index) = emission.iter().position(|&value| value < T::ZERO) {
            return Err(InputError::Negative { index });
        }
        self.take(exec, frame, Some(emission));
        Ok(())
    }

    fn check(&self, frame: &[T]) -> Result<(), InputError> {
        finite(frame, self.cells())
    }

    fn take(&mut self, exec: &dyn Exec, frame: &[T], emission: Option<&[T]>) {
        let scale = T::from_f64(self.density_scale);
        let [first, second, _] = &mut self.frames;
        if self.emission {
            core::mem::swap(first, &mut self.whole);
            crate::field::rows::scale(self.whole, scale, frame);
            second.copy_from_slice(self.whole);
        } else {
            core::mem::swap(first, second);
            crate::field::rows::scale(second, scale, frame);
        }
        if self.given == 0 {
            let [carried, _] = &mut self.carried;
            if self.params.readvect {
                carried.copy_from_slice(frame);
            }
            self.begin(exec);
        } else if let Some(emission) = emission {
            crate::field::rows::add_scaled(second, -scale, emission);
        }
        self.given += 1;
    }

    /// P_0 = Q v_init.
    fn begin(&mut self, exec: &dyn Exec) {
        // The observer does not break.
        let _ = self.project(exec, &mut Silent);
    }

    /// Whether there are two frames whose flow was not found yet.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.given >= 2 && self.pairs + 1 < self.given
    }

    /// The first frame carried by the flow up to the last one, as it was given; empty without `readvect`.
    #[must_use]
    pub fn carried(&self) -> &[T] {
        self.carried[0]
    }
}
