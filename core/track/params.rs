//! What a caller chooses for tracking.

use crate::flow::{FlowParams, MAX_LEVELS, Minimiser, Warping};
use crate::grid::Boundary;
use crate::method::choices::{Choices, Kind, Numbers, choices};
use crate::method::refusal::{PlanError, count};
use crate::problem::{Feature, Problem, ProblemError};
use crate::words::{Named, named};

/// What densities are scaled to: the weights mean something for densities up to this (Gregson 2015, table 5.1, whose units this reproduces).
pub const FULL: f64 = 10.0;

/// How the flow of the next pair of frames is predicted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Prediction {
    /// The implicit step of a simulation.
    #[default]
    Implicit,
    /// The flow carried by itself, then projected.
    Bfecc,
    /// The flow before, as it is.
    None,
}

named!(Prediction { Implicit = "implicit", Bfecc = "bfecc", None = "none" });

/// Frames of smoke in a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capture<'a> {
    /// Cells along x, y (and z).
    pub cells: &'a [usize],
    /// How each axis ends: wall or periodic.
    pub boundary: &'a [Boundary],
    /// The longest side of the box.
    pub length: f64,
    /// The time between two frames.
    pub dt: f64,
    /// What densities are multiplied by: the weights mean something for densities up to about 10.
    pub density_scale: f64,
    /// Acceleration along each axis where the density is 1, in lengths and times of the capture, in the prediction.
    pub buoyancy: [f64; 3],
    /// Whether smoke is made between frames, and known: then it is given beside them.
    pub emission: bool,
}

impl<'a> Capture<'a> {
    /// Frames in a box of length 1, one a unit of time, of densities up to 10.
    #[must_use]
    pub fn new(cells: &'a [usize], boundary: &'a [Boundary]) -> Self {
        Self {
            cells,
            boundary,
            length: 1.0,
            dt: 1.0,
            density_scale: 1.0,
            buoyancy: [0.0; 3],
            emission: false,
        }
    }

    /// Velocities of the capture in one of a cell a frame.
    #[must_use]
    pub fn velocity_unit(&self) -> f64 {
        self.length / (self.dt * self.longest())
    }

    fn longest(&self) -> f64 {
        self.cells.iter().copied().max().unwrap_or(1) as f64
    }

    /// The acceleration in cells and frames where the scaled density is 1.
    pub(super) fn lift(&self) -> [f64; 3] {
        let unit = self.dt * self.dt * self.longest() / (self.length * self.density_scale);
        self.buoyancy.map(|along| along * unit)
    }

    /// Checks every field.
    pub(super) fn check(&self, dims: usize) -> Result<(), PlanError> {
        let given = self.cells.len();
        if given != dims {
            return Err(ProblemError::Dimensions {
                expected: dims,
                given,
            }
            .into());
        }
        let problem = Problem {
            length: self.length,
            dt: self.dt,
            ..Problem::new(self.cells, self.boundary, &[2])
        };
        if problem.asks_for(Feature::Open) {
            let (method, feature) = ("track", Feature::Open);
            return Err(ProblemError::Unfit { method, feature }.into());
        }
        problem.check()?;
        crate::problem::positive("density_scale", self.density_scale)?;
        match self.buoyancy.iter().find(|along| !along.is_finite()) {
            None => Ok(()),
            Some(&given) => {
                let field = "buoyancy";
                Err(ProblemError::NotFinite { field, given }.into())
            }
        }
    }
}

/// What a caller chooses for tracking. Weights are in cells and frames, for scaled densities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackParams {
    /// How the flow between two frames is found.
    pub flow: FlowParams,
    /// How the flow of the next pair is predicted.
    pub predict: Prediction,
    /// Whether every pair is on its own.
    pub independent: bool,
    /// Whether the first frame is carried by the flow, to be compared with the others.
    pub readvect: bool,
    /// Whether the force is handed out that leads from the flow of a pair to that of the next.
    pub forces: bool,
    /// Threads that memory is planned for.
    pub threads: usize,
}

