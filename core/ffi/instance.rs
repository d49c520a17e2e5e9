//! The instance in its memory, and how a call enters it.
//!
//! The caller's block holds the instance first, with the solver's header, and behind it the solver's own block. The instance points
//! into that block, so it must not be moved; its mark holds its address, and a copy elsewhere is not taken for an instance.

use crate::config::{ConfigError, ThuribleConfig, ThuriblePrecision};
use crate::result::{ThuribleResult, ThuribleStatus};
use core::cell::UnsafeCell;
use core::fmt;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use thurible_core::{
    D2, D3, Exec, InputError, Objective, Observer, Params, Plan, Problem, Progress, Real, SavedError, Solver,
    Space, Status,
};

/// A solver of either precision in either dimension.
#[derive(Debug)]
pub enum AnySolver<'m> {
    /// 2D in `f32`.
    Plane32(Solver<'m, f32, D2>),
    /// 2D in `f64`.
    Plane64(Solver<'m, f64, D2>),
    /// 3D in `f32`.
    Space32(Solver<'m, f32, D3>),
    /// 3D in `f64`.
    Space64(Solver<'m, f64, D3>),
}

/// Calls the same method of whichever it is.
#[macro_export]
macro_rules! each {
    ($any:expr, $solver:ident => $call:expr) => {
        match $any {
            $crate::instance::AnySolver::Plane32($solver) => $call,
            $crate::instance::AnySolver::Plane64($solver) => $call,
            $crate::instance::AnySolver::Space32($solver) => $call,
            $crate::instance::AnySolver::Space64($solver) => $call,
        }
    };
}

/// The sizes of a solve.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// Steps N.
    pub steps: usize,
    /// Axes.
    pub dims: usize,
    /// Keyframes.
    pub keyframes: usize,
    /// Cells.
    pub cells: usize,
    /// Bytes of a number.
    pub precision: usize,
    /// Threads planned for.
    pub threads: usize,
}

/// How a solve goes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct ThuribleProgress {
    /// How the solve ended, or that it goes on.
    pub status: ThuribleStatus,
    /// Iterations so far.
    pub iteration: usize,
    /// Data term of the objective.
    pub data: f64,
    /// Force term of the objective.
    pub force: f64,
    /// Cells of the grid that the direct method or L-BFGS worked on.
    pub cells: [usize; 3],
    /// That grid, 0 for the finest.
    pub level: usize,
    /// Iteration on that grid.
    pub level_iteration: usize,
    /// Step along the direction, of the direct method or L-BFGS; blending step of ADMM.
    pub step: f64,
    /// Objectives computed in the iteration, of the direct method or L-BFGS.
    pub evaluations: usize,
    /// ADMM: change of the densities over the largest.
    pub density_change: f64,
    /// ADMM: max |v - v*| over max |v|.
    pub gap: f64,
    /// ADMM: the largest violation of the conditions of an optimum.
    pub kkt: f64,
}

impl From<&Progress> for ThuribleProgress {
    fn from(progress: &Progress) -> Self {
        let Progress {
            iteration,
            status,
            objective,
            admm,
            direct,
        } = progress;
        Self {
            status: (*status).into(),
            iteration: *iteration,
            data: objective.data,
            force: objective.force,
            cells: direct.cells,
            level: direct.level,
            level_iteration: direct.level_iteration,
            step: if direct.level_iteration > 0 {
                direct.step
            } else {
                admm.ao_step
            },
            evaluations: direct.evaluations,
            density_change: admm.density_change,
            gap: admm.gap,
            kkt: admm.kkt,
        }
    }
}

/// Why the last call was refused.
#[derive(Clone, Copy, Debug)]
pub enum Refusal {
    /// As the code says.
    Result(ThuribleResult),
    /// A field was refused.
    Input(InputError),
    /// Saved bytes were refused.
    Saved(SavedError),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Result(ThuribleResult::Ok) => Ok(()),
            Self::Result(result) => f.write_str(result.words()),
            Self::Input(error) => error.fmt(f),
            Self::Saved(error) => error.fmt(f),
        }
    }
}

impl From<ThuribleResult> for Refusal {
    fn from(result: ThuribleResult) -> Self {
        Self::Result(result)
    }
}

impl From<InputError> for Refusal {
    fn from(error: InputError) -> Self {
        Self::Input(error)
    }
}

impl From<SavedError> for Refusal {
    fn from(error: SavedError) -> Self {
        Self::Saved(error)
    }
}

impl Refusal {
    fn result(self) -> ThuribleResult {
        match self {
            Self::Result(result) => result,
            Self::Input(error) => error.into(),
            Self::Saved(error) => error.into(),
        }
    }
}

/// What an instance is made of.
#[derive(Debug)]
pub struct Body {
    /// The solver.
    pub solver: AnySolver<'static>,
    /// Its sizes.
    pub sizes: Sizes,
    /// How far it is.
    pub progress: ThuribleProgress,
    refusal: Refusal,
}

