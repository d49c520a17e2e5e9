//! One call of AO by the core on a trajectory: the data term of the flow, and its gradient.

use crate::fields::{Components, Memory, view, view_mut, zeros};
use core::ops::ControlFlow;
use thurible_core::exec::ranks::Alone;
use thurible_core::grid::Grid;
use thurible_core::grid::levels::Levels;
use thurible_core::grid::solids::Surfaces;
use thurible_core::memory::Arena;
use thurible_core::memory::{Ledger, Pool};
use thurible_core::method::admm::ao::{self, Fields, Setup};
use thurible_core::method::lbfgs::evaluate::{Push, Simulated, Warm};
use thurible_core::method::templates::search::Search;
use thurible_core::objective::flow::{self, Evaluation};
use thurible_core::objective::script::{Lists, Script};
use thurible_core::objective::sweep;
use thurible_core::operators::blur::Metric;
use thurible_core::optimise::descent::Function;
use thurible_core::optimise::quasi_newton::fields;
use thurible_core::optimise::quasi_newton::history::History;
use thurible_core::{Advection, Boundary, D2, D3, Event, Objective, Observer, Real, Serial, Silent, Space};

/// A flow that should carry `source` to the targets.
pub struct Control<'a, T> {
    pub grid: &'a Grid,
    pub steps: usize,
    /// Density at step 0, rho_0.
    pub source: &'a [T],
    /// Keyframes, emitters and the schedule.
    pub lists: Lists<'a>,
    /// The fields that go with them, one after the other.
    pub fields: &'a [T],
    /// Acceleration where the density is 1.
    pub buoyancy: [f64; 3],
    /// Which cells are solid; none, or one flag each.
    pub solid: &'a [bool],
    /// Whether the flow sticks to them and to walls.
    pub sticks: bool,
    /// Velocity at step 0, v_0.
    pub initial: &'a Components<T>,
    pub advection: Advection,
    /// Filters of the metric.
    pub filters: usize,
    pub penalty: f64,
    /// Kinematic viscosity nu.
    pub viscosity: f64,
    /// s^2 of the price of curls, in box lengths squared.
    pub smoothing: f64,
}

/// What a call found.
pub struct Found<T> {
    /// Q(v + lambda/K + A_v^T mu / K) - v*, of the last iteration.
    pub direction: Components<T>,
    /// What AO says of itself.
    pub info: ao::Info,
}

impl<T: Real> Control<'_, T> {
    /// One call of AO with `iterations` from v with multipliers lambda / K.
    pub fn solve(&self, v: &Components<T>, multiplier: &Components<T>, iterations: usize) -> Found<T> {
        let (grid, slots) = (self.grid, self.steps - 1);
        let setup = Setup {
            penalty: self.penalty,
            iterations,
            momentum: 0.0,
            flow: self.flow(1.0),
        };
        let mut sums = vec![0.0; grid.rows() * slots.max(2)];
        let mut memory = Memory::new(1 << 20);
        let levels = self.levels(memory.block());
        let mut ledger = Ledger::new();
        ao::measure::<T>(&levels, &setup, &mut Pool::measuring(&mut ledger));
        let mut region = vec![T::ZERO; ledger.elements(T::BYTES)];
        let (mut star, mut direction) = (v.clone(), zeros(grid, slots));
        let mut rho = self.source.repeat(self.steps + 1);
        let script = Script::new(self.lists, self.fields);
        let fields = Fields {
            v: view(v),
            multiplier: view(multiplier),
            star: view_mut(&mut star),
            direction: view_mut(&mut direction),
            initial: view(self.initial),
            rho: &mut rho,
            script: &script,
        };
        let mut step = 1.0;
        let solve = if grid.dims == 2 {
            ao::solve::<T, D2>
        } else {
            ao::solve::<T, D3>
        };
        let info = solve(
            &Serial,
            &mut Silent,
            &levels,
            &setup,
            fields,
            &mut step,
            &mut region,
            &mut sums,
        )
        .unwrap();
        Found { direction, info }
    }

    fn surfaces(&self) -> Surfaces {
        Surfaces {
            obstacles: !self.solid.is_empty(),
            stick: self.sticks,
        }
    }

    fn levels<'m>(&self, block: &'m mut [core::mem::MaybeUninit<u8>]) -> Levels<'m, T> {
        let mut levels = Levels::bare(self.grid, self.filters).with_surfaces(self.surfaces());
        levels.fill(&mut Arena::new(block)).unwrap();
        levels.set_solids(&Alone, |cell| self.solid.get(cell).copied().unwrap_or(false));
        levels
    }

    fn sweep(&self) -> sweep::Setup {
        let metric = Metric {
            filters: self.filters,
            identity: 1.0,
        };
        sweep::Setup {
            slots: self.steps - 1,
            metric,
            stepping: self.advection.into(),
            largest: 1.0,
            threads: 1,
            surfaces: self.surfaces(),
            overlap: false,
        }
    }

    fn flow(&self, force_weight: f64) -> flow::Setup {
        flow::Setup {
            sweep: self.sweep(),
            viscosity: self.viscosity,
            force_weight,
            smoothing: self.smoothing,
            scheduled: !self.lists.knots.is_empty(),
            masked: self.lists.mask,
            buoyancy: self.buoyancy,
            projection_tolerance: 1e-13,
        }
    }

    /// The objective of the direct method at v with force weight r, and its gradient.
    pub fn direct<S: Space>(&self, v: &Components<T>, force_weight: f64) -> (Objective, Components<T>) {
        let (grid, slots) = (self.grid, self.steps - 1);
        let mut memory = Memory::new(1 << 20);
        let levels = self.levels(memory.block());
        let mut ledger = Ledger::new();
        Evaluation::<T>::measure(&levels, 0, &self.sweep(), &mut Pool::measuring(&mut ledger));
        let (mut priced, mut divided) = (zeros(grid, slots), zeros(grid, slots));
        let mut evaluation = Evaluation {
            priced: view_mut(&mut priced),
            divided: view_mut(&mut divided),
            levels: &levels,
            level: 0,
            setup: self.flow(force_weight),
            initial: view(self.initial),
            rho: &mut self.source.repeat(self.steps + 1),
            script: Script::new(self.lists, self.fields),
            region: &mut vec![T::from_f64(f64::NAN); ledger.elements(T::BYTES)],
            sums: &mut vec![0.0; 4 * grid.rows()],
        };
        let (mut w, mut gradient) = (zeros(grid, slots), zeros(grid, slots));
        let value = evaluation
            .value::<S>(
                &Serial,
                &mut Silent,
                view(v),
                &mut view_mut(&mut w),
                f64::INFINITY,
            )
            .unwrap();
        evaluation
            .gradient::<S>(
                &Serial,
                &mut Silent,
                view(v),
                view(&w),
                &mut view_mut(&mut gradient),
            )
            .unwrap();
        (value, gradient)
    }

    /// The objective of the forces u with force weight r, and its gradient, with steps solved to `tolerance`; the work of both.
    pub fn simulated<S: Space>(
        &self,
        u: &Components<T>,
        force_weight: f64,
        tolerance: f64,
    ) -> (Objective, Components<T>, [usize; 2]) {
        let (grid, slots) = (self.grid, self.steps - 1);
        let mut memory = Memory::new(1 << 20);
        let levels = self.levels(memory.block());
        let mut ledger = Ledger::new();
        Simulated::<T>::measure(&levels, &self.flow(1.0), false, &mut Pool::measuring(&mut ledger));
        let (mut priced, mut divided) = (zeros(grid, slots), zeros(grid, slots));
        let evaluation = Evaluation {
            priced: view_mut(&mut priced),
            divided: view_mut(&mut divided),
            levels: &levels,
            level: 0,
            setup: self.flow(force_weight),
            initial: view(self.initial),
            rho: &mut self.source.repeat(self.steps + 1),
            script: Script::new(self.lists, self.fields),
            region: &mut vec![T::from_f64(f64::NAN); ledger.elements(T::BYTES)],
            sums: &mut vec![0.0; 4 * grid.rows()],
        };
        let mut simulated = Simulated {
            evaluation,
            tolerance,
        };
        let (rest, mut v, mut gradient) = (zeros(grid, slots), zeros(grid, slots), zeros(grid, slots));
        let warm = Warm {
            v: view(&rest),
            change: (view(&rest), 0.0),
        };
        let mut work = [Work(0), Work(0)];
        let value = simulated
            .value::<S>(
                &Serial,
                &mut work[0],
                view(u),
                warm,
                &mut view_mut(&mut v),
                f64::INFINITY,
            )
            .unwrap();
        simulated
            .gradient::<S>(
                &Serial,
                &mut work[1],
                Push::by(view(u)),
                view(&v),
                &mut view_mut(&mut gradient),
            )
            .unwrap();
        (value, gradient, work.map(|work| work.0))
    }
}

