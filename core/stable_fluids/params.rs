//! What a caller chooses for Stable Fluids.

use super::slots::Slots;
use crate::method::choices::{Choices, Kind, Numbers, choices};
use crate::method::refusal::{PlanError, count};
use crate::optimise::quasi_newton::history::MAX_PAIRS;
use crate::problem::{Feature, Problem, ProblemError, TemplateError, TemplateKind};
use crate::words::named;

/// The name of the method.
pub const NAME: &str = "stable_fluids";

/// How the pressure is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pressure {
    /// By Gauss-Seidel sweeps.
    #[default]
    GaussSeidel,
    /// By conjugate gradients.
    Conjugate,
}

named!(Pressure { GaussSeidel = "gauss_seidel", Conjugate = "cg" });

/// What the adjoint of conjugate gradients is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Adjoint {
    /// That of the iterations that were done.
    #[default]
    Exact,
    /// One more solve: right in the limit, in less memory.
    SecondSolve,
}

named!(Adjoint { Exact = "exact", SecondSolve = "second_solve" });

/// What is searched for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// The velocity at the start.
    InitialVelocity,
    /// A force in every cell and step.
    Forces,
    /// Amplitudes of templates, and middles and radii of those that move.
    Templates,
}

named!(Control { InitialVelocity = "initial_velocity", Forces = "forces", Templates = "templates" });

/// The controls of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Controls([bool; 3]);

impl Default for Controls {
    fn default() -> Self {
        Self::none().with(Control::InitialVelocity)
    }
}

impl Controls {
    /// Nothing is searched for.
    #[must_use]
    pub const fn none() -> Self {
        Self([false; 3])
    }

    /// These and `control`.
    #[must_use]
    pub const fn with(self, control: Control) -> Self {
        let Self([mut initial, mut forces, mut templates]) = self;
        match control {
            Control::InitialVelocity => initial = true,
            Control::Forces => forces = true,
            Control::Templates => templates = true,
        }
        Self([initial, forces, templates])
    }

    /// Whether `control` is one of them.
    #[must_use]
    pub const fn has(self, control: Control) -> bool {
        let Self([initial, forces, templates]) = self;
        match control {
            Control::InitialVelocity => initial,
            Control::Forces => forces,
            Control::Templates => templates,
        }
    }

    /// All of them.
    pub fn list(self) -> impl Iterator<Item = Control> {
        let all = <Control as crate::words::Named>::ALL.iter().copied();
        all.filter(move |&control| self.has(control))
    }

    /// Whether nothing is searched for.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        matches!(self, Self([false, false, false]))
    }
}

/// What a caller chooses besides the problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FluidsParams {
    /// What is searched for.
    pub controls: Controls,
    /// How the pressure is found.
    pub pressure: Pressure,
    /// Gauss-Seidel sweeps, of pressure and diffusion.
    pub sweeps: usize,
    /// Iterations of conjugate gradients at most.
    pub cg_iterations: usize,
    /// What they leave, in parts of their right-hand side.
    pub cg_tolerance: f64,
    /// What their adjoint is.
    pub adjoint: Adjoint,
    /// Diffusion of the density, in length^2 / time.
    pub diffusion: f64,
    /// Price r_v of the initial velocity.
    pub initial_weight: f64,
    /// What is kept for the way back.
    pub slots: Slots,
    /// Pairs of L-BFGS.
    pub history: usize,
    /// Stop when the objective falls by less than this times itself in an iteration, twice in a row.
    pub tolerance: f64,
    /// Iterations at most.
    pub iterations: usize,
    /// Threads that scratch is planned for.
    pub threads: usize,
    /// Whether an initial velocity is given; 0 otherwise.
    pub initial_velocity: bool,
}

impl Default for FluidsParams {
    fn default() -> Self {
        Self {
            controls: Controls::default(),
            pressure: Pressure::default(),
            sweeps: 20,
            cg_iterations: 200,
            cg_tolerance: 1e-5,
            adjoint: Adjoint::default(),
            diffusion: 0.0,
            initial_weight: 10.0,
            slots: Slots::Tape,
            history: 5,
            tolerance: 1e-4,
            iterations: 60,
            threads: 1,
            initial_velocity: false,
        }
    }
}

/// Sweeps and iterations at most.
const MOST: usize = 100_000;

