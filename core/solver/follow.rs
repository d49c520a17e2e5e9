//! A solver that several ranks share: the first of them is asked, as a solver of one program is, and the others do what it does.

use super::Solver;
use super::shared::Verb;
use crate::checkpoint::{self, PartStore};
use crate::exec::ranks::tell;
use crate::exec::{Exec, Ranks};
use crate::grid::Space;
use crate::observe::Silent;
use crate::real::Real;

impl<'m, T: Real, S: Space> Solver<'m, T, S> {
    /// Lets `ranks` share the solve, each with the part of its problem's [`share`](crate::Problem::share); before anything is set. From now on
    /// every `exec` has to be one of these ranks, [`Together`](crate::exec::Together). The first rank is asked, all others [follow](Self::follow) until they are
    /// [dismissed](Self::dismiss). Among obstacles and with open sides all ranks call this at the same time, and nothing is known of cells before.
    pub fn share(&mut self, ranks: &'m dyn Ranks) {
        if self.grid().is_part() {
            self.shared.ranks = Some(ranks);
            let levels = &mut self.engine.get_mut().parts().animation.levels;
            levels.set_solids(ranks, |_| false);
        }
    }

    /// Whether other ranks have other parts of the box, so that what is stored here is not all of a field.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        self.grid().is_part()
    }

    /// Lets the other ranks go, which followed.
    pub fn dismiss(&self) {
        self.shared.ask(Verb::End, [0; 3]);
    }

    /// Does what the first rank is asked for, until that dismisses; parts of states are in `store`.
    pub fn follow(&mut self, exec: &dyn Exec, store: &mut dyn PartStore) {
        while let Some(ranks) = self.shared.ranks {
            let mut words = [0; 4];
            tell(ranks, 0, &mut words);
            let [verb, a, b, c] = words;
            match Verb::ALL.get(verb) {
                Some(Verb::Solids) => self.take_solids(&[]),
                Some(Verb::Source) => self.take_source(&[], [0.0; 2]),
                Some(Verb::Emitter) => self.take_emitter(a, &[]),
                Some(Verb::Part) => self.put_field(a, &[]),
                Some(Verb::Velocity) => self.take_velocity(a, &[]),
                Some(Verb::Keyframe) => {
                    let _ = self.take_keyframe(a, &[]);
                }
                Some(Verb::Mass) => {
                    self.added_mass(a);
                }
                // How these end the first rank says.
                Some(Verb::Prepare) => {
                    let _ = self.prepare(exec);
                }
                Some(Verb::Step) => {
                    let _ = self.step(exec, &mut Silent);
                }
                Some(Verb::Finish) => {
                    let _ = self.finish(exec);
                }
                Some(Verb::Read) => self.send_output(a, b, c),
                Some(Verb::Given) => self.send_given(a),
                Some(Verb::Emission) => self.emission(exec, a, &mut []),
                Some(Verb::Jet) => self.send_jet(a, b),
                Some(Verb::GoOn) => self.take_left(&[]),
                Some(Verb::Guess) => self.take_guess(a, b, &[]),
                Some(Verb::Begin) => {
                    let _ = self.begin_at_given(exec);
                }
                Some(Verb::Price) => {
                    self.objective_of(exec, a, b);
                }
                Some(Verb::Save) => {
                    let _ = checkpoint::save_parts(self, store);
                }
                Some(Verb::Restore) => {
                    let _ = checkpoint::restore_parts(self, store);
                }
                Some(Verb::End) | None => return,
            }
        }
    }
}
