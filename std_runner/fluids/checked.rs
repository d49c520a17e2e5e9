//! Taylor's test of the gradient of a search by Stable Fluids: its objective, by each of its controls and by all of them at once.

use super::inputs;
use super::plan::{Planned, planned};
use crate::exit::Failure;
use crate::gradient::{Kept, STEPS, Table, noise};
use crate::plan::PlanOptions;
use crate::problem::Precision;
use crate::region::Region;
use crate::run::inputs::solver_refusal;
use crate::run::messages::no_memory;
use crate::scene::Scene;
use crate::threads;
use core::mem::MaybeUninit;
use thurible_core::stable_fluids::{Control, Controls};
use thurible_core::transport::Stop;
use thurible_core::{D2, D3, Exec, Fluids, Named, Silent, Space};

/// Of the velocity at the start where the gradient is taken: cells a step. From rest every place that is traced back is the centre of a cell, where
/// there is a gradient to either side.
const STIR: f64 = 0.1;
/// Of forces and amplitudes, cells a squared step.
const PUSH: f64 = 0.02;
/// Of middles, in parts of the radius, and of logarithms of radii, at most.
const SHIFT: f64 = 0.1;

/// Checks the gradient of a scene that Stable Fluids steers, in double precision.
pub(crate) fn check(scene: &Scene, options: &PlanOptions) -> Result<Table, Failure> {
    if scene.keyframes.is_empty() {
        let why =
            "is missing, and without one nothing is searched for whose gradient could be checked; write one";
        return Err(scene.document.refuse("keyframe", why));
    }
    let options = PlanOptions {
        precision: Precision::F64,
        ..*options
    };
    let planned = planned(scene, &options)?;
    let count = planned.params.threads;
    let bytes = planned.plan.bytes();
    let mut region = Region::new(bytes).ok_or_else(|| no_memory(bytes))?;
    let block = region.carve(bytes).ok_or_else(|| no_memory(bytes))?;
    threads::with(count, || {
        threads::together(count, |exec| {
            if scene.grid.cells.len() == 2 {
                run::<D2>(scene, &planned, exec, block)
            } else {
                run::<D3>(scene, &planned, exec, block)
            }
        })
    })?
}

/// Which unknowns belong to each control: the velocity at the start comes first, then forces, then templates.
fn parts(controls: Controls, count: usize, [field, steps]: [usize; 2]) -> Vec<(Control, usize)> {
    let of = |control: Control, before: usize| match control {
        Control::InitialVelocity => field,
        Control::Forces => field * steps,
        Control::Templates => count - before,
    };
    let mut before = 0;
    let each = controls.list().map(|control| {
        let own = of(control, before);
        before += own;
        (control, own)
    });
    each.collect()
}

fn run<S: Space>(
    scene: &Scene,
    planned: &Planned,
    exec: &dyn Exec,
    block: &mut [MaybeUninit<u8>],
) -> Result<Table, Failure> {
    let problem = planned.problem.problem();
    let mut fluids =
        Fluids::<f64, S>::new(&problem, &planned.params, block).map_err(|error| solver_refusal(&error))?;
    inputs::set(scene, &mut fluids)?;
    let (cells, steps) = (fluids.cells(), fluids.steps());
    let count = fluids.unknowns().len();
    let parts = parts(planned.params.controls, count, [cells * S::DIM, steps]);
    let longest = problem.cells.iter().copied().max().unwrap_or(1) as f64;
    let n = steps as f64;
    // Unknowns are velocities in parts of 1 / N, and forces and amplitudes in parts of 1 / N^2.
    let size = |control: Control| match control {
        Control::InitialVelocity => STIR * n / longest,
        Control::Forces => PUSH * n * n / longest,
        Control::Templates => (PUSH * n * n / longest).min(SHIFT),
    };
    let sizes = parts
        .iter()
        .flat_map(|&(control, own)| core::iter::repeat_n(size(control), own));
    let sizes: Vec<f64> = sizes.collect();
    let drawn = |what: u64| -> Vec<f64> {
        let sizes = sizes.iter().enumerate();
        sizes.map(|(at, size)| size * noise(what, 0, 0, at)).collect()
    };
    let begin = fluids.unknowns().iter().zip(drawn(21)).map(|(z, d)| z + d);
    let (begin, way) = (begin.collect::<Vec<f64>>(), drawn(22));
    let path = scene.document.path().display();
    let stopped = |_: Stop| Failure::NotFinite(format!("{path}: the flow is too fast to be followed"));
    fluids.unknowns_mut().copy_from_slice(&begin);
    let value = fluids.value(exec, &mut Silent).map_err(stopped)?.total();
    let mut gradient = vec![0.0; count];
    let repeated = fluids
        .gradient(exec, &mut Silent, &mut gradient)
        .map_err(stopped)?;
    let mut at = 0;
    let along = parts.iter().map(|&(control, own)| {
        let span = at..at + own;
        at += own;
        let terms = gradient[span.clone()].iter().zip(&way[span]);
        (control.name(), terms.map(|(g, d)| g * d).sum())
    });
    let kept = Kept {
        bytes: planned.plan.bytes(),
        slots: planned.params.slots.states(),
        repeated,
    };
    let mut table = Table::new(value, along.collect(), kept);
    for step in STEPS {
        let moved = begin.iter().zip(&way).map(|(z, d)| z + step * d);
        let places = fluids.unknowns_mut().iter_mut();
        places.zip(moved).for_each(|(place, z)| *place = z);
        table.push(step, fluids.value(exec, &mut Silent).map_err(stopped)?.total());
    }
    Ok(table)
}
