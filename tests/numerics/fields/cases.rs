//! Control problems for the whole solver.

use super::effects::Effects;
use super::flow::swirl;
use super::{Components, Memory, boundaries, grid, places, to_file};
use core::ops::ControlFlow;
use thurible_core::grid::Grid;
use thurible_core::{
    Advection, Boundary, Event, Exec, Method, Observer, Params, Plan, Problem, Progress, Real, Scheme,
    Serial, Silent, Solver, Space, Status,
};

/// A problem with its densities.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Cells along each axis.
    pub cells: Vec<usize>,
    /// How the axes end.
    pub boundary: Vec<Boundary>,
    pub length: f64,
    pub dt: f64,
    pub steps: usize,
    /// Steps of the keyframes.
    pub keyframes: Vec<usize>,
    /// Kinematic viscosity nu.
    pub viscosity: f64,
    /// Weight r of the force.
    pub force_weight: f64,
    pub scheme: Scheme,
    /// Where its series is cut, in parts of max rho_0.
    pub cut: f64,
    pub params: Params,
    /// rho_0 and the keyframes.
    pub densities: Vec<Vec<f64>>,
    pub effects: Effects,
}

/// The choices of a solve by ADMM.
pub fn admm() -> Params {
    Params {
        method: Method::Admm,
        ..Params::default()
    }
}

/// Soft balls of `radius` around centres in box lengths.
pub fn balls(grid: &Grid, centres: &[[f64; 3]], radius: f64) -> Vec<f64> {
    let largest = 1.0 / grid.h[0];
    let middle = |at: [usize; 3], a: usize| {
        if a < grid.dims {
            (at[a] as f64 + 0.5) / largest
        } else {
            0.5
        }
    };
    let one = |at: [usize; 3], centre: &[f64; 3]| {
        let distance = (0..3)
            .map(|a| (middle(at, a) - if a < grid.dims { centre[a] } else { 0.5 }).powi(2))
            .sum::<f64>()
            .sqrt();
        0.5 - 0.5 * ((distance - radius) / grid.h[0]).tanh()
    };
    places(grid)
        .map(|at| centres.iter().map(|centre| one(at, centre)).sum::<f64>().min(1.0))
        .collect()
}

impl Scene {
    /// A ball that should be elsewhere at the end: a small problem of any shape.
    pub fn small(cells: &[usize], ends: &str, steps: usize) -> Self {
        // Shapes have no cells outside.
        let grid = grid(cells, "www");
        let side = |a: usize| {
            if a < cells.len() {
                cells[a] as f64 * grid.h[0]
            } else {
                1.0
            }
        };
        let at = |x: f64, y: f64| [x * side(0), y * side(1), 0.5 * side(2)];
        let radius = 0.25 * (0..cells.len()).map(side).fold(1.0, f64::min);
        Scene {
            cells: cells.to_vec(),
            boundary: boundaries(ends),
            length: 1.0,
            dt: 1.0,
            steps,
            keyframes: vec![steps],
            viscosity: 0.0,
            force_weight: 1e2,
            scheme: Scheme::Quick,
            cut: 1e-5,
            params: Params {
                iterations: 3,
                ..admm()
            },
            densities: vec![
                balls(&grid, &[at(0.4, 0.45)], radius),
                balls(&grid, &[at(0.6, 0.55)], radius),
            ],
            effects: Effects::default(),
        }
    }

    /// Circle to two circles, 32 x 32 x 20, the case of the prototypes.
    pub fn two_circles() -> Self {
        let grid = grid(&[32, 32], "ww");
        let (one, two) = (
            balls(&grid, &[[0.5, 0.5, 0.5]], 0.2),
            balls(&grid, &[[0.3, 0.5, 0.5], [0.7, 0.5, 0.5]], 0.14),
        );
        let params = Params {
            iterations: 25,
            ..admm()
        };
        Scene {
            force_weight: 1e3,
            scheme: Scheme::Central,
            params,
            densities: vec![one, two],
            ..Self::small(&[32, 32], "ww", 20)
        }
    }

