//! The objective as a function of the forces: the flow simulated forwards, and the exact discrete adjoint of what was simulated.
//!
//! ```text
//! forward     v_k + Adv(v_k) + grad p_k = v_{k-1} + u_{k-1} + B rho_k,  div v_k = 0   for k = 1 .. T, rho_k carried by v_{k-1}
//! backward    z_k + J(v_k)^T z_k + grad q_k = z_{k+1} - A_v^T mu_k,  div z_k = 0      for k = T .. 1, z_{T+1} = 0
//! gradient    r f (1 + s^2 C^T C) u_{k-1} + z_k
//! ```
//!
//! Where emitters push, K v_{k-1} is subtracted and T added on the way forward, and z_{k+1} is (1 - K_{k+1}) z_{k+1} on the way back.
//!
//! Buoyancy B pulls mu_k down by B^T z_k, so that both go back together where there is any (`backward.rs`).

use crate::exec::Exec;
use crate::field::slot::{Slot, put};
use crate::field::{Vector, VectorMut, view};
use crate::force::lift::Lift;
use crate::grid::Space;
use crate::grid::levels::Levels;
use crate::memory::{Pool, Sharing};
use crate::method::simulate::step::{self, Step};
use crate::objective::flow::{self, Evaluation};
use crate::objective::sweep::DensitySweep;
use crate::observe::Observer;
use crate::progress::Objective;
use crate::real::Real;
use crate::transport::{Flow, Stop};

/// The last trajectory that was accepted, and what the forces have changed by since: where steps begin.
#[derive(Clone, Copy, Debug)]
pub struct Warm<'a, T> {
    /// v_1 .. v_{N-1}.
    pub v: Vector<'a, T>,
    /// A trajectory, and how many times it was added to the forces.
    pub change: (Vector<'a, T>, f64),
}

/// Part of a force that follows from the densities.
pub trait Pull<T>: Sync {
    /// `given +=` that part in slot `slot`, a field of one slot, by the densities `rho` of all steps.
    fn add(&self, exec: &dyn Exec, rho: &[T], slot: usize, given: &mut VectorMut<'_, T>);

    /// `mu += s` times what the covector `b` of the force in slot `slot` is for the density there.
    fn add_adjoint(&self, exec: &dyn Exec, s: f64, b: Vector<'_, T>, slot: usize, mu: &mut [T]);
}

/// What pushes the flow beside buoyancy.
#[derive(Clone, Copy)]
pub struct Push<'a, T> {
    /// The forces u_0 .. u_{N-2}; what densities add is not among them where the flow is simulated, and is where its gradient is taken.
    pub u: Vector<'a, T>,
    /// What the densities add.
    pub pull: Option<&'a dyn Pull<T>>,
}

impl<'a, T> Push<'a, T> {
    /// Forces alone.
    #[must_use]
    pub fn by(u: Vector<'a, T>) -> Self {
        Self { u, pull: None }
    }
}

/// J(u) = 1/2 <e, C e> + r/2 sum f <u, (1 + s^2 C^T C) u>.
pub struct Simulated<'a, 'm, T> {
    /// Weights, densities and work; see [`Self::measure`].
    pub evaluation: Evaluation<'a, 'm, T>,
    /// The relative tolerance of steps.
    pub tolerance: f64,
}

impl<T: Real> Simulated<'_, '_, T> {
    /// What evaluations on the finest grid take of a region, for a pool that measures; densities push the flow where they `pull`, or have
    /// buoyancy.
    pub fn measure<'l>(levels: &'l Levels<'_, T>, setup: &flow::Setup, pull: bool, pool: &mut Pool<'l, T>) {
        let sweep = &setup.sweep;
        let sharing = if setup.lifts() || pull {
            Sharing::Together
        } else {
            Sharing::InTurn
        };
        pool.group("evaluation and step", sharing, |pool| {
            Evaluation::measure(levels, 0, sweep, pool);
            // A step's tolerance and viscosity take no memory.
            Step::carve(levels, 0, step::Setup::both_ways(0.0, 0.0, sweep.threads), pool);
        });
    }

