//! Where a gradient is checked, and along which direction.
//!
//! That is near where the scene begins, but not there: a flow at rest, smoke with sharp edges and shapes that are exactly 1 stand at kinks of
//! the transport and of the emitters, where there is a gradient to either side. So there is some haze everywhere, a stir of a tenth of a cell a step, and
//! a little force. All of it is drawn from hashes of the places, the same at every run.

use crate::exit::Failure;
use crate::keyframes::read_velocity;
use crate::owned::OwnedProblem;
use crate::run::drawn::{drawn, refusal};
use crate::scene::Scene;
use thurible_core::operator::Given;
use thurible_core::{Boundary, Emitter, Operator, Space, Supply};

/// What the scene is differentiated by, as the table calls it.
pub const INPUTS: [&str; 7] = [
    "density",
    "velocity",
    "forces",
    "buoyancy",
    "rates and targets",
    "velocities of emitters",
    "shapes of emitters",
];

/// Of the largest density.
const HAZE: f64 = 0.05;
/// Cells a step.
const STIR: f64 = 0.1;
/// Cells a squared step, of the forces there are and of their direction.
const PUSH: [f64; 2] = [0.02, 0.1];

/// A point and a direction.
pub struct Point {
    density: Vec<f64>,
    largest: f64,
    velocity: Vec<Vec<f64>>,
    shapes: Vec<Vec<f64>>,
    /// Numbers of each component.
    faces: Vec<usize>,
    /// A cell a step, and a cell a squared step.
    units: [f64; 2],
    emitters: Vec<Emitter>,
    buoyancy: [f64; 3],
    dims: usize,
}

