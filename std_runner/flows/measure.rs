//! How far flows are from what they were.

use crate::owned::OwnedProblem;
use thurible_core::{Boundary, Real};

/// By what part of itself the flow changed: everywhere, and weighted by the smoke at each face.
pub(super) fn changes<T: Real>(
    problem: &OwnedProblem,
    given: &[Vec<T>],
    flow: &[Vec<T>],
    smoke: &[f64],
) -> [f64; 2] {
    let mut sums = [[0.0; 2]; 2];
    for (axis, (given, flow)) in given.iter().zip(flow).enumerate() {
        let mut n = problem.cells.clone();
        let stride: usize = n.iter().take(axis).product();
        n[axis] += usize::from(problem.boundary[axis] != Boundary::Periodic);
        for (face, (given, flow)) in given.iter().zip(flow).enumerate() {
            // The cell above the face, or the last one below the wall.
            let (along, rest) = (face / stride % n[axis], face / (stride * n[axis]));
            let cell = along.min(problem.cells[axis] - 1);
            let place = (rest * problem.cells[axis] + cell) * stride + face % stride;
            let dyed = smoke.get(place).copied().unwrap_or_default();
            let (change, size) = (flow.to_f64() - given.to_f64(), given.to_f64());
            for (sums, weight) in sums.iter_mut().zip([1.0, dyed]) {
                sums[0] += weight * change * change;
                sums[1] += weight * size * size;
            }
        }
    }
    sums.map(|[change, size]| (change / size.max(f64::MIN_POSITIVE)).sqrt())
}
