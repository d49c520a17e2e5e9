//! Fields on a device: what a search needs of its memory, to the byte, before any of it is taken.

use wgpu::{Buffer, BufferDescriptor, BufferUsages, Device, Limits};

/// Numbers to a multiple of which every field is padded, so that any of them may be bound alone.
const ALIGNED: usize = 64;
const BYTES: u64 = 4;

/// Some steps of a field, as kernels see them.
#[derive(Clone, Debug)]
pub struct Part {
    pub buffer: Buffer,
    pub offset: u64,
    pub bytes: u64,
}

impl Part {
    /// The component along an axis of a step of faces, `apart` numbers each.
    pub fn of_axis(self, axis: usize, apart: usize) -> Self {
        let bytes = apart as u64 * BYTES;
        Self {
            offset: self.offset + axis as u64 * bytes,
            bytes,
            ..self
        }
    }
}

/// How large a field is: so many steps of so many numbers, and how many of them lie in one buffer at most.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    name: &'static str,
    steps: usize,
    numbers: usize,
    together: usize,
}

/// A list of steps, each of cells or of faces along every axis.
#[derive(Debug)]
pub struct Field {
    size: Size,
    buffers: Vec<Buffer>,
}

/// The memory that a search takes of a device, field by field.
#[derive(Debug, Default)]
pub struct Plan {
    sizes: Vec<Size>,
}

/// Numbers from one field of `cells` cells to the next.
pub fn apart(cells: usize) -> usize {
    cells.next_multiple_of(ALIGNED)
}

/// Bytes that a device binds at once at most, below 2^31 by wgpu itself.
fn at_once(limits: &Limits) -> u64 {
    let allowed = limits.max_storage_buffer_binding_size;
    allowed.min(limits.max_buffer_size)
}

impl Size {
    /// That of `steps` steps of `numbers` numbers each under the limits of a device.
    pub fn new(limits: &Limits, name: &'static str, steps: usize, numbers: usize) -> Self {
        let most = at_once(limits);
        let of_step = (numbers as u64 * BYTES).max(1);
        let together = usize::try_from(most / of_step).unwrap_or(usize::MAX);
        Self {
            name,
            steps,
            numbers,
            together: together.clamp(1, steps.max(1)),
        }
    }

    /// Its bytes.
    pub fn bytes(&self) -> u64 {
        self.steps as u64 * self.numbers as u64 * BYTES
    }

    /// Bytes of one step.
    pub fn step_bytes(&self) -> u64 {
        self.numbers as u64 * BYTES
    }

    /// Steps that may be bound together: ranges that lie in one buffer, of `most` steps at most.
    pub fn windows(self, most: usize) -> impl Iterator<Item = (usize, usize)> {
        let Self { steps, together, .. } = self;
        let most = most.clamp(1, together);
        (0..steps).step_by(together).flat_map(move |begin| {
            let end = (begin + together).min(steps);
            (begin..end)
                .step_by(most)
                .map(move |first| (first, most.min(end - first)))
        })
    }
}

impl Plan {
    /// One more field.
    pub fn add(&mut self, size: Size) {
        self.sizes.push(size);
    }

    /// All fields, in order.
    pub fn sizes(&self) -> &[Size] {
        &self.sizes
    }

    /// Bytes in all.
    pub fn bytes(&self) -> u64 {
        self.sizes.iter().map(Size::bytes).sum()
    }

    /// Names with their bytes, those of one name together.
    pub fn lines(&self) -> Vec<(&'static str, u64)> {
        let mut lines: Vec<(&'static str, u64)> = Vec::new();
        for size in self.sizes.iter().filter(|size| size.bytes() > 0) {
            match lines.last_mut() {
                Some((name, bytes)) if *name == size.name => *bytes += size.bytes(),
                _ => lines.push((size.name, size.bytes())),
            }
        }
        lines
    }

    /// A sentence that says why it cannot be had.
    pub fn refusal(&self, why: &str) -> String {
        format!(
            "the search needs {} bytes of the device: {why}; take fewer pairs (method.direct.history), steps or cells",
            self.bytes()
        )
    }

    /// Refuses it where it is above the ceiling `most`, or where the device does not bind a step of it at once.
    pub fn check(&self, limits: &Limits, most: Option<u64>) -> Result<(), String> {
        if let Some(most) = most.filter(|&most| self.bytes() > most) {
            return Err(self.refusal(&format!("it may take {most}")));
        }
        let bound = at_once(limits);
        match self.sizes.iter().map(Size::step_bytes).max() {
            Some(largest) if largest > bound => Err(self.refusal(&format!(
                "a step of {largest} bytes is more than the {bound} that it takes at once"
            ))),
            _ => Ok(()),
        }
    }
}

impl Field {
    /// Takes the memory.
    pub fn new(device: &Device, size: Size) -> Self {
        let buffer = |steps: usize| {
            device.create_buffer(&BufferDescriptor {
                label: Some(size.name),
                size: (steps as u64 * size.numbers as u64 * BYTES).max(ALIGNED as u64 * BYTES),
                usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let buffers = (0..size.steps)
            .step_by(size.together)
            .map(|begin| buffer(size.together.min(size.steps - begin)))
            .collect();
        Self { size, buffers }
    }

    /// The buffers that it lies in.
    pub fn buffers(&self) -> impl Iterator<Item = &Buffer> {
        self.buffers.iter()
    }

    /// See [`Size::windows`].
    pub fn windows(&self, most: usize) -> impl Iterator<Item = (usize, usize)> + use<> {
        self.size.windows(most)
    }

    /// Steps.
    pub fn steps(&self) -> usize {
        self.size.steps
    }

    /// Numbers of a step.
    pub fn numbers(&self) -> usize {
        self.size.numbers
    }

    /// `count` steps from `first` on, of one window.
    pub fn part(&self, first: usize, count: usize) -> Part {
        let Size {
            numbers, together, ..
        } = self.size;
        Part {
            buffer: self.buffers[first / together].clone(),
            offset: ((first % together) * numbers) as u64 * BYTES,
            bytes: (count * numbers) as u64 * BYTES,
        }
    }

    /// One step.
    pub fn step(&self, step: usize) -> Part {
        self.part(step, 1)
    }
}
