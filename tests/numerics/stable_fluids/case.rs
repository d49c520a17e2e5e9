//! What the tests of Stable Fluids share.

use crate::fields::random::Random;
use crate::fields::{Memory, boundaries, cast};
use core::ops::ControlFlow;
use thurible_core::method::refusal::PlanError;
use thurible_core::stable_fluids::{Control, Controls, Moment, Slots};
use thurible_core::{
    Boundary, Exec, Fluids, FluidsParams, FluidsPlan, Objective, Problem, Real, Serial, Silent, Space,
    Template, TemplateKind,
};

/// Bytes of a plan.
pub fn built<T: Real, S: Space>(problem: &Problem<'_>, params: &FluidsParams) -> Result<usize, PlanError> {
    FluidsPlan::new::<T, S>(problem, params).map(|plan| plan.bytes())
}

/// Sees the flow at the start and after every step.
pub fn replay<T: Real, S: Space>(fluids: &mut Fluids<'_, T, S>, mut each: impl FnMut(Moment<'_, '_, T>)) {
    let all = fluids.replay(&Serial, &mut Silent, &mut |moment| {
        each(moment);
        ControlFlow::Continue(())
    });
    all.unwrap();
}

/// A scene with everything that moves a flow, in lengths and times of its own.
pub struct Scene {
    pub cells: Vec<usize>,
    pub boundary: Vec<Boundary>,
    pub keys: Vec<usize>,
    pub templates: Vec<Template>,
    pub steps: usize,
    pub force_weight: f64,
    pub params: FluidsParams,
    pub source: Vec<f64>,
    pub keyframes: Vec<Vec<f64>>,
}

/// The two templates of a scene.
pub fn templates(dims: usize, steps: usize) -> Vec<Template> {
    let wind = Template {
        interval: 2,
        moves: true,
        amplitude: [0.02, -0.03, 0.01],
        ..Template::new(TemplateKind::Wind, [0.9, 0.8, 0.7], 0.4, steps)
    };
    let vortex = Template {
        from: 1,
        moves: true,
        amplitude: if dims == 2 {
            [0.1, 0.0, 0.0]
        } else {
            [0.05, -0.02, 0.1]
        },
        ..Template::new(TemplateKind::Vortex, [0.7, 1.0, 0.6], 0.3, steps)
    };
    vec![wind, vortex]
}

impl Scene {
    /// Walls and rings by letter.
    pub fn new(cells: &[usize], ends: &str, controls: &[Control]) -> Self {
        let steps = 5;
        let count = cells.iter().product();
        let mut random = Random::new(7);
        let blob = |random: &mut Random| {
            let at: Vec<f64> = cells
                .iter()
                .map(|&n| (0.3 + 0.4 * random.unit()) * n as f64)
                .collect();
            let density = |index: usize| {
                let (x, rest) = (index % cells[0], index / cells[0]);
                let place = [x, rest % cells[1], rest / cells[1]];
                let square: f64 = at
                    .iter()
                    .zip(place)
                    .map(|(c, x)| (x as f64 + 0.5 - c).powi(2))
                    .sum();
                (-square / 8.0).exp() + 0.05
            };
            (0..count).map(density).collect::<Vec<f64>>()
        };
        Scene {
            cells: cells.to_vec(),
            boundary: boundaries(ends),
            keys: vec![3, steps],
            templates: templates(cells.len(), steps),
            steps,
            force_weight: 3.0,
            params: FluidsParams {
                controls: controls.iter().copied().fold(Controls::none(), Controls::with),
                diffusion: 2e-3,
                initial_weight: 2.0,
                initial_velocity: true,
                ..FluidsParams::default()
            },
            source: blob(&mut random),
            keyframes: vec![blob(&mut random), blob(&mut random)],
        }
    }

    pub fn problem(&self) -> Problem<'_> {
        let mut buoyancy = [0.0; 3];
        buoyancy[self.cells.len() - 1] = 0.04;
        Problem {
            length: 2.0,
            dt: 0.5,
            steps: self.steps,
            templates: &self.templates,
            viscosity: 4e-3,
            buoyancy,
            force_weight: self.force_weight,
            ..Problem::new(&self.cells, &self.boundary, &self.keys)
        }
    }

    pub fn count(&self) -> usize {
        self.cells.iter().product()
    }

    /// A smooth velocity, in lengths and times of the scene, of about a cell a step, or of so many.
    pub fn velocity(&self, courant: f64) -> Vec<Vec<f64>> {
        let (nx, ny) = (self.cells[0], self.cells[1]);
        let unit = courant * 2.0 / (0.5 * *self.cells.iter().max().unwrap() as f64);
        (0..self.cells.len())
            .map(|axis| {
                let wave = |index: usize| {
                    let (x, y, z) = (index % nx, index / nx % ny, index / (nx * ny));
                    (0.61 * x as f64 + 0.43 * y as f64 + 0.37 * z as f64 + 2.0 * axis as f64).sin()
                };
                (0..self.count()).map(|index| unit * wave(index)).collect()
            })
            .collect()
    }

    /// Makes it and calls `work`.
    pub fn with<T: Real, S: Space, R>(&self, work: impl FnOnce(&mut Fluids<'_, T, S>) -> R) -> R {
        let problem = self.problem();
        let mut memory = Memory::new(built::<T, S>(&problem, &self.params).unwrap());
        let mut fluids = Fluids::<T, S>::new(&problem, &self.params, memory.block()).unwrap();
        self.fill(&mut fluids);
        work(&mut fluids)
    }

    pub fn fill<T: Real, S: Space>(&self, fluids: &mut Fluids<'_, T, S>) {
        fluids.set_source(&cast::<f64, T>(&self.source)).unwrap();
        for (index, keyframe) in self.keyframes.iter().enumerate() {
            fluids.set_keyframe(index, &cast::<f64, T>(keyframe)).unwrap();
        }
        if self.params.initial_velocity {
            for (axis, velocity) in self.velocity(0.8).iter().enumerate() {
                fluids
                    .set_initial_velocity(axis, &cast::<f64, T>(velocity))
                    .unwrap();
            }
        }
    }

    pub fn kept(mut self, slots: Slots) -> Self {
        self.params.slots = slots;
        self
    }
}

/// Random unknowns in which nothing is still.
pub fn stir<T: Real, S: Space>(fluids: &mut Fluids<'_, T, S>) {
    let mut random = Random::new(11);
    let amplitudes = fluids.unknowns_mut();
    amplitudes
        .iter_mut()
        .for_each(|z| *z += T::from_f64(0.1 * random.signed()));
}

/// J and its gradient.
pub fn gradient<T: Real, S: Space>(
    exec: &dyn Exec,
    fluids: &mut Fluids<'_, T, S>,
) -> (Objective, Vec<T>, usize) {
    let objective = fluids.value(exec, &mut Silent).unwrap();
    let mut gradient = vec![T::ZERO; fluids.unknowns().len()];
    let repeated = fluids.gradient(exec, &mut Silent, &mut gradient).unwrap();
    (objective, gradient, repeated)
}
