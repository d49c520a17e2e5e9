//! The force that unknowns of templates stand for, before it is projected.

use super::unknowns::{Place, places};
use crate::exec::Exec;
use crate::field::trajectory::Shape;
use crate::field::{Vector, VectorMut};
use crate::force::template::Placed;
use crate::grid::solids::Solids;
use crate::method::lbfgs::evaluate::Pull;
use crate::objective::script::Script;
use crate::real::Real;

/// The sum of all templates as unknowns have them.
#[derive(Clone, Copy)]
pub struct Sum<'a, T> {
    /// Where trajectories of the force live.
    pub shape: Shape<'a>,
    /// The solid cells there.
    pub solids: Solids<'a>,
    /// The templates as they are given.
    pub script: Script<'a, T>,
    /// The unknowns.
    pub z: &'a [T],
}

impl<'a, T: Real> Sum<'a, T> {
    /// The places of all templates among the unknowns, and each on its grid.
    pub fn placed(&self) -> impl Iterator<Item = (Place, Placed<'a>)> + use<'a, T> {
        let Self {
            shape,
            solids,
            script,
            z,
        } = *self;
        let Shape { grid, slots } = shape;
        let places = places(script.templates(), grid, slots);
        places.map(move |place| (place, Placed::new(grid, solids, slots, place.template(z))))
    }

    /// Whether a template acts on smoke.
    #[must_use]
    pub fn pulls(&self) -> bool {
        self.script.templates().any(|template| template.kind.on_smoke())
    }

    /// `u +=` those that act on smoke, or those that do not.
    pub fn add_to(&self, exec: &dyn Exec, on_smoke: bool, rho: &[T], u: &mut VectorMut<'_, T>) {
        let (z, slots) = (self.z, self.shape.slots);
        for (place, placed) in self
            .placed()
            .filter(|(place, _)| place.given.kind.on_smoke() == on_smoke)
        {
            placed.add(
                exec,
                &|interval| place.amplitude(z, interval),
                rho,
                (0..slots, 0),
                u,
            );
        }
    }
}

impl<T: Real> Pull<T> for Sum<'_, T> {
    fn add(&self, exec: &dyn Exec, rho: &[T], slot: usize, given: &mut VectorMut<'_, T>) {
        for (place, placed) in self.placed().filter(|(place, _)| place.given.kind.on_smoke()) {
            let amplitude = |interval| place.amplitude(self.z, interval);
            placed.add(exec, &amplitude, rho, (slot..slot + 1, slot), given);
        }
    }

    fn add_adjoint(&self, exec: &dyn Exec, s: f64, b: Vector<'_, T>, slot: usize, mu: &mut [T]) {
        for (place, placed) in self.placed() {
            placed.add_to_density(
                exec,
                &|interval| place.amplitude(self.z, interval),
                (s, b),
                slot,
                mu,
            );
        }
    }
}
