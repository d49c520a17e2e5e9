//! What a search has on a device, and the verbs that are one kernel or a few.

use crate::kernels::{FLAGS, Kernel, Numbers};
use crate::machine::Machine;
use crate::memory::{Field, Part, Plan, Size, apart};
use core::ops::Range;
use thurible_core::exec::device::{Place, Room, Search};
use thurible_core::grid::gaussian::Gaussian;
use wgpu::Limits;

/// Slots that are projected together at most.
const BATCH: usize = 16;
/// States of the sub-steps of a step that are kept on the way back; others are computed again.
pub const STATES: usize = 8;

/// Fields of cells that are worked in, behind the states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    A,
    B,
    OfB,
    OfA,
    Mu,
    Error,
    Image,
    Work,
}

const CELLS: usize = 8;

/// Which axes are rings, and whether there are solid cells or open sides, as kernels are told.
fn flags(search: &Search<'_>) -> u32 {
    let rings = search.rings.iter().enumerate();
    let solids = u32::from(search.room.solids) << 3;
    rings.fold(solids, |bits, (axis, &ring)| bits | (u32::from(ring) << axis))
}

/// Sums that were begun: where each will be.
type Begun = Vec<Range<usize>>;

/// The numbers of a search that stay as they are.
#[derive(Debug)]
pub struct Facts {
    pub room: Room,
    pub inverse: [f64; 3],
    pub inside: [Range<usize>; 3],
    pub viscosity: f64,
    pub force_weight: f64,
    pub smoothing: f64,
    pub factors: Vec<f64>,
    pub lengths: Vec<f64>,
    pub pivots: Vec<f64>,
    pub coupling: f64,
    pub courant: [f64; 2],
    pub negligible: f64,
    pub projection_tolerance: f64,
    pub keyframes: Vec<(usize, f64)>,
    pub identity: f64,
    pub least_of_mask: f64,
    pub buoyancy: [f64; 3],
    /// Number, what is added and up to what is filled, of the emitters of a step, from 0.
    pub supplies: Vec<Vec<(usize, [f64; 2])>>,
    /// Number and velocity of those that push v_k, by k.
    pub jets: Vec<Vec<(usize, [f64; 3])>>,
    flags: u32,
}

impl Facts {
    fn new(search: &Search<'_>) -> Self {
        let (room, factor) = (search.room, search.factor);
        let emitters = || 0..room.emitters;
        let supplies = |step: usize| {
            let of = |index: usize| Some((index, (search.supply)(step, index)?));
            emitters().filter_map(of).collect()
        };
        let jets = |slot: usize| {
            let of = |index: usize| Some((index, (search.jet)(slot, index)?));
            emitters().filter_map(of).collect()
        };
        Self {
            room,
            inverse: search.inverse,
            inside: search.inside.clone(),
            viscosity: search.viscosity,
            force_weight: search.force_weight,
            smoothing: search.smoothing,
            factors: factor.map_or_else(Vec::new, |factor| (0..room.slots).map(factor).collect()),
            lengths: (0..).map_while(|step| (search.lengths)(step)).collect(),
            pivots: search.pivots.into(),
            coupling: search.coupling,
            courant: search.courant,
            negligible: search.negligible,
            projection_tolerance: search.projection_tolerance,
            keyframes: (0..).map_while(|index| (search.keyframe)(index)).collect(),
            identity: search.identity,
            least_of_mask: search.least_of_mask,
            buoyancy: search.buoyancy,
            supplies: (0..room.slots + 2).map(supplies).collect(),
            jets: (0..room.slots).map(jets).collect(),
            flags: flags(search),
        }
    }

    fn count(&self) -> usize {
        self.room.cells.iter().product()
    }
}

/// The filters of the metric that are added up tap by tap: all of them among solid cells.
pub fn gaussians(room: &Room) -> impl Iterator<Item = Gaussian> + use<> {
    (1..=if room.solids { room.filters } else { 0 }).map(Gaussian::new)
}