impl Body {
    /// One iteration.
    pub fn step(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) {
        self.progress = each!(&mut self.solver, solver => step_of(solver, exec, observer));
    }

    /// Makes the result feasible.
    pub fn finish(&mut self, exec: &dyn Exec) {
        match each!(&mut self.solver, solver => finish_of(solver, exec)) {
            Ok(Objective { data, force }) => (self.progress.data, self.progress.force) = (data, force),
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

/// A solve in memory of the caller: a handle, whose inside is the library's.
#[repr(align(64))]
pub struct Thurible {
    mark: AtomicUsize,
    busy: AtomicBool,
    body: UnsafeCell<Body>,
}

/// What marks an instance, together with its address.
const MARK: usize = 0x5468_7572;
/// Alignment of the caller's memory.
pub const ALIGN: usize = if align_of::<Thurible>() > Plan::ALIGN {
    align_of::<Thurible>()
} else {
    Plan::ALIGN
};
/// Where the solver's block begins.
const BLOCK: usize = size_of::<Thurible>().next_multiple_of(ALIGN);

fn mark(instance: *const Thurible) -> usize {
    MARK ^ instance.addr()
}

/// Bytes of an instance, and of one that is saved.
#[derive(Clone, Copy, Debug)]
pub struct Planned {
    /// The caller's memory.
    pub bytes: usize,
    /// A saved instance.
    pub saved: usize,
}

/// Plans an instance.
///
/// # Errors
/// [`ConfigError`].
///
/// # Safety
/// `config.keyframes` points to `keyframe_count` numbers.
pub unsafe fn plan(config: &ThuribleConfig) -> Result<Planned, ConfigError> {
    // SAFETY: the caller's promise.
    let planned = unsafe {
        config.with(|problem, params| match choose(config)? {
            (ThuriblePrecision::F32, 2) => sizes_of::<f32, D2>(problem, params),
            (ThuriblePrecision::F64, 2) => sizes_of::<f64, D2>(problem, params),
            (ThuriblePrecision::F32, _) => sizes_of::<f32, D3>(problem, params),
            (ThuriblePrecision::F64, _) => sizes_of::<f64, D3>(problem, params),
        })
    };
    planned.flatten()
}

// Functions of one kind of solver are not inlined where the kind is chosen, so that the stack of one call serves them in turn.

#[inline(never)]
fn sizes_of<T: Real, S: Space>(problem: &Problem<'_>, params: &Params) -> Result<Planned, ConfigError> {
    let plan = Plan::new::<T, S>(problem, params)?;
    let bytes = plan
        .bytes()
        .checked_add(BLOCK)
        .ok_or(ConfigError::Result(ThuribleResult::TooLarge))?;
    Ok(Planned {
        bytes,
        saved: plan.saved_bytes(),
    })
}

/// Precision and dimension.
fn choose(config: &ThuribleConfig) -> Result<(ThuriblePrecision, u32), ConfigError> {
    match config.precision {
        4 => Ok((ThuriblePrecision::F32, config.dimensions)),
        8 => Ok((ThuriblePrecision::F64, config.dimensions)),
        given => Err(ConfigError::Code {
            field: "precision",
            given,
        }),
    }
}

/// Makes an instance in the first bytes of `memory`.
///
/// # Errors
/// [`ThuribleResult`].
///
/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses while the instance lives; `config.keyframes` points to
/// `keyframe_count` numbers.
pub unsafe fn make(
    memory: *mut u8,
    bytes: usize,
    config: &ThuribleConfig,
) -> Result<*mut Thurible, ThuribleResult> {
    if memory.is_null() {
        return Err(ThuribleResult::Null);
    }
    if !memory.addr().is_multiple_of(ALIGN) {
        return Err(ThuribleResult::Misaligned);
    }
    // SAFETY: the caller's promise.
    let Planned { bytes: needed, .. } = unsafe { plan(config) }.map_err(ConfigError::result)?;
    if bytes < needed {
        return Err(ThuribleResult::TooSmall);
    }
    // SAFETY: `needed` bytes are there and no more than the address space, the instance takes `BLOCK` of them, and the rest is the
    // solver's alone: nothing else of this library points there.
    let block: &'static mut [MaybeUninit<u8>] =
        unsafe { core::slice::from_raw_parts_mut(memory.add(BLOCK).cast(), needed - BLOCK) };
    let dims = if config.dimensions == 2 { 2 } else { 3 };
    let sizes = Sizes {
        steps: config.steps,
        dims,
        keyframes: config.keyframe_count,
        cells: config.cells.iter().take(dims).product(),
        precision: if config.precision == 4 { 4 } else { 8 },
        threads: config.threads,
    };
    let instance: *mut Thurible = memory.cast();
    // SAFETY: the caller's promise; `instance` is aligned, and the bytes before the solver's block are its own.
    let made = unsafe {
        config.with(
            |problem, params| match choose(config).map_err(ConfigError::result)? {
                (ThuriblePrecision::F32, 2) => {
                    place(instance, sizes, problem, params, block, AnySolver::Plane32)
                }
                (ThuriblePrecision::F64, 2) => {
                    place(instance, sizes, problem, params, block, AnySolver::Plane64)
                }
                (ThuriblePrecision::F32, _) => {
                    place(instance, sizes, problem, params, block, AnySolver::Space32)
                }
                (ThuriblePrecision::F64, _) => {
                    place(instance, sizes, problem, params, block, AnySolver::Space64)
                }
            },
        )
    };
    made.map_err(ConfigError::result)??;
    Ok(instance)
}

/// Makes a solver of one kind in `block` and the instance where it belongs.
///
/// # Safety
/// `instance` is aligned and points to the bytes of an instance.
#[inline(never)]
unsafe fn place<T: Real, S: Space>(
    instance: *mut Thurible,
    sizes: Sizes,
    problem: &Problem<'_>,
    params: &Params,
    block: &'static mut [MaybeUninit<u8>],
    wrap: fn(Solver<'static, T, S>) -> AnySolver<'static>,
) -> Result<(), ThuribleResult> {
    let solver = wrap(Solver::new(problem, params, block)?);
    let body = Body {
        solver,
        sizes,
        progress: ThuribleProgress::default(),
        refusal: ThuribleResult::Ok.into(),
    };
    // SAFETY: the caller's promise.
    unsafe {
        instance.write(Thurible {
            mark: AtomicUsize::new(mark(instance)),
            busy: AtomicBool::new(false),
            body: UnsafeCell::new(body),
        })
    };
    Ok(())
}

/// One iteration of one kind.
#[inline(never)]
fn step_of<T: Real, S: Space>(
    solver: &mut Solver<'_, T, S>,
    exec: &dyn Exec,
    observer: &mut dyn Observer,
) -> ThuribleProgress {
    ThuribleProgress::from(&solver.step(exec, observer))
}

/// The end of one kind.
#[inline(never)]
fn finish_of<T: Real, S: Space>(solver: &mut Solver<'_, T, S>, exec: &dyn Exec) -> Result<Objective, Status> {
    solver.finish(exec)
}

/// Enters an instance: one call at a time.
///
/// # Safety
/// `instance` is null or points to readable memory of an instance's size.
pub unsafe fn enter(
    instance: *const Thurible,
    work: impl FnOnce(&mut Body) -> Result<(), Refusal>,
) -> ThuribleResult {
    if instance.is_null() {
        return ThuribleResult::Null;
    }
    if !instance.is_aligned() {
        return ThuribleResult::Misaligned;
    }
    // SAFETY: aligned and readable; an atomic has no wrong pattern of bits.
    let found = unsafe { (&raw const (*instance).mark).as_ref() };
    if found.is_none_or(|found| found.load(Ordering::Acquire) != mark(instance)) {
        return ThuribleResult::NoInstance;
    }
    // SAFETY: the mark says that here is an instance.
    let Thurible { busy, body, .. } = unsafe { &*instance };
    if busy.swap(true, Ordering::Acquire) {
        return ThuribleResult::Busy;
    }
    // SAFETY: `busy` was false and is true now, so nobody else is in the body.
    let body = unsafe { &mut *body.get() };
    let refused = work(body).err().unwrap_or(ThuribleResult::Ok.into());
    body.refusal = refused;
    busy.store(false, Ordering::Release);
    refused.result()
}

/// Ends an instance, so that its handle is refused from now on.
///
/// # Safety
/// As [`enter`].
pub unsafe fn close(instance: *mut Thurible) -> ThuribleResult {
    // SAFETY: the caller's promise.
    let result = unsafe { enter(instance, |_| Ok(())) };
    if result == ThuribleResult::Ok {
        // SAFETY: an instance is there. It has nothing to give back: its memory is the caller's.
        unsafe { (*instance).mark.store(0, Ordering::Release) };
    }
    result
}

/// Writes why the last call that entered the instance was refused.
///
/// # Safety
/// As [`enter`]; `buffer` is null or points to `size` bytes.
pub unsafe fn message(instance: *const Thurible, buffer: *mut core::ffi::c_char, size: usize) -> usize {
    let mut last = Refusal::Result(ThuribleResult::Ok);
    let read = |body: &mut Body| {
        last = body.refusal;
        Err(last)
    };
    // SAFETY: the caller's promise.
    let found = unsafe { enter(instance, read) };
    if let (Refusal::Result(ThuribleResult::Ok), false) = (last, found == ThuribleResult::Ok) {
        last = found.into();
    }
    // SAFETY: the caller's promise.
    unsafe { crate::text::write(buffer, size, &last) }
}
