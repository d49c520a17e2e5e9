//! Fields of every step, from the caller's arrays or into them: densities at cells and components of velocities, forces or covectors.

use crate::host::ThuribleObserver;
use crate::pointer::elements;
use crate::result::ThuribleResult;
use core::cell::Cell;
use core::ffi::c_void;
use core::ops::ControlFlow;
use thurible_core::operator::Simulator;
use thurible_core::{Event, Observer, Real};

/// Told of a step: before what is given for it is read, or after what is handed out was written. 0 goes on; `THURIBLE_NOTHING`, where something is
/// to be given, says that there is nothing at this step; anything else stops, and so does that one where a step was handed out. It must
/// return: no exception of C++ and no `longjmp` may leave it.
pub type ThuribleOnStep = Option<unsafe extern "C" fn(context: *mut c_void, step: usize) -> i32>;

/// What a `ThuribleOnStep` returns where all of a step is 0.
pub const THURIBLE_NOTHING: i32 = 1;

/// Arrays of the host for every step: x fastest, in the scene's units. Each is either that of one step, which every step uses in its turn, or that
/// of all steps, one after the other; its bytes say which. Null stands for what is not given, which is 0, or not wanted.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleSteps {
    /// Called for every step; null for nobody.
    pub on: ThuribleOnStep,
    /// Passed to `on` as it is; the library never reads it.
    pub context: *mut c_void,
    /// One number for each cell. Forces have none.
    pub density: *mut c_void,
    /// Its bytes.
    pub density_bytes: usize,
    /// Components along x, y and z.
    pub vector: [*mut c_void; 3],
    /// Their bytes.
    pub vector_bytes: [usize; 3],
}

/// The density, then the components.
pub(crate) const PARTS: usize = 4;

/// Numbers of each part of a state.
pub fn lens<T: Real>(simulator: &impl Simulator<T>) -> [usize; PARTS] {
    let [x, y, z] = [0, 1, 2].map(|axis| simulator.vector_len(axis));
    [simulator.density_len(), x, y, z]
}

/// An array of the host.
#[derive(Clone, Copy, Debug)]
struct Place {
    values: *mut c_void,
    /// Bytes of a step.
    bytes: usize,
    /// Bytes from one step to the next.
    pitch: usize,
}

/// The arrays of the host, checked, and whether it said stop.
pub struct Steps<'a> {
    on: ThuribleOnStep,
    context: *mut c_void,
    places: [Option<Place>; PARTS],
    stopped: &'a Cell<bool>,
}

impl<'a> Steps<'a> {
    /// Checks the arrays of so many steps, whose fields have so many numbers of `number` bytes; 0 for one that there is not.
    ///
    /// # Errors
    /// [`ThuribleResult`]: misaligned, wrong bytes, or a field that there is not.
    ///
    /// # Safety
    /// `steps` is null or points to one; its arrays are null or have the bytes that it says, and live as long as the call.
    pub unsafe fn read(
        steps: *const ThuribleSteps,
        count: usize,
        (lens, number): ([usize; PARTS], usize),
        stopped: &'a Cell<bool>,
    ) -> Result<Self, ThuribleResult> {
        let mut own = Self {
            on: None,
            context: core::ptr::null_mut(),
            places: [None; PARTS],
            stopped,
        };
        if steps.is_null() {
            return Ok(own);
        }
        if !steps.is_aligned() {
            return Err(ThuribleResult::Misaligned);
        }
        // SAFETY: not null, aligned, and the caller promises the rest.
        let given = unsafe { steps.read() };
        (own.on, own.context) = (given.on, given.context);
        let [x, y, z] = given.vector;
        let [of_x, of_y, of_z] = given.vector_bytes;
        let arrays = [
            (given.density, given.density_bytes),
            (x, of_x),
            (y, of_y),
            (z, of_z),
        ];
        for ((place, array), len) in own.places.iter_mut().zip(arrays).zip(lens) {
            *place = checked(array, len.saturating_mul(number), count, number)?;
        }
        Ok(own)
    }

    /// What the host answers to a step.
    fn ask(&self, step: usize) -> i32 {
        // SAFETY: the host's function with its context.
        self.on.map_or(0, |on| unsafe { on(self.context, step) })
    }

    /// Whether the host has a part.
    pub fn has(&self, part: usize) -> bool {
        self.places.get(part).is_some_and(Option::is_some)
    }

    /// Asks the host for what there is at a step and hands on each part.
    pub fn give<T: Real>(&self, step: usize, mut take: impl FnMut(usize, &[T])) {
        if self.stopped.get() {
            return;
        }
        match self.ask(step) {
            0 => {}
            THURIBLE_NOTHING => return,
            _ => return self.stopped.set(true),
        }
        for part in 0..PARTS {
            if let Some(values) = self.part(part, step) {
                take(part, values);
            }
        }
    }

    /// One part of a step, without asking.
    pub fn part<T: Real>(&self, part: usize, step: usize) -> Option<&[T]> {
        let (values, bytes) = self.place(part, step)?;
        // SAFETY: checked by `read`, and the caller promises the bytes.
        unsafe { elements(values, bytes) }.ok()
    }

    /// Has each part of a step written that the host wants, and tells it.
    pub fn take<T: Real>(&self, step: usize, mut write: impl FnMut(usize, &mut [T])) {
        if self.stopped.get() {
            return;
        }
        for part in 0..PARTS {
            if let Some((values, bytes)) = self.place(part, step) {
                // SAFETY: checked by `read`, and the caller promises the bytes.
                if let Ok(out) = unsafe { crate::pointer::array(values, bytes, bytes / T::BYTES) } {
                    write(part, out);
                }
            }
        }
        // Nothing is given here that there could be nothing of: whatever is not 0 stops.
        if self.ask(step) != 0 {
            self.stopped.set(true);
        }
    }

    fn place(&self, part: usize, step: usize) -> Option<(*mut c_void, usize)> {
        let place = self.places.get(part).copied().flatten()?;
        Some((place.values.wrapping_byte_add(step * place.pitch), place.bytes))
    }
}

/// An array of `count` steps of `bytes` bytes, or of one of them.
fn checked(
    (values, given): (*mut c_void, usize),
    bytes: usize,
    count: usize,
    number: usize,
) -> Result<Option<Place>, ThuribleResult> {
    if values.is_null() {
        return Ok(None);
    }
    if bytes == 0 {
        return Err(ThuribleResult::Index);
    }
    if !values.addr().is_multiple_of(number) {
        return Err(ThuribleResult::Misaligned);
    }
    let pitch = match given {
        given if given == bytes => 0,
        given if Some(given) == bytes.checked_mul(count) => bytes,
        _ => return Err(ThuribleResult::Length),
    };
    Ok(Some(Place { values, bytes, pitch }))
}

/// The host's observer, which stops too where a callback of a step said so.
pub struct Watch<'a> {
    /// The host's.
    pub observer: ThuribleObserver,
    /// Whether a callback said stop.
    pub stopped: &'a Cell<bool>,
}

impl Observer for Watch<'_> {
    fn on(&mut self, event: Event) -> ControlFlow<()> {
        if self.stopped.get() {
            return ControlFlow::Break(());
        }
        self.observer.on(event)
    }
}
