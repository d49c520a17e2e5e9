//! The simulation as an operator: its gradients against differences, by each of its inputs and by all at once.

use crate::fields::random::Random;
use crate::fields::{Memory, boundaries, cast, dot};
use crate::gradients::taylor;
use core::f64::consts::TAU;
use thurible_core::operator::{OperatorError, Start};
use thurible_core::{
    Advection, D2, D3, Emitter, Exec, Operator, OperatorParams, OperatorPlan, Problem, Real, Scheme, Serial,
    Silent, Space, Supply, Template, TemplateKind,
};

/// Everything that a simulation follows from and can be differentiated by, in the scene's units and the layout of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inputs {
    pub density: Vec<f64>,
    pub velocity: Vec<Vec<f64>>,
    /// By step and axis.
    pub forces: Vec<Vec<Vec<f64>>>,
    pub buoyancy: Vec<f64>,
    /// Rate or target of each emitter.
    pub supplies: Vec<f64>,
    /// Velocity of each emitter.
    pub jets: Vec<Vec<f64>>,
    pub shapes: Vec<Vec<f64>>,
}

/// The inputs one after the other.
pub const KINDS: [&str; 7] = [
    "density", "velocity", "forces", "buoyancy", "supplies", "jets", "shapes",
];

impl Inputs {
    fn parts(&mut self) -> [Vec<&mut f64>; 7] {
        [
            self.density.iter_mut().collect(),
            self.velocity.iter_mut().flatten().collect(),
            self.forces.iter_mut().flatten().flatten().collect(),
            self.buoyancy.iter_mut().collect(),
            self.supplies.iter_mut().collect(),
            self.jets.iter_mut().flatten().collect(),
            self.shapes.iter_mut().flatten().collect(),
        ]
    }

    /// Each number by `of`, which is told its kind.
    fn map(&self, mut of: impl FnMut(usize, f64) -> f64) -> Self {
        let mut mapped = self.clone();
        for (kind, part) in mapped.parts().into_iter().enumerate() {
            part.into_iter().for_each(|x| *x = of(kind, *x));
        }
        mapped
    }

    /// self + s other.
    pub fn plus(&self, s: f64, other: &Self) -> Self {
        let mut other = other.clone();
        let mut others = other.parts().into_iter().flatten();
        let mut sum = self.clone();
        for x in sum.parts().into_iter().flatten() {
            *x += s * *others.next().unwrap();
        }
        sum
    }

    /// <self, other> over the numbers of the chosen kinds.
    pub fn dot(&self, other: &Self, chosen: impl Fn(usize) -> bool) -> f64 {
        let (mut own, mut other) = (self.clone(), other.clone());
        let pairs = own.parts().into_iter().zip(other.parts()).enumerate();
        pairs
            .filter(|(kind, _)| chosen(*kind))
            .flat_map(|(_, (own, other))| own.into_iter().zip(other))
            .map(|(x, y)| *x * *y)
            .sum()
    }
}

/// A box with a flow in it.
#[derive(Clone, Debug)]
pub struct Case {
    pub cells: Vec<usize>,
    pub ends: &'static str,
    pub steps: usize,
    pub scheme: Scheme,
    /// Where series are cut, in parts of the largest density.
    pub cut: f64,
    pub viscosity: f64,
    pub length: f64,
    pub dt: f64,
    pub emitters: Vec<Emitter>,
    pub solid: Vec<bool>,
    pub templates: Vec<Template>,
    pub params: OperatorParams,
    pub projection_tolerance: f64,
}

impl Case {
    pub fn new(cells: &[usize], ends: &'static str, steps: usize) -> Self {
        Self {
            cells: cells.to_vec(),
            ends,
            steps,
            scheme: Scheme::Limited,
            cut: 1e-5,
            viscosity: 1e-3,
            length: 2.0,
            dt: 0.5,
            emitters: Vec::new(),
            solid: Vec::new(),
            templates: Vec::new(),
            params: OperatorParams {
                tolerance: 1e-12,
                ..OperatorParams::default()
            },
            projection_tolerance: 1e-5,
        }
    }

    /// The same by a scheme without kinks, no series of which is ever cut.
    pub fn smooth(self) -> Self {
        Self {
            scheme: Scheme::Central,
            cut: 1e-200,
            ..self
        }
    }

