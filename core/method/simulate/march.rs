//! From step to step, and what is made of the flow that was simulated.

use super::MARCH;
use super::drive::Drive;
use super::forward::Simulation;
use super::guide::Guide;
use super::setup::Push;
use super::step::Step;
use crate::exec::Exec;
use crate::field::slot::{Slot, clear, put, put_everywhere};
use crate::field::view;
use crate::force::lift::Lift;
use crate::force::mask::{By, Mask};
use crate::force::template::Placed;
use crate::grid::Space;
use crate::memory::Pool;
use crate::method::animation::Animation;
use crate::method::contract::Followed;
use crate::objective::script::Script;
use crate::objective::script::jets::Jets;
use crate::objective::sweep::DensitySweep;
use crate::observe::{Event, Observer, Silent};
use crate::progress::{Objective, Status};
use crate::real::Real;
use crate::transport::{Flow, Stop};

/// Says that v_k is known, of so many.
fn say(observer: &mut dyn Observer, k: usize, slots: usize) -> Result<(), Stop> {
    let said = observer.on(Event::PhaseStep {
        phase: MARCH,
        step: k,
        value: slots as f64,
        taken: 0.0,
    });
    if said.is_break() {
        return Err(Stop::Cancelled);
    }
    Ok(())
}

impl<T: Real, S: Space> Simulation<'_, T, S> {
    /// Simulates all steps.
    pub(super) fn march(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
    ) -> Result<(), Stop> {
        let slots = self.animation.slots;
        let Animation {
            levels, initial, v, ..
        } = &mut self.animation;
        if self.setup.guide().is_none() {
            put_everywhere(exec, &levels.finest, view(initial), v, slots);
        }
        self.marched = Followed::InPart;
        if observer.on(Event::IterationBegin { iteration: 1 }).is_break() {
            return Err(Stop::Cancelled);
        }
        say(observer, 0, slots)?;
        for k in 1..=slots {
            let kept = match self.push(exec, observer, script, k) {
                Ok(kept) => kept,
                Err(stop) => return Err(self.without(exec, k - 1, stop)),
            };
            self.advance(exec, observer, k, kept)?;
            say(observer, k, slots)?;
        }
        self.carry(exec, observer, script, slots)
            .map_err(|stop| self.without(exec, slots, stop))?;
        self.marched = Followed::Whole;
        Ok(())
    }

    /// v_k from the part `kept` of v_{k-1} and the force in slot k of w.
    fn advance(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        k: usize,
        kept: f64,
    ) -> Result<(), Stop> {
        let step_setup = self.setup.step();
        let slots = self.animation.slots;
        let Animation {
            levels,
            v,
            initial,
            sums,
            ..
        } = &mut self.animation;
        let mut pool = Pool::new(self.region);
        let mut step = Step::carve(levels, 0, step_setup, &mut pool);
        let at = |k: usize| Slot::at(k, view(initial), view(v), slots);
        let (before, earlier) = (at(k - 1), at(k.saturating_sub(2)));
        let force = Slot {
            field: view(&self.w),
            slots,
            slot: k - 1,
        };
        step.give(exec, [(kept, before), (1.0, force)]);
        step.guess(exec, [(2.0, before), (-1.0, earlier)]);
        step.advance::<S>(exec, observer, sums)?;
        if let Some(params) = self.setup.guide() {
            let mut guide = Guide::carve(levels, params, step_setup.threads, &mut pool);
            let reference = at(k);
            step.stir(exec, observer, &mut guide, k, sums)?;
            step.guide(exec, observer, &mut guide, reference, sums)?;
        }
        put(exec, &levels.finest, view(&step.v), v, k - 1);
        Ok(())
    }

    /// Puts v_0 in the place of v_step where that was too fast to carry a density, and in those after it where they hold a given flow: what was
    /// simulated before it is a result.
    fn without(&mut self, exec: &dyn Exec, step: usize, stop: Stop) -> Stop {
        if let (Stop::TooFast, Some(slot)) = (stop, step.checked_sub(1)) {
            let Animation {
                levels,
                initial,
                v,
                slots,
                ..
            } = &mut self.animation;
            let end = if self.setup.guide().is_some() {
                *slots
            } else {
                slot + 1
            };
            (slot..end).for_each(|slot| put(exec, &levels.finest, view(initial), v, slot));
        }
        stop
    }

    /// Density k and, in slot k of w, its buoyancy and the force that it asks for; what v_{k-1} keeps of its momentum.
    fn push(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
        k: usize,
    ) -> Result<f64, Stop> {
        self.carry(exec, observer, script, k - 1)?;
        let Self {
            animation,
            w,
            region,
            setup,
            ..
        } = self;
        let Animation {
            levels, rho, sums, ..
        } = animation;
        let grid = &levels.finest;
        let kept = match setup.push {
            Push::Nothing | Push::Reference(_) => {
                clear(exec, grid, w, k - 1);
                let (slots, solids) = (animation.slots, levels.solids(0));
                for template in script.templates() {
                    let placed = Placed::new(grid, solids, slots, template);
                    placed.add(exec, &|_| template.amplitude, rho, (k - 1..k, 0), w);
                }
                1.0
            }
            Push::Target(pd) => {
                let (next, steps) = script.next(k);
                let mut drive = Drive::carve(
                    levels,
                    setup.flow.sweep.metric,
                    setup.flow.sweep.threads,
                    &mut Pool::new(region),
                );
                let rho = &rho[k * grid.cells()..][..grid.cells()];
                drive.load(exec, rho, script.target(next, grid.cells()));
                let [kept, impulse] = pd.step(steps);
                drive.force(exec, impulse, w, k - 1, sums);
                let mask = Mask {
                    grid,
                    slots: animation.slots,
                    cells: script.mask(grid.cells()),
                };
                mask.weigh(exec, By::Factor(0.0), k - 1..k, w);
                kept
            }
        };
        self.lift(exec, script, k);
        Ok(kept)
    }

    /// Adds what the densities and the emitters ask for to slot k of w.
    fn lift(&mut self, exec: &dyn Exec, script: &Script<'_, T>, k: usize) {
        let Animation {
            levels,
            rho,
            v,
            initial,
            slots,
            ..
        } = &mut self.animation;
        let (grid, slots, solids) = (&levels.finest, *slots, levels.solids(0));
        let acceleration = self.setup.flow.buoyancy;
        let lift = Lift {
            grid,
            slots,
            solids,
            acceleration,
        };
        lift.add(exec, 1.0, rho, k - 1..k, &mut self.w);
        let before = Slot::at(k - 1, view(initial), view(v), slots);
        let jets = Jets {
            grid,
            solids,
            script: *script,
        };
        jets.add(exec, [1.0, -1.0], k - 1, before, (&mut self.w, k - 1));
    }

    /// Density `step + 1` from the one before.
    fn carry(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
        step: usize,
    ) -> Result<(), Stop> {
        let Self {
            animation,
            region,
            setup,
            ..
        } = self;
        let Animation {
            levels,
            v,
            initial,
            rho,
            sums,
            ..
        } = animation;
        let grid = &levels.finest;
        let flow = Flow {
            initial: view(initial),
            v: view(v),
            along: None,
        };
        let mut sweep = DensitySweep::carve(levels, 0, &setup.flow.sweep, &mut Pool::new(region));
        sweep.carry_step(exec, observer, &flow, rho, step, script, sums)?;
        if let Push::Target(pd) = setup.push
            && pd.gathering > 0.0
        {
            let rho = &mut rho[(step + 1) * grid.cells()..][..grid.cells()];
            let (next, steps) = script.next(step + 1);
            let target = script.target(next, grid.cells());
            let mut drive = Drive::carve(
                levels,
                setup.flow.sweep.metric,
                setup.flow.sweep.threads,
                &mut Pool::new(region),
            );
            drive.load(exec, rho, target);
            drive.gather(exec, pd.gathering / steps as f64, rho, target, sums)?;
        }
        Ok(())
    }

    /// Sets all forces to 0: where nothing acts they are but what equations left.
    pub fn forget_forces(&mut self) {
        self.w.iter_mut().for_each(|component| component.fill(T::ZERO));
    }

    /// Projects v, takes the forces from it, and transports rho_0 by it, but where densities were gathered; the objective.
    pub(super) fn make_feasible(
        &mut self,
        exec: &dyn Exec,
        script: &Script<'_, T>,
    ) -> Result<Objective, Status> {
        let gathered = matches!(self.setup.push, Push::Target(pd) if pd.gathering > 0.0)
            && self.marched == Followed::Whole;
        let flow = self.setup.flow;
        let w = &mut self.w;
        let (mut evaluation, v) = self.animation.evaluation(flow, script, self.region);
        let mut objective = Objective::default();
        if gathered {
            objective.data = evaluation.data(exec, usize::MAX);
            evaluation
                .force::<S>(exec, &mut Silent, view(v), w)
                .map_err(|_| Status::Cancelled)?;
        } else {
            objective = evaluation.finish::<S>(exec, v, w)?;
        }
        // Where hardly any force acts the first projection leaves more than there is.
        let force = evaluation
            .projected::<S>(exec, &mut Silent, w)
            .map_err(|_| Status::Cancelled)?;
        let objective = Objective {
            data: objective.data,
            ..force
        };
        if objective.total().is_finite() {
            Ok(objective)
        } else {
            Err(Status::NotFinite)
        }
    }
}
