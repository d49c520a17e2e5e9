//! The residuals of a case, cycle by cycle.

use crate::common::sure;
use thurible_bench::navier_stokes::Case;
use thurible_core::{Exec, Real, Silent, Space};

/// A residual below this part of the largest one is rounding.
pub const FLOOR: f64 = 1e-10;
/// A cycle that leaves more than this part gains nothing any more.
const STALLED: f64 = 0.9;
/// Cycles of a synthetic row at most.
const CYCLES: usize = 16;

/// max |f| before the first cycle and after each, down to the rounding floor, in double precision.
pub fn cycles<S: Space>(exec: &dyn Exec, case: &Case) -> Vec<f64> {
    residuals_of::<f64, S>(exec, case)
}

/// The same in any precision.
pub fn residuals_of<T: Real, S: Space>(exec: &dyn Exec, case: &Case) -> Vec<f64> {
    sure(case.pose::<T, S, _>(exec, |nso| {
        let mut residuals = vec![nso.residual(exec)];
        let goes = |residuals: &[f64]| {
            residuals
                .windows(2)
                .last()
                .is_none_or(|pair| pair[1] < STALLED * pair[0])
        };
        while residuals.len() <= CYCLES
            && residuals.last() > Some(&(FLOOR * residuals[0]))
            && goes(&residuals)
        {
            let _ = nso.vcycle(exec, &mut Silent);
            residuals.push(nso.residual(exec));
        }
        residuals
    }))
}