    /// The same with emitters of both kinds, one of which pushes, over another that pushes too.
    pub fn emitting(mut self) -> Self {
        let emitter = |supply, velocity: [f64; 3]| Emitter {
            from: 0,
            to: self.steps.saturating_sub(1).max(1),
            supply,
            velocity: Some(velocity),
        };
        self.emitters = vec![
            emitter(Supply::Rate(0.2), [0.2, -0.1, 0.05]),
            emitter(Supply::Target(0.9), [-0.1, 0.3, -0.2]),
            Emitter {
                velocity: None,
                ..emitter(Supply::Rate(0.1), [0.0; 3])
            },
        ];
        self
    }

    /// The same with a template of each kind.
    pub fn with_templates(mut self) -> Self {
        let kinds = [
            TemplateKind::Wind,
            TemplateKind::Vortex,
            TemplateKind::Noise,
            TemplateKind::Attract,
        ];
        let make = |kind| Template {
            amplitude: [0.1, -0.05, 0.02],
            ..Template::new(kind, [0.6; 3], 0.4, self.steps)
        };
        self.templates = kinds.map(make).to_vec();
        self
    }

    /// The same with a block and a plate of solid cells.
    pub fn among_solids(mut self) -> Self {
        let n = [
            self.cells[0],
            self.cells[1],
            self.cells.get(2).copied().unwrap_or(1),
        ];
        let solid = |at: usize| {
            let at = [at % n[0], at / n[0] % n[1], at / n[0] / n[1]];
            let block = (0..self.cells.len()).all(|a| (n[a] / 2..n[a] / 2 + 2).contains(&at[a]));
            block || (at[0] == 1 && at[1] < n[1] / 2)
        };
        self.solid = (0..n.iter().product()).map(solid).collect();
        self
    }

