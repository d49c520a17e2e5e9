//! The devices that there are, and a search on one of them.

use crate::machine::{Bounds, Machine};
use crate::memory::Taken;
use crate::state::{State, fit};
use core::fmt;
use pollster::block_on;
use std::sync::{Mutex, MutexGuard, PoisonError};
use thurible_core::exec::Device;
use thurible_core::exec::device::{NotFinite, Place, Room, Search, Stride, WithGradient};
use wgpu::{Adapter, Backends, DeviceType, Instance, InstanceDescriptor};

/// An adapter: its name, and whether it is a processor that plays a card.
pub struct Named {
    /// As its driver calls it.
    pub name: String,
    /// Whether it is a program on the processor: right, and slow.
    pub is_software: bool,
    adapter: Adapter,
}

/// All adapters, cards before programs that play one.
#[must_use]
pub fn adapters() -> Vec<Named> {
    let instance = Instance::new(InstanceDescriptor::new_without_display_handle());
    let mut all: Vec<_> = block_on(instance.enumerate_adapters(Backends::VULKAN))
        .into_iter()
        .map(|adapter| {
            let info = adapter.get_info();
            Named {
                name: info.name,
                is_software: info.device_type == DeviceType::Cpu,
                adapter,
            }
        })
        .collect();
    all.sort_by_key(|named| named.is_software);
    // Equal cards are told apart by their numbers.
    for index in (1..all.len()).rev() {
        let same = all[..index].iter().filter(|other| other.name == all[index].name);
        let earlier = same.count();
        if earlier > 0 {
            all[index].name = format!("{} #{}", all[index].name, earlier + 1);
        }
    }
    all
}

/// A device that searches.
pub struct Gpu {
    name: String,
    /// Bytes that a search may take of it.
    most: Option<u64>,
    inner: Mutex<(Machine, Option<State>)>,
}

impl fmt::Debug for Gpu {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "Gpu({})", self.name)
    }
}

impl Named {
    /// Opens it for searches that take at most so many bytes.
    ///
    /// # Errors
    /// A sentence.
    pub fn open(&self, most: Option<u64>) -> Result<Gpu, String> {
        self.open_within(most, Bounds::default())
    }

    /// The same, where no more is done at once than `bounds` say.
    ///
    /// # Errors
    /// A sentence.
    pub fn open_within(&self, most: Option<u64>, bounds: Bounds) -> Result<Gpu, String> {
        Ok(Gpu {
            name: self.name.clone(),
            most,
            inner: Mutex::new((Machine::open(&self.adapter, bounds)?, None)),
        })
    }
}

impl Gpu {
    fn inner(&self) -> MutexGuard<'_, (Machine, Option<State>)> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// As its driver calls it.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What went wrong first, if anything did.
    #[must_use]
    pub fn failure(&self) -> Option<String> {
        self.inner().0.failure()
    }

    /// Bytes that a search takes.
    ///
    /// # Errors
    /// A sentence, where it does not fit.
    pub fn plan(&self, room: &Room) -> Result<Taken, String> {
        Ok(fit(&self.inner().0, room, self.most)?.taken())
    }

    /// Bytes that were copied between the device's memory and the machine's so far, where steps are streamed.
    #[must_use]
    pub fn streamed(&self) -> u64 {
        self.inner().0.streamed()
    }

    /// What `verb` answers, or `otherwise` where no search was begun.
    fn with<R>(&self, otherwise: R, verb: impl FnOnce(&mut State, &mut Machine) -> R) -> R {
        let mut inner = self.inner();
        let (machine, state) = &mut *inner;
        match state {
            Some(state) if machine.failure().is_none() => verb(state, machine),
            _ => otherwise,
        }
    }
}

impl Device for Gpu {
    fn begin(&self, search: &Search<'_>) {
        let mut inner = self.inner();
        let (machine, state) = &mut *inner;
        *state = None;
        match State::new(machine, search, self.most) {
            Ok(begun) => *state = Some(begun),
            Err(text) => machine.fail(text),
        }
    }

    fn write(&self, place: Place, row: &mut dyn FnMut(usize, &mut [f32])) {
        self.with((), |state, machine| {
            let (rows, mut values) = state.rows();
            machine.write(state.place(place), rows, &mut values, row);
        });
    }

    fn read(&self, place: Place, row: &mut dyn FnMut(usize, &[f32])) {
        self.with((), |state, machine| {
            let (rows, mut values) = state.rows();
            machine.read(state.place(place), rows, &mut values, row);
        });
    }

    fn form(&self, into: usize, terms: &mut dyn Iterator<Item = (f64, usize)>) {
        self.with((), |state, machine| state.form(machine, into, terms));
    }

    fn divergence(&self, field: usize) -> [f64; 2] {
        self.with([f64::NAN; 2], |state, machine| {
            state.relative_divergence(machine, field)
        })
    }

    fn project(&self, field: usize, tolerance: f64) {
        self.with((), |state, machine| {
            state.project(machine, &state.fields[field], tolerance);
        });
    }

    fn advance(&self, field: usize, s: f64) {
        self.with((), |state, machine| state.advance(machine, field, s));
    }

    fn retreat(&self, keep: f64) {
        self.with((), |state, machine| state.retreat(machine, keep));
    }

    fn value(&self, force: usize) -> Result<[f64; 3], NotFinite> {
        self.with(Err(NotFinite), |state, machine| state.value(machine, force))
    }

    fn gradient(&self, force: usize, into: usize) -> Result<(), NotFinite> {
        self.with(Err(NotFinite), |state, machine| {
            state.gradient(machine, force, into)
        })
    }

    fn arrive(
        &self,
        gradient: usize,
        image: usize,
        step: Option<Stride>,
        pairs: &mut dyn Iterator<Item = [usize; 2]>,
        products: &mut dyn FnMut([f64; 2]),
    ) -> WithGradient {
        let nothing = WithGradient {
            norm: f64::NAN,
            step: [f64::NAN; 2],
        };
        self.with(nothing, |state, machine| {
            state.arrive(machine, [gradient, image], step, pairs, products)
        })
    }
}