/// From -1 to 1, by a hash (SplitMix64) of what is asked for.
pub(crate) fn noise(what: u64, step: usize, axis: usize, at: usize) -> f64 {
    let seed = [what, step as u64, axis as u64, at as u64];
    let mixed = seed.into_iter().fold(0x9E37_79B9_7F4A_7C15_u64, |state, part| {
        let mut z = (state ^ part).wrapping_add(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    });
    (mixed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

impl Point {
    /// That of a scene.
    pub(super) fn new(scene: &Scene) -> Result<Self, Failure> {
        let cells = &scene.grid.cells;
        let most = cells.iter().copied().max().unwrap_or(1) as f64;
        let unit = scene.grid.length / scene.time.dt / most;
        let source = match &scene.source {
            Some(source) => drawn(scene, "source", source, &mut Vec::new())?,
            None => vec![0.0; cells.iter().product()],
        };
        let largest = source.iter().fold(0.0, |most: f64, &x: &f64| most.max(x));
        let largest = if largest > 0.0 { largest } else { 1.0 };
        let haze = |(at, x): (usize, &f64)| x + HAZE * largest * (1.0 + noise(1, 0, 0, at));
        let faces = (0..cells.len()).map(|axis| {
            let extent = |(a, &n): (usize, &usize)| {
                n + usize::from(a == axis && scene.grid.boundary.get(a) != Some(&Boundary::Periodic))
            };
            cells.iter().enumerate().map(extent).product()
        });
        let faces: Vec<usize> = faces.collect();
        let given = match &scene.control.initial_velocity {
            Some(path) => {
                read_velocity(path, &scene.canvas()).map_err(|error| refusal(scene, "control", &error))?
            }
            None => faces.iter().map(|&len| vec![0.0; len]).collect(),
        };
        let stirred = |(axis, v): (usize, Vec<f64>)| {
            let stir = |(at, v): (usize, f64)| v + STIR * unit * noise(2, 0, axis, at);
            v.into_iter().enumerate().map(stir).collect()
        };
        let mut shapes = Vec::new();
        for emitter in &scene.emitters {
            let shape: Vec<f64> = drawn(scene, &emitter.key, &emitter.shape, &mut Vec::new())?;
            let below = |(at, x): (usize, f64)| x * (0.9 + 0.05 * noise(3, shapes.len(), 0, at));
            shapes.push(shape.into_iter().enumerate().map(below).collect());
        }
        Ok(Self {
            density: source.iter().enumerate().map(haze).collect(),
            largest,
            velocity: given.into_iter().enumerate().map(stirred).collect(),
            shapes,
            faces,
            units: [unit, unit / scene.time.dt],
            emitters: scene.emitters.iter().map(|emitter| emitter.emits).collect(),
            buoyancy: scene.flow.buoyancy,
            dims: cells.len(),
        })
    }

    pub(super) fn density(&self, t: f64) -> Vec<f64> {
        let densities = self.density.iter().enumerate();
        densities.map(|(at, x)| x + t * self.by_density(at)).collect()
    }

    fn by_density(&self, at: usize) -> f64 {
        self.largest * noise(4, 0, 0, at)
    }

    pub(super) fn velocity(&self, t: f64) -> Vec<Vec<f64>> {
        let moved = |(axis, v): (usize, &Vec<f64>)| {
            let faces = v.iter().enumerate();
            faces.map(|(at, v)| v + t * self.by_velocity(axis, at)).collect()
        };
        self.velocity.iter().enumerate().map(moved).collect()
    }

    fn by_velocity(&self, axis: usize, at: usize) -> f64 {
        self.units[0] * noise(5, 0, axis, at)
    }

    pub(super) fn shapes(&self, t: f64) -> Vec<Vec<f64>> {
        let moved = |(index, shape): (usize, &Vec<f64>)| {
            let cells = shape.iter().enumerate();
            cells
                .map(|(at, x)| x * (1.0 + t * noise(6, index, 0, at)))
                .collect()
        };
        self.shapes.iter().enumerate().map(moved).collect()
    }

    /// Adds the force of a step.
    pub(super) fn push(&self, step: usize, t: f64, given: &mut Given<'_, f64>) {
        for (axis, &len) in self.faces.iter().enumerate() {
            let force = |at: usize| {
                self.units[1] * (PUSH[0] * noise(7, step, axis, at) + t * PUSH[1] * noise(8, step, axis, at))
            };
            let force: Vec<f64> = (0..len).map(force).collect();
            given.vector(axis, &force);
        }
    }

    /// <gradient, direction> of a component of the force of a step.
    pub(super) fn along_force(&self, step: usize, axis: usize, gradient: &[f64]) -> f64 {
        let faces = gradient.iter().enumerate();
        let terms = faces.map(|(at, g)| g * self.units[1] * PUSH[1] * noise(8, step, axis, at));
        terms.sum()
    }

    /// The numbers of the direction: of buoyancy, of a rate or target, of an emitter's velocity.
    fn by_buoyancy(&self, axis: usize) -> f64 {
        PUSH[1] * self.units[1] / self.largest * noise(9, 0, axis, 0)
    }

    fn by_supply(emitter: &Emitter, index: usize) -> f64 {
        let (Supply::Rate(x) | Supply::Target(x)) = emitter.supply;
        x * noise(10, index, 0, 0)
    }

    fn by_jet(&self, index: usize, axis: usize) -> f64 {
        self.units[0] * noise(11, index, axis, 0)
    }

    /// The problem at `t` along the direction.
    pub(super) fn moved(&self, problem: &OwnedProblem, t: f64) -> OwnedProblem {
        let moved = |(index, emitter): (usize, &Emitter)| {
            let by = t * Self::by_supply(emitter, index);
            Emitter {
                supply: match emitter.supply {
                    Supply::Rate(rate) => Supply::Rate(rate + by),
                    Supply::Target(target) => Supply::Target(target + by),
                },
                velocity: emitter.velocity.map(|v| {
                    core::array::from_fn(|axis| {
                        let by = if axis < self.dims {
                            t * self.by_jet(index, axis)
                        } else {
                            0.0
                        };
                        v.get(axis).copied().unwrap_or(0.0) + by
                    })
                }),
                ..*emitter
            }
        };
        let buoyancy = |axis: usize| {
            let by = if axis < self.dims {
                t * self.by_buoyancy(axis)
            } else {
                0.0
            };
            self.buoyancy.get(axis).copied().unwrap_or(0.0) + by
        };
        OwnedProblem {
            emitters: self.emitters.iter().enumerate().map(moved).collect(),
            buoyancy: core::array::from_fn(buoyancy),
            ..problem.clone()
        }
    }

    /// <gradient, direction> of each input, after the operator's way back.
    pub(super) fn along<S: Space>(
        &self,
        operator: &Operator<'_, f64, S>,
        by_force: f64,
    ) -> [f64; INPUTS.len()] {
        let (view, mut field) = (operator.gradient(), vec![0.0; operator.cells()]);
        view.read_density(&mut field);
        let by_density = field
            .iter()
            .enumerate()
            .map(|(at, g)| g * self.by_density(at))
            .sum();
        let mut by_velocity = 0.0;
        for (axis, &len) in self.faces.iter().enumerate() {
            let mut faces = vec![0.0; len];
            view.read_vector(axis, &mut faces);
            let terms = faces
                .iter()
                .enumerate()
                .map(|(at, g)| g * self.by_velocity(axis, at));
            by_velocity += terms.sum::<f64>();
        }
        let of_buoyancy = operator.buoyancy_gradient();
        let axes = of_buoyancy.iter().enumerate().take(self.dims);
        let by_buoyancy = axes.map(|(axis, g)| g * self.by_buoyancy(axis)).sum();
        let (mut by_supply, mut by_jet, mut by_shape) = (0.0, 0.0, 0.0);
        for (index, (emitter, shape)) in self.emitters.iter().zip(&self.shapes).enumerate() {
            let gradient = operator.emitter_gradient(index);
            by_supply += gradient.supply * Self::by_supply(emitter, index);
            if emitter.velocity.is_some() {
                let axes = gradient.velocity.iter().enumerate().take(self.dims);
                by_jet += axes.map(|(axis, g)| g * self.by_jet(index, axis)).sum::<f64>();
            }
            operator.shape_gradient(index).read_density(&mut field);
            let cells = field.iter().zip(shape).enumerate();
            by_shape += cells
                .map(|(at, (g, x))| g * x * noise(6, index, 0, at))
                .sum::<f64>();
        }
        [
            by_density,
            by_velocity,
            by_force,
            by_buoyancy,
            by_supply,
            by_jet,
            by_shape,
        ]
    }
}
