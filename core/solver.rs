//! The front door: how many bytes a solve needs, and a solver that lives in them.

use crate::admm::{Admm, AdmmParams, Dimensions, Settings};
use crate::arena::{ALIGN, Arena, TooSmall};
use crate::exec::Exec;
use crate::grid::Space;
use crate::nso::Shape;
use crate::observe::Observer;
use crate::plan::{Entry, Ledger, Sharing};
use crate::problem::keyframes::Keyframes;
use crate::problem::{Problem, ProblemError, Units};
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;
use core::fmt;
use core::mem::MaybeUninit;

/// How a problem is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// The paper's: ADMM over an advection and a Navier-Stokes problem.
    #[default]
    Admm,
}

/// What a caller chooses besides the problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params {
    /// The method.
    pub method: Method,
    /// Outer iterations at most.
    pub iterations: usize,
    /// Threads that scratch is planned for; the [`Exec`] of a step must not have more.
    pub threads: usize,
    /// Bytes that the plan should stay within if it can.
    pub ceiling: Option<usize>,
    /// Choices of ADMM.
    pub admm: AdmmParams,
}

impl Default for Params {
    fn default() -> Self {
        Self { method: Method::Admm, iterations: 60, threads: 1, ceiling: None, admm: AdmmParams::default() }
    }
}

/// Most threads that a plan serves.
pub const MAX_THREADS: usize = 1024;

/// Why a [`Plan`] is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PlanError {
    /// The problem or a parameter is wrong.
    Problem(ProblemError),
    /// `iterations` or `threads` is 0 or absurd.
    OutOfRange {
        /// The field.
        field: &'static str,
        /// The value.
        given: usize,
        /// The largest value.
        most: usize,
    },
    /// The sizes do not fit this machine's addresses.
    TooLarge,
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Problem(error) => error.fmt(f),
            Self::OutOfRange { field, given, most } => write!(f, "{field} is {given}; it must be from 1 to {most}"),
            Self::TooLarge => write!(f, "cells times steps is more than this machine can address; use fewer cells or steps"),
        }
    }
}

impl core::error::Error for PlanError {}

impl From<ProblemError> for PlanError {
    fn from(error: ProblemError) -> Self {
        Self::Problem(error)
    }
}

/// Every buffer of a solve, to the byte.
#[derive(Clone, Debug)]
pub struct Plan {
    ledger: Ledger,
    bytes: usize,
    method_bytes: usize,
    paper_bound: usize,
    shape: Shape,
}

impl Plan {
    /// Alignment that the memory must have.
    pub const ALIGN: usize = ALIGN;

    /// Plans `problem` in precision `T` and dimension `S`.
    ///
    /// # Errors
    /// [`PlanError`] when a field is wrong or sizes overflow.
    pub fn new<T: Real, S: Space>(problem: &Problem<'_>, params: &Params) -> Result<Self, PlanError> {
        check::<T, S>(problem, params)?;
        let bound = paper_bound::<T, S>(problem);
        let together: &[usize] = if S::DIM == 2 { &[8, 4, 2, 1] } else { &[1] };
        let shapes = [16, 8, 4, 1].into_iter().flat_map(|lanes| together.iter().map(move |&together| Shape { lanes, together }));
        let mut fastest = None;
        let mut smallest: Option<Self> = None;
        let mut within_ceiling = None;
        for shape in shapes {
            let plan = Self::with_shape::<T, S>(problem, params, shape, bound)?;
            let fits = params.ceiling.is_none_or(|ceiling| plan.bytes <= ceiling);
            if fits && plan.method_bytes <= bound {
                return Ok(plan);
            }
            if fits && within_ceiling.is_none() {
                within_ceiling = Some(plan.clone());
            }
            if smallest.as_ref().is_none_or(|smallest| plan.bytes < smallest.bytes) {
                smallest = Some(plan.clone());
            }
            fastest = fastest.or(Some(plan));
        }
        let chosen = if params.ceiling.is_some() { within_ceiling.or(smallest) } else { fastest };
        chosen.ok_or(PlanError::TooLarge)
    }

