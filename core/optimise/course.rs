//! What an iteration of a descent reports.

use crate::progress::{Fact, Kind, Progress};

const STEP: Fact = Fact::new(
    "step",
    Kind::Number,
    "step along the direction, 0 when none gained anything",
);
const SLOPE: Fact = Fact::new(
    "slope",
    Kind::Number,
    "the objective's derivative along the direction",
);
const GRADIENT: Fact = Fact::new(
    "gradient_norm",
    Kind::Number,
    "norm of the objective's gradient, in the norm of the first inverse Hessian",
)
.in_chart("Gradient");
const EVALUATIONS: Fact = Fact::new("evaluations", Kind::Count, "how often the objective was computed");

/// How one iteration went.
#[derive(Clone, Copy, Debug, Default)]
pub struct Course {
    /// Its number, from 1.
    pub iteration: usize,
    /// Step along the direction, 0 when none gained anything.
    pub step: f64,
    /// <gradient, direction>: the objective's derivative along the direction.
    pub slope: f64,
    /// <g, P g>^(1/2) of the gradient g at the end, P being the first inverse Hessian.
    pub gradient: f64,
    /// How often the objective was computed.
    pub evaluations: usize,
}

impl Course {
    /// Tells it, if an iteration was begun.
    pub fn tell(&self, progress: &mut Progress) {
        progress.level_iteration = self.iteration;
        if self.iteration > 0 {
            progress.report.tell(STEP, &[self.step]);
            progress.report.tell(SLOPE, &[self.slope]);
            progress.report.tell(GRADIENT, &[self.gradient]);
            progress.report.tell(EVALUATIONS, &[self.evaluations as f64]);
        }
    }
}
