//! What is minimised: a function of a trajectory, at a point that can be moved.

use super::quasi_newton::recursion::{Borrowed, QuasiNewton};
use crate::exec::Exec;
use crate::observe::Observer;
use crate::progress::Objective;
use crate::real::Real;
use crate::transport::Stop;

/// A function of a trajectory of faces, at a point that can be moved.
pub trait Function<T: Real, S> {
    /// Writes the direction's field; <gradient, direction>, which is not finite where the direction is of no use.
    ///
    /// # Errors
    /// [`Stop`].
    fn direction(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        newton: &mut QuasiNewton,
    ) -> Result<f64, Stop>;
    /// Moves the point by `s` times field `direction`.
    fn move_along(&mut self, exec: &dyn Exec, direction: usize, s: f64);
    /// Part of a step that is tried next when it is too long, at least and at most.
    fn shrink(&self) -> [f64; 2] {
        [0.1, 0.5]
    }
    /// Takes the point back towards where a solve begins: `keep` of the way from there is left.
    fn retreat(&mut self, exec: &dyn Exec, keep: f64);
    /// The value, with what the gradient needs of it in field `work`; perhaps not all of it where a part is above `bound`.
    ///
    /// # Errors
    /// [`Stop`].
    fn value(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        work: usize,
        bound: f64,
    ) -> Result<Objective, Stop>;
    /// The gradient into field `into`, from field `work`: the point is the new one from here on.
    ///
    /// # Errors
    /// [`Stop`], where the gradient is not finite too: the point is then taken back.
    fn gradient(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        work: usize,
        into: usize,
    ) -> Result<(), Stop>;
    /// Calls [`QuasiNewton::arrive`] with its fields.
    fn arrive(&mut self, exec: &dyn Exec, newton: &mut QuasiNewton, borrowed: Borrowed, step: Option<f64>);
}
