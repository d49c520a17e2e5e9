//! Down to the coarsest grid before the first iteration, up grid by grid, and the end.

use super::Direct;
use super::level::{NextMut, down};
use super::setup::{slots_on, stride};
use crate::exec::{Capped, Exec};
use crate::field::slot::put_everywhere;
use crate::field::{reborrow, rows, view};
use crate::grid::Space;
use crate::memory::Pool;
use crate::objective::coarse::{self, Scene, SceneMut};
use crate::objective::script::Script;
use crate::observe::{Observer, Silent};
use crate::optimise::descent::Descent;
use crate::progress::{Objective, Status};
use crate::real::Real;

impl<T: Real, S: Space> Direct<'_, T, S> {
    /// Passes the scene down to the coarsest grid that takes part, where the flow begins as v_0 in all slots; that grid.
    pub(super) fn begin(&mut self, exec: &dyn Exec, script: &Script<'_, T>) -> usize {
        let coarsest = self.threads.len() - 1;
        let setup = self.setup;
        let (levels, mut at) = self.finest(script);
        for (level, grid) in levels.grids.iter().skip(1).take(coarsest).enumerate() {
            let mut next = NextMut::within(grid, slots_on(&setup, level + 1), script.fields(), at.rest);
            let fine = Scene {
                source: &at.rho[..levels.grids[level].cells()],
                initial: view(&at.initial),
                script: &at.script,
            };
            let coarse = SceneMut {
                source: &mut next.rho[..grid.cells()],
                initial: reborrow(&mut next.initial),
                fields: &mut *next.fields,
            };
            coarse::restrict(exec, levels, level, &fine, coarse, next.rest);
            let [coarser, finer] = [level + 1, level].map(|level| stride(&setup, level));
            next.initial
                .iter_mut()
                .for_each(|initial| rows::scale_in_place(initial, T::from_f64(f64::from(coarser / finer))));
            at = next.complete(script, coarser);
        }
        let slots = slots_on(&setup, coarsest);
        put_everywhere(exec, &levels.grids[coarsest], view(&at.initial), &mut at.v, slots);
        self.level = Some(coarsest);
        coarsest
    }

    /// Forgets how the descent went on another grid, and whoever went along it.
    fn begin_descent(&mut self) {
        self.descent = Descent::new(self.setup.history);
        self.there = None;
    }

    /// Begins on the finest grid with v as it is, projected; whether that is a flow.
    pub(super) fn begin_on_finest(&mut self, exec: &dyn Exec, script: &Script<'_, T>) -> bool {
        self.level = Some(0);
        self.begin_descent();
        let mut work = self.work(0, script);
        let tolerance = work.evaluation.setup.projection_tolerance;
        let projected = work.evaluation.project(exec, &mut Silent, &mut work.v, tolerance);
        let usable = projected.is_ok_and(f64::is_finite);
        drop(work);
        if !usable {
            self.level = None;
        }
        usable
    }

    /// Prolongs the flow to the next finer grid and goes on there.
    pub(super) fn ascend(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
    ) -> Result<(), Status> {
        self.fetch_flow(exec, script);
        let setup = self.setup;
        let fine = self.level.unwrap_or(0).saturating_sub(1);
        let [slots, few] = [fine, fine + 1].map(|level| slots_on(&setup, level));
        let (levels, finest) = self.finest(script);
        let at = down(levels, &setup, finest, fine);
        let grid = &levels.grids[fine + 1];
        let coarse = NextMut::within(grid, few, script.fields(), at.rest);
        let mut pool = Pool::new(coarse.rest);
        let v = if slots == few {
            coarse.v
        } else {
            let mut v = pool.take_vector("velocity", S::DIM, grid.cells() * slots);
            coarse::refine_time(
                exec,
                grid,
                few,
                view(&coarse.initial),
                view(&coarse.v),
                reborrow(&mut v),
            );
            v
        };
        coarse::prolong(exec, levels, fine, slots, view(&v), at.v, pool.into_rest());
        self.level = Some(fine);
        self.begin_descent();
        let mut work = self.work(fine, script);
        let exec = &Capped::new(exec, work.evaluation.setup.sweep.threads);
        work.evaluation
            .project(
                exec,
                observer,
                &mut work.v,
                work.evaluation.setup.projection_tolerance,
            )
            .map(drop)
            .map_err(|_| Status::Cancelled)
    }

    /// Up to the finest grid, v projected, its densities, and its force in the field of the direction; the objective.
    pub(crate) fn make_feasible(
        &mut self,
        exec: &dyn Exec,
        script: &Script<'_, T>,
    ) -> Result<Objective, Status> {
        if self.level.is_none() {
            self.begin(exec, script);
        }
        while self.level.is_some_and(|level| level > 0) {
            self.ascend(exec, &mut Silent, script)?;
        }
        self.fetch_flow(exec, script);
        self.begin_descent();
        let force = self.descent.newton.direction;
        let stepping = self.setup.flow.sweep.stepping;
        let mut work = self.work(0, script);
        work.evaluation.setup.sweep.stepping = stepping;
        work.evaluation
            .finish::<S>(exec, &mut work.v, &mut work.fields[force])
    }
}
