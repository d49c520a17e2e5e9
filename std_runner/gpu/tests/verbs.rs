//! Each verb of a device beside the core's, from the same fields: odd numbers of cells, walls and rings, every price, sub-steps enough that not
//! all of their states are kept.

use super::device as the_device;
use core::mem::MaybeUninit;
use thurible_core::exec::Device;
use thurible_core::exec::device::Place;
use thurible_core::exec::ranks::Alone;
use thurible_core::field::VectorMut;
use thurible_core::force::time_line::TimeLine;
use thurible_core::grid::Grid;
use thurible_core::grid::levels::Levels;
use thurible_core::grid::solids::{Surfaces, closed};
use thurible_core::memory::{Arena, Ledger, Pool};
use thurible_core::method::direct::there::hand_over;
use thurible_core::method::first_hessian;
use thurible_core::objective::flow::{self, Evaluation};
use thurible_core::objective::script::{Lists, Script};
use thurible_core::objective::sweep;
use thurible_core::operators::blur::Metric;
use thurible_core::optimise::quasi_newton::fields;
use thurible_core::optimise::quasi_newton::history::History;
use thurible_core::optimise::quasi_newton::recursion::QuasiNewton;
use thurible_core::{Advection, Boundary, D2, D3, Serial, Silent, Space};
use thurible_gpu::{Bounds, Gpu, adapters};

/// What two programs in f32 may differ by, in parts of the largest value of a field: transforms add up whole lines, some sub-steps a dozen
/// stages.
const BOUND: f64 = 2e-6;

/// Numbers from -1 to 1, the same in every run (a linear congruence, Knuth's MMIX).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A field of faces: 0 on walls, up to `most` elsewhere.
    fn faces(&mut self, grid: &Grid, slots: usize, most: f64) -> [Vec<f32>; 3] {
        core::array::from_fn(|axis| {
            if axis >= grid.dims {
                return Vec::new();
            }
            let mut field = vec![0.0; grid.cells() * slots];
            for (place, value) in field.iter_mut().enumerate() {
                let (row, x) = (place / grid.n[0] / slots, place % grid.n[0]);
                let at = grid.cell_at(row, x);
                if grid.axis(axis).is_ring() || at[axis] > 0 {
                    *value = (most * self.next()) as f32;
                }
            }
            field
        })
    }

    fn cells(&mut self, count: usize) -> Vec<f32> {
        (0..count).map(|_| self.next().abs() as f32).collect()
    }
}

fn view(field: &[Vec<f32>; 3]) -> [&[f32]; 3] {
    field.each_ref().map(|component| &component[..])
}

fn view_mut(field: &mut [Vec<f32>; 3]) -> VectorMut<'_, f32> {
    field.each_mut().map(|component| &mut component[..])
}

/// A case: a box, and how fast the flow is in cells a step.
struct Case {
    cells: &'static [usize],
    boundary: &'static [Boundary],
    speed: f64,
    smoothing: f64,
    viscosity: f64,
    scheduled: bool,
    regions: bool,
    /// Buoyancy, and two emitters that push: one by a rate, one up to a target.
    emits: bool,
    masked: bool,
    /// A block of solid cells in the middle, and one at a corner.
    solids: bool,
}

const SLOTS: usize = 5;
const FIELDS: usize = 6;

/// Asserts that a field of the device is `here`, up to rounding.
fn same(device: &Gpu, what: &str, places: impl Iterator<Item = (Place, Vec<f32>)>) {
    let (mut worst, mut largest) = (0.0f64, 0.0f64);
    for (place, here) in places {
        let mut there = vec![0.0; here.len()];
        device.read(place, &mut |row, values| {
            there[row * values.len()..][..values.len()].copy_from_slice(values);
        });
        for (here, there) in here.iter().zip(&there) {
            let [here, there] = [here, there].map(|&value| f64::from(value));
            assert!(there.is_finite(), "{what}: {place:?}");
            worst = worst.max((here - there).abs());
            largest = largest.max(here.abs());
        }
    }
    println!("  {what}: {worst:.1e} of {largest:.1e}");
    assert!(
        largest > 0.0 && worst <= BOUND * largest,
        "{what}: {worst} of {largest}"
    );
}

fn close(what: &str, here: f64, there: f64, size: f64) {
    println!("  {what}: {here} and {there}");
    assert!((here - there).abs() <= BOUND * size, "{what}: {here} and {there}");
}

