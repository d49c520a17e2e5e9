//! One variant of one case: its block of memory, its steps.

use super::cases::{Case, Variant};
use super::planned::{Line, Planned, refused};
use crate::bytes::{grouped, rounded};
use crate::exit::Failure;
use crate::interrupt::Interrupt;
use crate::problem::Precision;
use crate::progress::{Clock, Display, in_words};
use crate::region::{Region, touch};
use crate::report::count;
use crate::threads;
use core::mem::MaybeUninit;
use core::ops::ControlFlow;
use serde_json::json;
use thurible_core::condense::{BUILD, CondenseParams, Condenser, DIRECTION, SEARCH, Step, Topology};
use thurible_core::{Event, Exec, Observer, Real, Status};

/// What a run came to.
pub(super) struct Outcome {
    pub params: CondenseParams,
    pub precision: Precision,
    pub status: Status,
    /// Of each step that was begun.
    pub iterations: Vec<usize>,
    pub builds: Vec<usize>,
    /// Before each iteration and at each end, step after step.
    pub energy: Vec<f64>,
    pub residual: Vec<f64>,
    /// Seconds from the first step to there.
    pub at: Vec<f64>,
    /// The rest state and those at the ends of steps, one after the other.
    pub position: Vec<f64>,
    /// The step that it ended in, from 1.
    pub ended_in: usize,
    /// Build, direction, search.
    pub seconds: [f64; 3],
    pub total: f64,
    pub planned: usize,
    pub used: usize,
    pub ledger: Vec<Line>,
}

impl Outcome {
    /// Keeps the last state alone, of `numbers` numbers: all that a page draws.
    pub fn keep_last(&mut self, numbers: usize) {
        let before = self.position.len().saturating_sub(numbers);
        self.position.drain(..before);
        self.position.shrink_to_fit();
    }
}

/// Its word in reports.
pub(super) fn status_word(status: Status) -> &'static str {
    match status {
        Status::Converged => "converged",
        Status::MaxIterations => "cap",
        Status::Stalled => "stalled",
        Status::Cancelled => "cancelled",
        Status::NotFinite | Status::NotReady => "not_finite",
    }
}

/// Takes the time of the pieces, and stops where the user asks for it.
struct Watch<'a> {
    interrupt: &'a Interrupt,
    display: &'a Display,
    clock: Clock,
}

impl Observer for Watch<'_> {
    fn on(&mut self, event: Event) -> ControlFlow<()> {
        match event {
            Event::PhaseBegin(phase) => self.clock.enter(phase.name),
            Event::PhaseEnd(_) => self.clock.leave(),
            _ => self.display.tick(),
        }
        if self.interrupt.asked() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// Who is told, and who may stop it.
#[derive(Clone, Copy)]
pub(super) struct Listeners<'a> {
    pub interrupt: &'a Interrupt,
    pub display: &'a Display,
    pub precision: Precision,
}

/// Solves a planned variant.
pub(super) fn run(
    case: &Case,
    variant: &Variant,
    planned: &Planned,
    listeners: Listeners<'_>,
) -> Result<Outcome, Failure> {
    let bytes = planned.plan.bytes();
    let no_memory = || {
        Failure::Memory(format!(
            "the system has not the {} bytes that {} needs; close other programs, or give a coarser mesh",
            grouped(bytes),
            variant.name
        ))
    };
    announce(case, variant, planned, listeners);
    let mut region = Region::new(bytes).ok_or_else(no_memory)?;
    let used = region.footprint() + 4 * planned.words;
    let block = region.carve(bytes).ok_or_else(no_memory)?;
    touch(block);
    let count = planned.params.threads;
    let outcome = threads::with(count, || {
        threads::together(count, |exec| dispatch(exec, case, planned, listeners, block))
    })??;
    Ok(Outcome { used, ..outcome })
}

fn announce(case: &Case, variant: &Variant, planned: &Planned, listeners: Listeners<'_>) {
    let mesh = &case.problem.mesh;
    listeners.display.event(
        "variant",
        json!({ "case": case.label, "name": variant.name, "vertices": mesh.held.len(), "elements": mesh.mesh().count(),
                "planned_bytes": planned.bytes(), "threads": planned.params.threads }),
    );
    let label = if case.label.is_empty() {
        String::new()
    } else {
        format!("{}: ", case.label)
    };
    listeners.display.note(&format!(
        "{label}{}: {} vertices, {} elements, {} bytes ({}) in {}, {}",
        variant.name,
        mesh.held.len(),
        mesh.mesh().count(),
        grouped(planned.bytes()),
        rounded(planned.bytes()),
        listeners.precision.name(),
        count(planned.params.threads, "thread")
    ));
}

