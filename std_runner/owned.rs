//! A problem that owns its lists, which the core's [`Problem`] borrows.

use thurible_core::{Advection, Boundary, Problem};

/// The owned form of the core's [`Problem`], which borrows its lists.
#[derive(Clone, Debug)]
pub struct OwnedProblem {
    /// Cells per axis.
    pub cells: Vec<usize>,
    /// Boundary per axis.
    pub boundary: Vec<Boundary>,
    /// Steps of the keyframes, ascending.
    pub keyframes: Vec<usize>,
    /// Number of time steps N.
    pub steps: usize,
    /// The longest side of the box.
    pub length: f64,
    /// Length of a step.
    pub dt: f64,
    /// Kinematic viscosity nu.
    pub viscosity: f64,
    /// Weight r of the force.
    pub force_weight: f64,
    /// Smoothness of the force in cells, or `None` for the default.
    pub smoothness: Option<f64>,
    /// Number m of Gaussian filters, or `None` for the default.
    pub filters: Option<usize>,
    /// Whether keyframes take the mass of the source.
    pub match_mass: bool,
    /// How density is carried.
    pub advection: Advection,
    /// Relative tolerance of the projection.
    pub projection_tolerance: f64,
}

impl OwnedProblem {
    /// A box of walls with the core's defaults; N is the step of the last keyframe, 0 if there is none.
    pub fn new(cells: Vec<usize>, keyframes: Vec<usize>) -> Self {
        let boundary = vec![Boundary::Wall; cells.len()];
        let Problem {
            length,
            dt,
            steps,
            viscosity,
            force_weight,
            smoothness,
            filters,
            match_mass,
            advection,
            projection_tolerance,
            ..
        } = Problem::new(&cells, &boundary, &keyframes);
        Self {
            cells,
            boundary,
            keyframes,
            steps,
            length,
            dt,
            viscosity,
            force_weight,
            smoothness,
            filters,
            match_mass,
            advection,
            projection_tolerance,
        }
    }

    /// The core's view of this problem.
    pub fn problem(&self) -> Problem<'_> {
        Problem {
            cells: &self.cells,
            boundary: &self.boundary,
            length: self.length,
            dt: self.dt,
            steps: self.steps,
            keyframes: &self.keyframes,
            viscosity: self.viscosity,
            force_weight: self.force_weight,
            smoothness: self.smoothness,
            filters: self.filters,
            match_mass: self.match_mass,
            advection: self.advection,
            projection_tolerance: self.projection_tolerance,
        }
    }
}
