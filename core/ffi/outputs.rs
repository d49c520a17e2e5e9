//! What a method gives, one output after the other: named, seen in place, and copied in the layout of files.

use crate::each;
use crate::instance::{self, Body, Thurible};
use crate::pointer::{array, required};
use crate::result::ThuribleResult;
use crate::text::{THURIBLE_NAME_BYTES, THURIBLE_WORDS_BYTES, put_text};
use core::ffi::{c_char, c_void};
use thurible_core::solver::Strided;
use thurible_core::{Output, Place, Real, Solver, Space, Unit};

/// Where the elements of an output are.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuriblePlace {
    /// At the centres of cells: one component.
    Cells = 0,
    /// On the faces of cells: a component for each axis, on the faces across it.
    Faces = 1,
}

impl From<Place> for ThuriblePlace {
    fn from(place: Place) -> Self {
        match place {
            Place::Cells => Self::Cells,
            Place::Faces => Self::Faces,
        }
    }
}

/// In what an output is measured, in the scene's units.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleUnit {
    /// As the source.
    Density = 0,
    /// Length / time.
    Velocity = 1,
    /// Length / time^2.
    Force = 2,
}

impl From<Unit> for ThuribleUnit {
    fn from(unit: Unit) -> Self {
        match unit {
            Unit::Density => Self::Density,
            Unit::Velocity => Self::Velocity,
            Unit::Force => Self::Force,
        }
    }
}

/// Something that the method of an instance gives: a field for each of many steps.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleOutput {
    /// Its name, lower case with underscores, as files have it; components have their axis added there: `velocity_x`.
    pub name: [c_char; THURIBLE_NAME_BYTES],
    /// What it is, in a few words.
    pub words: [c_char; THURIBLE_WORDS_BYTES],
    /// Where its elements are.
    pub place: ThuriblePlace,
    /// In what it is measured.
    pub unit: ThuribleUnit,
    /// How many steps it has.
    pub steps: usize,
    /// How many of the first of them are not found but given: these can be read at any time.
    pub given: usize,
    /// How many components it has.
    pub components: usize,
    /// Bytes that `thurible_read_output` writes of component 0, 1 and 2, or 0 where there is none.
    pub bytes: [usize; 3],
}

/// A field as it lies in the instance. Element (x, y, z) is at `data` plus x `strides[0]` + y `strides[1]` + z `strides[2]` elements of the
/// instance's precision; times `unit` it is in the scene's units.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleView {
    /// Element (0, 0, 0).
    pub data: *const c_void,
    /// Elements along x, y and z. A component of a velocity or force has the low face of every cell along its axis; on a wall axis the
    /// first is on the wall, where nothing flows, and the last wall is left out.
    pub extent: [usize; 3],
    /// Elements from one to the next along x, y and z.
    pub strides: [usize; 3],
    /// The scene's unit of these elements.
    pub unit: f64,
    /// Bytes of an element: 4 for `float`, 8 for `double`.
    pub bytes_per_number: usize,
}

impl ThuribleView {
    /// That of a component in an instance.
    pub(crate) fn of<T: Real>(component: Strided<'_, T>) -> Self {
        let Strided {
            numbers,
            extent,
            strides,
            unit,
        } = component;
        Self {
            data: numbers.as_ptr().cast(),
            extent,
            strides,
            unit,
            bytes_per_number: T::BYTES,
        }
    }
}

/// All outputs of an instance.
pub(crate) fn all(body: &Body) -> &'static [Output] {
    each!(&body.solver, solver => solver.outputs())
}

/// Output `index` of an instance.
fn at(body: &Body, index: usize) -> Result<Output, ThuribleResult> {
    all(body).get(index).copied().ok_or(ThuribleResult::Index)
}

/// One component of an output at one step, which exists and is known by now.
#[derive(Clone, Copy)]
pub(crate) struct Part {
    output: Output,
    step: usize,
    axis: usize,
}

impl Part {
    pub fn new(body: &Body, output: Output, step: usize, axis: usize) -> Result<Self, ThuribleResult> {
        let sizes = body.sizes;
        if step >= output.count(sizes.steps) || axis >= output.components(sizes.dims) {
            return Err(ThuribleResult::Index);
        }
        if step >= output.given && !each!(&body.solver, solver => solver.is_finished()) {
            return Err(ThuribleResult::NoResult);
        }
        Ok(Self { output, step, axis })
    }

    pub fn view<T: Real, S: Space>(self, solver: &Solver<'_, T, S>) -> ThuribleView {
        ThuribleView::of(solver.in_place(&self.output, self.step, self.axis))
    }

    /// # Safety
    /// `out` is null or points to `bytes` bytes to write.
    pub unsafe fn copy<T: Real, S: Space>(
        self,
        solver: &Solver<'_, T, S>,
        out: *mut c_void,
        bytes: usize,
    ) -> Result<(), ThuribleResult> {
        // SAFETY: the caller's promise.
        let out = unsafe { array::<T>(out, bytes, solver.elements(&self.output, self.axis)) }?;
        solver.read(&self.output, self.step, self.axis, out);
        Ok(())
    }
}

/// Bytes of component `axis` of an output in the layout of files.
pub(crate) fn bytes_of(body: &Body, output: &Output, axis: usize) -> Result<usize, ThuribleResult> {
    if axis >= output.components(body.sizes.dims) {
        return Err(ThuribleResult::Index);
    }
    Ok(each!(&body.solver, solver => solver.elements(output, axis)) * body.sizes.precision)
}

/// How many outputs the method of an instance has. Densities, velocities and forces are among them where a `ThuribleField` of them can
/// be had.
///
/// # Safety
/// `instance` as in `thurible_close`; `count` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_output_count(
    instance: *const Thurible,
    count: *mut usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            required(count)?;
            count.write(all(body).len());
            Ok(())
        })
    }
}

/// Says what output `index` is, from 0 on.
///
/// # Safety
/// `instance` as in `thurible_close`; `output` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_output(
    instance: *const Thurible,
    index: usize,
    output: *mut ThuribleOutput,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            required(output)?;
            let found = at(body, index)?;
            let bytes = |axis| bytes_of(body, &found, axis).unwrap_or_default();
            let mut said = ThuribleOutput {
                name: [0; _],
                words: [0; _],
                place: found.place.into(),
                unit: found.unit.into(),
                steps: found.count(body.sizes.steps),
                given: found.given,
                components: found.components(body.sizes.dims),
                bytes: [bytes(0), bytes(1), bytes(2)],
            };
            put_text(&mut said.name, found.name);
            put_text(&mut said.words, found.words);
            output.write(said);
            Ok(())
        })
    }
}

/// As `thurible_view`, of output `index`.
///
/// # Safety
/// As `thurible_view`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_view_output(
    instance: *const Thurible,
    index: usize,
    step: usize,
    axis: usize,
    view: *mut ThuribleView,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            required(view)?;
            let part = Part::new(body, at(body, index)?, step, axis)?;
            view.write(each!(&body.solver, solver => part.view(solver)));
            Ok(())
        })
    }
}

/// As `thurible_copy`, of output `index`: component `axis` at a step, into `out` of exactly `bytes` bytes.
///
/// # Safety
/// As `thurible_copy`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_read_output(
    instance: *const Thurible,
    index: usize,
    step: usize,
    axis: usize,
    out: *mut c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            let part = Part::new(body, at(body, index)?, step, axis)?;
            Ok(each!(&body.solver, solver => part.copy(solver, out, bytes))?)
        })
    }
}
