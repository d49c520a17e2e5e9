//! What another simulator found, as the methods of the staggered grid would have it: its flow brought to faces, the smoke carried by that, and the
//! force that makes it. So one table compares the same objective.

use crate::exit::Failure;
use crate::keyframes::{Series, ShapeError};
use crate::plan::{self, PlanOptions, Planned};
use crate::problem::Precision;
use crate::region::Region;
use crate::remarks::keyframe_errors;
use crate::report::{ARCHIVE, ObjectiveRecord};
use crate::run::drawn::narrowed;
use crate::run::inputs::{set_inputs, solver_refusal};
use crate::run::messages::{no_memory, not_finite};
use crate::scene::Scene;
use crate::threads;
use core::mem::MaybeUninit;
use std::path::Path;
use thurible_core::{Boundary, D2, D3, Exec, InputError, Method, Real, Solver, Space};

/// A result on the staggered grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Staggered {
    /// J there; the price of a velocity at the start is that of its own grid.
    pub objective: ObjectiveRecord,
    /// The largest relative distance from a keyframe.
    pub keyframe_error: f64,
}

/// The scene by which the staggered grid prices a flow that is given.
fn priced(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.method.fluids.chosen = false;
    scene.method.params.method = Method::Direct;
    // The flow is that which was found, from its start on.
    scene.control.initial_velocity = None;
    scene.templates.clear();
    scene
}

/// Refuses a scene whose result could not be brought to the staggered grid.
pub(crate) fn check(scene: &Scene, options: &PlanOptions) -> Result<(), Failure> {
    plan::choose(&priced(scene), options).map(drop)
}

/// The result in `folder` of `scene`, whose velocities are at the centres of cells, on the staggered grid.
pub(crate) fn staggered(scene: &Scene, folder: &Path, options: &PlanOptions) -> Result<Staggered, Failure> {
    let scene = priced(scene);
    let planned = plan::choose(&scene, options)?;
    let bytes = planned.plan.bytes();
    let mut region = Region::new(bytes).ok_or_else(|| no_memory(bytes))?;
    let block = region.carve(bytes).ok_or_else(|| no_memory(bytes))?;
    let count = planned.params.threads;
    threads::with(count, || {
        threads::together(count, |exec| {
            match (planned.problem.cells.len(), planned.precision) {
                (2, Precision::F32) => carried::<f32, D2>(&scene, folder, &planned, exec, block),
                (2, Precision::F64) => carried::<f64, D2>(&scene, folder, &planned, exec, block),
                (_, Precision::F32) => carried::<f32, D3>(&scene, folder, &planned, exec, block),
                (_, Precision::F64) => carried::<f64, D3>(&scene, folder, &planned, exec, block),
            }
        })
    })?
}

fn carried<T: Real, S: Space>(
    scene: &Scene,
    folder: &Path,
    planned: &Planned,
    exec: &dyn Exec,
    block: &mut [MaybeUninit<u8>],
) -> Result<Staggered, Failure> {
    let problem = planned.problem.problem();
    let mut solver =
        Solver::<T, S>::new(&problem, &planned.params, block).map_err(|error| solver_refusal(&error))?;
    let refused = |error: InputError| Failure::Input(format!("{}: {error}", folder.display()));
    let unread = |error: ShapeError| error.failure(format!("{}: {error}", folder.display()));
    let mut flow = Vec::new();
    for name in ["velocity_x", "velocity_y", "velocity_z"]
        .into_iter()
        .take(S::DIM)
    {
        flow.push(Series::open(&folder.join(ARCHIVE), Some(name), "result").map_err(unread)?);
    }
    let mut faces = |axis: usize, step: usize| -> Result<Vec<T>, Failure> {
        let centers = flow[axis].read(step).map_err(unread)?;
        let ring = problem.boundary.get(axis) == Some(&Boundary::Periodic);
        Ok(narrowed(to_faces(problem.cells, axis, ring, &centers)))
    };
    for axis in 0..S::DIM {
        solver
            .set_initial_velocity(axis, &faces(axis, 0)?)
            .map_err(refused)?;
    }
    set_inputs(scene, &mut solver, None)?;
    for step in 1..problem.steps {
        for axis in 0..S::DIM {
            solver
                .give_velocity(step, axis, &faces(axis, step)?)
                .map_err(refused)?;
        }
    }
    solver.begin_at_given(exec).map_err(refused)?;
    let objective = solver.finish(exec).map_err(|_| not_finite(scene))?;
    let errors = keyframe_errors(&solver, &problem);
    Ok(Staggered {
        objective: objective.into(),
        keyframe_error: errors.iter().map(|error| error.after).fold(0.0, f64::max),
    })
}

/// A component from the centres of cells to the faces across its axis: the mean of both sides, and nothing through walls.
fn to_faces(cells: &[usize], axis: usize, ring: bool, centers: &[f64]) -> Vec<f64> {
    let n = cells[axis];
    let stride: usize = cells[..axis].iter().product();
    let count = if ring { n } else { n + 1 };
    let outer = centers.len() / (stride * n);
    let mut faces = Vec::with_capacity(outer * count * stride);
    for plane in centers.chunks_exact(stride * n) {
        for face in 0..count {
            let sides = match face {
                0 if ring => Some([n - 1, 0]),
                0 => None,
                face if face == n => None,
                face => Some([face - 1, face]),
            };
            faces.extend((0..stride).map(|at| {
                sides.map_or(0.0, |sides| {
                    0.5 * sides.iter().map(|side| plane[side * stride + at]).sum::<f64>()
                })
            }));
        }
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_between_centers() {
        let centers = [1.0, 3.0, 5.0, 7.0, 9.0, 11.0];
        assert_eq!(
            to_faces(&[3, 2], 0, false, &centers),
            [0.0, 2.0, 4.0, 0.0, 0.0, 8.0, 10.0, 0.0]
        );
        assert_eq!(
            to_faces(&[3, 2], 0, true, &centers),
            [3.0, 2.0, 4.0, 9.0, 8.0, 10.0]
        );
        assert_eq!(
            to_faces(&[3, 2], 1, false, &centers),
            [0.0, 0.0, 0.0, 4.0, 6.0, 8.0, 0.0, 0.0, 0.0]
        );
    }
}