/// The rows of a slot of a trajectory, one after the other.
fn slot_of(grid: &Grid, field: &[f32], slots: usize, slot: usize) -> Vec<f32> {
    let n = grid.n[0];
    (0..grid.rows())
        .flat_map(|row| field[(row * slots + slot) * n..][..n].to_vec())
        .collect()
}

fn slots_of<'a>(
    grid: &'a Grid,
    field: [&'a [f32]; 3],
    place: impl Fn(usize, usize) -> Place + 'a,
) -> impl Iterator<Item = (Place, Vec<f32>)> + 'a {
    let all = (0..SLOTS).flat_map(|slot| (0..grid.dims).map(move |axis| (slot, axis)));
    all.map(move |(slot, axis)| (place(slot, axis), slot_of(grid, field[axis], SLOTS, slot)))
}

/// A case where all fits, and where every step is streamed.
fn check<S: Space>(case: &Case) {
    let device = the_device();
    check_on::<S>(&device, case);
    let paged = Bounds {
        paged: Some(2),
        ..Bounds::default()
    };
    let streams = adapters()[0].open_within(None, paged).unwrap();
    check_on::<S>(&streams, case);
    assert!(streams.streamed() > 0);
}

fn check_on<S: Space>(device: &Gpu, case: &Case) {
    println!("{:?} {:?}", case.cells, case.boundary);
    let grid = Grid::new(case.cells, case.boundary);
    let cells = grid.cells();
    let mut random = Random(7);
    let most = case.speed * grid.h[0];
    let mut v = random.faces(&grid, SLOTS, most);
    let mut initial = random.faces(&grid, 1, most);
    let keyframes = 2;
    let emitters = if case.emits { 2 } else { 0 };
    let fields = keyframes * (1 + usize::from(case.regions)) + emitters + usize::from(case.masked);
    let given = random.cells(cells * fields);
    let mut rho = random.cells(cells * (SLOTS + 2));
    let metric = Metric {
        filters: 3,
        identity: 1.0,
    };
    let surfaces = Surfaces {
        obstacles: case.solids,
        stick: false,
    };
    let setup = flow::Setup {
        sweep: sweep::Setup {
            slots: SLOTS,
            metric,
            stepping: Advection::default().into(),
            largest: 1.0,
            threads: 1,
            surfaces,
            overlap: false,
        },
        viscosity: case.viscosity,
        force_weight: 1.5,
        smoothing: case.smoothing,
        scheduled: case.scheduled,
        masked: case.masked,
        buoyancy: if case.emits { [2e-3, 0.0, -5e-3] } else { [0.0; 3] },
        projection_tolerance: 1e-6,
    };
    let lists = Lists {
        steps: &[3, 6],
        weights: &[1.0, 0.7],
        regions: case.regions,
        knots: if case.scheduled { &[1, 5] } else { &[] },
        factors: if case.scheduled { &[1.0, 3.0] } else { &[] },
        spans: if case.emits { &[0, 4, 2, 6] } else { &[] },
        supplies: if case.emits { &[0.3, 0.0, 0.0, 0.8] } else { &[] },
        jets: if case.emits {
            &[1.0, 0.02, -0.03, 0.01, 1.0, -0.01, 0.04, 0.02]
        } else {
            &[]
        },
        mask: case.masked,
        ..Lists::default()
    };
    let mut memory = vec![MaybeUninit::new(0u8); 1 << 22];
    let at = memory.as_ptr().align_offset(64);
    let mut levels = Levels::<f32>::bare(&grid, metric.filters).with_surfaces(surfaces);
    levels.fill(&mut Arena::new(&mut memory[at..])).unwrap();
    if case.solids {
        levels.set_solids(&Alone, |cell| {
            let at = grid.cell_at(cell / grid.n[0], cell % grid.n[0]);
            let within = |from: usize, to: usize| (0..grid.dims).all(|axis| (from..to).contains(&at[axis]));
            within(3, 5) || within(0, 2)
        });
    }
    let (solids, n) = (levels.solids(0), grid.n[0]);
    for row in 0..if solids.there() { grid.rows() } else { 0 } {
        for axis in 0..grid.dims {
            let of_row = &mut v[axis][row * SLOTS * n..(row + 1) * SLOTS * n];
            solids.clear(n, row, closed(axis), of_row);
            solids.clear(n, row, closed(axis), &mut initial[axis][row * n..(row + 1) * n]);
        }
    }
    let mut ledger = Ledger::new();
    Evaluation::<f32>::measure(&levels, 0, &setup.sweep, &mut Pool::measuring(&mut ledger));
    let mut region = vec![f32::NAN; ledger.elements(4)];
    let mut ledger = Ledger::new();
    let history = History::full(2);
    fields::take(&grid, SLOTS, history, &mut Pool::<f32>::measuring(&mut ledger));
    let mut pairs = vec![0.0f32; ledger.elements(4)];
    let mut fields = fields::take(&grid, SLOTS, history, &mut Pool::new(&mut pairs));
    assert_eq!(fields.len(), FIELDS);
    let [mut priced, mut divided] = [(); 2].map(|()| random.faces(&grid, SLOTS, 0.0));
    let mut sums = vec![0.0; 16 * grid.rows()];
    let mut evaluation = Evaluation {
        levels: &levels,
        level: 0,
        setup,
        initial: view(&initial),
        rho: &mut rho,
        script: Script::new(lists, &given),
        priced: view_mut(&mut priced),
        divided: if case.masked {
            view_mut(&mut divided)
        } else {
            Default::default()
        },
        region: &mut region,
        sums: &mut sums,
    };
    let mut pivots = [0.0; SLOTS];
    let line = TimeLine::new(1e-2, 1e-3, &mut pivots);
    hand_over(device, &evaluation, view(&v), line, FIELDS);
    assert_eq!(device.failure(), None);

    // The value: densities, the force, and the three sums.
    let (work, gradient) = (2, 3);
    let here = evaluation
        .value::<S>(&Serial, &mut Silent, view(&v), &mut fields[work], f64::INFINITY)
        .unwrap();
    let [data, price, plain] = device.value(work).unwrap();
    close("data term", here.data, data, here.data);
    close("price", here.force, price, here.force);
    close("force squared", here.plain, plain, here.plain);
    let densities = (1..SLOTS + 2).map(|step| {
        (
            Place::Density(step),
            evaluation.rho[step * cells..(step + 1) * cells].to_vec(),
        )
    });
    same(device, "densities", densities);
    let field = |which: usize| move |slot: usize, axis: usize| Place::Field(which, slot, axis);
    same(
        device,
        "force",
        slots_of(&grid, fields[work].each_ref().map(|c| &**c), field(work)),
    );

    // The gradient.
    let force = fields[work].each_ref().map(|component| component.to_vec());
    let mut into = core::mem::take(&mut fields[gradient]);
    evaluation
        .gradient::<S>(&Serial, &mut Silent, view(&v), view(&force), &mut into)
        .unwrap();
    fields[gradient] = into;
    device.gradient(work, gradient).unwrap();
    same(
        device,
        "gradient",
        slots_of(&grid, fields[gradient].each_ref().map(|c| &**c), field(gradient)),
    );

    // The first inverse Hessian, and inner products with the gradient.
    let mut newton = QuasiNewton::new(history);
    let borrowed = thurible_core::optimise::quasi_newton::recursion::Borrowed { work, gradient };
    first_hessian::arrive::<f32, S>(
        &Serial,
        &mut evaluation,
        Some(line),
        &mut fields,
        &mut newton,
        (borrowed, None),
    );
    let mut products = Vec::new();
    let with = device.arrive(
        gradient,
        work,
        None,
        &mut [[gradient, work]].into_iter(),
        &mut |pair| {
            products.push(pair);
        },
    );
    same(
        device,
        "P g",
        slots_of(&grid, fields[work].each_ref().map(|c| &**c), field(work)),
    );
    let norm = newton.gradient_norm();
    close("<g, P g>", norm * norm, with.norm, norm * norm);
    close("the same, by fields", with.norm, products[0][1], with.norm);
    let squares = |field: &[&mut [f32]; 3]| -> f64 {
        let all = field.iter().flat_map(|component| component.iter());
        all.map(|&value| f64::from(value) * f64::from(value)).sum()
    };
    let square = squares(&fields[gradient]);
    close("<g, g>", square, products[0][0], square);

    // Sums of fields, a projection, and steps of the flow.
    device.form(4, &mut [(0.5, gradient), (-2.0, work)].into_iter());
    let sum: [Vec<f32>; 3] = core::array::from_fn(|axis| {
        let pairs = fields[gradient][axis].iter().zip(&*fields[work][axis]);
        pairs.map(|(g, p)| 0.5 * g - 2.0 * p).collect()
    });
    same(device, "a sum", slots_of(&grid, view(&sum), field(4)));
    let mut cleaned = sum.clone();
    let [_, speed] = evaluation
        .clean(&Serial, &mut Silent, &mut view_mut(&mut cleaned))
        .unwrap();
    device.project(4, 0.02);
    let [left, fastest] = device.divergence(4);
    close("max |d|", speed, fastest, speed);
    assert!(left < 1e-4, "{left}");
    same(
        device,
        "a clean direction",
        slots_of(&grid, view(&cleaned), field(4)),
    );
    device.advance(4, 0.25);
    for (v, d) in v.iter_mut().zip(&cleaned) {
        v.iter_mut().zip(d).for_each(|(v, d)| *v += 0.25 * d);
    }
    let flow = |slot: usize, axis: usize| Place::Flow(slot + 1, axis);
    same(device, "a step", slots_of(&grid, view(&v), flow));
    device.retreat(0.5);
    evaluation.retreat(&Serial, &mut view_mut(&mut v), 0.5);
    same(device, "half of the way back", slots_of(&grid, view(&v), flow));
    device.retreat(0.0);
    evaluation.retreat(&Serial, &mut view_mut(&mut v), 0.0);
    same(device, "all of it", slots_of(&grid, view(&v), flow));
    assert_eq!(device.failure(), None);
}

