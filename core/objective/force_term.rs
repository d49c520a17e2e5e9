//! The force that a flow needs, and its part of the objective.

use crate::exec::Exec;
use crate::field::slot::Slot;
use crate::field::trajectory::{self, Shape};
use crate::field::{Vector, VectorMut, reborrow, rows, sums, view};
use crate::force::lift::Lift;
use crate::force::mask::{By, Mask};
use crate::force::{self, price};
use crate::grid::Space;
use crate::objective::flow::Evaluation;
use crate::objective::script::jets::Jets;
use crate::observe::{Observer, Silent};
use crate::operators::self_advection::Fluid;
use crate::progress::Objective;
use crate::real::Real;
use crate::transport::Stop;
use core::ops::Range;

impl<'a, T: Real> Evaluation<'a, '_, T> {
    /// Where its trajectories live.
    #[must_use]
    pub fn shape(&self) -> Shape<'a> {
        Shape {
            grid: &self.levels.grids[self.level],
            slots: self.setup.sweep.slots,
        }
    }

    /// A fluid in all slots of this grid, of which nu is `viscosity`.
    pub(super) fn fluid(&self, viscosity: f64) -> Fluid<'a> {
        let Shape { grid, slots } = self.shape();
        Fluid {
            grid,
            slots,
            viscosity,
            solids: self.levels.solids(self.level),
        }
    }

    /// Buoyancy on this grid.
    #[must_use]
    pub fn lift(&self) -> Lift<'a> {
        let Shape { grid, slots } = self.shape();
        Lift {
            grid,
            slots,
            solids: self.levels.solids(self.level),
            acceleration: self.setup.buoyancy,
        }
    }

    /// Where force may act on this grid.
    fn mask(&self) -> Mask<'a, T> {
        let Shape { grid, slots } = self.shape();
        Mask {
            grid,
            slots,
            cells: self.script.mask(grid.cells()),
        }
    }

    /// What emitters do to the flow of this grid.
    #[must_use]
    pub fn jets(&self) -> Jets<'a, T> {
        Jets {
            grid: self.shape().grid,
            solids: self.levels.solids(self.level),
            script: self.script,
        }
    }

    /// Elements of the region in which a force is computed.
    pub(super) fn force_scratch(&self) -> Range<usize> {
        let Shape { grid, slots } = self.shape();
        0..self.setup.sweep.threads * force::scratch_per_thread(grid, slots)
    }

    /// The force that produces v beside the buoyancy of the densities, and its part of the objective, with no data term.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn force<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        v: Vector<'_, T>,
        w: &mut VectorMut<'_, T>,
    ) -> Result<Objective, Stop> {
        self.acceleration::<S>(exec, v, w);
        self.projected::<S>(exec, observer, w)
    }

    /// What the force would be without a pressure.
    pub(super) fn acceleration<S: Space>(
        &mut self,
        exec: &dyn Exec,
        v: Vector<'_, T>,
        w: &mut VectorMut<'_, T>,
    ) {
        let (fluid, scratch) = (self.fluid(self.setup.viscosity), self.force_scratch());
        let scratch = rows::part_mut(self.region, scratch);
        force::from_velocity::<T, S>(exec, fluid, v, self.initial, &[], reborrow(w), scratch);
        let lift = self.lift();
        lift.add(exec, -1.0, self.rho, 0..lift.slots, w);
        let (jets, slots) = (self.jets(), lift.slots);
        if !jets.is_none() {
            for slot in 0..slots {
                let before = Slot::at(slot, self.initial, v, slots);
                jets.add(exec, [-1.0, 1.0], slot, before, (w, slot));
            }
        }
    }

    /// Projects a force; its part of the objective, with no data term.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn projected<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        w: &mut VectorMut<'_, T>,
    ) -> Result<Objective, Stop> {
        self.project(exec, observer, w, self.setup.projection_tolerance)?;
        Ok(self.price::<S>(exec, view(w)))
    }

    /// `out` = what the price is divided by roughly, times `gradient`: q(1 + s^2 C^T C), and with a mask m the projection of m q m; false,
    /// and nothing done, where that is 1. m is at least `least` here. What [`Self::priced`] held is lost.
    pub fn divide_by_price<S: Space>(
        &mut self,
        exec: &dyn Exec,
        gradient: Vector<'_, T>,
        least: f64,
        out: &mut VectorMut<'_, T>,
    ) -> bool {
        let (mask, shape) = (self.mask(), self.shape());
        if self.setup.smoothing == 0.0 && !mask.there() {
            return false;
        }
        let slots = 0..shape.slots;
        let mut source = gradient;
        if mask.there() {
            trajectory::add(exec, shape, &mut self.divided, 0.0, 1.0, gradient);
            mask.weigh(exec, By::Factor(least), slots.clone(), &mut self.divided);
            source = view(&self.divided);
        }
        if self.setup.smoothing > 0.0 {
            let (fluid, scratch) = (self.fluid(self.setup.smoothing), self.force_scratch());
            let scratch = rows::part_mut(self.region, scratch);
            let work = reborrow(&mut self.priced);
            price::solve::<T, S>(exec, fluid, source, reborrow(out), work, scratch);
        } else {
            trajectory::add(exec, shape, out, 0.0, 1.0, source);
        }
        if mask.there() {
            mask.weigh(exec, By::Factor(least), slots, out);
            // Nobody is asked, since nothing is cut short.
            let _ = self.project(exec, &mut Silent, out, self.setup.projection_tolerance);
        }
        true
    }

    /// The force's part of the objective, r/2 sum <w_k, z_k> with z_k = f_k D (1 + s^2 C^T C) D w_k, which [`Self::priced`] becomes; D is 1
    /// without a mask.
    pub fn price<S: Space>(&mut self, exec: &dyn Exec, w: Vector<'_, T>) -> Objective {
        let (shape, mask) = (self.shape(), self.mask());
        let weight = 0.5 * self.setup.force_weight;
        let plain = weight * sums::sum_squares(exec, shape.grid, shape.slots, w, self.sums);
        if !self.setup.weighs() {
            return Objective::of_force(plain, plain);
        }
        let mut source = w;
        if mask.there() {
            trajectory::add(exec, shape, &mut self.divided, 0.0, 1.0, w);
            mask.weigh(exec, By::Divisor, 0..shape.slots, &mut self.divided);
            source = view(&self.divided);
        }
        if self.setup.smoothing > 0.0 {
            let (fluid, scratch) = (self.fluid(self.setup.smoothing), self.force_scratch());
            let scratch = rows::part_mut(self.region, scratch);
            price::apply::<T, S>(exec, fluid, source, reborrow(&mut self.priced), scratch);
        } else {
            trajectory::add(exec, shape, &mut self.priced, 0.0, 1.0, source);
        }
        mask.weigh(exec, By::Divisor, 0..shape.slots, &mut self.priced);
        if self.setup.scheduled {
            let script = self.script;
            trajectory::scale_slots(exec, shape, &mut self.priced, &|slot| script.factor(slot));
        }
        let price = weight * trajectory::dot(exec, shape, w, view(&self.priced), self.sums);
        Objective::of_force(price, plain)
    }

    /// [`Self::price`] of the force in the first `slots` slots alone.
    pub fn price_of_first<S: Space>(&mut self, exec: &dyn Exec, w: Vector<'_, T>, slots: usize) -> Objective {
        let (all, shape) = (self.price::<S>(exec, w), self.shape());
        if slots >= shape.slots {
            return all;
        }
        let weight = 0.5 * self.setup.force_weight;
        let mut of = |z| weight * trajectory::dot_of_first(exec, shape, slots, [w, z], self.sums);
        let plain = of(w);
        if self.setup.weighs() {
            Objective::of_force(of(view(&self.priced)), plain)
        } else {
            Objective::of_force(plain, plain)
        }
    }

    /// Makes [`Self::priced`], of the force of the last [`Self::price`], the derivative along fields free of divergence: with a mask it has
    /// to be projected for that.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn prepare_gradient(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<(), Stop> {
        if !self.setup.masked {
            return Ok(());
        }
        let mut priced = core::mem::take(&mut self.priced);
        let done = self.project(exec, observer, &mut priced, self.setup.projection_tolerance);
        self.priced = priced;
        done.map(drop)
    }
}
