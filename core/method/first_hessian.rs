//! The first inverse Hessian of the methods that descend by quasi-Newton directions: exact in time where a flow is at rest, and divided
//! by the price of curls.

use crate::exec::Exec;
use crate::force::mask::LEAST;
use crate::force::time_line::TimeLine;
use crate::grid::Space;
use crate::objective::flow::Evaluation;
use crate::optimise::quasi_newton::fields::{Fields, Initial, prepare};
use crate::optimise::quasi_newton::recursion::{Borrowed, QuasiNewton};
use crate::real::Real;

/// The least value of a mask for flows: where no force acts they change too, by what is pushed elsewhere. With 0.3 instead of
/// [`LEAST`] a mask down to 0.1 comes to J = 107 instead of 245 in 60 iterations.
pub const LEAST_OF_FLOWS: f64 = 0.3;

/// Lets `newton` arrive at a point (see [`QuasiNewton::arrive`]) with the first inverse Hessian (K + r S)^-1 by the factored `line`
/// kappa + S, or with 1 / r alone, either divided by the price of curls.
pub fn arrive<T: Real, S: Space>(
    exec: &dyn Exec,
    evaluation: &mut Evaluation<'_, '_, T>,
    line: Option<TimeLine<'_>>,
    fields: &mut Fields<'_, T>,
    newton: &mut QuasiNewton,
    (borrowed, step): (Borrowed, Option<f64>),
) {
    let least = if line.is_some() { LEAST_OF_FLOWS } else { LEAST };
    let prepared = prepare(fields, borrowed, |gradient, image| {
        evaluation.divide_by_price::<S>(exec, gradient, least, image)
    });
    let initial = Initial {
        line,
        scale: 1.0 / evaluation.setup.force_weight,
        prepared,
    };
    let shape = evaluation.shape();
    newton.arrive(exec, shape, fields, borrowed, step, &initial, evaluation.sums);
}