    /// As the core takes it.
    pub fn problem(&self) -> Problem<'_> {
        Problem {
            cells: &self.cells,
            share: None,
            boundary: &self.boundary,
            length: self.length,
            dt: self.dt,
            steps: self.steps,
            keyframes: &self.keyframes,
            keyframe_weights: &self.effects.weights,
            keyframe_regions: !self.effects.regions.is_empty(),
            emitters: &self.effects.emitters,
            solids: !self.effects.solid.is_empty(),
            buoyancy: self.effects.buoyancy,
            templates: &self.effects.templates,
            release: self.effects.release,
            schedule: &self.effects.schedule,
            mask: !self.effects.mask.is_empty(),
            viscosity: self.viscosity,
            slip: !self.effects.sticks,
            force_weight: self.force_weight,
            smoothness: None,
            filters: None,
            match_mass: !self.effects.keep_mass,
            advection: Advection {
                scheme: self.scheme,
                tolerance: self.cut,
            },
            projection_tolerance: 1e-5,
        }
    }

    pub fn plan<T: Real, S: Space>(&self) -> Plan {
        Plan::new::<T, S>(&self.problem(), &self.params).unwrap()
    }

    /// Calls `work` with a solver that has its densities, in a block filled with `fill`.
    pub fn with_fill<T: Real, S: Space, R>(
        &self,
        fill: u8,
        work: impl FnOnce(&mut Solver<'_, T, S>) -> R,
    ) -> R {
        let mut memory = Memory::filled(self.plan::<T, S>().bytes(), fill);
        let mut solver = Solver::<T, S>::new(&self.problem(), &self.params, memory.block()).unwrap();
        if !self.effects.solid.is_empty() {
            solver.set_solids(&self.effects.solid).unwrap();
        }
        solver.set_source(&super::cast(&self.densities[0])).unwrap();
        self.set_rest(&mut solver);
        work(&mut solver)
    }

    /// Gives a solver that has its source all other densities.
    pub fn set_rest<T: Real, S: Space>(&self, solver: &mut Solver<'_, T, S>) {
        for (index, shape) in self.effects.shapes.iter().enumerate() {
            solver.set_emitter(index, &super::cast(shape)).unwrap();
        }
        for (index, region) in self.effects.regions.iter().enumerate() {
            solver.set_region(index, &super::cast(region)).unwrap();
        }
        if !self.effects.mask.is_empty() {
            solver.set_mask(&super::cast(&self.effects.mask)).unwrap();
        }
        if self.params.method == Method::Guide {
            self.set_reference(solver);
        }
        for (index, target) in self.densities[1..].iter().enumerate() {
            solver.set_keyframe(index, &super::cast(target)).unwrap();
        }
    }

    /// The flow that guides: a swirl that grows slower, at half a cell a step to begin with.
    pub fn reference(&self, step: usize) -> Components<f64> {
        let grid = self.problem().grid();
        swirl(&grid, 1, 0.5 / (1.0 + step as f64))
    }

    /// Gives a solver the flow that guides.
    pub fn set_reference<T: Real, S: Space>(&self, solver: &mut Solver<'_, T, S>) {
        let grid = self.problem().grid();
        for step in 1..self
            .problem()
            .steps
            .min(self.effects.release.unwrap_or(usize::MAX))
        {
            let flow = self.reference(step);
            for axis in 0..S::DIM {
                let faces = super::cast(&to_file(&grid, axis, &flow[axis]));
                solver.set_reference(axis, step, &faces).unwrap();
            }
        }
    }

    /// As [`Self::with_fill`], in a block filled with 0xA5.
    pub fn with<T: Real, S: Space, R>(&self, work: impl FnOnce(&mut Solver<'_, T, S>) -> R) -> R {
        self.with_fill(0xA5, work)
    }

    pub fn solve<T: Real, S: Space>(&self, exec: &dyn Exec, observer: &mut dyn Observer) -> Solved {
        self.with::<T, S, _>(|solver| Solved::run(self, solver, exec, observer))
    }

    /// Solves it on one thread.
    pub fn solve_alone<T: Real, S: Space>(&self) -> Solved {
        self.solve::<T, S>(&Serial, &mut Silent)
    }
}

/// What a solve left, in double precision and the scene's units.
pub struct Solved {
    pub status: Status,
    /// What every iteration said.
    pub history: Vec<Progress>,
    /// The objective: data and force.
    pub objective: [f64; 2],
    /// Densities rho_0 .. rho_N.
    pub density: Vec<Vec<f64>>,
    /// v_0 .. v_{N-1}, components as in files.
    pub velocity: Vec<Vec<Vec<f64>>>,
    /// Forces u_0 .. u_{N-2}, each by component.
    pub force: Vec<Vec<Vec<f64>>>,
    /// The keyframes' targets, after scaling.
    pub targets: Vec<Vec<f64>>,
}

impl Solved {
    /// Solves to the end.
    pub fn run<T: Real, S: Space>(
        scene: &Scene,
        solver: &mut Solver<'_, T, S>,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
    ) -> Self {
        let mut history = Vec::new();
        let status = solver.solve(exec, observer, &mut |progress| history.push(progress.clone()));
        Self::read(scene, solver, status, history)
    }

    /// Reads the result of a solver that finished.
    pub fn read<T: Real, S: Space>(
        scene: &Scene,
        solver: &Solver<'_, T, S>,
        status: Status,
        history: Vec<Progress>,
    ) -> Self {
        let vector = |take: &dyn Fn(usize, &mut [T])| {
            let component = |axis| {
                let mut out = vec![T::from_f64(f64::NAN); solver.faces(axis)];
                take(axis, &mut out);
                super::cast(&out)
            };
            (0..S::DIM).map(component).collect::<Vec<Vec<f64>>>()
        };
        let objective = solver.objective();
        Solved {
            status,
            history,
            objective: [objective.data, objective.force],
            density: (0..=scene.steps)
                .map(|i| super::cast(solver.density(i)))
                .collect(),
            velocity: (0..scene.steps)
                .map(|i| vector(&|axis, out| solver.velocity(i, axis, out)))
                .collect(),
            force: (0..scene.steps - 1)
                .map(|i| vector(&|axis, out| solver.force(i, axis, out)))
                .collect(),
            targets: (0..scene.keyframes.len())
                .map(|i| super::cast(solver.keyframe(i)))
                .collect(),
        }
    }

    /// All numbers of the result, bit by bit.
    pub fn bits(&self) -> Vec<u64> {
        let faces = self.velocity.iter().chain(&self.force).flatten().flatten();
        self.density
            .iter()
            .flatten()
            .chain(faces)
            .chain(&self.objective)
            .map(|x| x.to_bits())
            .collect()
    }
}

/// Says stop at event `at`.
pub struct StopAt {
    /// Events before the stop.
    pub at: usize,
    pub seen: usize,
}

impl Observer for StopAt {
    fn on(&mut self, _event: Event) -> ControlFlow<()> {
        self.seen += 1;
        if self.seen > self.at {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// Says stop at one event alone.
pub struct StopOnce {
    /// Its number, from 1 on.
    pub at: usize,
    pub seen: usize,
}

impl Observer for StopOnce {
    fn on(&mut self, _event: Event) -> ControlFlow<()> {
        self.seen += 1;
        if self.seen == self.at {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}
