//! The plan of a scene under a ceiling: as many states as it holds.

use crate::bytes::{self, grouped};
use crate::console::print;
use crate::exit::Failure;
use crate::ledger::{line, over, print_least, print_ledger};
use crate::plan::{PlanOptions, size_in_words};
use crate::problem::{self, OwnedProblem, Precision};
use crate::region::MARGIN;
use crate::report::count;
use crate::scene::Scene;
use crate::threads;
use serde_json::{Value, json};
use thurible_core::problem::TemplateError;
use thurible_core::stable_fluids::{Adjoint, Control, Controls, NAME, Slots};
use thurible_core::{D2, D3, FluidsParams, FluidsPlan, PlanError, ProblemError};

/// A plan, and what it was made from.
pub(crate) struct Planned {
    pub problem: OwnedProblem,
    pub params: FluidsParams,
    pub precision: Precision,
    pub plan: FluidsPlan,
}

impl Planned {
    /// Steps that a gradient repeats.
    pub fn repeated(&self) -> usize {
        self.params.slots.repeated_steps(self.problem.steps)
    }

    /// The plan as JSON.
    pub fn fields(&self) -> Value {
        let ledger: Vec<Value> = self
            .plan
            .entries()
            .iter()
            .map(|entry| json!({ "name": entry.name, "bytes": entry.bytes, "depth": entry.depth }))
            .collect();
        json!({ "cells": self.problem.cells, "steps": self.problem.steps, "precision": self.precision.name(),
                "threads": self.params.threads, "method": NAME, "bytes": self.plan.bytes(), "slots": self.params.slots.states(),
                "recomputed_steps": self.repeated(), "ledger": ledger })
    }
}

/// Plans a scene within the ceiling: with the states that it asks for, or the most that fit; on fewer threads, if their number was not given
/// and that makes it fit.
pub(crate) fn planned(scene: &Scene, options: &PlanOptions) -> Result<Planned, Failure> {
    let problem = OwnedProblem::of(scene);
    let ceiling = options.limit.or_else(bytes::of_machine);
    let section = scene.method.fluids;
    let searched = !scene.keyframes.is_empty();
    let mut params = FluidsParams {
        initial_velocity: scene.control.initial_velocity.is_some(),
        threads: options.threads.unwrap_or_else(threads::available),
        ..section.params
    };
    let slots = if searched {
        section.slots.map(Slots::of)
    } else {
        params.controls = Controls::none();
        Some(Slots::None)
    };
    loop {
        match within(&problem, &params, options.precision, (slots, ceiling)) {
            Ok((params, plan)) => {
                return Ok(Planned {
                    problem,
                    params,
                    precision: options.precision,
                    plan,
                });
            }
            Err(PlanError::Ceiling { .. }) if options.threads.is_none() && params.threads > 1 => {
                params.threads /= 2;
            }
            Err(PlanError::Ceiling { .. }) => {
                let slots = slots.unwrap_or(Slots::States(1));
                let least = FluidsParams { slots, ..params };
                let plan = plan_of(&problem, &least, options.precision);
                let plan = plan.map_err(|error| refusal(scene, error))?;
                return Err(over_limit(scene, options, &plan, ceiling.unwrap_or(usize::MAX)));
            }
            Err(error) => return Err(refusal(scene, error)),
        }
    }
}

/// Choices and plan of a block within a ceiling, beside which the program takes a little.
fn within(
    problem: &OwnedProblem,
    params: &FluidsParams,
    precision: Precision,
    (slots, ceiling): (Option<Slots>, Option<usize>),
) -> Result<(FluidsParams, FluidsPlan), PlanError> {
    let (view, ceiling) = (
        problem.problem(),
        ceiling.map(|limit| limit.saturating_sub(MARGIN)),
    );
    match (problem.cells.len(), precision) {
        (2, Precision::F32) => FluidsPlan::within::<f32, D2>(&view, params, slots, ceiling),
        (2, Precision::F64) => FluidsPlan::within::<f64, D2>(&view, params, slots, ceiling),
        (_, Precision::F32) => FluidsPlan::within::<f32, D3>(&view, params, slots, ceiling),
        (_, Precision::F64) => FluidsPlan::within::<f64, D3>(&view, params, slots, ceiling),
    }
}

fn plan_of(
    problem: &OwnedProblem,
    params: &FluidsParams,
    precision: Precision,
) -> Result<FluidsPlan, PlanError> {
    within(problem, params, precision, (Some(params.slots), None)).map(|(_, plan)| plan)
}

