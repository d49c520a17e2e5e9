//! A finished solver as the [`Frames`] that the output modules write, one field at a time.

use crate::output::{Frames, Given, GivenValues, Precision, Sample, Samples};
use crate::problem::OwnedProblem;
use thurible_core::{Boundary, Exec, Output, Real, Solver, Space};

/// Which cells are solid, 1 or 0.
const SOLID: &str = "solid";
/// What was added after each step.
pub(super) const EMISSION: &str = "emission";
/// Where force may act.
const MASK: &str = "mask";
/// What emitters add to the force to give their smoke its velocity, along each axis.
const JETS: [&str; 3] = ["emitter_force_x", "emitter_force_y", "emitter_force_z"];
/// Where each keyframe matters.
pub(super) const REGION: &str = "keyframe_region";

/// A solver, its problem and its number type.
pub struct SolverFrames<'a, 'm, T: Real, S: Space> {
    solver: &'a mut Solver<'m, T, S>,
    exec: &'a dyn Exec,
    problem: &'a OwnedProblem,
    periodic: Vec<bool>,
}

impl<'a, 'm, T: Real, S: Space> SolverFrames<'a, 'm, T, S> {
    /// The frames of `solver`, which solved `problem`; emission is computed anew, on the threads of `exec`.
    pub fn new(solver: &'a mut Solver<'m, T, S>, exec: &'a dyn Exec, problem: &'a OwnedProblem) -> Self {
        let periodic = problem
            .boundary
            .iter()
            .map(|&boundary| boundary == Boundary::Periodic)
            .collect();
        SolverFrames {
            solver,
            exec,
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
        let out = room::<T>(out, self.solver.cells());
        self.solver.read_keyframe(index, out);
    }

    fn outputs(&self) -> &[Output] {
        self.solver.outputs()
    }

    fn read(&self, output: &Output, step: usize, axis: usize, out: &mut Samples) {
        let count = self.solver.elements(output, axis);
        self.solver.read(output, step, axis, room::<T>(out, count));
    }

    fn given(&self) -> Vec<Given> {
        let factors = (0..self.problem.steps - 1).map(|slot| self.solver.force_factor(slot));
        given(self.problem, factors.collect())
    }

    fn given_field(&mut self, name: &str, index: usize, out: &mut Samples) {
        if let Some(axis) = JETS.iter().position(|jet| *jet == name) {
            let out = room::<T>(out, self.solver.faces(axis));
            return self.solver.jet(index, axis, out);
        }
        let out = room::<T>(out, self.problem.cells.iter().product());
        match name {
            SOLID => {
                let solver = &*self.solver;
                let [nx, ny] = [0, 1].map(|axis| self.problem.cells[axis]);
                let flag = |cell: usize| {
                    let at = [cell % nx, cell / nx % ny, cell / (nx * ny)];
                    T::from_f64(f64::from(u8::from(solver.is_solid(at))))
                };
                out.iter_mut()
                    .enumerate()
                    .for_each(|(cell, out)| *out = flag(cell));
            }
            MASK => self.solver.read_mask(out),
            EMISSION => self.solver.emission(self.exec, index, out),
            REGION => self.solver.read_region(index, out),
            _ => {}
        }
    }
}

/// What a scene gives for its steps, with the factors of its force's price.
pub(super) fn given(problem: &OwnedProblem, factors: Vec<f64>) -> Vec<Given> {
    let OwnedProblem {
        steps,
        keyframes,
        keyframe_weights,
        keyframe_regions,
        emitters,
        solids,
        schedule,
        mask,
        cells,
        ..
    } = problem;
    let all = [
        (*solids, SOLID, GivenValues::Cells),
        (*mask, MASK, GivenValues::Cells),
        (!emitters.is_empty(), EMISSION, GivenValues::Fields(*steps)),
        (*keyframe_regions, REGION, GivenValues::Fields(keyframes.len())),
        (
            !keyframe_weights.is_empty(),
            "keyframe_weight",
            GivenValues::Numbers(keyframe_weights.clone()),
        ),
        (
            !schedule.is_empty(),
            "force_weight_schedule",
            GivenValues::Numbers(factors),
        ),
    ];
    let pushes = emitters.iter().any(|emitter| emitter.velocity.is_some());
    let jets = JETS.into_iter().enumerate().take(cells.len());
    let jets = jets.map(|(axis, name)| (pushes, name, GivenValues::Faces(steps - 1, axis)));
    let there = all.into_iter().chain(jets).filter(|(there, ..)| *there);
    there.map(|(_, name, values)| Given { name, values }).collect()
}

fn room<T: Real + Sample>(out: &mut Samples, count: usize) -> &mut [T] {
    let list = T::list(out);
    list.clear();
    list.resize(count, T::from_f64(0.0));
    list
}
