//! The buffers of a simulation and its control, said once.

use super::cells::Cells;
use super::conjugate::Stopping;
use super::fields::{self, Flow, Physics, pitch};
use super::params::{Adjoint, FluidsParams, Pressure};
use super::project::Solve;
use super::slots::Slots;
use super::template::{SUMS, Shape};
use super::unknowns::Unknowns;
use super::{Fluids, Search};
use crate::grid::{Boundary, Grid, Space};
use crate::memory::{Layout, TooSmall};
use crate::operators::blur::{along_len, widest};
use crate::optimise::descent::Descent;
use crate::optimise::quasi_newton::history::{History, MAX_PAIRS};
use crate::problem::{PACKED, Problem};
use crate::progress::Objective;
use crate::real::Real;
use core::marker::PhantomData;

/// The most rows that a list of unknowns is cut into, for threads.
const MOST_ROWS: u32 = 6;

/// A list of so many numbers as a grid of rows: the same for any number of threads.
fn list(numbers: usize) -> Grid {
    let rows = 1 << numbers.trailing_zeros().min(MOST_ROWS);
    let mut list = Grid::new(&[numbers / rows, rows], &[Boundary::Wall; 2]);
    list.dims = 1;
    list
}

fn physics(problem: &Problem<'_>, params: &FluidsParams) -> Physics {
    let per_step = problem.dt / (problem.length * problem.length);
    let stopping = Stopping {
        tolerance: params.cg_tolerance,
        most: params.cg_iterations,
    };
    Physics {
        viscosity: problem.scaled_viscosity(),
        diffusion: params.diffusion * per_step,
        buoyancy: problem.scaled_buoyancy(),
        sweeps: params.sweeps,
        solve: match params.pressure {
            Pressure::GaussSeidel => Solve::Sweeps(params.sweeps),
            Pressure::Conjugate => Solve::Conjugate(stopping, params.adjoint),
        },
    }
}

/// Whether the adjoint reads all iterations of conjugate gradients.
fn exact(params: &FluidsParams) -> bool {
    params.pressure == Pressure::Conjugate && params.adjoint == Adjoint::Exact
}

impl<'m, T: Real, S: Space> Fluids<'m, T, S> {
    /// One without memory.
    #[inline(never)]
    pub(super) fn bare(problem: &Problem<'_>, params: &FluidsParams) -> Self {
        let cells = Cells::new(problem.cells, problem.boundary);
        let templates = problem.templates.iter().copied();
        let unknowns = Unknowns::new(&cells, problem.steps, params.controls, templates);
        let units = problem.units();
        Self {
            params: *params,
            units,
            length: problem.length,
            match_mass: problem.match_mass,
            unknowns,
            prices: [
                problem.scaled_force_weight(),
                params.initial_weight * units.velocity * units.velocity,
            ],
            filters: problem.filters(),
            keys: problem.keyframes.len(),
            placed: problem.templates.len(),
            flow: Flow {
                cells,
                grid: cells.grid(),
                physics: physics(problem, params),
                fields: &mut [],
                conjugate: &mut [],
                tape: Default::default(),
                force: Default::default(),
                sums: &mut [],
            },
            z: &mut [],
            list: list(pitch::<T>(unknowns.total())),
            fields: (0..History::full(params.history).fields())
                .map(|_| Default::default())
                .collect(),
            slots: &mut [],
            kept: &mut [],
            source: &mut [],
            keyframes: &mut [],
            metric: Default::default(),
            initial: Default::default(),
            steps: &mut [],
            numbers: &mut [],
            taps: &mut [],
            mass: 0.0,
            descent: Descent::new(History::full(params.history)),
            scale: 1.0,
            taped: false,
            repeated: 0,
            of_buoyancy: [0.0; 3],
            begun: false,
            iteration: 0,
            objective: Objective::default(),
            fingerprint: 0,
            saved_bytes: 0,
            space: PhantomData,
        }
    }

    /// Numbers of a state that is kept, or of the tape of a step.
    pub(super) fn kept_len(&self) -> usize {
        match self.params.slots {
            Slots::None => 0,
            Slots::Tape => Flow::<T>::tape_len(&self.flow.cells, exact(&self.params)),
            Slots::States(_) => Flow::<T>::state_len(&self.flow.cells),
        }
    }

    /// How many of them there are.
    fn kept_count(&self) -> usize {
        match self.params.slots {
            Slots::None => 0,
            Slots::Tape => self.unknowns.steps,
            Slots::States(slots) => slots,
        }
    }