fn dispatch(
    exec: &dyn Exec,
    case: &Case,
    planned: &Planned,
    listeners: Listeners<'_>,
    block: &mut [MaybeUninit<u8>],
) -> Result<Outcome, Failure> {
    match (case.problem.mesh.dims, listeners.precision) {
        (1, Precision::F32) => solve::<f32, 1>(exec, case, planned, listeners, block),
        (1, Precision::F64) => solve::<f64, 1>(exec, case, planned, listeners, block),
        (2, Precision::F32) => solve::<f32, 2>(exec, case, planned, listeners, block),
        (2, Precision::F64) => solve::<f64, 2>(exec, case, planned, listeners, block),
        (_, Precision::F32) => solve::<f32, 3>(exec, case, planned, listeners, block),
        (_, Precision::F64) => solve::<f64, 3>(exec, case, planned, listeners, block),
    }
}

fn solve<T: Real, const D: usize>(
    exec: &dyn Exec,
    case: &Case,
    planned: &Planned,
    listeners: Listeners<'_>,
    block: &mut [MaybeUninit<u8>],
) -> Result<Outcome, Failure> {
    let (problem, mesh) = (&case.problem, case.problem.mesh.mesh());
    let mut words = vec![0; planned.words];
    let refuse = |error| refused(case, &error);
    let topology = Topology::new(&mesh, planned.params.radius, &mut words).map_err(refuse)?;
    let mut condenser = Condenser::<T, D>::new(mesh, topology, planned.params, block).map_err(refuse)?;
    if let Some((vertex, value)) = &problem.impulse {
        let mut velocity = vec![0.0; problem.mesh.rest.len()];
        let mass = condenser.mass(*vertex);
        for (to, from) in velocity.iter_mut().skip(vertex * D).zip(value) {
            *to = from / mass;
        }
        condenser.set_velocity(&velocity).map_err(refuse)?;
    }
    let mut watch = Watch {
        interrupt: listeners.interrupt,
        display: listeners.display,
        clock: Clock::start(),
    };
    let start = Clock::start();
    let mut outcome = Outcome {
        params: planned.params,
        precision: listeners.precision,
        status: Status::Converged,
        iterations: Vec::new(),
        builds: Vec::new(),
        energy: Vec::new(),
        residual: Vec::new(),
        at: Vec::new(),
        position: Vec::new(),
        ended_in: 0,
        seconds: [0.0; 3],
        total: 0.0,
        planned: planned.bytes(),
        used: 0,
        ledger: planned.ledger(),
    };
    outcome.position.extend(positions(&condenser));
    for index in 0..problem.steps {
        let (shift, gravity) = load(case, index);
        let told = outcome.energy.len();
        let step = Step {
            shift: &shift,
            gravity,
        };
        let stepped = condenser.step(exec, &step, &mut watch, &mut |state| {
            outcome.energy.push(state.energy);
            outcome.residual.push(state.residual);
            outcome.at.push(start.total());
        });
        let stepped = stepped.map_err(refuse)?;
        (outcome.status, outcome.ended_in) = (stepped.status, index + 1);
        // Stopped before its build, a step has no state.
        if outcome.energy.len() == told {
            break;
        }
        outcome.iterations.push(stepped.iterations);
        outcome.builds.push(stepped.builds);
        outcome.position.extend(positions(&condenser));
        show(&outcome, index, problem.steps, listeners.display, &start);
        if stepped.status != Status::Converged {
            break;
        }
    }
    outcome.total = start.total();
    outcome.seconds = [BUILD, DIRECTION, SEARCH].map(|phase| watch.clock.spent(phase.name).seconds());
    Ok(outcome)
}

/// What happens before step `index`: moves of vertices and the acceleration.
fn load(case: &Case, index: usize) -> (Vec<f64>, [f64; 3]) {
    let problem = &case.problem;
    let part = if problem.params.dt.is_some() {
        1.0
    } else {
        (index + 1) as f64 / problem.steps as f64
    };
    let mut shift = problem.moves.clone();
    if index == 0 && !problem.bump.is_empty() {
        shift.resize(problem.bump.len(), 0.0);
        shift
            .iter_mut()
            .zip(&problem.bump)
            .for_each(|(to, from)| *to += from);
    }
    (shift, problem.gravity.map(|along| part * along))
}

fn positions<T: Real, const D: usize>(condenser: &Condenser<'_, T, D>) -> impl Iterator<Item = f64> {
    (0..condenser.vertices()).flat_map(|vertex| condenser.position(vertex).into_iter().take(D))
}

fn show(outcome: &Outcome, index: usize, steps: usize, display: &Display, start: &Clock) {
    let last = |list: &[usize]| list.last().copied().unwrap_or_default();
    let energy = outcome.energy.last().copied().unwrap_or_default();
    let residual = outcome.residual.last().copied().unwrap_or_default();
    let iterations = last(&outcome.iterations);
    display.event(
        "step",
        json!({ "step": index + 1, "iterations": iterations, "builds": last(&outcome.builds), "energy": energy, "residual": residual,
                "status": status_word(outcome.status), "seconds": start.total() }),
    );
    let left = start.total() / (index + 1) as f64 * (steps - index - 1) as f64;
    display.piece(
        index + 1,
        &format!(
            "{iterations} iterations, residual {residual:.1e}, {} left",
            in_words(left)
        ),
    );
}