    pub fn problem<'a>(
        &'a self,
        boundary: &'a [thurible_core::Boundary],
        emitters: &'a [Emitter],
        b: &[f64],
    ) -> Problem<'a> {
        Problem {
            length: self.length,
            dt: self.dt,
            steps: self.steps,
            viscosity: self.viscosity,
            buoyancy: core::array::from_fn(|a| b.get(a).copied().unwrap_or(0.0)),
            emitters,
            solids: !self.solid.is_empty(),
            templates: &self.templates,
            advection: Advection {
                scheme: self.scheme,
                tolerance: self.cut,
            },
            projection_tolerance: self.projection_tolerance,
            ..Problem::new(&self.cells, boundary, &[])
        }
    }

    /// The emitters with the numbers of `inputs`.
    pub fn emitters(&self, inputs: &Inputs) -> Vec<Emitter> {
        let with = |(emitter, (&supply, jet)): (&Emitter, (&f64, &Vec<f64>))| Emitter {
            supply: match emitter.supply {
                Supply::Rate(_) => Supply::Rate(supply),
                Supply::Target(_) => Supply::Target(supply),
            },
            velocity: emitter
                .velocity
                .map(|_| core::array::from_fn(|a| jet.get(a).copied().unwrap_or(0.0))),
            ..*emitter
        };
        let numbers = inputs.supplies.iter().zip(&inputs.jets);
        self.emitters.iter().zip(numbers).map(with).collect()
    }

    /// Calls `work` with an operator, everything but its start and forces set.
    pub fn with<T: Real, S: Space, R>(
        &self,
        inputs: &Inputs,
        work: impl FnOnce(&mut Operator<'_, T, S>) -> R,
    ) -> R {
        let (boundary, emitters) = (boundaries(self.ends), self.emitters(inputs));
        let problem = self.problem(&boundary, &emitters, &inputs.buoyancy);
        let plan = OperatorPlan::new::<T, S>(&problem, &self.params).unwrap();
        let mut memory = Memory::new(plan.bytes());
        let mut operator = Operator::<T, S>::new(&problem, &self.params, memory.block()).unwrap();
        if !self.solid.is_empty() {
            operator.set_solids(&self.solid).unwrap();
        }
        for (index, shape) in inputs.shapes.iter().enumerate() {
            operator.set_emitter(index, &cast::<f64, T>(shape)).unwrap();
        }
        work(&mut operator)
    }

    /// The plan.
    pub fn plan<T: Real, S: Space>(&self, params: &OperatorParams) -> OperatorPlan {
        let boundary = boundaries(self.ends);
        OperatorPlan::new::<T, S>(&self.problem(&boundary, &self.emitters, &[]), params).unwrap()
    }

    /// Inputs drawn at random: waves with some noise, of `courant` cells a step.
    pub fn draw(&self, seed: u64, courant: f64) -> Inputs {
        let mut random = Random::new(seed);
        let n = self.cells.clone();
        let dims = n.len();
        let most = n.iter().copied().max().unwrap() as f64;
        let cells: usize = n.iter().product();
        let unit = self.length / self.dt / most;
        let ends = boundaries(self.ends);
        let periodic = |a: usize| ends[a] == thurible_core::Boundary::Periodic;
        let faces = |random: &mut Random, axis: usize, size: f64| -> Vec<f64> {
            let extent = |a: usize| match n.get(a) {
                Some(&n) => n + usize::from(a == axis && !periodic(a)),
                None => 1,
            };
            let phase: Vec<f64> = (0..3).map(|_| TAU * random.unit()).collect();
            (0..extent(0) * extent(1) * extent(2))
                .map(|i| {
                    let at = [
                        i % extent(0),
                        i / extent(0) % extent(1),
                        i / extent(0) / extent(1),
                    ];
                    let along = at[axis];
                    if !periodic(axis)
                        && (along == 0 || along == n[axis])
                        && ends[axis] == thurible_core::Boundary::Wall
                    {
                        // What is given on walls counts for nothing, so that no gradient is there either.
                        return 0.0;
                    }
                    let waves = (0..dims).fold(1.0, |product, a| {
                        product * (TAU * at[a] as f64 / n[a] as f64 + phase[a]).sin()
                    });
                    size * (waves + 0.2 * random.signed())
                })
                .collect()
        };
        let in_fluid = |cell: usize| !self.solid.get(cell).copied().unwrap_or(false);
        let density = |random: &mut Random| -> Vec<f64> {
            let phase: Vec<f64> = (0..3).map(|_| TAU * random.unit()).collect();
            (0..cells)
                .map(|i| {
                    let at = [i % n[0], i / n[0] % n[1], i / n[0] / n[1]];
                    let wave: f64 = (0..dims)
                        .map(|a| (TAU * at[a] as f64 / n[a] as f64 + phase[a]).cos())
                        .sum();
                    let inside = if in_fluid(i) { 1.0 } else { 0.0 };
                    inside * (0.5 + 0.4 * wave / dims as f64 + 0.05 * random.signed())
                })
                .collect()
        };
        Inputs {
            density: density(&mut random),
            velocity: (0..dims).map(|a| faces(&mut random, a, courant * unit)).collect(),
            forces: (0..self.steps)
                .map(|_| {
                    (0..dims)
                        .map(|a| faces(&mut random, a, 0.2 * unit / self.dt))
                        .collect()
                })
                .collect(),
            buoyancy: (0..dims).map(|_| 0.2 * random.signed()).collect(),
            supplies: self
                .emitters
                .iter()
                .map(|emitter| match emitter.supply {
                    Supply::Rate(x) | Supply::Target(x) => x,
                })
                .collect(),
            jets: self
                .emitters
                .iter()
                .map(|emitter| match emitter.velocity {
                    Some(v) => v[..dims].to_vec(),
                    None => Vec::new(),
                })
                .collect(),
            shapes: self.emitters.iter().map(|_| density(&mut random)).collect(),
        }
    }

    /// A direction: random, and as large as the inputs are.
    pub fn direction(&self, inputs: &Inputs, seed: u64) -> Inputs {
        let mut random = Random::new(seed);
        inputs.map(|_, x| {
            if x == 0.0 {
                0.0
            } else {
                random.signed() * (0.2 + x.abs())
            }
        })
    }
}

/// Covectors of a trajectory.
#[derive(Clone, Debug)]
pub struct Covectors {
    pub density: Vec<Vec<f64>>,
    pub velocity: Vec<Vec<Vec<f64>>>,
}

impl Covectors {
    pub fn draw(case: &Case, inputs: &Inputs, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let mut like = |x: &[f64]| -> Vec<f64> { x.iter().map(|_| random.signed()).collect() };
        let (mut density, mut velocity) = (Vec::new(), Vec::new());
        for _ in 0..=case.steps {
            density.push(like(&inputs.density));
            velocity.push(inputs.velocity.iter().map(|v| like(v)).collect());
        }
        Self { density, velocity }
    }
}

