//! A device that is open: its queue, its kernels, and the numbers that come back.

use crate::kernels::{GROUP, Kernel, Kernels, NUMBERS, Numbers};
use crate::memory::{Field, Part, Plan, Size, Streaming};
use core::num::NonZeroU64;
use pollster::block_on;
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use wgpu::{
    Adapter, BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, Buffer, BufferBinding,
    BufferDescriptor, BufferTransition, BufferUsages, BufferUses, CommandEncoderDescriptor,
    ComputePassDescriptor, Device, DeviceDescriptor, ErrorFilter, Features, Limits, MapMode, PollType, Queue,
};

/// Dispatches that wait at most before they are handed over.
const WAITING: usize = 256;
/// Elements for each invocation of a sum before there are more groups.
const PIECE: usize = 16;
/// Sums that may come back together.
const SUMS: usize = 1 << 20;
/// Bytes that are written at most before the device takes them: until then they are held twice.
const STAGED: u64 = 1 << 26;

/// How much is done at once. Tighter ones have a small box go the ways that otherwise only a large one goes.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Bytes of a buffer at most, unless the device allows fewer.
    pub buffer: u64,
    /// Groups in a row of a dispatch at most.
    pub row: u64,
    /// Groups of a sum at most. As many numbers come back.
    pub partial: usize,
    /// Sums that come back together at most.
    pub sums: usize,
    /// Steps of a page, each of which is streamed, whatever there is room for.
    pub paged: Option<usize>,
}

impl Default for Bounds {
    fn default() -> Self {
        Self {
            buffer: u64::MAX,
            row: 32768,
            partial: 1024,
            sums: SUMS,
            paged: None,
        }
    }
}

/// What waits to be handed over.
enum Command {
    /// One kernel over some parts of fields.
    Dispatch {
        kernel: Kernel,
        bound: BindGroup,
        numbers: [u8; NUMBERS],
        groups: [u32; 2],
    },
    /// A page from its home into a frame, or back.
    Copy { from: Buffer, to: Buffer, bytes: u64 },
}

impl Command {
    fn is_copy(&self) -> bool {
        matches!(self, Self::Copy { .. })
    }
}

/// A page: on the device for good, or at home in the machine's memory and in a frame for as long as it is used.
enum Page {
    Stays(Buffer),
    Streamed {
        home: Buffer,
        bytes: u64,
        frame: Option<usize>,
    },
}

/// A place on the device for a page that is streamed.
struct Frame {
    buffer: Buffer,
    page: Option<usize>,
    /// Whether it differs from the page's home.
    is_changed: bool,
    /// The last dispatch that asked for it.
    used: u64,
}

/// Pages of the machine's own: sums, and what is bound where there is nothing.
const OWN: usize = 2;
const STAYS: BufferUsages = BufferUsages::STORAGE
    .union(BufferUsages::COPY_SRC)
    .union(BufferUsages::COPY_DST);
/// What is mapped to be read lies in the machine's memory, where reading it is quick.
const HOME: BufferUsages = BufferUsages::MAP_READ
    .union(BufferUsages::COPY_SRC)
    .union(BufferUsages::COPY_DST);

fn buffer(device: &Device, name: &'static str, bytes: u64, usage: BufferUsages) -> Buffer {
    device.create_buffer(&BufferDescriptor {
        label: Some(name),
        size: bytes,
        usage,
        mapped_at_creation: false,
    })
}

/// What went wrong first, if anything did.
type Failure = Arc<Mutex<Option<String>>>;

