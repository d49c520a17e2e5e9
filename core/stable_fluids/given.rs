//! What a search follows from, and the velocity and forces that unknowns make of it.

use super::cells::Cells;
use super::params::Control;
use super::template::Shape;
use super::unknowns::{Placed, Unknowns};
use crate::exec::Exec;
use crate::field::{Vector, VectorMut, rows};
use crate::grid::Grid;
use crate::real::Real;

/// What a search follows from, beside its unknowns.
#[derive(Clone, Copy, Debug)]
pub struct Given<'a, T> {
    /// Which unknown is what.
    pub unknowns: Unknowns,
    /// rho_0.
    pub source: &'a [T],
    /// The velocity at the start as it is given, empty where there is none.
    pub initial: Vector<'a, T>,
    /// Densities of keyframes, `pitch` numbers from one to the next.
    pub keyframes: &'a [T],
    /// See above.
    pub pitch: usize,
    /// Their steps.
    pub steps: &'a [u32],
    /// Their weights.
    pub weights: &'a [f64],
    /// Packed templates.
    pub templates: &'a [f64],
    /// r and r_v, scaled.
    pub prices: [f64; 2],
    /// Filters of the metric.
    pub filters: usize,
    /// Threads that scratch is for.
    pub threads: usize,
}

impl<T: Real> Given<'_, T> {
    /// Whether there is any force.
    pub fn has_force(&self) -> bool {
        self.unknowns.controls.has(Control::Forces) || !self.templates.is_empty()
    }

    /// The number of the keyframe at a step.
    pub fn keyframe(&self, step: usize) -> Option<usize> {
        self.steps.iter().position(|&at| at as usize == step)
    }

    /// The weight of a keyframe.
    pub fn weight(&self, index: usize) -> f64 {
        self.weights.get(index).copied().unwrap_or(1.0)
    }

    /// Writes the velocity at the start, without ghosts, component `axis` at a time.
    pub fn begin(&self, z: &[T], axis: usize, out: &mut [T]) {
        let given = self.initial.get(axis).copied().unwrap_or_default();
        match given.get(..out.len()) {
            Some(given) => out.copy_from_slice(given),
            None => out.fill(T::ZERO),
        }
        if let Some(z) = z.get(self.unknowns.initial(axis)).filter(|z| !z.is_empty()) {
            rows::add_scaled(out, T::from_f64(self.unknowns.of_velocity()), z);
        }
    }

    /// Writes the force of a step, without ghosts.
    pub fn force(
        &self,
        exec: &dyn Exec,
        (cells, grid): (&Cells, &Grid),
        z: &[T],
        step: usize,
        factors: &mut [f64],
        out: &mut VectorMut<'_, T>,
    ) {
        let unit = T::from_f64(self.unknowns.of_force());
        for (axis, out) in out.iter_mut().enumerate().take(cells.dims) {
            match z.get(self.unknowns.force(step, axis)).filter(|z| !z.is_empty()) {
                Some(z) => rows::scale(out.get_mut(..z.len()).unwrap_or_default(), unit, z),
                None => out.fill(T::ZERO),
            }
        }
        self.add_templates(exec, (cells, grid), z, step, factors, out);
    }

    /// Adds the templates that act in a step to its force, without ghosts.
    pub fn add_templates(
        &self,
        exec: &dyn Exec,
        (cells, grid): (&Cells, &Grid),
        z: &[T],
        step: usize,
        factors: &mut [f64],
        out: &mut VectorMut<'_, T>,
    ) {
        for placed in self.unknowns.placed(self.templates) {
            if let Some(interval) = placed.interval(step) {
                shape(cells, &placed, z, interval, factors).add(exec, grid, out);
            }
        }
    }
}

/// A template as it is in an interval.
pub fn shape<'s, T: Real>(
    cells: &'s Cells,
    placed: &Placed,
    z: &[T],
    interval: usize,
    factors: &'s mut [f64],
) -> Shape<'s> {
    let (kind, amplitude) = (placed.given.kind, placed.amplitude(z, interval));
    Shape::new(cells, kind, placed.now(z), amplitude, factors)
}