choices!(FluidsParams, "stable_fluids" {
    pressure: pressure, Kind::Word(<Pressure as crate::words::Named>::WORDS), "how the pressure is found";
    sweeps: sweeps, Kind::Count(MOST), "Gauss-Seidel sweeps, of pressure and diffusion";
    cg_iterations: cg_iterations, Kind::Count(MOST), "iterations of conjugate gradients at most";
    cg_tolerance: cg_tolerance, Kind::Number(Numbers::Fraction),
        "what conjugate gradients leave, in parts of their right-hand side";
    adjoint: adjoint, Kind::Word(<Adjoint as crate::words::Named>::WORDS), "the adjoint of conjugate gradients";
    diffusion: diffusion, Kind::Number(Numbers::NotNegative), "diffusion of the density, in length^2 / time";
    initial_weight: initial_weight, Kind::Number(Numbers::NotNegative), "price of the initial velocity";
    history: history, Kind::Count(MAX_PAIRS), "pairs that it remembers";
    tolerance: tolerance, Kind::Number(Numbers::Below(1.0)),
        "converged when the objective falls by less than this part of itself, twice in a row";
});

impl FluidsParams {
    /// Checks the problem and every choice.
    ///
    /// # Errors
    /// [`PlanError`] names the first that is wrong.
    pub fn check(&self, problem: &Problem<'_>, dims: usize) -> Result<(), PlanError> {
        let given = problem.cells.len();
        if given != dims {
            return Err(ProblemError::Dimensions {
                expected: dims,
                given,
            }
            .into());
        }
        let unfit = |&feature: &Feature| problem.asks_for(feature) && !takes(feature);
        if let Some(&feature) = <Feature as crate::words::Named>::ALL
            .iter()
            .find(|feature| unfit(feature))
        {
            return Err(ProblemError::Unfit {
                method: NAME,
                feature,
            }
            .into());
        }
        let bare = Problem {
            keyframes: &[],
            keyframe_weights: &[],
            templates: &[],
            ..*problem
        };
        bare.check()?;
        check_keyframes(problem)?;
        check_templates(problem)?;
        Choices::check(self)?;
        count(
            "iterations",
            self.iterations,
            crate::method::params::MAX_ITERATIONS,
        )?;
        count("threads", self.threads, crate::method::params::MAX_THREADS)?;
        self.check_search(problem)
    }

    fn check_search(&self, problem: &Problem<'_>) -> Result<(), PlanError> {
        if self.adjoint == Adjoint::SecondSolve && self.pressure == Pressure::GaussSeidel {
            return Err(ProblemError::SecondSolve.into());
        }
        if self.controls.has(Control::Templates) && problem.templates.is_empty() {
            return Err(ProblemError::NoTemplate.into());
        }
        if !self.controls.is_empty() && problem.keyframes.is_empty() {
            return Err(ProblemError::NoKeyframe.into());
        }
        match self.slots {
            Slots::States(given) if !(1..=problem.steps).contains(&given) => {
                let steps = problem.steps;
                Err(ProblemError::Slots { given, steps }.into())
            }
            _ => Ok(()),
        }
    }
}

/// Whether the method can do what a problem may ask for.
fn takes(feature: Feature) -> bool {
    matches!(feature, Feature::Buoyancy | Feature::Templates)
}

fn check_keyframes(problem: &Problem<'_>) -> Result<(), ProblemError> {
    let steps = problem.steps;
    if let Some(&step) = problem.keyframes.iter().find(|step| !(1..=steps).contains(step)) {
        return Err(ProblemError::KeyframeFrom1 { step, steps });
    }
    let mut pairs = problem.keyframes.iter().zip(problem.keyframes.iter().skip(1));
    if let Some((_, &step)) = pairs.find(|(before, step)| before >= step) {
        return Err(ProblemError::Order { step });
    }
    if problem.keyframe_weights.len() > problem.keyframes.len() {
        let given = problem.keyframe_weights.len();
        return Err(ProblemError::Weights { given });
    }
    let mut weights = problem.keyframe_weights.iter();
    weights.try_for_each(|&weight| crate::problem::positive("keyframe.weight", weight))
}

/// There is a force for every step here, the first and the last too.
fn check_templates(problem: &Problem<'_>) -> Result<(), ProblemError> {
    for (index, template) in problem.templates.iter().enumerate() {
        if !matches!(template.kind, TemplateKind::Wind | TemplateKind::Vortex) {
            let error = TemplateError::Kind { method: NAME };
            return Err(ProblemError::Template { index, error });
        }
        template.check(index, problem, problem.steps)?;
    }
    Ok(())
}
