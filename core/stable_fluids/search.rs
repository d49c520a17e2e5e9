//! The objective as a function of the unknowns, for L-BFGS.

use super::fields::Flow;
use super::given::Given;
use super::march::March;
use super::script::{Pricing, Work};
use super::slots::Slots;
use crate::exec::Exec;
use crate::field::trajectory::Shape;
use crate::field::{rows, sums, view};
use crate::grid::Grid;
use crate::observe::Observer;
use crate::optimise::descent::Function;
use crate::optimise::quasi_newton::fields::{Fields, Initial};
use crate::optimise::quasi_newton::recursion::{Borrowed, QuasiNewton};
use crate::progress::Objective;
use crate::real::Real;
use crate::transport::Stop;

/// The largest change of an unknown in the first step that is tried.
const FIRST_STEP: f64 = 0.1;

/// What is kept for the way back.
#[derive(Debug)]
pub struct Kept<'a, T> {
    /// What that is.
    pub slots: Slots,
    /// States, or the tape.
    pub fields: &'a mut [T],
    /// Numbers of each.
    pub len: usize,
    /// The steps of states.
    pub steps: &'a mut [usize],
    /// Whether the tape is that of the unknowns as they are.
    pub taped: bool,
    /// Steps that the last gradient repeated.
    pub repeated: usize,
}

/// The objective at a point that can be moved.
pub struct Search<'a, 'm, T> {
    /// The flow.
    pub flow: &'a mut Flow<'m, T>,
    /// What it follows from.
    pub given: Given<'a, T>,
    /// Where scripts work.
    pub work: Work<'a, T>,
    /// What is kept for the way back.
    pub kept: Kept<'a, T>,
    /// The unknowns.
    pub z: &'a mut [T],
    /// The same as a grid of rows.
    pub list: Grid,
    /// Gradients, directions and pairs.
    pub fields: &'a mut Fields<'m, T>,
    /// The first inverse Hessian: so many times the gradient.
    pub scale: &'a mut f64,
}

impl<T: Real> Search<'_, '_, T> {
    fn pricing<'s>(
        given: Given<'s, T>,
        work: &'s mut Work<'_, T>,
        z: &'s [T],
        out: &'s mut [T],
    ) -> Pricing<'s, T> {
        let [e, image] = work.metric.each_mut();
        Pricing {
            given,
            work: Work {
                metric: [e, image],
                taps: work.taps,
                factors: work.factors,
            },
            z,
            out,
            objective: Objective::default(),
            pays: false,
        }
    }

    /// The state at the start becomes that at hand.
    pub fn begin(&mut self) {
        let cells = self.flow.cells;
        let out = self.work.metric[0].get_mut(..cells.count()).unwrap_or_default();
        self.flow.put_density(self.given.source);
        for axis in 0..cells.dims {
            self.given.begin(self.z, axis, out);
            self.flow.put_velocity(axis, out);
        }
    }

    /// J at the unknowns; the tape is written, where there is one.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn value(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<Objective, Stop> {
        self.begin();
        self.kept.taped = false;
        let steps = self.given.unknowns.steps;
        let mut pricing = Self::pricing(self.given, &mut self.work, self.z, &mut []);
        pricing.pays = true;
        pricing.pay_initial();
        let tape: &mut [T] = match self.kept.slots {
            Slots::Tape => self.kept.fields,
            _ => &mut [],
        };
        let mut march = March {
            flow: self.flow,
            script: &mut pricing,
            observer,
        };
        march.forward(exec, steps, (tape, self.kept.len))?;
        self.kept.taped = self.kept.slots == Slots::Tape;
        Ok(pricing.objective)
    }

    /// The gradient by the unknowns.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn gradient(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        out: &mut [T],
    ) -> Result<(), Stop> {
        if self.kept.slots == Slots::Tape && !self.kept.taped {
            self.value(exec, observer)?;
        }
        if self.kept.slots != Slots::Tape {
            self.begin();
        }
        out.fill(T::ZERO);
        let steps = self.given.unknowns.steps;
        let mut pricing = Self::pricing(self.given, &mut self.work, self.z, out);
        let mut march = March {
            flow: &mut *self.flow,
            script: &mut pricing,
            observer,
        };
        let kept = &mut self.kept;
        kept.repeated = match kept.slots {
            Slots::Tape => march
                .backward_on_tape(exec, steps, (kept.fields, kept.len))
                .map(|()| 0)?,
            _ => march.backward(exec, steps, kept.fields, kept.steps)?,
        };
        let cells = self.flow.cells;
        pricing.take_initial(&cells, self.flow.v_adjoint());
        Ok(())
    }
}

impl<T: Real, S> Function<T, S> for Search<'_, '_, T> {
    fn direction(
        &mut self,
        exec: &dyn Exec,
        _observer: &mut dyn Observer,
        newton: &mut QuasiNewton,
    ) -> Result<f64, Stop> {
        let list = self.list;
        let shape = Shape {
            grid: &list,
            slots: 1,
        };
        let slope = newton.descend(exec, shape, self.fields);
        let largest = self.fields.get(newton.direction).map_or(0.0, |direction| {
            sums::max_abs(exec, shape.grid, 1, view(direction), self.flow.sums)
        });
        Ok(if largest.is_finite() { slope } else { f64::NAN })
    }

    fn move_along(&mut self, _: &dyn Exec, direction: usize, s: f64) {
        if let Some([direction, ..]) = self.fields.get(direction) {
            rows::add_scaled(self.z, T::from_f64(s), direction);
        }
        self.kept.taped = false;
    }

    /// By halves.
    fn shrink(&self) -> [f64; 2] {
        [0.5, 0.5]
    }

    fn retreat(&mut self, _: &dyn Exec, keep: f64) {
        rows::scale_in_place(self.z, T::from_f64(keep));
        self.kept.taped = false;
    }

    fn value(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        _work: usize,
        _bound: f64,
    ) -> Result<Objective, Stop> {
        let objective = Search::value(self, exec, observer)?;
        if objective.total().is_finite() {
            Ok(objective)
        } else {
            Err(Stop::TooFast)
        }
    }

    fn gradient(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        _work: usize,
        into: usize,
    ) -> Result<(), Stop> {
        let mut field = self.fields.get_mut(into).map(core::mem::take).unwrap_or_default();
        let [out, ..] = &mut field;
        let done = Search::gradient(self, exec, observer, out);
        let largest = sums::max_abs(exec, &self.list, 1, view(&field), self.flow.sums);
        if let Some(place) = self.fields.get_mut(into) {
            *place = field;
        }
        done?;
        if largest.is_finite() {
            Ok(())
        } else {
            Err(Stop::TooFast)
        }
    }

    fn arrive(&mut self, exec: &dyn Exec, newton: &mut QuasiNewton, borrowed: Borrowed, step: Option<f64>) {
        let list = self.list;
        let shape = Shape {
            grid: &list,
            slots: 1,
        };
        if let (None, Some(gradient)) = (step, self.fields.get(borrowed.gradient)) {
            let largest = sums::max_abs(exec, shape.grid, 1, view(gradient), self.flow.sums);
            *self.scale = if largest > 0.0 { FIRST_STEP / largest } else { 1.0 };
        }
        let initial = Initial {
            line: None,
            scale: *self.scale,
            prepared: false,
        };
        newton.arrive(exec, shape, self.fields, borrowed, step, &initial, self.flow.sums);
    }
}