impl Control<'_, f64> {
    /// The objective of the unknowns `z` of templates with force weight r, and its gradient, with steps solved to 1e-13.
    pub fn searched<S: Space>(&self, z: &[f64], force_weight: f64) -> (Objective, Vec<f64>) {
        let (grid, slots) = (self.grid, self.steps - 1);
        let unknowns = Grid::new(&[z.len()], &[Boundary::Wall]);
        let mut memory = Memory::new(1 << 20);
        let levels = self.levels(memory.block());
        let mut ledger = Ledger::new();
        Simulated::<f64>::measure(&levels, &self.flow(1.0), true, &mut Pool::measuring(&mut ledger));
        let mut region = vec![f64::NAN; ledger.elements(8)];
        let mut ledger = Ledger::new();
        fields::take(
            &unknowns,
            1,
            History::full(1),
            &mut Pool::<f64>::measuring(&mut ledger),
        );
        let mut pairs = vec![f64::NAN; ledger.elements(8)];
        let [mut priced, mut u, mut v, mut trial, mut gradient] = [(); 5].map(|()| zeros(grid, slots));
        let evaluation = Evaluation {
            priced: view_mut(&mut priced),
            divided: Default::default(),
            levels: &levels,
            level: 0,
            setup: self.flow(force_weight),
            initial: view(self.initial),
            rho: &mut self.source.repeat(self.steps + 1),
            script: Script::new(self.lists, self.fields),
            region: &mut region,
            sums: &mut vec![0.0; z.len().max(19) * grid.rows()],
        };
        let mut search = Search {
            simulated: Simulated {
                evaluation,
                tolerance: 1e-13,
            },
            unknowns,
            z: &mut z.to_vec(),
            u: view_mut(&mut u),
            v: view_mut(&mut v),
            trial: view_mut(&mut trial),
            gradient: view_mut(&mut gradient),
            fields: fields::take(&unknowns, 1, History::full(1), &mut Pool::new(&mut pairs)),
            scale: &mut 1.0,
        };
        let function: &mut dyn Function<f64, S> = &mut search;
        let value = function.value(&Serial, &mut Silent, 0, f64::INFINITY).unwrap();
        function.gradient(&Serial, &mut Silent, 0, 1).unwrap();
        (value, search.fields[1][0].to_vec())
    }
}

/// Counts pieces of work.
struct Work(usize);

impl Observer for Work {
    fn on(&mut self, event: Event) -> ControlFlow<()> {
        self.0 += usize::from(event == Event::Work);
        ControlFlow::Continue(())
    }
}
