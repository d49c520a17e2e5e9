//! The line search: how far to go along a direction.

use super::course::Course;
use super::function::Function;
use super::quasi_newton::recursion::{Borrowed, QuasiNewton};
use crate::exec::Exec;
use crate::observe::Observer;
use crate::progress::Objective;
use crate::real::Real;
use crate::transport::Stop;

/// Part of the decrease that the slope promises, which a step must keep (Armijo).
const ENOUGH: f64 = 1e-4;
/// The smallest step that is tried.
pub const SMALLEST_STEP: f64 = 1.0 / (1 << 20) as f64;

/// What a line search found.
pub enum Found {
    /// A step of this length, with the value there and the gradient in its field.
    Step(f64, Objective),
    /// No step; whether the shortest one was finite. The point is where it was.
    Nothing {
        /// See above.
        finite: bool,
    },
}

/// Moves the point along the direction by the first step, 1 or shorter, with which the value falls enough and the gradient is finite
/// (Nocedal & Wright, section 3.5). Leaves the point where it was if there is none, or if it is cancelled.
pub fn search<T: Real, S>(
    exec: &dyn Exec,
    observer: &mut dyn Observer,
    function: &mut impl Function<T, S>,
    newton: &QuasiNewton,
    borrowed: Borrowed,
    before: f64,
    slope: f64,
    course: &mut Course,
) -> Result<Found, Stop> {
    let shrink = function.shrink();
    let (mut length, mut moved) = (1.0, 0.0);
    let mut finite = true;
    while length >= SMALLEST_STEP {
        function.move_along(exec, newton.direction, length - moved);
        moved = length;
        let bound = before + ENOUGH * length * slope;
        course.evaluations += 1;
        let tried = match function.value(exec, observer, borrowed.work, bound) {
            Ok(after) if after.total() <= bound => function
                .gradient(exec, observer, borrowed.work, borrowed.gradient)
                .map(|()| Found::Step(length, after)),
            Ok(after) => {
                finite = after.total().is_finite();
                length = shorter(shrink, length, after.total() - before, slope);
                continue;
            }
            Err(stop) => Err(stop),
        };
        match tried {
            Err(Stop::TooFast) => (length, finite) = (shrink[1] * length, false),
            Err(Stop::Cancelled) => {
                function.move_along(exec, newton.direction, -moved);
                return Err(Stop::Cancelled);
            }
            ended => return ended,
        }
    }
    function.move_along(exec, newton.direction, -moved);
    Ok(Found::Nothing { finite })
}

/// The step to try after one of `length` that changed the value by `change`: where the parabola through the value and the slope before
/// and the value there is lowest.
fn shorter(shrink: [f64; 2], length: f64, change: f64, slope: f64) -> f64 {
    let lowest = -0.5 * slope * length * length / (change - slope * length);
    if lowest.is_finite() {
        lowest.clamp(shrink[0] * length, shrink[1] * length)
    } else {
        shrink[1] * length
    }
}