/// A device that is open.
pub struct Machine {
    device: Device,
    queue: Queue,
    kernels: Kernels,
    limits: Limits,
    bounds: Bounds,
    waiting: Vec<Command>,
    /// Those of the machine, and behind them those of the search.
    pages: Vec<Page>,
    frames: Vec<Frame>,
    /// Dispatches so far.
    now: u64,
    /// Bytes that pages were copied by so far.
    streamed: u64,
    /// Where sums are left, and where they are read.
    sums: Field,
    nothing: Field,
    /// The table of solid cells of the search, if there is one.
    solids: Option<Part>,
    staging: Buffer,
    taken: usize,
    /// Bytes that were written since the device took some.
    staged: u64,
    failure: Failure,
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Machine {
    /// Opens an adapter.
    pub fn open(adapter: &Adapter, bounds: Bounds) -> Result<Self, String> {
        let bounds = Bounds {
            sums: bounds.sums.min(SUMS),
            ..bounds
        };
        let limits = adapter.limits();
        if !adapter.features().contains(Features::IMMEDIATES)
            || (limits.max_immediate_size as usize) < NUMBERS
        {
            return Err("its driver offers no immediate data (push constants) of 64 bytes".into());
        }
        // Pages that are streamed have homes that the device copies from and to.
        let streams = adapter.features() & Features::MAPPABLE_PRIMARY_BUFFERS;
        let described = DeviceDescriptor {
            label: Some("thurible"),
            required_features: Features::IMMEDIATES | streams,
            required_limits: limits.clone(),
            ..DeviceDescriptor::default()
        };
        let (device, queue) =
            block_on(adapter.request_device(&described)).map_err(|error| error.to_string())?;
        let failure = Failure::default();
        let heard = Arc::clone(&failure);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            lock(&heard).get_or_insert_with(|| error.to_string());
        }));
        let heard = Arc::clone(&failure);
        device.set_device_lost_callback(move |reason, text| {
            // It is lost in the end of every program, too.
            if reason != wgpu::DeviceLostReason::Destroyed {
                lock(&heard).get_or_insert_with(|| format!("the device was lost: {text}"));
            }
        });
        let kernels = Kernels::new(&device);
        let own =
            [("sums", SUMS), ("nothing", 64)].map(|(name, numbers)| Size::new(&limits, name, 1, numbers));
        let pages = own.map(|size| Page::Stays(buffer(&device, size.name, size.bytes(), STAYS)));
        let staging = device.create_buffer(&BufferDescriptor {
            label: Some("sums, to be read"),
            size: 4 * SUMS as u64,
            usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let [sums, nothing] = [0, 1].map(|page| Field::new(own[page], page));
        // What a search takes is planned within the bounds.
        let limits = Limits {
            max_storage_buffer_binding_size: limits.max_storage_buffer_binding_size.min(bounds.buffer),
            ..limits
        };
        let machine = Self {
            sums,
            nothing,
            solids: None,
            device,
            queue,
            kernels,
            limits,
            bounds,
            waiting: Vec::new(),
            pages: pages.into(),
            frames: Vec::new(),
            now: 0,
            streamed: 0,
            staging,
            taken: 0,
            staged: 0,
            failure,
        };
        match machine.failure() {
            None => Ok(machine),
            Some(text) => Err(text),
        }
    }

    /// Compiles the kernels for boxes of so many axes, unless they are, which see this table of solid cells.
    pub fn compile(&mut self, dims: usize, solids: Option<Part>) {
        self.kernels.compile(&self.device, dims);
        self.solids = solids;
    }

    /// Its limits.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// What went wrong first, if anything did.
    pub fn failure(&self) -> Option<String> {
        lock(&self.failure).clone()
    }

    /// Says what went wrong, unless something did before.
    pub fn fail(&self, text: String) {
        lock(&self.failure).get_or_insert(text);
    }

    /// Bytes that were copied between the device and homes of pages so far.
    pub fn streamed(&self) -> u64 {
        self.streamed
    }

    /// Takes the fields of a plan in the place of those before, or none of them.
    pub fn fields(&mut self, plan: &Plan) -> Option<Vec<Field>> {
        self.flush();
        self.pages.truncate(OWN);
        self.frames.clear();
        let scope = self.device.push_error_scope(ErrorFilter::OutOfMemory);
        let mut all = Vec::new();
        let mut take = |name, bytes, usage| {
            let buffer = buffer(&self.device, name, bytes, usage);
            all.push(buffer.clone());
            buffer
        };
        let mut fields = Vec::new();
        for (size, pages) in plan.fields() {
            fields.push(Field::new(size, self.pages.len()));
            for (bytes, stays) in pages {
                self.pages.push(if stays {
                    Page::Stays(take(size.name, bytes, STAYS))
                } else {
                    let home = take("a page's home", bytes, HOME);
                    Page::Streamed {
                        home,
                        bytes,
                        frame: None,
                    }
                });
            }
        }
        let &Streaming { frame, frames, .. } = plan.streaming();
        for _ in 0..frames {
            self.frames.push(Frame {
                buffer: take("a frame", frame, STAYS),
                page: None,
                is_changed: false,
                used: 0,
            });
        }
        // What was not made is not cleared: that would be another error than the one that says why.
        if block_on(scope.pop()).is_some() {
            return None;
        }
        let scope = self.device.push_error_scope(ErrorFilter::OutOfMemory);
        // All of it is 0 before anything else is done: what the device has not so much of is refused now, and nothing is cleared later on.
        let mut encoder = self
            .device
            .create_command_encoder(&CommandEncoderDescriptor::default());
        for buffer in &all {
            encoder.clear_buffer(buffer, 0, None);
        }
        self.queue.submit([encoder.finish()]);
        let waited = self.device.poll(PollType::wait_indefinitely()).is_ok();
        let refused = block_on(scope.pop());
        (waited && refused.is_none()).then_some(fields)
    }

    /// Makes a plan fit under the ceiling `most`, or says why that cannot be.
    pub fn fit(&self, plan: Plan, most: Option<u64>) -> Result<Plan, String> {
        let plan = plan.fit(&self.limits, most, self.bounds.paged)?;
        let streams = self
            .device
            .features()
            .contains(Features::MAPPABLE_PRIMARY_BUFFERS);
        if plan.streaming().frames > 0 && !streams {
            let why = "its driver cannot stream steps (MAPPABLE_PRIMARY_BUFFERS); raise --device-memory";
            return Err(plan.refusal(why));
        }
        Ok(plan)
    }

    /// Where a page is on the device, brought there if need be, for the dispatch `self.now`, which `writes` it or does not.
    fn bring(&mut self, page: usize, writes: bool) -> Buffer {
        let index = match &self.pages[page] {
            Page::Stays(buffer) => return buffer.clone(),
            Page::Streamed {
                frame: Some(index), ..
            } => *index,
            Page::Streamed { frame: None, .. } => self.exchange(page),
        };
        let frame = &mut self.frames[index];
        frame.used = self.now;
        frame.is_changed |= writes;
        frame.buffer.clone()
    }

    /// Brings a page into the frame that was used least lately.
    fn exchange(&mut self, page: usize) -> usize {
        let frames = self.frames.iter().enumerate();
        let index = frames
            .min_by_key(|(_, frame)| frame.used)
            .map_or(0, |(index, _)| index);
        let frame = &self.frames[index];
        if frame.page.is_some() && frame.used == self.now {
            self.fail("more pages than frames in a dispatch".into());
        }
        let (before, is_changed, place) = (frame.page, frame.is_changed, frame.buffer.clone());
        if let Some(Page::Streamed { home, bytes, frame }) = before.map(|before| &mut self.pages[before]) {
            *frame = None;
            if is_changed {
                self.streamed += *bytes;
                self.waiting.push(Command::Copy {
                    from: place.clone(),
                    to: home.clone(),
                    bytes: *bytes,
                });
            }
        }
        if let Page::Streamed { home, bytes, frame } = &mut self.pages[page] {
            *frame = Some(index);
            self.streamed += *bytes;
            self.waiting.push(Command::Copy {
                from: home.clone(),
                to: place,
                bytes: *bytes,
            });
        }
        let frame = &mut self.frames[index];
        (frame.page, frame.is_changed) = (Some(page), false);
        index
    }

    /// Writes `rows` rows of numbers into a part from its beginning, each as long as `values` and as `row` fills them in.
    pub fn write(
        &mut self,
        part: Part,
        rows: usize,
        values: &mut [f32],
        row: &mut dyn FnMut(usize, &mut [f32]),
    ) {
        self.now += 1;
        let buffer = self.bring(part.page, true);
        self.flush();
        let of_row = size_of_val(values);
        let bytes = (rows * of_row) as u64;
        let Some(size) = NonZeroU64::new(bytes) else {
            return;
        };
        let Some(mut to) = self.queue.write_buffer_with(&buffer, part.offset, size) else {
            return self.fail("there is no room for what is written".into());
        };
        let mut words = vec![0; of_row];
        for index in 0..rows {
            row(index, values);
            for (word, value) in words.chunks_exact_mut(4).zip(&*values) {
                word.copy_from_slice(&value.to_le_bytes());
            }
            to.slice(index * of_row..(index + 1) * of_row)
                .copy_from_slice(&words);
        }
        drop(to);
        self.staged += bytes;
        if self.staged >= STAGED {
            self.queue.submit([]);
            if self.device.poll(PollType::wait_indefinitely()).is_err() {
                self.fail("what was written did not arrive".into());
            }
            self.staged = 0;
        }
    }

    /// Reads `rows` rows from the beginning of a part, each as long as `values`; none where the device failed.
    pub fn read(&mut self, part: Part, rows: usize, values: &mut [f32], row: &mut dyn FnMut(usize, &[f32])) {
        let staging = self.device.create_buffer(&BufferDescriptor {
            label: Some("to be read"),
            size: part.bytes,
            usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.now += 1;
        let buffer = self.bring(part.page, false);
        self.flush();
        self.read_by(&staging, (&buffer, part.offset), rows, values, row);
    }

    fn read_by(
        &self,
        staging: &Buffer,
        (buffer, offset): (&Buffer, u64),
        rows: usize,
        values: &mut [f32],
        row: &mut dyn FnMut(usize, &[f32]),
    ) {
        let bytes = (rows * size_of_val(values)) as u64;
        let mut encoder = self
            .device
            .create_command_encoder(&CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, offset, staging, 0, bytes);
        // Vulkan shows the host what a device has written only behind a barrier, which wgpu records where it is asked for (gfx-rs/wgpu, issue 9306).
        let shown = BufferTransition {
            buffer: staging,
            state: BufferUses::MAP_READ,
        };
        encoder.transition_resources([shown].into_iter(), core::iter::empty());
        self.queue.submit([encoder.finish()]);
        let (tell, told) = mpsc::channel();
        staging.map_async(MapMode::Read, 0..bytes, move |mapped| {
            // Whoever waits for it is there until it comes.
            let _ = tell.send(mapped.is_ok());
        });
        let waited = self.device.poll(PollType::wait_indefinitely()).is_ok();
        let view = (waited && told.try_recv().unwrap_or(false))
            .then(|| staging.get_mapped_range(0..bytes).ok())
            .flatten();
        let Some(view) = view else {
            return self.fail("its numbers could not be read back".into());
        };
        for (index, words) in view.chunks_exact(size_of_val(values)).enumerate() {
            for (value, word) in values.iter_mut().zip(words.chunks_exact(4)) {
                *value = word.try_into().map_or(f32::NAN, f32::from_le_bytes);
            }
            row(index, values);
        }
        drop(view);
        staging.unmap();
    }

    /// Hands over what waits.
    pub fn flush(&mut self) {
        if self.waiting.is_empty() {
            return;
        }
        let mut encoder = self
            .device
            .create_command_encoder(&CommandEncoderDescriptor::default());
        let alike = |a: &Command, b: &Command| !a.is_copy() && !b.is_copy();
        for commands in self.waiting.chunk_by(alike) {
            if let [Command::Copy { from, to, bytes }] = commands {
                encoder.copy_buffer_to_buffer(from, 0, to, 0, *bytes);
                continue;
            }
            let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
            for command in commands {
                if let Command::Dispatch {
                    kernel,
                    bound,
                    numbers,
                    groups,
                } = command
                {
                    pass.set_pipeline(self.kernels.pipeline(*kernel));
                    pass.set_bind_group(0, bound, &[]);
                    pass.set_immediates(0, numbers);
                    pass.dispatch_workgroups(groups[0], groups[1], 1);
                }
            }
        }
        self.queue.submit([encoder.finish()]);
        self.waiting.clear();
    }

    /// One kernel for so many elements; parts that it does not read are left out.
    pub fn run(&mut self, kernel: Kernel, parts: &[Option<Part>], numbers: &Numbers, elements: usize) {
        self.run_groups(kernel, parts, numbers, (elements as u64).div_ceil(GROUP));
    }

    /// One kernel by so many groups.
    pub fn run_groups(&mut self, kernel: Kernel, parts: &[Option<Part>], numbers: &Numbers, groups: u64) {
        let rows = groups.div_ceil(self.bounds.row).max(1);
        let groups = [groups.div_ceil(rows) as u32, rows as u32];
        self.dispatch(kernel, parts, numbers, groups);
    }

    fn dispatch(&mut self, kernel: Kernel, parts: &[Option<Part>], numbers: &Numbers, groups: [u32; 2]) {
        self.now += 1;
        let nothing = self.nothing.step(0);
        let solids = self.solids.unwrap_or(nothing);
        let bound: Vec<_> = (0..kernel.buffers())
            .map(|binding| {
                let part = if binding + 1 == kernel.buffers() {
                    solids
                } else {
                    parts.get(binding).copied().flatten().unwrap_or(nothing)
                };
                (self.bring(part.page, binding < kernel.writes()), part)
            })
            .collect();
        let entries: Vec<_> = bound
            .iter()
            .enumerate()
            .map(|(binding, (buffer, part))| BindGroupEntry {
                binding: binding as u32,
                resource: BindingResource::Buffer(BufferBinding {
                    buffer,
                    offset: part.offset,
                    size: NonZeroU64::new(part.bytes),
                }),
            })
            .collect();
        let bound = self.device.create_bind_group(&BindGroupDescriptor {
            label: None,
            layout: self.kernels.layout(kernel),
            entries: &entries,
        });
        self.waiting.push(Command::Dispatch {
            kernel,
            bound,
            numbers: numbers.bytes(),
            groups,
        });
        if self.waiting.len() >= WAITING {
            self.flush();
        }
    }

    /// A kernel that leaves a number for each of its groups in each of `rows` rows of so many elements; where they will be among
    /// [`Self::sums`], row by row.
    pub fn reduce(
        &mut self,
        kernel: Kernel,
        parts: [Option<Part>; 5],
        numbers: Numbers,
        (rows, elements): (usize, usize),
    ) -> core::ops::Range<usize> {
        let groups = elements.div_ceil(GROUP as usize * PIECE);
        let groups = groups.clamp(1, self.bounds.partial);
        let begin = self.taken;
        self.taken += rows * groups;
        if self.taken > self.bounds.sums {
            self.fail("more sums than there is room for".into());
            return self.taken..self.taken + 1;
        }
        let numbers = Numbers {
            first: begin as u32,
            ..numbers
        };
        let [a, b, c, d, e] = parts;
        let sums = Some(self.sums.step(0));
        let groups = [groups as u32, rows as u32];
        self.dispatch(kernel, &[sums, a, b, c, d, e], &numbers, groups);
        begin..self.taken
    }

    /// Whether there is room for so many sums more.
    pub fn has_room(&self, sums: usize) -> bool {
        self.taken + sums <= self.bounds.sums
    }

    /// All that [`Self::reduce`] left since the last time; not finite ones where the device failed.
    pub fn sums(&mut self) -> Vec<f32> {
        self.flush();
        let count = core::mem::take(&mut self.taken).min(SUMS);
        let mut sums = vec![f32::NAN; count];
        if count > 0 {
            let mut came = vec![0.0; count];
            let all = |_: usize, values: &[f32]| sums.copy_from_slice(values);
            let left = self.bring(self.sums.step(0).page, false);
            self.read_by(&self.staging, (&left, 0), 1, &mut came, &mut { all });
        }
        sums
    }
}