/// What a search takes of a device, in the order of [`State`].
fn plan(limits: &Limits, room: &Room) -> Plan {
    let cells = apart(room.cells.iter().product());
    let faces = room.dims * cells;
    let axes = || room.cells.iter().take(room.dims);
    let (lines, matrices): (usize, usize) = (axes().sum(), axes().map(|n| n * n).sum());
    let taps: usize = gaussians(room).map(|gaussian| gaussian.radius + 1).sum();
    let filters = if room.solids { 0 } else { room.filters };
    let table = apart(matrices + (1 + filters) * lines + taps);
    let steps = |there: bool, steps: usize| if there { steps } else { 0 };
    let batch = BATCH.min(room.slots);
    let mut plan = Plan::default();
    let size = |name, steps, numbers| Size::new(limits, name, steps, numbers);
    // What there is of every step may be streamed.
    plan.add(size("velocity", room.slots, faces).streams());
    plan.add(size("densities", room.slots + 2, cells).streams());
    let mut add = |name, steps, numbers| plan.add(size(name, steps, numbers));
    add("given velocity", 1, faces);
    add("targets", room.keyframes, cells);
    add("regions", steps(room.regions, room.keyframes), cells);
    add("shapes of emitters", room.emitters, cells);
    add("mask", steps(room.masked, 1), cells);
    add("solid cells", steps(room.solids, 1), cells);
    add("gradient of a step", 1, faces);
    add("states and stages of transport, metric", STATES + CELLS, cells);
    add("potentials", batch, cells);
    add("potentials, transformed", batch, cells);
    for _ in 0..3 {
        add("conjugate gradients", steps(room.obstacles, batch), cells);
    }
    add("factors of a batch", steps(room.obstacles, 1), apart(batch));
    add("eigenvectors and eigenvalues", 1, table);
    let mut add = |name, there| plan.add(size(name, steps(there, room.slots), faces).streams());
    add("force times its price", room.weighs);
    add("force divided by its mask", room.masked);
    (0..room.fields).for_each(|_| add("a field of L-BFGS", true));
    plan
}

/// The same under the ceiling `most`, or why that cannot be.
pub fn fit(machine: &Machine, room: &Room, most: Option<u64>) -> Result<Plan, String> {
    machine.fit(plan(machine.limits(), room), most)
}

/// What a search has on a device.
#[derive(Debug)]
pub struct State {
    pub facts: Facts,
    v: Field,
    rho: Field,
    initial: Field,
    targets: Field,
    regions: Field,
    emitters: Field,
    mask: Field,
    solids: Field,
    gradient: Field,
    cells: Field,
    pub potentials: [Field; 2],
    /// Residuals, directions and images of conjugate gradients, and a factor for each slot of a batch.
    pub conjugate: [Field; 3],
    pub factors: Field,
    pub table: Field,
    pub priced: Field,
    pub divided: Field,
    pub fields: Vec<Field>,
    /// Sub-steps of each step of the flow that was carried last.
    pub substeps: Vec<usize>,
}

impl State {
    /// Makes room for a search, or says why there is none. `most` is the ceiling.
    pub fn new(machine: &mut Machine, search: &Search<'_>, most: Option<u64>) -> Result<Self, String> {
        let facts = Facts::new(search);
        let plan = fit(machine, &search.room, most)?;
        let why = "it has not so much left; give less by --device-memory, and steps are streamed";
        let none = || plan.refusal(why);
        let mut fields = machine.fields(&plan).ok_or_else(none)?.into_iter();
        let mut next = || fields.next().ok_or_else(none);
        let mut state = Self {
            v: next()?,
            rho: next()?,
            initial: next()?,
            targets: next()?,
            regions: next()?,
            emitters: next()?,
            mask: next()?,
            solids: next()?,
            gradient: next()?,
            cells: next()?,
            potentials: [next()?, next()?],
            conjugate: [next()?, next()?, next()?],
            factors: next()?,
            table: next()?,
            priced: next()?,
            divided: next()?,
            fields: Vec::new(),
            substeps: Vec::new(),
            facts,
        };
        state.fields = fields.collect();
        let solids = search.room.solids.then(|| state.solids.step(0));
        machine.compile(search.room.dims, solids);
        let mut table = state.numbers_of_axes(search);
        let part = state.table.step(0);
        machine.write(part, 1, &mut table, &mut |_, _| {});
        Ok(state)
    }

