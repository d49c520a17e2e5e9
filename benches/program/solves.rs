//! Whole solves and their iterations on the clock.

use super::prepared::PreparedScene;
use super::process::resident;
use super::timing::timed;
use core::ops::ControlFlow;
use std::fs;
use std::time::Instant;
use thurible::exit::Failure;
use thurible::problem::Precision;
use thurible_core::{Exec, Progress, Real, Silent, Solver, Space, Status};

/// How close to the final objective counts as there.
const NEAR: f64 = 1.01;

/// Iterations on the finest grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Iterations {
    /// Seconds of one: the median, since other machines on the same chip disturb some.
    pub seconds: f64,
    /// Objectives that one computes, on average.
    pub evaluations: f64,
    /// The largest Courant number at the end.
    pub courant: f64,
    /// Bytes of the block by its plan.
    pub planned: usize,
    /// Bytes that became resident, where the system tells.
    pub touched: Option<usize>,
}

/// Iterations `first` to `last` on the finest grid, from 1, and as many after them, on each of `execs` in turn. What comes before
/// them runs on the last one.
pub(super) fn iterations<T: Real, S: Space, const N: usize>(
    execs: [&dyn Exec; N],
    prepared: &PreparedScene,
    [first, last]: [usize; 2],
) -> Result<[Iterations; N], Failure> {
    let planned = prepared.plan(Precision::of::<T>())?.bytes();
    let before = forget_peak();
    prepared.with::<T, S, _>(execs[N - 1], |solver| {
        let mut number = 1;
        while number < first {
            let progress = solver.step(execs[N - 1], &mut Silent);
            number += usize::from(progress.level == 0);
        }
        execs.map(|exec| {
            let (mut evaluations, count) = (0, last + 1 - first);
            let mut seconds: Vec<f64> = (0..count)
                .map(|_| timed(|| evaluations += evaluated(&solver.step(exec, &mut Silent))))
                .collect();
            seconds.sort_by(f64::total_cmp);
            let touched = resident("VmHWM:")
                .zip(before)
                .map(|(most, before)| most.saturating_sub(before));
            let evaluations = evaluations as f64 / count as f64;
            Iterations {
                seconds: seconds[count / 2],
                evaluations,
                courant: prepared.courant(solver),
                planned,
                touched,
            }
        })
    })
}

/// Forgets the largest memory that this process had so far; what it has now, where the system tells and lets one.
fn forget_peak() -> Option<usize> {
    fs::write("/proc/self/clear_refs", "5").ok()?;
    resident("VmRSS:")
}

/// A solve until it was good enough.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reached {
    /// Seconds from the first iteration, which may be on a coarser grid; `None` if it was never good enough.
    pub seconds: Option<f64>,
    /// Iterations until then, on all grids.
    pub iterations: usize,
}

/// Solves to the end: when the objective was within 1 % of the last.
pub(super) fn to_final<S: Space>(exec: &dyn Exec, prepared: &PreparedScene) -> Result<Reached, Failure> {
    prepared.with::<f32, S, _>(exec, |solver| {
        let mut path = Vec::new();
        watch(exec, solver, |_, progress, seconds| {
            path.push((
                seconds,
                if progress.level == 0 {
                    progress.objective.total()
                } else {
                    f64::INFINITY
                },
            ));
            ControlFlow::Continue(())
        });
        let last = solver
            .finish(exec)
            .map_or(f64::NAN, |objective| objective.total());
        reached(&path, NEAR * last)
    })
}

/// Solves to the end of ADMM's own rule.
pub(super) fn to_stop<S: Space>(exec: &dyn Exec, prepared: &PreparedScene) -> Result<Reached, Failure> {
    prepared.with::<f32, S, _>(exec, |solver| {
        let mut reached = Reached {
            seconds: None,
            iterations: 0,
        };
        watch(exec, solver, |_, progress, seconds| {
            let converged = progress.status == Some(Status::Converged);
            reached = Reached {
                seconds: converged.then_some(seconds),
                iterations: progress.iteration,
            };
            ControlFlow::Continue(())
        });
        reached
    })
}

/// Solves until half the squared distance from the last keyframe, without any blur, is `part` of what it was at rest.
pub(super) fn to_part<T: Real, S: Space>(
    exec: &dyn Exec,
    prepared: &PreparedScene,
    part: f64,
) -> Result<Reached, Failure> {
    let (steps, last) = (prepared.problem().steps, prepared.problem().keyframes.len() - 1);
    prepared.with::<T, S, _>(exec, |solver| {
        let at_rest = distance(solver.density(0), solver.keyframe(last));
        let mut path = Vec::new();
        watch(exec, solver, |solver, progress, seconds| {
            let on_finest = progress.level == 0;
            let distance = if on_finest {
                distance(solver.density(steps), solver.keyframe(last))
            } else {
                f64::INFINITY
            };
            path.push((seconds, distance));
            if distance <= part * at_rest {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        reached(&path, part * at_rest)
    })
}

/// Calls `each` after every iteration with the seconds until then, to the end or a break.
fn watch<'m, T: Real, S: Space>(
    exec: &dyn Exec,
    solver: &mut Solver<'m, T, S>,
    mut each: impl FnMut(&Solver<'m, T, S>, &Progress, f64) -> ControlFlow<()>,
) {
    let began = Instant::now();
    loop {
        let progress = solver.step(exec, &mut Silent);
        if each(solver, &progress, began.elapsed().as_secs_f64()).is_break() || progress.status.is_some() {
            return;
        }
    }
}

/// When a path of seconds and values came down to `goal`.
fn reached(path: &[(f64, f64)], goal: f64) -> Reached {
    let index = path.iter().position(|&(_, value)| value <= goal);
    Reached {
        seconds: index.map(|index| path[index].0),
        iterations: index.map_or(path.len(), |index| index + 1),
    }
}

fn distance<T: Real>(a: &[T], b: &[T]) -> f64 {
    a.iter().zip(b).map(|(&a, &b)| (a - b).to_f64().powi(2)).sum()
}

/// How often an iteration computed the objective.
fn evaluated(progress: &Progress) -> usize {
    progress.report.get("evaluations").unwrap_or(0.0) as usize
}
