//! The facts that `tools/verify.py` checks, with the same tolerances, in Rust.

use super::field::{Field, indices, with};
use super::npz::{self, Array};
use super::physics::Grid;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// A result folder as numbers.
pub struct Outcome {
    pub report: Value,
    pub grid: Grid,
    pub density: Vec<Field>,
    /// By step, then by axis.
    pub velocity: Vec<Vec<Field>>,
    pub force: Vec<Vec<Field>>,
    pub targets: Vec<(usize, Field)>,
    /// What was added after each step; none where nothing was.
    pub emission: Vec<Field>,
    /// What emitters with a velocity add to the forces; none where there are none.
    pub jets: Vec<Vec<Field>>,
    /// What the error at each keyframe is multiplied by; none where all is.
    pub regions: Vec<Field>,
    /// Where force may act; none where it may everywhere.
    pub mask: Option<Field>,
    /// What each keyframe's data term is multiplied by; none where all by 1.
    pub weights: Vec<f64>,
    /// What the price of each force is multiplied by; none where all by 1.
    pub schedule: Vec<f64>,
}

fn split(array: &Array, size: [usize; 3], axes: usize) -> Vec<Field> {
    let stored: Vec<usize> = size[..axes].iter().rev().copied().collect();
    assert_eq!(&array.shape[1..], stored, "shape of an array");
    let count: usize = size.iter().product();
    array
        .data
        .chunks_exact(count)
        .map(|data| Field {
            size,
            data: data.to_vec(),
        })
        .collect()
}

fn by_step(components: Vec<Vec<Field>>) -> Vec<Vec<Field>> {
    let steps = components[0].len();
    (0..steps)
        .map(|step| {
            components
                .iter()
                .map(|component| component[step].clone())
                .collect()
        })
        .collect()
}

impl Outcome {
    pub fn read(folder: &Path) -> Self {
        let report: Value =
            serde_json::from_str(&std::fs::read_to_string(folder.join("report.json")).unwrap()).unwrap();
        let arrays = npz::read(&folder.join("result.npz"));
        let counts: Vec<usize> = report["cells"]
            .as_array()
            .unwrap()
            .iter()
            .map(|count| count.as_u64().unwrap() as usize)
            .collect();
        let axes = counts.len();
        let mut grid = Grid {
            cells: [1; 3],
            axes,
            periodic: [false; 3],
            h: 0.0,
        };
        for (axis, &count) in counts.iter().enumerate() {
            grid.cells[axis] = count;
            grid.periodic[axis] = report["boundary"][axis] == "periodic";
        }
        grid.h = report["length"].as_f64().unwrap() / *counts.iter().max().unwrap() as f64;
        let vector = |name: &str, arrays: &BTreeMap<String, Array>| {
            let component = |axis: usize| {
                split(
                    &arrays[&format!("{name}_{}", ["x", "y", "z"][axis])],
                    grid.faces(axis),
                    axes,
                )
            };
            by_step((0..axes).map(component).collect())
        };
        let (velocity, force) = (vector("velocity", &arrays), vector("force", &arrays));
        let jets = if arrays.contains_key("emitter_force_x") {
            vector("emitter_force", &arrays)
        } else {
            Vec::new()
        };
        let fields = |name: &str| {
            let given = arrays.get(name);
            given.map_or_else(Vec::new, |array| split(array, grid.cells, axes))
        };
        let numbers = |name: &str| arrays.get(name).map_or_else(Vec::new, |array| array.data.clone());
        let steps = arrays["keyframe_step"].data.iter().map(|&step| step as usize);
        Outcome {
            density: split(&arrays["density"], grid.cells, axes),
            targets: steps
                .zip(split(&arrays["keyframe_density"], grid.cells, axes))
                .collect(),
            emission: fields("emission"),
            jets,
            regions: fields("keyframe_region"),
            mask: arrays.get("mask").map(|array| Field {
                size: grid.cells,
                data: array.data.clone(),
            }),
            weights: numbers("keyframe_weight"),
            schedule: numbers("force_weight_schedule"),
            report,
            grid,
            velocity,
            force,
        }
    }

    fn number(&self, pointer: &str) -> f64 {
        self.report
            .pointer(pointer)
            .and_then(Value::as_f64)
            .unwrap_or(f64::NAN)
    }
}