    /// Matrices axis by axis, eigenvalues axis by axis, and those of each filter axis by axis, or its taps.
    fn numbers_of_axes(&self, search: &Search<'_>) -> Vec<f32> {
        let axes = || search.room.cells.into_iter().enumerate().take(search.room.dims);
        let mut table = Vec::with_capacity(self.table.numbers());
        for (axis, n) in axes() {
            for k in 0..n {
                table.extend((0..n).map(|i| (search.vector)([axis, k, i]) as f32));
            }
        }
        for (axis, n) in axes() {
            table.extend((0..n).map(|k| (search.eigenvalue)([axis, k]) as f32));
        }
        let by_taps = gaussians(&search.room).count();
        for j in by_taps + 1..=search.room.filters {
            for (axis, n) in axes() {
                table.extend((0..n).map(|k| (search.blur)([axis, j, k]) as f32));
            }
        }
        for gaussian in gaussians(&search.room) {
            table.extend(gaussian.taps().map(|(_, tap)| tap as f32));
        }
        table
    }

    /// The numbers that every dispatch is given.
    pub fn numbers(&self) -> Numbers {
        Numbers {
            n: self.facts.room.cells.map(|n| n as u32),
            apart: self.apart() as u32,
            inverse: self.facts.inverse.map(|x| x as f32),
            flags: self.facts.flags,
            ..Numbers::default()
        }
    }

    /// Numbers between fields.
    pub fn apart(&self) -> usize {
        apart(self.facts.count())
    }

    /// Cells of the box.
    pub fn count(&self) -> usize {
        self.facts.count()
    }

    /// Rows of a field of cells, and room for one.
    pub fn rows(&self) -> (usize, Vec<f32>) {
        let [x, y, z] = self.facts.room.cells;
        (y * z, vec![0.0; x])
    }

    /// The field at a place.
    pub fn place(&self, place: Place) -> Part {
        match place {
            Place::Flow(step, axis) => self.flow(step).of_axis(axis, self.apart()),
            Place::Density(step) => self.rho.step(step),
            Place::Target(index) => self.targets.step(index),
            Place::Region(index) => self.regions.step(index),
            Place::Emitter(index) => self.emitters.step(index),
            Place::Mask => self.mask.step(0),
            Place::Solids => self.solids.step(0),
            Place::Field(which, slot, axis) => self.fields[which].step(slot).of_axis(axis, self.apart()),
        }
    }

    /// The flow of a step, from v_0 on.
    pub fn flow(&self, step: usize) -> Part {
        match step.checked_sub(1) {
            None => self.initial.step(0),
            Some(slot) => self.v.step(slot),
        }
    }

    /// The velocity in all slots.
    pub fn velocity(&self) -> &Field {
        &self.v
    }

    /// The density of a step.
    pub fn density(&self, step: usize) -> Part {
        self.rho.step(step)
    }

    /// The gradient by the flow of a step.
    pub fn gradient_of_step(&self) -> Part {
        self.gradient.step(0)
    }

    /// A field of cells to work in.
    pub fn cell(&self, which: Cell) -> Part {
        self.cells.step(STATES + which as usize)
    }

    /// A state of a sub-step.
    pub fn kept(&self, state: usize) -> Part {
        self.cells.step(state)
    }

    /// out = a out + b x, in parts of the same length.
    pub fn add(&self, machine: &mut Machine, out: Part, factors: [f64; 2], x: Option<Part>) {
        self.by_element(machine, Kernel::Add, out, [x, None], factors);
    }

    /// A kernel over the elements of `to`, which is told two numbers: `to`, `x` and `y` of `kernels/elements.wgsl`.
    pub fn by_element(
        &self,
        machine: &mut Machine,
        kernel: Kernel,
        to: Part,
        x: [Option<Part>; 2],
        [a, b]: [f64; 2],
    ) {
        let count = (to.bytes / 4) as usize;
        let numbers = Numbers {
            a: a as f32,
            b: b as f32,
            count: count as u32,
            ..self.numbers()
        };
        let [x, y] = x;
        machine.run(kernel, &[Some(to), x, y], &numbers, count);
    }

    /// [`Self::add`] of whole fields.
    pub fn add_fields(&self, machine: &mut Machine, out: &Field, factors: [f64; 2], x: &Field) {
        for (first, count) in out.windows(usize::MAX) {
            self.add(
                machine,
                out.part(first, count),
                factors,
                Some(x.part(first, count)),
            );
        }
    }