/// What was simulated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trajectory {
    pub density: Vec<Vec<f64>>,
    pub velocity: Vec<Vec<Vec<f64>>>,
}

impl Trajectory {
    /// The inner product with covectors.
    pub fn with(&self, covectors: &Covectors) -> f64 {
        let density: f64 = self
            .density
            .iter()
            .zip(&covectors.density)
            .map(|(x, y)| dot(x, y))
            .sum();
        let velocity: f64 = self
            .velocity
            .iter()
            .flatten()
            .zip(covectors.velocity.iter().flatten())
            .map(|(x, y)| dot(x, y))
            .sum();
        density + velocity
    }
}

/// Simulates.
pub fn simulate<T: Real, S: Space>(
    operator: &mut Operator<'_, T, S>,
    exec: &dyn Exec,
    inputs: &Inputs,
) -> Result<Trajectory, OperatorError> {
    let (cells, faces): (usize, Vec<usize>) = (
        operator.cells(),
        (0..S::DIM).map(|a| operator.faces_len(a)).collect(),
    );
    let density: Vec<T> = cast(&inputs.density);
    let velocity: Vec<Vec<T>> = inputs.velocity.iter().map(|v| cast(v)).collect();
    let start = Start {
        density: &density,
        velocity: core::array::from_fn(|a| velocity.get(a).map_or(&[][..], |v| v)),
    };
    let mut trajectory = Trajectory::default();
    operator.simulate(
        exec,
        &mut Silent,
        &start,
        &mut |step, given| {
            for (axis, force) in inputs.forces[step].iter().enumerate() {
                given.vector(axis, &cast::<f64, T>(force));
            }
        },
        &mut |step, view| {
            assert_eq!(step, trajectory.density.len());
            let mut rho = vec![T::ZERO; cells];
            view.read_density(&mut rho);
            trajectory.density.push(cast(&rho));
            let read = |axis: usize| {
                let mut v = vec![T::ZERO; faces[axis]];
                view.read_vector(axis, &mut v);
                cast(&v)
            };
            trajectory.velocity.push((0..S::DIM).map(read).collect());
        },
    )?;
    Ok(trajectory)
}

/// The gradient of a linear function of the trajectory that was simulated.
pub fn vjp<T: Real, S: Space>(
    operator: &mut Operator<'_, T, S>,
    exec: &dyn Exec,
    inputs: &Inputs,
    covectors: &Covectors,
) -> Result<Inputs, OperatorError> {
    let faces: Vec<usize> = (0..S::DIM).map(|a| operator.faces_len(a)).collect();
    let mut gradient = inputs.map(|_, _| 0.0);
    let (mut asked, mut shown) = (operator.steps() + 1, operator.steps());
    operator.vjp(
        exec,
        &mut Silent,
        &mut |step, given| {
            for (axis, force) in inputs.forces[step].iter().enumerate() {
                given.vector(axis, &cast::<f64, T>(force));
            }
        },
        &mut |step, given| {
            asked -= 1;
            assert_eq!(step, asked);
            given.density(&cast::<f64, T>(&covectors.density[step]));
            for (axis, v) in covectors.velocity[step].iter().enumerate() {
                given.vector(axis, &cast::<f64, T>(v));
            }
        },
        &mut |step, view| {
            shown -= 1;
            assert_eq!(step, shown);
            for (axis, force) in gradient.forces[step].iter_mut().enumerate() {
                let mut read = vec![T::ZERO; faces[axis]];
                view.read_vector(axis, &mut read);
                *force = cast(&read);
            }
        },
    )?;
    assert_eq!((asked, shown), (0, 0));
    let view = operator.gradient();
    let mut rho = vec![T::ZERO; operator.cells()];
    view.read_density(&mut rho);
    gradient.density = cast(&rho);
    for (axis, v) in gradient.velocity.iter_mut().enumerate() {
        let mut read = vec![T::ZERO; faces[axis]];
        view.read_vector(axis, &mut read);
        *v = cast(&read);
    }
    let b = operator.buoyancy_gradient();
    gradient.buoyancy.copy_from_slice(&b[..S::DIM]);
    for index in 0..inputs.supplies.len() {
        let of = operator.emitter_gradient(index);
        gradient.supplies[index] = of.supply;
        let count = gradient.jets[index].len();
        gradient.jets[index].copy_from_slice(&of.velocity[..count]);
        operator.shape_gradient(index).read_density(&mut rho);
        gradient.shapes[index] = cast(&rho);
    }
    Ok(gradient)
}