/// The sentence for a plan that the core refuses.
fn refusal(scene: &Scene, error: PlanError) -> Failure {
    let refuse = |key: &str, why: String| scene.document.refuse(key, why);
    match error {
        PlanError::Problem(ProblemError::NoTemplate) => refuse(
            "method.stable_fluids.control",
            "asks for templates, but the scene has no [[template]]; write one, or take them out".into(),
        ),
        PlanError::Problem(ProblemError::SecondSolve) => refuse(
            "method.stable_fluids.adjoint",
            "is second_solve, which only conjugate gradients have; set `method.stable_fluids.pressure` to \"cg\", or take \"exact\"".into(),
        ),
        PlanError::Problem(ProblemError::Slots { given, steps }) => refuse(
            "method.stable_fluids.slots",
            format!("is {given}, more than the {steps} steps that there are; make it {steps} at most, or 0 for all that the adjoint reads"),
        ),
        PlanError::Problem(ProblemError::Template {
            index,
            error: TemplateError::Kind { .. },
        }) => refuse(
            &format!("template[{index}].kind"),
            format!("is one that the method {NAME} does not know; take \"wind\" or \"vortex\""),
        ),
        other => problem::refusal(scene, other),
    }
}

/// What would make a plan smaller.
fn remedy(plan: &FluidsPlan, params: &FluidsParams) -> Option<&'static str> {
    let bytes = |name: &str| {
        let found = plan.entries().iter().find(|entry| entry.name == name);
        found.map_or(0, |entry| entry.bytes)
    };
    let half = plan.bytes() / 2;
    if bytes("iterations of conjugate gradients") > half && params.adjoint == Adjoint::Exact {
        return Some(
            "the iterations of conjugate gradients take most of it: `method.stable_fluids.adjoint` \"second_solve\" keeps none",
        );
    }
    let vectors = bytes("unknowns") + bytes("gradient, direction and pairs of unknowns");
    (vectors > half && params.controls.has(Control::Forces)).then_some(
        "the vectors of the search take most of it: `method.stable_fluids.history` 1 keeps fewer, and templates have few unknowns",
    )
}

fn over_limit(scene: &Scene, options: &PlanOptions, plan: &FluidsPlan, limit: usize) -> Failure {
    let needed = plan.bytes().saturating_add(MARGIN);
    let section = scene.method.fluids;
    let less = match (remedy(plan, &section.params), section.slots) {
        (Some(remedy), _) => remedy,
        (None, Some(_)) => "set `method.stable_fluids.slots` to \"auto\"",
        (None, None) if options.precision == Precision::F64 => "use --precision f32",
        (None, None) => "make `grid.cells` smaller",
    };
    let (path, given) = (scene.document.path(), options.limit.is_some());
    let what = format!("{NAME} needs");
    over(path, &what, (needed, limit), given, &[less.into()])
}

/// Says what is planned, buffer by buffer, and what one more state would take.
pub(crate) fn print_plan(scene: &Scene, planned: &Planned) {
    let Planned {
        problem,
        params,
        precision,
        plan,
    } = planned;
    print(&format!(
        "{}: {} cells, {} steps, {}, {}, method {NAME}",
        scene.document.path().display(),
        size_in_words(&problem.cells),
        problem.steps,
        precision.name(),
        count(params.threads, "thread")
    ));
    print_ledger(plan.entries().iter().map(line), plan.bytes(), "");
    print_least(plan.bytes());
    let repeated = planned.repeated();
    match params.slots {
        Slots::None => {}
        Slots::Tape => print("\nslots 0: all that the adjoint reads is kept, so a gradient repeats no step"),
        Slots::States(slots) => print(&format!("\nslots {slots}: a gradient repeats {repeated} steps")),
    }
    let next = match params.slots {
        Slots::States(slots) if slots < problem.steps => Some(Slots::States(slots + 1)),
        Slots::States(_) => Some(Slots::Tape),
        _ => None,
    };
    if let Some(slots) = next
        && let Ok(more) = plan_of(problem, &FluidsParams { slots, ..*params }, *precision)
    {
        let what = match slots {
            Slots::States(slots) => format!(
                "slots {slots}, {} steps repeated",
                Slots::States(slots).repeated_steps(problem.steps)
            ),
            _ => "slots 0, none repeated".into(),
        };
        print(&format!(
            "{:>18}  is the ceiling of the next: {what}",
            grouped(more.bytes() + MARGIN)
        ));
    }
    if let Some(remedy) = remedy(plan, params) {
        print(&format!("\nnote: {remedy}"));
    }
}