use Boundary::{Open, OpenHigh, Periodic, Wall};

/// Between walls, with nothing special.
const PLAIN: Case = Case {
    cells: &[17, 12],
    boundary: &[Wall, Wall],
    speed: 0.3,
    smoothing: 0.0,
    viscosity: 0.0,
    scheduled: false,
    regions: false,
    emits: false,
    masked: false,
    solids: false,
};

#[test]
fn verbs_in_2d() {
    check::<D2>(&PLAIN);
    check::<D2>(&Case {
        cells: &[16, 13],
        boundary: &[Periodic, Wall],
        speed: 3.0,
        smoothing: 2e-3,
        viscosity: 1e-4,
        scheduled: true,
        regions: true,
        ..PLAIN
    });
    check::<D2>(&Case {
        cells: &[15, 11],
        speed: 0.7,
        emits: true,
        ..PLAIN
    });
    check::<D2>(&Case {
        smoothing: 2e-3,
        scheduled: true,
        masked: true,
        ..PLAIN
    });
    check::<D2>(&Case {
        speed: 0.5,
        emits: true,
        solids: true,
        ..PLAIN
    });
    check::<D2>(&Case {
        cells: &[13, 12],
        boundary: &[Open, Wall],
        speed: 0.9,
        smoothing: 1e-3,
        emits: true,
        ..PLAIN
    });
    // Lines longer than a tile of a transform.
    check::<D2>(&Case {
        cells: &[70, 131],
        ..PLAIN
    });
}

