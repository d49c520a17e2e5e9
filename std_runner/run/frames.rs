//! A finished solver as the [`Frames`] that the output modules write, one field at a time.

use crate::output::{Frames, Precision, Sample, Samples};
use crate::problem::OwnedProblem;
use thurible_core::{Boundary, Output, Real, Solver, Space};

/// A solver, its problem and its number type.
pub struct SolverFrames<'a, 'm, T: Real, S: Space> {
    solver: &'a Solver<'m, T, S>,
    problem: &'a OwnedProblem,
    periodic: Vec<bool>,
}

impl<'a, 'm, T: Real, S: Space> SolverFrames<'a, 'm, T, S> {
    /// The frames of `solver`, which solved `problem`.
    pub fn new(solver: &'a Solver<'m, T, S>, problem: &'a OwnedProblem) -> Self {
        let periodic = problem
            .boundary
            .iter()
            .map(|&boundary| boundary == Boundary::Periodic)
            .collect();
        SolverFrames {
            solver,
            problem,
            periodic,
        }
    }
}

impl<T: Real + Sample, S: Space> Frames for SolverFrames<'_, '_, T, S> {
    fn cells(&self) -> &[usize] {
        &self.problem.cells
    }

    fn periodic(&self) -> &[bool] {
        &self.periodic
    }

    fn steps(&self) -> usize {
        self.problem.steps
    }

    fn precision(&self) -> Precision {
        T::PRECISION
    }

    fn keyframe_steps(&self) -> &[usize] {
        &self.problem.keyframes
    }

    fn keyframe(&self, index: usize, out: &mut Samples) {
        let list = T::list(out);
        list.clear();
        list.extend_from_slice(self.solver.keyframe(index));
    }

    fn outputs(&self) -> &[Output] {
        self.solver.outputs()
    }

    fn read(&self, output: &Output, step: usize, axis: usize, out: &mut Samples) {
        let count = self.solver.elements(output, axis);
        self.solver.read(output, step, axis, room::<T>(out, count));
    }
}

fn room<T: Real + Sample>(out: &mut Samples, count: usize) -> &mut [T] {
    let list = T::list(out);
    list.clear();
    list.resize(count, T::from_f64(0.0));
    list
}