/// Panics with everything that does not hold; `name` says whose result it is.
pub fn verify(name: &str, folder: &Path) -> Outcome {
    let outcome = Outcome::read(folder);
    let mut wrong = Vec::new();
    let mut check = |what: &str, value: f64, tolerance: f64| {
        if !(value.is_finite() && value <= tolerance) {
            wrong.push(format!("{what}: {value:.3e}, at most {tolerance:.0e}"));
        }
    };
    shapes(&outcome, &mut check);
    incompressible(&outcome, &mut check);
    momentum(&outcome, &mut check);
    transported(&outcome, &mut check);
    objective(&outcome, &mut check);
    assert!(wrong.is_empty(), "{name}: {}", wrong.join("; "));
    outcome
}

type Check<'a> = &'a mut dyn FnMut(&str, f64, f64);

fn largest<'a>(fields: impl Iterator<Item = &'a Field>) -> f64 {
    fields.map(Field::max_abs).fold(
        1e-30,
        |max, value| if value.is_nan() { f64::NAN } else { value.max(max) },
    )
}

fn shapes(outcome: &Outcome, check: Check<'_>) {
    let steps = outcome.report["steps"].as_u64().unwrap() as usize;
    check(
        "number of densities",
        (outcome.density.len() as f64 - (steps + 1) as f64).abs(),
        0.0,
    );
    check(
        "number of velocities",
        (outcome.velocity.len() as f64 - steps as f64).abs(),
        0.0,
    );
    check(
        "number of forces",
        (outcome.force.len() as f64 - (steps - 1) as f64).abs(),
        0.0,
    );
    check("largest density", largest(outcome.density.iter()), 1e6);
    let values = || outcome.density.iter().flat_map(|field| &field.data).copied();
    for (part, value) in [
        ("min", values().fold(f64::INFINITY, f64::min)),
        ("max", values().fold(f64::NEG_INFINITY, f64::max)),
    ] {
        let reported = outcome.number(&format!("/density_{part}"));
        check(&format!("density_{part}"), (reported - value).abs(), 1e-12);
    }
}

fn incompressible(outcome: &Outcome, check: Check<'_>) {
    let grid = &outcome.grid;
    for (name, series) in [("v", &outcome.velocity), ("u", &outcome.force)] {
        let divergence = series
            .iter()
            .map(|field| grid.divergence(field).max_abs())
            .fold(0.0, f64::max);
        check(
            &format!("div {name}"),
            divergence * grid.h / largest(series.iter().flatten()),
            1e-3,
        );
        let mut through_walls = 0.0_f64;
        for (axis, field) in series
            .iter()
            .flat_map(|field| field.iter().enumerate())
            .filter(|(axis, _)| !grid.periodic[*axis])
        {
            let walls = indices(with(field.size, axis, 1));
            through_walls = walls.fold(through_walls, |max, at| {
                max.max(field.at(at).abs())
                    .max(field.at(with(at, axis, grid.cells[axis])).abs())
            });
        }
        check(&format!("{name} through walls"), through_walls, 0.0);
    }
}

/// (v' - v)/dt + Adv[v'] + nu C^T C v' - B rho' - u is a pure gradient.
fn momentum(outcome: &Outcome, check: Check<'_>) {
    let (grid, dt) = (&outcome.grid, outcome.number("/dt"));
    let acceleration: Vec<f64> = (0..grid.axes)
        .map(|axis| outcome.number(&format!("/acceleration/{axis}")))
        .collect();
    let scale = largest(outcome.force.iter().flatten());
    let (mut curl, mut mean) = (0.0_f64, 0.0_f64);
    for (step, force) in outcome.force.iter().enumerate() {
        let (before, after) = (&outcome.velocity[step], &outcome.velocity[step + 1]);
        let mut residual = grid.self_advection(after);
        let mut viscous = grid.curl_curl(after);
        if outcome.report["slip"] == false {
            let sticking = grid.sticking(after);
            for (viscous, sticking) in viscous.iter_mut().zip(&sticking) {
                let all = viscous.data.iter_mut().zip(&sticking.data);
                all.for_each(|(viscous, sticking)| *viscous += sticking);
            }
        }
        for (axis, field) in residual.iter_mut().enumerate() {
            let lifted = grid.at_faces(&outcome.density[step + 1], axis);
            for (index, value) in field.data.iter_mut().enumerate() {
                *value += outcome.number("/viscosity") * viscous[axis].data[index];
                *value -= acceleration[axis] * lifted.data[index];
                *value += (after[axis].data[index] - before[axis].data[index]) / dt - force[axis].data[index];
                *value -= outcome.jets.get(step).map_or(0.0, |jet| jet[axis].data[index]);
            }
            if grid.periodic[axis] {
                mean = mean.max((field.sum() / field.data.len() as f64).abs());
            }
        }
        curl = curl.max(grid.curl_max(&residual) * grid.h);
    }
    check("curl of momentum residual", curl / scale, 2e-3);
    check("mean of momentum residual", mean / scale, 2e-3);
}

