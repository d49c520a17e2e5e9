//! What a scene may have beside source, keyframes and a flow, and the second implementation of it.

use super::cases::{Scene, balls};
use super::naive::Naive;
use super::{Components, boundaries, grid, places};
use thurible_core::grid::Grid;
use thurible_core::{Emitter, Feature, Method, Named, NsoSolver, Scheme, Supply, Template, TemplateKind};

/// All of it; nothing by default.
#[derive(Clone, Debug, Default)]
pub struct Effects {
    /// What each keyframe's data term is multiplied by, 1 where there is none.
    pub weights: Vec<f64>,
    /// What the keyframes' errors are multiplied by, cell by cell; none, or one for each.
    pub regions: Vec<Vec<f64>>,
    pub emitters: Vec<Emitter>,
    /// The emitters' shapes.
    pub shapes: Vec<Vec<f64>>,
    /// Which cells are solid; none, or one flag each.
    pub solid: Vec<bool>,
    /// Whether the flow sticks to walls and solid cells.
    pub sticks: bool,
    /// Acceleration where the density is 1.
    pub buoyancy: [f64; 3],
    pub templates: Vec<Template>,
    pub release: Option<usize>,
    /// Step and factor of the force's price.
    pub schedule: Vec<(usize, f64)>,
    /// Where force may act, cell by cell; none where it may everywhere.
    pub mask: Vec<f64>,
    /// Whether keyframes keep the mass that they are given.
    pub keep_mass: bool,
}

/// Whether a method lets smoke out.
pub fn knows_open_sides(method: Method) -> bool {
    !matches!(method, Method::Guide | Method::Templates)
}

/// A block in the middle and a plate one cell thick beside it.
pub fn block(grid: &Grid) -> Vec<bool> {
    let inside = |at: [usize; 3]| {
        let middle = (0..grid.dims).all(|a| (3 * grid.n[a] / 8..grid.n[a] / 2 + 1).contains(&at[a]));
        middle || (at[0] == grid.n[0] - 3 && at[1] < grid.n[1] / 2)
    };
    places(grid).map(inside).collect()
}

impl Scene {
    /// The same with everything that its method can do: a small scene of one keyframe at its last step gets two steps more.
    pub fn with_everything(self) -> Self {
        let (steps, ends): (usize, String) = (self.steps, self.ends());
        let grid = grid(&self.cells, &ends);
        let side = |a: usize| self.cells.get(a).map_or(1.0, |&n| n as f64 * grid.h[0]);
        let ball = |x: f64, y: f64| {
            balls(
                &grid,
                &[[x * side(0), y * side(1), 0.5 * side(2)]],
                0.15 * side(1),
            )
        };
        let region = |at: usize| if at.is_multiple_of(3) { 0.5 } else { 1.0 };
        let mut scene = Self {
            steps: steps + 2,
            effects: Effects {
                weights: vec![2.0],
                regions: vec![(0..grid.cells()).map(region).collect(); self.keyframes.len()],
                emitters: vec![
                    Emitter {
                        from: 0,
                        to: steps + 1,
                        supply: Supply::Rate(0.1),
                        velocity: Some([0.02, 0.05, -0.03].map(|v: f64| v * (16.0 * grid.h[0]).min(1.0))),
                    },
                    Emitter {
                        from: 1,
                        to: steps + 1,
                        supply: Supply::Target(0.8),
                        velocity: None,
                    },
                ],
                shapes: vec![ball(0.3, 0.3), ball(0.6, 0.3)],
                solid: Vec::new(),
                sticks: false,
                buoyancy: [1e-4, -2e-4, if grid.dims == 3 { 3e-4 } else { 0.0 }],
                templates: Vec::new(),
                release: Some(steps),
                schedule: vec![(0, 2.0), (steps - 1, 0.5)],
                mask: (0..grid.cells()).map(|at| region(at + 1)).collect(),
                keep_mass: true,
            },
            ..self
        };
        if scene.params.method == Method::Templates {
            scene = scene.with_templates();
        }
        let takes = |feature| thurible_core::method::registry::takes(&scene.params, feature);
        let [lifts, schedules, masks] = [Feature::Buoyancy, Feature::Schedule, Feature::Mask].map(takes);
        if !lifts {
            scene.effects.buoyancy = [0.0; 3];
        }
        if !takes(Feature::Jets) {
            scene
                .effects
                .emitters
                .iter_mut()
                .for_each(|emitter| emitter.velocity = None);
        }
        if !schedules {
            scene.effects.schedule.clear();
        }
        if !masks {
            scene.effects.mask.clear();
        }
        scene
    }

    /// The same among solid cells, by `limited` transport.
    pub fn among_solids(mut self) -> Self {
        self.scheme = Scheme::Limited;
        self.effects.solid = block(&self.problem().grid());
        self
    }

