//! The paper's rule to stop: between two iterations no density changes by more than a part of the largest one at the start.

use thurible_core::{Real, Solver, Space};

/// The densities of the last iteration, to be compared with those of the next one.
pub(super) struct Settled<T> {
    part: f64,
    before: Vec<T>,
}

impl<T: Real> Settled<T> {
    /// The rule for changes below `part` of the largest density at the start.
    pub fn new(part: f64) -> Self {
        Self {
            part,
            before: Vec::new(),
        }
    }

    /// Whether the densities of `solver` have changed so little since this was asked last; never the first time.
    pub fn after_iteration<S: Space>(&mut self, solver: &Solver<'_, T, S>) -> bool {
        let densities = || (0..=solver.steps()).flat_map(|step| solver.density(step));
        let change = self
            .before
            .iter()
            .zip(densities())
            .map(|(before, now)| (before.to_f64() - now.to_f64()).abs())
            .fold(0.0, f64::max);
        let largest = solver
            .density(0)
            .iter()
            .map(|rho| rho.to_f64())
            .fold(0.0, f64::max);
        let settled = !self.before.is_empty() && change < self.part * largest;
        self.before.clear();
        self.before.extend(densities());
        settled
    }
}