    /// Every buffer, in order.
    pub(super) fn layout(&mut self, layout: &mut Layout<'_, 'm, T>) -> Result<(), TooSmall> {
        let cells = self.flow.cells;
        let (dims, plain, padded) = (cells.dims, pitch::<T>(cells.count()), pitch::<T>(cells.padded));
        let unknowns = pitch::<T>(self.unknowns.total());
        let searched = !self.params.controls.is_empty();
        layout.keep("unknowns", &mut self.z, unknowns)?;
        layout.keep_each(
            "gradient, direction and pairs of unknowns",
            self.fields.iter_mut().map(|[field, ..]| field),
            if searched { unknowns } else { 0 },
        )?;
        let (count, len) = (self.kept_count(), self.kept_len());
        let name = match self.params.slots {
            Slots::Tape => "what the adjoint reads of every step",
            _ => "states that are kept",
        };
        layout.work(name, &mut self.slots, count * len)?;
        layout.work(
            "a step and its adjoint",
            &mut self.flow.fields,
            fields::fields(dims) * padded,
        )?;
        let conjugate = self.params.pressure == Pressure::Conjugate;
        layout.work(
            "conjugate gradients",
            &mut self.flow.conjugate,
            if conjugate { 5 * padded } else { 0 },
        )?;
        let iterations = if exact(&self.params) && self.params.slots != Slots::None {
            self.params.cg_iterations
        } else {
            0
        };
        let [fields, scalars] = &mut self.flow.tape;
        layout.work(
            "iterations of conjugate gradients",
            fields,
            2 * iterations * plain,
        )?;
        layout.work("their factors", scalars, 3 * iterations)?;
        layout.keep("source", &mut self.source, plain)?;
        layout.keep("keyframes", &mut self.keyframes, self.keys * plain)?;
        let [e, image] = &mut self.metric;
        layout.work("error of a keyframe", e, plain)?;
        layout.work("its image in the metric", image, plain)?;
        layout.work_vector("force of a step", &mut self.flow.force, dims, cells.count())?;
        if self.params.initial_velocity {
            let len = cells.count();
            layout.keep_vector("velocity at the start", &mut self.initial, (dims, len), None)?;
        }
        self.small(layout)
    }

    /// What takes little.
    fn small(&mut self, layout: &mut Layout<'_, 'm, T>) -> Result<(), TooSmall> {
        let (cells, params) = (self.flow.cells, self.params);
        layout.work("steps of states", &mut self.kept, params.slots.states())?;
        layout.work("steps of keyframes", &mut self.steps, self.keys)?;
        let numbers = self.keys + PACKED * self.placed + Shape::len(&cells);
        layout.work("weights, templates and their factors", &mut self.numbers, numbers)?;
        let taps = if self.keys == 0 {
            0
        } else {
            along_len(&self.flow.grid, widest(self.filters), params.threads)
        };
        layout.work("Gaussian taps and rows", &mut self.taps, taps)?;
        let of_list = History::full(MAX_PAIRS).sums_per_row() + 2;
        let sums = (SUMS * self.flow.grid.rows()).max(of_list * self.list.rows());
        layout.work("sums of rows", &mut self.flow.sums, sums)
    }

    /// The search at the unknowns as they are.
    pub(super) fn search(&mut self) -> Search<'_, 'm, T> {
        let len = self.kept_len();
        let (weights, rest) = self.numbers.split_at_mut_checked(self.keys).unwrap_or_default();
        let (templates, factors) = rest
            .split_at_mut_checked(PACKED * self.placed)
            .unwrap_or_default();
        let [e, image] = self.metric.each_mut();
        Search {
            given: super::given::Given {
                unknowns: self.unknowns,
                source: self.source.get(..self.flow.cells.count()).unwrap_or_default(),
                initial: crate::field::view(&self.initial),
                keyframes: self.keyframes,
                pitch: pitch::<T>(self.flow.cells.count()),
                steps: self.steps,
                weights,
                templates,
                prices: self.prices,
                filters: self.filters,
                threads: self.params.threads,
            },
            work: super::script::Work {
                metric: [e, image],
                taps: self.taps,
                factors,
            },
            kept: super::search::Kept {
                slots: self.params.slots,
                fields: self.slots,
                len,
                steps: self.kept,
                taped: self.taped,
                repeated: 0,
            },
            flow: &mut self.flow,
            z: self.z,
            list: self.list,
            fields: &mut self.fields,
            scale: &mut self.scale,
        }
    }
}