#[test]
fn verbs_in_3d() {
    check::<D3>(&Case {
        cells: &[8, 9, 7],
        boundary: &[Wall, Periodic, Periodic],
        speed: 1.2,
        smoothing: 5e-3,
        viscosity: 1e-3,
        regions: true,
        ..PLAIN
    });
    check::<D3>(&Case {
        cells: &[6, 7, 9],
        boundary: &[Periodic, Wall, Wall],
        speed: 0.4,
        scheduled: true,
        ..PLAIN
    });
    check::<D3>(&Case {
        cells: &[7, 6, 8],
        boundary: &[Periodic, Wall, Wall],
        speed: 1.4,
        smoothing: 1e-3,
        viscosity: 1e-4,
        regions: true,
        emits: true,
        masked: true,
        ..PLAIN
    });
    check::<D3>(&Case {
        cells: &[9, 8, 7],
        boundary: &[Wall, Periodic, Wall],
        speed: 0.8,
        smoothing: 1e-3,
        viscosity: 1e-4,
        masked: true,
        solids: true,
        ..PLAIN
    });
    check::<D3>(&Case {
        cells: &[8, 9, 10],
        boundary: &[OpenHigh, Open, Periodic],
        speed: 1.2,
        smoothing: 1e-3,
        viscosity: 1e-4,
        scheduled: true,
        emits: true,
        solids: true,
        ..PLAIN
    });
    check::<D3>(&Case {
        cells: &[66, 5, 65],
        boundary: &[Wall, Wall, Periodic],
        speed: 0.4,
        smoothing: 5e-4,
        ..PLAIN
    });
}
