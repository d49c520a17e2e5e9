//! What an iteration of ADMM reports.

use crate::progress::{Fact, Kind, MAX_CYCLES, MAX_RESIDUALS, Report};

const AO_STEP: Fact = Fact::new("ao_step", Kind::Number, "blending step of the advection problem");
const DENSITY_CHANGE: Fact = Fact::new(
    "density_change",
    Kind::Number,
    "largest change of a density in one iteration, over the source's largest; convergence is judged by it",
)
.in_chart("Change of the density");
const NSO_RESIDUALS: Fact = Fact::new(
    "nso_residuals",
    Kind::Series,
    "residual max |f| before the first cycle of each iteration and after each",
)
.in_chart("Navier\u{2013}Stokes problem");
const KKT: Fact = Fact::new(
    "kkt",
    Kind::Number,
    "largest violation of the optimality conditions",
)
.in_chart("Optimality");
const AO_RESIDUALS: Fact = Fact::new(
    "ao_residuals",
    Kind::Series,
    "residual of the advection problem in each of its iterations",
)
.in_chart("Optimality");
const GAP: Fact = Fact::new("gap", Kind::Number, "max |v - v*| over max |v|").in_chart("Optimality");
const DATA_OF_STAR: Fact = Fact::new("data_of_star", Kind::Number, "data term of v*");
const HELD: Fact = Fact::new("held", Kind::Flag, "whether the multipliers were held");

/// How ADMM went in one outer iteration.
#[derive(Clone, Debug, Default)]
pub struct Course {
    /// Blending step alpha of AO.
    pub ao_step: f64,
    /// max change of rho since the iteration before, over max rho_0.
    pub density_change: f64,
    /// max |f| of NSO before its first V-cycle and after each.
    pub nso_residuals: heapless::Vec<f64, MAX_CYCLES>,
    /// max of AO's direction, over dt, in each of its iterations: the residual of its fixed point as an acceleration (the paper's
    /// Figure 7). Of more than [`MAX_RESIDUALS`] the last stands for all that came later.
    pub ao_residuals: heapless::Vec<f64, MAX_RESIDUALS>,
    /// The largest violation of the optimality conditions: of AO's, NSO's, and max |v - v*| over dt (the paper's Figure 7).
    pub kkt: f64,
    /// max |v - v*| over max |v|.
    pub gap: f64,
    /// Data term of v*, where the objective's is that of v.
    pub data_of_star: f64,
    /// Whether the multipliers were held: an iteration of the plain augmented Lagrangian.
    pub held: bool,
}

impl Course {
    /// Tells it, if the iteration came as far as the Navier-Stokes problem.
    pub fn tell(&self, report: &mut Report) {
        if self.nso_residuals.is_empty() {
            return;
        }
        report.tell(AO_STEP, &[self.ao_step]);
        report.tell(DENSITY_CHANGE, &[self.density_change]);
        report.tell(NSO_RESIDUALS, &self.nso_residuals);
        report.tell(KKT, &[self.kkt]);
        report.tell(AO_RESIDUALS, &self.ao_residuals);
        report.tell(GAP, &[self.gap]);
        report.tell(DATA_OF_STAR, &[self.data_of_star]);
        report.tell(HELD, &[f64::from(u8::from(self.held))]);
    }
}
