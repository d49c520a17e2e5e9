//! The price of force over time: a factor for every step, given at some of them and linear in its logarithm between.

use super::Script;
use crate::real::Real;

impl<T: Real> Script<'_, T> {
    /// What the price of the force in `slot` is multiplied by: that turns v_slot into v_{slot+1}, counted from 0. Before the first step
    /// that is given the factor is as there, and after the last one too; of a long step it is that of its middle.
    #[must_use]
    pub fn factor(&self, slot: usize) -> f64 {
        let stride = f64::from(self.stride.get());
        let step = stride * slot as f64 + 0.5 * (stride - 1.0);
        let knots = self.lists.knots.iter().map(|&knot| f64::from(knot));
        let mut before: Option<(f64, f64)> = None;
        for (knot, &factor) in knots.zip(self.lists.factors) {
            if step <= knot {
                return match before {
                    Some((at, earlier)) => {
                        let part = (step - at) / (knot - at);
                        earlier * libm::pow(factor / earlier, part)
                    }
                    None => factor,
                };
            }
            before = Some((knot, factor));
        }
        before.map_or(1.0, |(_, factor)| factor)
    }
}
