//! What an instance is made of.

use super::any::Any;
use super::handle::Handle;
use super::progress::ThuribleProgress;
use crate::config::ThuribleConfig;
use crate::each;
use crate::result::ThuribleStatus;
use thurible_core::{D2, D3, Exec, InputError, Objective, Observer, Real, Report, Solver, Space, Status};

/// A solver of either precision in either dimension.
pub type AnySolver<'m> =
    Any<Solver<'m, f32, D2>, Solver<'m, f64, D2>, Solver<'m, f32, D3>, Solver<'m, f64, D3>>;

/// A solve in memory of the caller: a handle, whose inside is the library's.
pub struct Thurible {
    _inside: (),
}

impl Handle for Thurible {
    type Body = Body;
    const MARK: usize = 0x5468_7572;
}

/// The sizes of a solve.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// Steps N; densities have one more.
    pub steps: usize,
    /// Axes of the box, 2 or 3.
    pub dims: usize,
    /// How many keyframes there are.
    pub keyframes: usize,
    /// How many regions of keyframes there are.
    pub regions: usize,
    /// How many emitters there are.
    pub emitters: usize,
    /// Cells of the finest grid.
    pub cells: usize,
    /// Bytes of an element of a field: 4 or 8.
    pub precision: usize,
    /// Threads that scratch is planned for.
    pub threads: usize,
}

impl Sizes {
    pub(super) fn of(config: &ThuribleConfig) -> Self {
        let dims = if config.dimensions == 2 { 2 } else { 3 };
        Self {
            steps: config.steps,
            dims,
            keyframes: config.keyframe_count,
            regions: if config.keyframe_regions == 0 {
                0
            } else {
                config.keyframe_count
            },
            emitters: config.emitter_count,
            cells: config.cells.iter().take(dims).product(),
            precision: if config.precision == 4 { 4 } else { 8 },
            threads: config.threads,
        }
    }
}

/// What an instance is made of.
#[derive(Debug)]
pub struct Body {
    /// The solver, in the block behind the instance.
    pub solver: AnySolver<'static>,
    /// The solver's sizes, which calls check against.
    pub sizes: Sizes,
    /// How far it is.
    pub progress: ThuribleProgress,
    /// What the method reported of the last iteration.
    pub report: Report,
}

impl Body {
    /// Runs one iteration of the method and keeps its progress and what it reports.
    pub fn step(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) {
        let Self {
            solver,
            progress,
            report,
            ..
        } = self;
        each!(solver, solver => step_of(solver, exec, observer, progress, report));
    }

    /// Makes the result feasible.
    pub fn finish(&mut self, exec: &dyn Exec) {
        match each!(&mut self.solver, solver => finish_of(solver, exec)) {
            Ok(Objective { data, force, .. }) => {
                (self.progress.data, self.progress.force) = (data, force);
                // The last flow that was finite is a result.
                if self.progress.status == ThuribleStatus::NotFinite {
                    self.progress.status = ThuribleStatus::Stalled;
                }
            }
            Err(status) => self.progress.status = Some(status).into(),
        }
    }

    /// Projects v_0 once all densities are there; by how much that changed it.
    ///
    /// # Errors
    /// [`InputError`].
    pub fn prepare(&mut self, exec: &dyn Exec) -> Result<f64, InputError> {
        each!(&mut self.solver, solver => solver.prepare(exec))
    }
}

// Functions of one type of solver are not inlined where the type is chosen, so that one frame of the stack serves them in turn.

/// One iteration by one type of solver.
#[inline(never)]
fn step_of<T: Real, S: Space>(
    solver: &mut Solver<'_, T, S>,
    exec: &dyn Exec,
    observer: &mut dyn Observer,
    progress: &mut ThuribleProgress,
    report: &mut Report,
) {
    let told = solver.step(exec, observer);
    *progress = ThuribleProgress::from(&told);
    *report = told.report;
}

/// The end of a solve by one type of solver.
#[inline(never)]
fn finish_of<T: Real, S: Space>(solver: &mut Solver<'_, T, S>, exec: &dyn Exec) -> Result<Objective, Status> {
    solver.finish(exec)
}