    fn with_shape<T: Real, S: Space>(problem: &Problem<'_>, params: &Params, shape: Shape, paper_bound: usize) -> Result<Self, PlanError> {
        let mut ledger = Ledger::new();
        let (keyframes, cells) = (problem.keyframes.len(), problem.grid().cells());
        ledger.group("the method", Sharing::Together, |ledger| {
            Admm::<T, S>::requirement(ledger, &settings(problem, params, shape));
        });
        ledger.line("keyframe steps", keyframes, 4);
        ledger.line("keyframe densities", keyframes * cells, T::BYTES);
        let bytes = ledger.bytes().ok_or(PlanError::TooLarge)?;
        let method_bytes = ledger.entries().first().map_or(0, |entry| entry.bytes);
        Ok(Self { ledger, bytes, method_bytes, paper_bound, shape })
    }

    /// Bytes of the whole block.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// Bytes of the method alone: all but the keyframes.
    #[must_use]
    pub fn method_bytes(&self) -> usize {
        self.method_bytes
    }

    /// The paper's bound for its method, 4 (1 + d) N prod(n) / (1 - 2^-d) numbers of the same precision, in bytes.
    #[must_use]
    pub fn paper_bound(&self) -> usize {
        self.paper_bound
    }

    /// The ledger, groups before their children.
    #[must_use]
    pub fn entries(&self) -> &[Entry] {
        self.ledger.entries()
    }
}

fn check<T: Real, S: Space>(problem: &Problem<'_>, params: &Params) -> Result<(), PlanError> {
    if problem.cells.len() != S::DIM {
        return Err(ProblemError::Dimensions { expected: S::DIM, given: problem.cells.len() }.into());
    }
    problem.check()?;
    params.admm.check()?;
    let ranges = [
        ("iterations", params.iterations, 1_000_000),
        ("threads", params.threads, MAX_THREADS),
        ("admm.ao_iterations", params.admm.ao_iterations, 1000),
        ("admm.nso_cycles", params.admm.nso.cycles, crate::nso::solve::MAX_CYCLES - 1),
    ];
    for (field, given, most) in ranges {
        if !(1..=most).contains(&given) {
            return Err(PlanError::OutOfRange { field, given, most });
        }
    }
    // No buffer holds more than this many numbers a cell and step (or a thread, row and step): later sizes cannot overflow.
    const NUMBERS: u128 = 4096;
    let cells: u128 = problem.cells.iter().map(|&n| n as u128).product();
    let numbers = cells * problem.steps as u128 + params.threads as u128 * (problem.steps as u128 + 4096);
    if numbers * NUMBERS * T::BYTES as u128 > isize::MAX as u128 * 64 {
        return Err(PlanError::TooLarge);
    }
    Ok(())
}

fn paper_bound<T: Real, S: Space>(problem: &Problem<'_>) -> usize {
    let cells: u128 = problem.cells.iter().map(|&n| n as u128).product();
    let (numbers, power) = (4 * (1 + S::DIM as u128) * problem.steps as u128 * cells, 1u128 << S::DIM);
    usize::try_from(numbers * T::BYTES as u128 * power / (power - 1)).unwrap_or(usize::MAX)
}

fn settings(problem: &Problem<'_>, params: &Params, shape: Shape) -> Settings {
    let dimensions = Dimensions { grid: problem.grid(), slots: problem.slots(), filters: problem.filters(), threads: params.threads, shape };
    Settings::new(problem, &params.admm, dimensions, params.iterations)
}

/// Why a [`Solver`] cannot be made.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SolverError {
    /// The plan is refused.
    Plan(PlanError),
    /// The memory has fewer bytes than planned.
    TooSmall {
        /// Bytes needed.
        needed: usize,
        /// Bytes given.
        given: usize,
    },
    /// The memory does not begin on a multiple of [`Plan::ALIGN`].
    Misaligned,
}

impl fmt::Display for SolverError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Plan(error) => error.fmt(f),
            Self::TooSmall { needed, given } => write!(f, "the solve needs {needed} bytes and was given {given}"),
            Self::Misaligned => write!(f, "the memory must begin on a multiple of {ALIGN} bytes"),
        }
    }
}

