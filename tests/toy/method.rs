//! Density blurred in time: no flow at all, but a method by its contract, and all that one takes. The densities begin as a blend of the
//! source and the last keyframe, of which rho_k has the part (k / N)^2; an iteration replaces each between rho_0 and rho_N in turn by
//! (rho_{k-1} + 2 rho_k + rho_{k+1}) / 4.

use crate::checkpoint::{Damaged, MANY, Mix, Record};
use crate::memory::{Layout, TooSmall};
use crate::method::contract::{Contract, Parts};
use crate::method::output::{DENSITY, Output, Stored, VELOCITY};
use crate::method::{animation::Animation, params::Params};
use crate::objective::{flow, script::Script};
use crate::progress::{Fact, Kind, Objective, Progress, Status};
use crate::{exec::Exec, field::rows, grid::Space, observe::Observer, problem::Problem, real::Real};

const CHANGE: Fact = Fact::new("change", Kind::Number, "largest change of a density").in_chart("Blur");
const BLEND: Output = Output {
    name: "blend",
    words: "density before it is blurred",
    ..DENSITY
};

/// The densities and what they were before.
#[derive(Debug)]
pub struct Toy<'m, T, S> {
    animation: Animation<'m, T>,
    blend: &'m mut [T],
    region: &'m mut [T],
    setup: flow::Setup,
    iteration: usize,
    iterations: usize,
    space: core::marker::PhantomData<S>,
}

impl<'m, T: Real, S: Space> Contract<'m, T, S> for Toy<'m, T, S> {
    fn new(problem: &Problem<'_>, params: &Params) -> Self {
        let setup = flow::Setup::new(problem, params.threads);
        Self {
            animation: Animation::new(&problem.grid(), &setup.sweep),
            blend: &mut [],
            region: &mut [],
            setup,
            iteration: 0,
            iterations: params.iterations,
            space: core::marker::PhantomData,
        }
    }

    fn mix(_: &Params, _: &mut Mix) {}

    fn animation(&self) -> &Animation<'m, T> {
        &self.animation
    }

    fn parts(&mut self) -> Parts<'_, 'm, T> {
        Parts {
            animation: &mut self.animation,
            setup: &mut self.setup,
            region: self.region,
        }
    }

    fn layout(&mut self, layout: &mut Layout<'_, 'm, T>) -> Result<(), TooSmall> {
        let (animation, threads) = (&mut self.animation, self.setup.sweep.threads);
        let (cells, rows) = (animation.grid().cells(), animation.grid().rows());
        animation.layout(layout, 2 * rows)?;
        layout.keep("blend", &mut self.blend, cells * (animation.slots + 2))?;
        layout.in_turn(&mut self.region, 0, |ledger| {
            animation.measure_initial(threads, ledger)
        })
    }

    fn scalars(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        record.count(&mut self.iteration, MANY)
    }

    fn step(
        &mut self,
        _: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
        progress: &mut Progress,
    ) -> Result<(), Status> {
        progress.begin(self.iteration + 1, observer)?;
        let (cells, rho) = (self.animation.grid().cells(), &mut *self.animation.rho);
        if self.iteration == 0 {
            let target = script.target(script.keyframes() - 1, cells);
            for at in cells..rho.len() {
                let (cell, part) = (at % cells, (at / cells) as f64 / (rho.len() / cells - 1) as f64);
                rho[at] = rho[cell] + (target[cell] - rho[cell]) * T::from_f64(part * part);
            }
            self.blend.copy_from_slice(rho);
        }
        let mut change = 0.0;
        for at in cells..rho.len() - cells {
            let blurred = (rho[at - cells] + rho[at] + rho[at] + rho[at + cells]) * T::from_f64(0.25);
            change = (blurred - rho[at]).to_f64().abs().max(change);
            rho[at] = blurred;
        }
        self.iteration += 1;
        progress.report.tell(CHANGE, &[change]);
        progress.objective.data = rows::sum_square_gaps(rho, self.blend);
        (self.iteration < self.iterations)
            .then_some(())
            .ok_or(Status::MaxIterations)
    }

    fn finish(&mut self, _: &dyn Exec, _: &Script<'_, T>) -> Result<Objective, Status> {
        let data = rows::sum_square_gaps(self.animation.rho, self.blend);
        Ok(Objective::of_data(data))
    }

    fn outputs(&self) -> &'static [Output] {
        &[DENSITY, VELOCITY, BLEND]
    }

    fn own(&self, _: &Output, step: usize) -> Stored<'_, T> {
        Stored::of_cells(self.blend, step, self.animation.grid().cells())
    }
}