/// Taylor's test to second order, along each kind of input alone and along all.
fn check<S: Space>(what: &str, case: &Case, courant: f64, first: f64) {
    let inputs = case.draw(3, courant);
    let covectors = Covectors::draw(case, &inputs, 5);
    let gradient = case.with::<f64, S, _>(&inputs, |operator| {
        simulate(operator, &Serial, &inputs).unwrap();
        vjp(operator, &Serial, &inputs, &covectors).unwrap()
    });
    let direction = case.direction(&inputs, 7);
    let kinds = (0..KINDS.len()).map(Some).chain([None]);
    for chosen in kinds {
        let takes = |kind: usize| chosen.is_none_or(|chosen| chosen == kind);
        let along = direction.map(|kind, x| if takes(kind) { x } else { 0.0 });
        if along.dot(&along, |_| true) == 0.0 {
            continue;
        }
        let slope = gradient.dot(&along, takes);
        let value = |t: f64| {
            let moved = inputs.plus(t, &along);
            case.with::<f64, S, _>(&moved, |operator| {
                simulate(operator, &Serial, &moved).unwrap().with(&covectors)
            })
        };
        let name = chosen.map_or("all", |kind| KINDS[kind]);
        let by_differences = (value(1e-6) - value(-1e-6)) / 2e-6;
        let size = slope.abs().max(by_differences.abs());
        assert!(
            (slope - by_differences).abs() < 2e-6 * size + 1e-9,
            "{what} by {name}: {slope:e} by the adjoint, {by_differences:e} by differences"
        );
        let linear = {
            let left = value(first) - value(0.0) - first * slope;
            left.abs() < 1e-10 * value(0.0).abs()
        };
        // Some functions are linear: by the density, where it pushes nothing and nothing is limited.
        if !linear && case.scheme == Scheme::Central {
            taylor(&format!("{what} by {name}"), first, slope, value);
        }
    }
}

#[test]
fn gradients_by_every_input_are_exact_to_second_order() {
    let case = |cells: &[usize], ends| Case::new(cells, ends, 4).smooth();
    check::<D2>("walls", &case(&[9, 7], "ww"), 0.7, 1e-3);
    check::<D2>("walls and ring", &case(&[7, 10], "pw"), 2.5, 1e-3);
    check::<D2>("rings, emitters", &case(&[8, 8], "pp").emitting(), 0.8, 1e-4);
    check::<D2>("templates", &case(&[8, 9], "ww").with_templates(), 0.5, 1e-3);
    check::<D3>("3D", &case(&[5, 6, 4], "wpw").emitting(), 1.3, 1e-4);
    check::<D3>("triply periodic", &case(&[6, 5, 7], "ppp"), 1.5, 1e-3);
}

#[test]
fn gradients_among_solids_and_open_sides_are_exact() {
    let case = |cells: &[usize], ends| Case::new(cells, ends, 3);
    check::<D2>("limited", &case(&[9, 7], "ww"), 0.7, 1e-4);
    check::<D2>(
        "solids",
        &case(&[9, 8], "wp").among_solids().emitting(),
        0.6,
        1e-4,
    );
    check::<D2>("open", &case(&[9, 8], "ho").emitting(), 0.6, 1e-4);
    check::<D2>(
        "solids, open",
        &case(&[10, 8], "ol").among_solids().with_templates(),
        1.4,
        1e-4,
    );
    check::<D3>(
        "3D solids",
        &case(&[6, 5, 6], "www").among_solids().emitting(),
        0.5,
        1e-4,
    );
    check::<D3>("3D open", &case(&[5, 6, 5], "wol"), 0.5, 1e-4);
}

#[test]
fn one_step_and_other_schemes() {
    check::<D2>(
        "one step",
        &Case::new(&[7, 6], "wp", 1).smooth().emitting(),
        0.6,
        1e-3,
    );
    let quick = Case {
        scheme: Scheme::Quick,
        cut: 1e-200,
        ..Case::new(&[8, 7], "wp", 3)
    };
    check::<D2>("quick", &quick, 0.9, 1e-4);
    let traced = Case {
        scheme: Scheme::SemiLagrangian,
        ..Case::new(&[8, 7], "wp", 3)
    };
    check::<D2>("semi-Lagrangian", &traced, 0.6, 1e-5);
}