    /// out *= x.
    pub fn multiply(&self, machine: &mut Machine, out: Part, x: Part) {
        self.by_element(machine, Kernel::Multiply, out, [Some(x), None], [0.0; 2]);
    }

    /// Begins the sum of x y over parts, or of x x.
    pub fn dot(&self, machine: &mut Machine, x: Part, y: Option<Part>) -> Range<usize> {
        self.dot_rows(machine, x, y, 1)
    }

    /// Begins that of each of so many rows of them.
    pub fn dot_rows(&self, machine: &mut Machine, x: Part, y: Option<Part>, rows: usize) -> Range<usize> {
        let (base, elements) = (self.numbers(), (x.bytes / 4) as usize / rows);
        let numbers = Numbers {
            count: elements as u32,
            flags: base.flags | (u32::from(y.is_none()) << FLAGS),
            ..base
        };
        let parts = [Some(x), y, None, None, None];
        machine.reduce(Kernel::DotAll, parts, numbers, (rows, elements))
    }

    /// Sums over whole fields of the size of `like`, one after the other: `begin` begins as many in each window of steps.
    pub fn products(
        &self,
        machine: &mut Machine,
        like: &Field,
        begin: &mut dyn FnMut(&mut Machine, (usize, usize)) -> Begun,
    ) -> Vec<f64> {
        let (mut totals, mut begun): (Vec<f64>, Vec<Begun>) = (Vec::new(), Vec::new());
        let windows: Vec<_> = like.windows(usize::MAX).collect();
        for (place, &window) in windows.iter().enumerate() {
            let ranges = begin(machine, window);
            let of_window = ranges.iter().map(ExactSizeIterator::len).sum();
            totals.resize(ranges.len(), 0.0);
            begun.push(ranges);
            if place + 1 == windows.len() || !machine.has_room(of_window) {
                let sums = machine.sums();
                for ranges in begun.drain(..) {
                    for (total, range) in totals.iter_mut().zip(ranges) {
                        let sums = sums.get(range).unwrap_or(&[f32::NAN]);
                        sums.iter().for_each(|&sum| *total += f64::from(sum));
                    }
                }
            }
        }
        totals
    }

    /// Begins the largest |x| of each of so many rows of a part.
    pub fn largest(&self, machine: &mut Machine, x: Part, rows: usize) -> Range<usize> {
        let elements = (x.bytes / 4) as usize / rows;
        let numbers = Numbers {
            count: elements as u32,
            ..self.numbers()
        };
        let parts = [Some(x), None, None, None, None];
        machine.reduce(Kernel::Largest, parts, numbers, (rows, elements))
    }

    /// Begins the Courant numbers of the steps of some flows, the same count of numbers for each.
    pub fn courant(&self, machine: &mut Machine, flows: Part) -> Range<usize> {
        let steps = (flows.bytes / 4) as usize / (self.facts.room.dims * self.apart());
        let parts = [None, None, None, None, Some(flows)];
        machine.reduce(Kernel::Courant, parts, self.numbers(), (steps, self.count()))
    }
}

/// Their sum.
pub fn total(sums: &[f32]) -> f64 {
    sums.iter().map(|&sum| f64::from(sum)).sum()
}

/// The sum of the numbers in a range.
pub fn sum_of(sums: &[f32], range: &Range<usize>) -> f64 {
    total(sums.get(range.clone()).unwrap_or(&[f32::NAN]))
}

/// The larger of two numbers, or what is none.
pub fn worse(most: f64, next: f64) -> f64 {
    if next > most || next.is_nan() { next } else { most }
}

/// The largest of them.
pub fn most(sums: &[f32]) -> f64 {
    sums.iter().map(|&sum| f64::from(sum)).fold(0.0, worse)
}

/// The largest of the numbers in a range.
pub fn largest_of(sums: &[f32], range: &Range<usize>) -> f64 {
    most(sums.get(range.clone()).unwrap_or(&[f32::NAN]))
}

/// The numbers of each of so many rows.
pub fn rows_of<'s>(sums: &'s [f32], range: &Range<usize>, rows: usize) -> impl Iterator<Item = &'s [f32]> {
    let sums = sums.get(range.clone()).unwrap_or(&[]);
    sums.chunks((sums.len() / rows.max(1)).max(1))
}