impl core::error::Error for SolverError {}

impl From<PlanError> for SolverError {
    fn from(error: PlanError) -> Self {
        Self::Plan(error)
    }
}

/// Why a field is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum InputError {
    /// It has the wrong number of values.
    Length {
        /// Values expected.
        expected: usize,
        /// Values given.
        given: usize,
    },
    /// A value is NaN or infinite.
    NotFinite {
        /// Its index.
        index: usize,
    },
    /// A density is negative.
    Negative {
        /// Its index.
        index: usize,
    },
    /// The density has no mass.
    Empty,
    /// There is no such keyframe or axis.
    Index {
        /// The index.
        given: usize,
        /// How many there are.
        count: usize,
    },
    /// The source must be set first.
    NoSource,
    /// A keyframe was not set.
    NoKeyframe {
        /// Its index.
        index: usize,
    },
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { expected, given } => write!(f, "it has {given} values where {expected} are needed"),
            Self::NotFinite { index } => write!(f, "value {index} is not finite"),
            Self::Negative { index } => write!(f, "value {index} is negative"),
            Self::Empty => write!(f, "it is empty: its mass is zero"),
            Self::Index { given, count } => write!(f, "index {given} is out of range; there are {count}"),
            Self::NoSource => write!(f, "the source must be set before the keyframes"),
            Self::NoKeyframe { index } => write!(f, "keyframe {index} was not set"),
        }
    }
}

impl core::error::Error for InputError {}

/// A solve in one block of memory.
#[derive(Debug)]
pub struct Solver<'m, T, S> {
    admm: Admm<'m, T, S>,
    keyframes: Keyframes<'m, T>,
    units: Units,
    match_mass: bool,
    mass: f64,
    missing: usize,
    prepared: Option<f64>,
    objective: Objective,
}

impl<'m, T: Real, S: Space> Solver<'m, T, S> {
    /// Carves `memory`, of at least [`Plan::bytes`]; nothing is allocated afterwards.
    ///
    /// # Errors
    /// [`SolverError`].
    pub fn new(problem: &Problem<'_>, params: &Params, memory: &'m mut [MaybeUninit<u8>]) -> Result<Self, SolverError> {
        let plan = Plan::new::<T, S>(problem, params)?;
        let given = memory.len();
        if !memory.as_ptr().addr().is_multiple_of(ALIGN) {
            return Err(SolverError::Misaligned);
        }
        let (memory, _) = memory.split_at_mut_checked(plan.bytes).ok_or(SolverError::TooSmall { needed: plan.bytes, given })?;
        let mut arena = Arena::new(memory);
        let short = |TooSmall { .. }: TooSmall| SolverError::TooSmall { needed: plan.bytes, given };
        let admm = Admm::carve(&mut arena, &settings(problem, params, plan.shape)).map_err(short)?;
        let count = problem.keyframes.len();
        let steps = arena.take::<u32>(count).map_err(short)?;
        steps.iter_mut().zip(problem.keyframes).for_each(|(slot, &step)| *slot = step as u32);
        let densities = arena.take(count * problem.grid().cells()).map_err(short)?;
        debug_assert_eq!(arena.left(), 0, "planned and carved bytes differ");
        Ok(Self {
            admm,
            keyframes: Keyframes { steps, densities },
            units: problem.units(),
            match_mass: problem.match_mass,
            mass: 0.0,
            missing: count,
            prepared: None,
            objective: Objective::default(),
        })
    }

    /// Sets rho_0: one density for each cell, x fastest.
    ///
    /// # Errors
    /// [`InputError`]: wrong length, a value that is negative or not finite, no mass.
    pub fn set_source(&mut self, density: &[T]) -> Result<(), InputError> {
        let cells = self.admm.grid().cells();
        let mass = mass(density, cells)?;
        let largest = density.iter().fold(0.0, |most: f64, &x| most.max(x.to_f64()));
        self.admm.set_source(density, largest);
        self.mass = mass;
        Ok(())
    }

