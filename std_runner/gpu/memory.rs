//! Fields on a device: what a search needs of its memory, to the byte, before any of it is taken.
//!
//! A field lies in pages, some of its steps each. Where a search does not fit under the ceiling, pages are streamed: they have their homes in
//! the machine's memory, and are brought into one of a few frames of the device's where a kernel asks for them.

use wgpu::Limits;

/// Numbers to a multiple of which every field is padded, so that any of them may be bound alone.
const ALIGNED: usize = 64;
const BYTES: u64 = 4;
/// Steps of faces of a page that is streamed, the largest first.
const PAGES: [usize; 5] = [16, 8, 4, 2, 1];
/// Frames for pages. On the way back through a step a search has two pages of densities, and one or two each of the flow, of the force and of
/// the gradient; with fewer frames than that it would bring some of them again and again.
const FRAMES: usize = 8;
/// Part of what pages may take that goes to frames at most, where smaller pages are to be had.
const FOR_FRAMES: u64 = 4;

/// Some steps of a field, as kernels see them: a place in a page.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    pub page: usize,
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

/// How large a field is: so many steps of so many numbers, and how many of them lie in one page at most.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    pub name: &'static str,
    steps: usize,
    numbers: usize,
    together: usize,
    /// Whether its pages may be streamed.
    streams: bool,
}

/// A list of steps, each of cells or of faces along every axis.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    size: Size,
    /// Its first page.
    first: usize,
}

/// Pages that are streamed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Streaming {
    /// Bytes of a frame.
    pub frame: u64,
    /// How many there are.
    pub frames: usize,
    /// Pages of fields that may be streamed and stay on the device: the first so many.
    pub stay: usize,
}

/// The memory that a search takes, field by field.
#[derive(Debug, Default)]
pub struct Plan {
    sizes: Vec<Size>,
    streaming: Streaming,
}