    /// The same in a box whose axes end otherwise, some of them open: by `limited` transport, and ADMM by Newton's method.
    pub fn in_open_box(mut self, ends: &str) -> Self {
        (self.scheme, self.boundary) = (Scheme::Limited, boundaries(ends));
        self.effects.keep_mass = true;
        self.params.admm.nso.solver = NsoSolver::NewtonCg;
        self
    }

    /// The same with a template of each kind.
    pub fn with_templates(mut self) -> Self {
        let most = self.cells.iter().copied().max().unwrap_or(1) as f64;
        let sides = core::array::from_fn(|a| self.cells.get(a).map_or(1.0, |&n| n as f64 / most));
        self.effects.templates = templates(&sides, self.steps);
        self
    }

    /// A letter for each axis.
    fn ends(&self) -> String {
        let letter = |&end: &thurible_core::Boundary| match end {
            thurible_core::Boundary::Wall => 'w',
            thurible_core::Boundary::Periodic => 'p',
            thurible_core::Boundary::Open => 'o',
            thurible_core::Boundary::OpenLow => 'l',
            thurible_core::Boundary::OpenHigh => 'h',
        };
        self.boundary.iter().map(letter).collect()
    }
}

/// One of each kind in a box of these sides: some move, some have several amplitudes.
pub fn templates(sides: &[f64; 3], steps: usize) -> Vec<Template> {
    let one = |(index, kind): (usize, TemplateKind)| Template {
        from: (index % 2).min(steps - 2),
        interval: 2 + index,
        moves: index != 2,
        size: 0.3,
        ..Template::new(
            kind,
            sides.map(|side| (0.4 + 0.1 * index as f64) * side),
            0.2,
            steps,
        )
    };
    TemplateKind::ALL.iter().copied().enumerate().map(one).collect()
}

impl Effects {
    /// `rho`, which was carried to `step`, with what is emitted on the way there.
    pub fn emit(&self, step: usize, rho: &mut [f64]) {
        let acts = |emitter: &&Emitter| emitter.from < step && step <= emitter.to;
        for (emitter, shape) in self.emitters.iter().zip(&self.shapes) {
            if let (true, Supply::Rate(rate)) = (acts(&emitter), emitter.supply) {
                rho.iter_mut()
                    .zip(shape)
                    .for_each(|(rho, shape)| *rho += rate * shape);
            }
        }
        for (emitter, shape) in self.emitters.iter().zip(&self.shapes) {
            if let (true, Supply::Target(target)) = (acts(&emitter), emitter.supply) {
                for (rho, shape) in rho.iter_mut().zip(shape) {
                    *rho += if *shape > 0.0 {
                        (target * shape - *rho).max(0.0)
                    } else {
                        0.0
                    };
                }
            }
        }
    }

    /// The acceleration by `rho` at faces, in the unit of the acceleration.
    pub fn lift(&self, naive: &Naive, rho: &[f64]) -> Components<f64> {
        naive.at_faces(|axis, at| {
            let low = naive.step(at, axis, -1).map(|low| rho[naive.id(low)]);
            low.map_or(0.0, |low| 0.5 * self.buoyancy[axis] * (low + rho[naive.id(at)]))
        })
    }

    /// `u` divided by the mask of its faces.
    pub fn divided(&self, naive: &Naive, u: &Components<f64>) -> Components<f64> {
        naive.at_faces(|axis, at| {
            let here = naive.id(at);
            let low = naive.step(at, axis, -1).map_or(here, |low| naive.id(low));
            let mask = |cell: usize| self.mask.get(cell).copied().unwrap_or(1.0);
            u[axis][here] / (0.5 * (mask(here) + mask(low))).max(1e-3)
        })
    }

    /// The acceleration by emitters at faces where the velocity is `v`, on its way from `step` to the next.
    pub fn push(&self, naive: &Naive, step: usize, v: &Components<f64>) -> Components<f64> {
        naive.at_faces(|axis, at| {
            let Some(low) = naive.step(at, axis, -1).map(|low| naive.id(low)) else {
                return 0.0;
            };
            let before = v[axis][naive.id(at)];
            let mut now = before;
            for (emitter, shape) in self.emitters.iter().zip(&self.shapes) {
                if let (true, Some(velocity)) = ((emitter.from..emitter.to).contains(&step), emitter.velocity)
                {
                    let e = shape[low].min(shape[naive.id(at)]).min(1.0);
                    now += e * (velocity[axis] - now);
                }
            }
            now - before
        })
    }

    /// What the price of the force in `slot` is multiplied by.
    pub fn factor(&self, slot: usize) -> f64 {
        let at = slot as f64;
        let Some(next) = self.schedule.iter().position(|&(step, _)| step >= slot) else {
            return self.schedule.last().map_or(1.0, |&(_, factor)| factor);
        };
        let (step, factor) = self.schedule[next];
        match next.checked_sub(1).map(|before| self.schedule[before]) {
            None => factor,
            Some((first, earlier)) => {
                let part = (at - first as f64) / (step - first) as f64;
                (earlier.ln() + part * (factor / earlier).ln()).exp()
            }
        }
    }
}