    /// Sets the target of keyframe `index`; the factor by which it was scaled to the source's mass.
    ///
    /// # Errors
    /// As [`Self::set_source`], or [`InputError::NoSource`], [`InputError::Index`].
    pub fn set_keyframe(&mut self, index: usize, density: &[T]) -> Result<f64, InputError> {
        let (cells, count) = (self.admm.grid().cells(), self.keyframes.steps.len());
        if index >= count {
            return Err(InputError::Index { given: index, count });
        }
        if self.mass <= 0.0 {
            return Err(InputError::NoSource);
        }
        let mass = mass(density, cells)?;
        let factor = if self.match_mass { self.mass / mass } else { 1.0 };
        let target = &mut self.keyframes.densities[index * cells..(index + 1) * cells];
        self.missing -= usize::from(target.iter().all(|&x| x == T::ZERO));
        target.iter_mut().zip(density).for_each(|(target, &x)| *target = T::from_f64(x.to_f64() * factor));
        Ok(factor)
    }

    /// Sets a component of v_0, in the layout of a file (one more face than cells along a wall axis), in the scene's units.
    ///
    /// # Errors
    /// [`InputError`]: no such axis, wrong length, a value that is not finite.
    pub fn set_initial_velocity(&mut self, axis: usize, faces: &[T]) -> Result<(), InputError> {
        let grid = *self.admm.grid();
        if axis >= grid.dims {
            return Err(InputError::Index { given: axis, count: grid.dims });
        }
        let layout = FileLayout::new(&grid, axis);
        if faces.len() != layout.len() {
            return Err(InputError::Length { expected: layout.len(), given: faces.len() });
        }
        if let Some(index) = faces.iter().position(|x| !x.is_finite()) {
            return Err(InputError::NotFinite { index });
        }
        let scale = T::from_f64(1.0 / self.units.velocity);
        let field = &mut self.admm.initial[axis];
        layout.each_row(|row, file, wall| {
            let at = &mut field[row * grid.n[0]..(row + 1) * grid.n[0]];
            for (x, value) in at.iter_mut().enumerate() {
                *value = if wall || layout.wall_face(x) { T::ZERO } else { faces[file + x] * scale };
            }
        });
        self.prepared = None;
        Ok(())
    }

    /// Checks that all densities are there and projects v_0; by how much that changed it, relative to max |v_0|.
    ///
    /// # Errors
    /// [`InputError::NoSource`], [`InputError::NoKeyframe`].
    pub fn prepare(&mut self, exec: &dyn Exec) -> Result<f64, InputError> {
        if self.mass <= 0.0 {
            return Err(InputError::NoSource);
        }
        let cells = self.admm.grid().cells();
        if self.missing > 0 {
            let unset = self.keyframes.densities.chunks_exact(cells).position(|target| target.iter().all(|&x| x == T::ZERO));
            return Err(InputError::NoKeyframe { index: unset.unwrap_or(0) });
        }
        Ok(match self.prepared {
            Some(change) => change,
            None => *self.prepared.insert(self.admm.project_initial(exec)),
        })
    }