/// What a search takes of a device, by name, and of the machine's memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Taken {
    /// Bytes of the device, by name.
    pub lines: Vec<(&'static str, u64)>,
    /// Bytes of the machine's memory: the homes of pages that are streamed.
    pub here: u64,
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
        let together = usize::MAX;
        let size = Self {
            name,
            steps,
            numbers,
            together,
            streams: false,
        };
        size.in_pages(limits, u64::MAX)
    }

    /// The same of a field whose pages may be streamed.
    pub fn streams(self) -> Self {
        Self {
            streams: true,
            ..self
        }
    }

    /// The same in pages of so many bytes at most, but of one step at least.
    fn in_pages(self, limits: &Limits, bytes: u64) -> Self {
        let together = at_once(limits).min(bytes) / self.step_bytes().max(1);
        let together = usize::try_from(together).unwrap_or(usize::MAX);
        Self {
            together: together.clamp(1, self.steps.max(1)),
            ..self
        }
    }

    /// Its bytes.
    pub fn bytes(&self) -> u64 {
        self.steps as u64 * self.step_bytes()
    }

    /// Bytes of one step.
    pub fn step_bytes(&self) -> u64 {
        self.numbers as u64 * BYTES
    }

    /// Bytes of its pages, one after the other.
    pub fn pages(self) -> impl Iterator<Item = u64> {
        let pages = self.windows(usize::MAX);
        pages.map(move |(_, count)| count as u64 * self.step_bytes())
    }

    /// Steps that may be bound together: ranges that lie in one page, of `most` steps at most.
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

    /// Frames, and which pages stay.
    pub fn streaming(&self) -> &Streaming {
        &self.streaming
    }

    /// Each field with its pages: their bytes, and whether they stay on the device.
    pub fn fields(&self) -> impl Iterator<Item = (Size, Vec<(u64, bool)>)> {
        let streams = self.streaming.frames > 0;
        let mut left = self.streaming.stay;
        self.sizes.iter().map(move |&size| {
            let pages = size.pages().map(|bytes| {
                let stays = !(streams && size.streams) || left > 0;
                if streams && size.streams {
                    left = left.saturating_sub(1);
                }
                (bytes, stays)
            });
            (size, pages.collect())
        })
    }

    /// Bytes of the device in all.
    pub fn bytes(&self) -> u64 {
        let lines = self.lines();
        lines.iter().map(|(_, bytes)| bytes).sum()
    }

    /// Bytes of the machine's memory.
    fn here(&self) -> u64 {
        let pages = self.fields().flat_map(|(_, pages)| pages);
        pages.filter(|(_, stays)| !stays).map(|(bytes, _)| bytes).sum()
    }

    /// Names with their bytes of the device, those of one name together.
    fn lines(&self) -> Vec<(&'static str, u64)> {
        let mut lines: Vec<(&'static str, u64)> = Vec::new();
        let fields = self.fields().map(|(size, pages)| {
            let stay = pages.iter().filter(|(_, stays)| *stays);
            (size.name, stay.map(|(bytes, _)| bytes).sum())
        });
        let frames = self.streaming.frames as u64 * self.streaming.frame;
        for (name, bytes) in fields.chain([("frames for what is streamed", frames)]) {
            match lines.last_mut() {
                Some((last, sum)) if *last == name => *sum += bytes,
                _ if bytes > 0 => lines.push((name, bytes)),
                _ => {}
            }
        }
        lines
    }

    /// What it takes.
    pub fn taken(&self) -> Taken {
        Taken {
            lines: self.lines(),
            here: self.here(),
        }
    }

    /// A sentence that says why it cannot be had, and what to do.
    pub fn refusal(&self, why: &str) -> String {
        format!(
            "the search needs {} bytes of the device: {why}, or take fewer pairs (method.direct.history), steps or cells",
            self.bytes()
        )
    }

    /// Makes it fit under the ceiling `most` by streaming as many pages as have to be, or all of them, in pages of `paged` steps, if that is
    /// asked for. Refuses it where that is not enough, or where the device does not bind a step at once.
    pub fn fit(self, limits: &Limits, most: Option<u64>, paged: Option<usize>) -> Result<Self, String> {
        let bound = at_once(limits);
        let largest = self.sizes.iter().map(Size::step_bytes).max().unwrap_or(0);
        if largest > bound {
            return Err(self.refusal(&format!(
                "a step of {largest} bytes is more than the {bound} that it takes at once; choose another device"
            )));
        }
        match (most, paged) {
            (Some(most), None) if most < self.bytes() => self.stream(limits, most),
            (_, Some(steps)) => Ok(self.in_pages(limits, steps, 0)),
            _ => Ok(self),
        }
    }

    /// Fields that may be streamed.
    fn streamed(&self) -> impl Iterator<Item = &Size> {
        self.sizes.iter().filter(|size| size.streams)
    }

    /// Streams as many pages as have to be.
    fn stream(self, limits: &Limits, most: u64) -> Result<Self, String> {
        let others = self.sizes.iter().filter(|size| !size.streams);
        let others: u64 = others.map(Size::bytes).sum();
        let step = self.streamed().map(Size::step_bytes).max().unwrap_or(0);
        let left = most.saturating_sub(others);
        let frames = |steps: usize| FRAMES as u64 * step * steps as u64;
        let least = others + frames(1);
        if least > most {
            return Err(self.refusal(&format!(
                "it may take {most}, and needs {least} with every step streamed; raise --device-memory"
            )));
        }
        let fits = |&&steps: &&usize| frames(steps) <= left / FOR_FRAMES;
        let steps = PAGES.iter().find(fits).copied().unwrap_or(1);
        Ok(self.in_pages(limits, steps, left))
    }

    /// The same in pages of so many steps, of which all are streamed for which there is no room in `left` bytes beside the frames.
    fn in_pages(mut self, limits: &Limits, steps: usize, left: u64) -> Self {
        let step = self.streamed().map(Size::step_bytes).max().unwrap_or(0);
        for size in self.sizes.iter_mut().filter(|size| size.streams) {
            *size = size.in_pages(limits, step * steps as u64);
        }
        let pages: Vec<u64> = self.streamed().flat_map(|size| size.pages()).collect();
        let frame = pages.iter().copied().max().unwrap_or(0);
        let mut left = left.saturating_sub(FRAMES as u64 * frame);
        let stays = |&&bytes: &&u64| {
            let fits = bytes <= left;
            left = left.saturating_sub(bytes);
            fits
        };
        self.streaming = Streaming {
            frame,
            frames: FRAMES,
            stay: pages.iter().take_while(stays).count(),
        };
        self
    }
}

impl Field {
    /// A field whose pages begin at the page `first`.
    pub fn new(size: Size, first: usize) -> Self {
        Self { size, first }
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
            page: self.first + first / together,
            offset: ((first % together) * numbers) as u64 * BYTES,
            bytes: (count * numbers) as u64 * BYTES,
        }
    }

    /// One step.
    pub fn step(&self, step: usize) -> Part {
        self.part(step, 1)
    }
}