fn transported(outcome: &Outcome, check: Check<'_>) {
    let scheme = outcome
        .report
        .pointer("/advection/scheme")
        .and_then(Value::as_str)
        .unwrap();
    if scheme == "semi_lagrangian" {
        return;
    }
    let (source, dt) = (&outcome.density[0], outcome.number("/dt"));
    let (largest, heaviest) = (
        largest(outcome.density.iter()),
        outcome.density.iter().map(Field::sum).fold(0.0, f64::max),
    );
    let cut = outcome.number("/advection/tolerance").min(1e-7) * largest;
    let (mut rho, mut mass) = (source.clone(), source.sum());
    let (mut worst, mut drift) = (0.0_f64, 0.0_f64);
    for (step, (velocity, stored)) in outcome.velocity.iter().zip(&outcome.density[1..]).enumerate() {
        rho = outcome.grid.advect(rho, velocity, dt, scheme, cut);
        if let Some(emitted) = outcome.emission.get(step) {
            rho.data
                .iter_mut()
                .zip(&emitted.data)
                .for_each(|(rho, emitted)| *rho += emitted);
            mass += emitted.sum();
        }
        let off = rho
            .data
            .iter()
            .zip(&stored.data)
            .map(|(left, right)| (left - right).abs());
        worst = off.fold(
            worst,
            |max, value| if value.is_nan() { f64::NAN } else { max.max(value) },
        );
        drift = drift.max((stored.sum() - mass).abs());
    }
    check("density transported again", worst / largest, 2e-3);
    check("mass drift", drift / heaviest, 1e-3);
}

/// A force divided by the mask of its faces, which is the mean of two cells' and at least 1e-3.
fn divided(outcome: &Outcome, u: &[Field]) -> Vec<Field> {
    let mut divided = u.to_vec();
    let Some(mask) = &outcome.mask else {
        return divided;
    };
    let grid = &outcome.grid;
    for (axis, component) in divided.iter_mut().enumerate() {
        let n = grid.cells[axis];
        let places: Vec<_> = indices(component.size).collect();
        for (at, value) in places.into_iter().zip(&mut component.data) {
            let face = at[axis];
            let low = if face > 0 {
                face - 1
            } else if grid.periodic[axis] {
                n - 1
            } else {
                0
            };
            let [low, high]: [f64; 2] = [low, face.min(n - 1)].map(|cell| mask.at(with(at, axis, cell)));
            *value /= (0.5 * (low + high)).max(1e-3);
        }
    }
    divided
}

fn objective(outcome: &Outcome, check: Check<'_>) {
    let filters = outcome.report["filters"].as_u64().unwrap() as usize;
    let mut data = 0.0;
    for (index, (step, target)) in outcome.targets.iter().enumerate() {
        let mut error = outcome.density[*step].clone();
        error
            .data
            .iter_mut()
            .zip(&target.data)
            .for_each(|(left, right)| *left -= right);
        if let Some(region) = outcome.regions.get(index) {
            error
                .data
                .iter_mut()
                .zip(&region.data)
                .for_each(|(error, part)| *error *= part);
        }
        let weight = outcome.weights.get(index).unwrap_or(&1.0);
        data += 0.5 * weight * outcome.grid.metric(&error, filters);
    }
    let [mut plain, mut squares, mut curls] = [0.0; 3];
    for (slot, u) in outcome.force.iter().enumerate() {
        let of_slot: f64 = u.iter().map(Field::sum_of_squares).sum();
        plain += of_slot;
        let u = &divided(outcome, u);
        let images = outcome.grid.curl_curl(u);
        let of_component = |(u, image): (&Field, &Field)| -> f64 {
            u.data.iter().zip(&image.data).map(|(u, image)| u * image).sum()
        };
        let factor = outcome.schedule.get(slot).unwrap_or(&1.0);
        squares += factor * u.iter().map(Field::sum_of_squares).sum::<f64>();
        curls += factor * u.iter().zip(&images).map(of_component).sum::<f64>();
    }
    let (weight, smoothness) = (
        outcome.number("/force_weight"),
        outcome.number("/force_smoothness"),
    );
    plain *= 0.5 * weight;
    let force = 0.5 * weight * (squares + smoothness * smoothness * curls);
    let total = data + force;
    for (part, value) in [
        ("data", data),
        ("force", force),
        ("force_plain", plain),
        ("total", total),
    ] {
        let reported = outcome.number(&format!("/objective/{part}"));
        check(
            &format!("objective.{part}, reported {reported:.6e}, recomputed {value:.6e}"),
            (reported - value).abs() / total.abs().max(1e-30),
            1e-3,
        );
    }
}