    pub(super) fn step_setup(&self) -> step::Setup {
        let flow::Setup { sweep, viscosity, .. } = self.evaluation.setup;
        step::Setup::both_ways(viscosity, self.tolerance, sweep.threads)
    }

    /// J(u), with the flow in `v` and rho carried by it; the force's part alone where that is above `bound`.
    ///
    /// # Errors
    /// [`Stop`].
    pub fn value<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        u: Vector<'_, T>,
        warm: Warm<'_, T>,
        v: &mut VectorMut<'_, T>,
        bound: f64,
    ) -> Result<Objective, Stop> {
        let force = self.evaluation.price::<S>(exec, u);
        if force.force > bound {
            return Ok(force);
        }
        self.simulate::<S>(exec, observer, Push::by(u), warm, v)?;
        let data = self.evaluation.data(exec, usize::MAX);
        Ok(Objective { data, ..force })
    }

    /// The density of `step` + 1 from the one before.
    fn carry(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        v: Vector<'_, T>,
        step: usize,
    ) -> Result<(), Stop> {
        let Evaluation {
            levels,
            level,
            setup,
            initial,
            rho,
            script,
            region,
            sums,
            ..
        } = &mut self.evaluation;
        let flow = Flow {
            initial: *initial,
            v,
            along: None,
        };
        let mut sweep = DensitySweep::carve(levels, *level, &setup.sweep, &mut Pool::new(region));
        sweep.carry_step(exec, observer, &flow, rho, step, script, sums)
    }

    /// The flow of what pushes it, with all densities that it carries.
    ///
    /// # Errors
    /// [`Stop`].
    pub fn simulate<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        push: Push<'_, T>,
        warm: Warm<'_, T>,
        v: &mut VectorMut<'_, T>,
    ) -> Result<(), Stop> {
        let slots = self.evaluation.setup.sweep.slots;
        (1..=slots).try_for_each(|k| {
            self.carry(exec, observer, view(v), k - 1)?;
            self.advance::<S>(exec, observer, push, warm, v, k)
        })?;
        self.carry(exec, observer, view(v), slots)
    }

    /// v_k, from v_{k-1}, u_{k-1} and rho_k.
    fn advance<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        Push { u, pull }: Push<'_, T>,
        warm: Warm<'_, T>,
        v: &mut VectorMut<'_, T>,
        k: usize,
    ) -> Result<(), Stop> {
        let step_setup = self.step_setup();
        let jets = self.evaluation.jets();
        let lift = Lift {
            slots: 1,
            ..self.evaluation.lift()
        };
        let Evaluation {
            levels,
            level,
            setup,
            initial,
            rho,
            region,
            sums,
            ..
        } = &mut self.evaluation;
        let (grid, slots) = (&levels.grids[*level], setup.sweep.slots);
        let mut step = Step::carve(levels, *level, step_setup, &mut Pool::new(region));
        let slot = |field| Slot {
            field,
            slots,
            slot: k - 1,
        };
        let before = Slot::at(k - 1, *initial, view(v), slots);
        let (change, s) = warm.change;
        let known = Slot::at(k - 1, *initial, warm.v, slots);
        step.give(exec, [(1.0, before), (1.0, slot(u))]);
        lift.add(exec, 1.0, &rho[(k - 1) * grid.cells()..], 0..1, &mut step.given);
        jets.add(exec, [1.0, -1.0], k - 1, before, (&mut step.given, 0));
        if let Some(pull) = pull {
            pull.add(exec, rho, k - 1, &mut step.given);
        }
        let terms = [
            (1.0, slot(warm.v)),
            (1.0, before),
            (-1.0, known),
            (s, slot(change)),
        ];
        step.guess(exec, terms);
        step.advance::<S>(exec, observer, sums)?;
        put(exec, grid, view(&step.v), v, k - 1);
        Ok(())
    }
}