    /// One outer iteration.
    pub fn step(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Progress {
        if self.prepare(exec).is_err() {
            return Progress { status: Some(Status::NotReady), ..Progress::default() };
        }
        self.admm.step(exec, observer, &self.keyframes)
    }

    /// Iterates to the end and makes the result feasible; `each` hears every iteration.
    pub fn solve(&mut self, exec: &dyn Exec, observer: &mut dyn Observer, each: &mut dyn FnMut(&Progress)) -> Status {
        loop {
            let progress = self.step(exec, observer);
            each(&progress);
            if let Some(status) = progress.status {
                return if status == Status::NotReady { status } else { self.finish(exec).map_or(Status::NotFinite, |_| status) };
            }
        }
    }

    /// Makes the result feasible (mathematics section 5): projects v, takes the force from it, transports rho_0 by it.
    ///
    /// # Errors
    /// [`Status::NotFinite`] when a number is not finite or the flow is too fast to be transported.
    pub fn finish(&mut self, exec: &dyn Exec) -> Result<Objective, Status> {
        self.objective = self.admm.make_feasible(exec, &self.keyframes)?;
        Ok(self.objective)
    }

    /// The objective of the result, after [`Self::finish`].
    #[must_use]
    pub fn objective(&self) -> Objective {
        self.objective
    }

    /// rho_step, one number for each cell.
    #[must_use]
    pub fn density(&self, step: usize) -> &[T] {
        let cells = self.admm.grid().cells();
        &self.admm.rho[step * cells..(step + 1) * cells]
    }

    /// The target of keyframe `index`, after any scaling of its mass.
    #[must_use]
    pub fn keyframe(&self, index: usize) -> &[T] {
        self.keyframes.density(index, self.admm.grid().cells())
    }

    /// Faces of a component of a velocity or force in the layout of a file.
    #[must_use]
    pub fn faces(&self, axis: usize) -> usize {
        FileLayout::new(self.admm.grid(), axis).len()
    }

    /// Component `axis` of v_step (step 0 .. N-1) in the layout of a file and the scene's units; `out` has [`Self::faces`] numbers.
    pub fn velocity(&self, step: usize, axis: usize, out: &mut [T]) {
        let slots = self.admm.slots();
        if step == 0 {
            self.write(self.admm.initial[axis], 1, 0, axis, self.units.velocity, out);
        } else {
            self.write(self.admm.v[axis], slots, step - 1, axis, self.units.velocity, out);
        }
    }

    /// Component `axis` of the force u_step (step 0 .. N-2) that turns v_step into v_{step+1}; as [`Self::velocity`].
    pub fn force(&self, step: usize, axis: usize, out: &mut [T]) {
        self.write(self.admm.w[axis], self.admm.slots(), step, axis, self.units.force, out);
    }

    fn write(&self, field: &[T], slots: usize, slot: usize, axis: usize, unit: f64, out: &mut [T]) {
        let grid = self.admm.grid();
        let (layout, n, unit) = (FileLayout::new(grid, axis), grid.n[0], T::from_f64(unit));
        out.fill(T::ZERO);
        layout.each_row(|row, file, wall| {
            if !wall {
                let from = &field[(row * slots + slot) * n..(row * slots + slot + 1) * n];
                out[file..file + n].iter_mut().zip(from).for_each(|(out, &x)| *out = x * unit);
            }
        });
    }
}

/// The sum of a density that is finite and nowhere negative.
fn mass<T: Real>(density: &[T], cells: usize) -> Result<f64, InputError> {
    if density.len() != cells {
        return Err(InputError::Length { expected: cells, given: density.len() });
    }
    if let Some(index) = density.iter().position(|x| !x.is_finite()) {
        return Err(InputError::NotFinite { index });
    }
    if let Some(index) = density.iter().position(|&x| x < T::ZERO) {
        return Err(InputError::Negative { index });
    }
    let mass: f64 = density.iter().map(|x| x.to_f64()).sum();
    if mass > 0.0 { Ok(mass) } else { Err(InputError::Empty) }
}

/// Faces of one component in a file: z, y, x with x fastest, one more along its own axis when that ends in walls.
struct FileLayout {
    n: [usize; 3],
    axis: usize,
    walls: bool,
}

impl FileLayout {
    fn new(grid: &crate::grid::Grid, axis: usize) -> Self {
        Self { n: grid.n, axis, walls: !grid.periodic[axis] }
    }

    fn extent(&self, axis: usize) -> usize {
        self.n[axis] + usize::from(self.walls && axis == self.axis)
    }

    fn len(&self) -> usize {
        (0..3).map(|axis| self.extent(axis)).product()
    }

    /// Whether face `x` of a row is on a wall.
    fn wall_face(&self, x: usize) -> bool {
        self.walls && self.axis == 0 && x == 0
    }

    /// Calls `visit` with every stored row, where it begins in the file, and whether all of it is on a wall.
    fn each_row(&self, mut visit: impl FnMut(usize, usize, bool)) {
        for z in 0..self.n[2] {
            for y in 0..self.n[1] {
                let wall = self.walls && (self.axis == 1 && y == 0 || self.axis == 2 && z == 0);
                visit(z * self.n[1] + y, (z * self.extent(1) + y) * self.extent(0), wall);
            }
        }
    }
}