impl Default for TrackParams {
    fn default() -> Self {
        Self::of(Minimiser::default())
    }
}

/// The widest blur, in cells.
const WIDEST: f64 = 32.0;
/// Iterations, warps and steps at most.
const MOST: usize = 100_000;

choices!(TrackParams, "track" {
    method: flow.minimiser, Kind::Word(Minimiser::WORDS), "how the flow between two frames is found";
    alpha: flow.alpha, Kind::Number(Numbers::NotNegative), "weight of smoothness";
    beta: flow.beta, Kind::Number(Numbers::NotNegative), "weight of the flow's kinetic energy";
    gamma: flow.gamma, Kind::Number(Numbers::NotNegative), "price of divergence, of horn_schunck alone";
    lambda: flow.lambda, Kind::Number(Numbers::Positive), "step of admm";
    iterations: flow.iterations, Kind::Count(MOST), "iterations of admm";
    levels: flow.levels, Kind::Count(MAX_LEVELS), "grids of the pyramid at most";
    eta: flow.eta, Kind::Number(Numbers::Below(1.0)), "cells of the next coarser grid along an axis, in parts";
    sigma: flow.sigma, Kind::Number(Numbers::UpTo(WIDEST)), "blur before a coarser grid, in cells";
    warps: flow.warps, Kind::Count(MOST), "how often each grid warps and solves";
    warp: flow.warp, Kind::Word(Warping::WORDS), "how a frame is pulled back by a flow";
    cg_tolerance: flow.cg_tolerance, Kind::Number(Numbers::Below(1.0)),
        "what conjugate gradients leave, in parts of their right-hand side";
    cg_iterations: flow.cg_iterations, Kind::Count(MOST), "steps of conjugate gradients at most";
    tolerance: flow.tolerance, Kind::Number(Numbers::Fraction), "admm ends early when it changes less; 0: never";
    predict: predict, Kind::Word(Prediction::WORDS), "how the next flow is predicted";
    independent: independent, Kind::Flag, "every pair on its own";
    readvect: readvect, Kind::Flag, "carry the first frame by the flow and compare";
    forces: forces, Kind::Flag, "the force from the flow of each pair to the next";
});

impl TrackParams {
    /// The defaults of a way to the flow: those of Gregson et al. 2014.
    #[must_use]
    pub fn of(minimiser: Minimiser) -> Self {
        let hard = minimiser != Minimiser::HornSchunck;
        let direct = minimiser == Minimiser::Direct;
        Self {
            flow: FlowParams {
                minimiser,
                alpha: if hard { 1e-4 } else { 0.2 },
                beta: if hard { 1.0 } else { 0.0 },
                gamma: 0.0,
                lambda: 1.0,
                iterations: 5,
                levels: 3,
                eta: 0.65,
                sigma: 0.5,
                warps: 1,
                warp: Warping::default(),
                cg_tolerance: match minimiser {
                    Minimiser::Direct => 1e-3,
                    Minimiser::Admm => 1e-4,
                    // Its equations hardly say anything where a frame has no gradient: by 1e-3 its terms differ by up to 1 % from those of
                    // the same equations solved by another program, by 1e-4 by 0.4 %, by 1e-5 by less than 1e-4.
                    Minimiser::HornSchunck => 1e-5,
                },
                cg_iterations: if direct { 200 } else { 1000 },
                tolerance: 0.0,
            },
            predict: if hard {
                Prediction::Implicit
            } else {
                Prediction::None
            },
            independent: !hard,
            readvect: true,
            forces: false,
            threads: 1,
        }
    }

    /// Whether anything is predicted from the pair before.
    pub(super) fn predicts(&self, prediction: Prediction) -> bool {
        !self.independent && self.predict == prediction
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`PlanError`] names the first that is wrong.
    pub fn check(&self) -> Result<(), PlanError> {
        Choices::check(self)?;
        count("threads", self.threads, MOST)
    }
}
