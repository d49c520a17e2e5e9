//! Nothing is allocated between `Solver::new` and the end of `solve`, saving and restoring included.
#![allow(unsafe_code, reason = "a global allocator that counts")]

use crate::fields::cases::Scene;
use crate::fields::effects::knows_open_sides;
use crate::fields::{Memory, cast, to_file};
use core::alloc::{GlobalAlloc, Layout};
use core::cell::Cell;
use std::alloc::System;
use thurible_core::flow::Minimiser;
use thurible_core::operator::{Given, Start};
use thurible_core::{
    Boundary, Capture, D2, D3, Emitter, Method, Operator, OperatorParams, OperatorPlan, Params, Problem,
    Real, Serial, Silent, Solver, Space, Status, Supply, TrackParams, TrackPlan, Tracker,
};

std::thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

/// The system's allocator, counting what each thread asks for.
struct Counting;

// SAFETY: every call is handed on to the system's allocator as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: as above.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, start: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(start, layout) }
    }

    unsafe fn realloc(&self, start: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: as above.
        unsafe { System.realloc(start, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

pub fn count() -> usize {
    COUNT.with(Cell::get)
}

fn allocates_nothing<T: Real, S: Space>(scene: &Scene) {
    let mut memory = Memory::new(scene.plan::<T, S>().bytes());
    let densities: Vec<Vec<T>> = scene.densities.iter().map(|density| cast(density)).collect();
    let [shapes, regions] = [&scene.effects.shapes, &scene.effects.regions]
        .map(|list| list.iter().map(|field| cast(field)).collect::<Vec<Vec<T>>>());
    let mask: Vec<T> = cast(&scene.effects.mask);
    let grid = scene.problem().grid();
    let guided = if scene.params.method == Method::Guide {
        2
    } else {
        1
    };
    let reference: Vec<(usize, usize, Vec<T>)> = (1..guided)
        .flat_map(|step| (0..S::DIM).map(move |axis| (step, axis)))
        .map(|(step, axis)| {
            let faces = to_file(&grid, axis, &scene.reference(step)[axis]);
            (step, axis, cast(&faces))
        })
        .collect();
    let problem = scene.problem();
    let block = memory.block();
    let mut saved = vec![0; scene.plan::<T, S>().saved_bytes()];
    let before = count();
    let mut solver = Solver::<T, S>::new(&problem, &scene.params, block).unwrap();
    solver.set_source(&densities[0]).unwrap();
    for (index, shape) in shapes.iter().enumerate() {
        solver.set_emitter(index, shape).unwrap();
    }
    solver.set_region(0, &regions[0]).unwrap();
    if problem.mask {
        solver.set_mask(&mask).unwrap();
    }
    solver.set_keyframe(0, &densities[1]).unwrap();
    for (step, axis, faces) in &reference {
        solver.set_reference(*axis, *step, faces).unwrap();
    }
    solver.save(&mut saved).unwrap();
    solver.restore(&saved).unwrap();
    let status = solver.solve(&Serial, &mut Silent, &mut |_| {});
    let after = count();
    let method = scene.params.method;
    let one_pass = matches!(method, Method::Pd | Method::Simulate | Method::Guide);
    assert_eq!(
        status,
        if one_pass {
            Status::Converged
        } else {
            Status::MaxIterations
        },
        "{method:?} on {:?}",
        scene.cells
    );
    assert_eq!(
        after - before,
        0,
        "{} allocations in {} on {:?}",
        after - before,
        T::NAME,
        scene.cells
    );
}

fn tracking_allocates_nothing<T: Real, S: Space>(
    cells: &[usize],
    boundary: &[Boundary],
    minimiser: Minimiser,
) {
    let capture = Capture::new(cells, boundary);
    let params = TrackParams::of(minimiser);
    let mut memory = Memory::new(TrackPlan::new::<T, S>(&capture, &params).unwrap().bytes());
    let frame = |time: usize| -> Vec<T> {
        let value = |cell: usize| 1.0 + (0.3 * cell as f64 + 0.5 * time as f64).sin();
        (0..cells.iter().product())
            .map(|cell| T::from_f64(value(cell)))
            .collect()
    };
    let frames = [0, 1, 2].map(frame);
    let mut out = vec![T::ZERO; 2 * frames[0].len()];
    let before = count();
    let mut tracker = Tracker::<T, S>::new(&capture, &params, memory.block()).unwrap();
    for frame in &frames {
        tracker.give(&Serial, frame).unwrap();
        if tracker.is_ready() {
            let told = &mut |_, faces: thurible_core::track::Faces<'_, T>| {
                let len = faces.len(0);
                faces.read(0, &mut out[..len]);
            };
            tracker.step(&Serial, &mut Silent, told).unwrap();
        }
    }
    assert_eq!(tracker.pairs(), 2);
    assert_eq!(count() - before, 0, "{minimiser:?} on {cells:?}");
}

#[test]
fn nothing_is_allocated_while_frames_are_tracked() {
    for minimiser in [Minimiser::Direct, Minimiser::Admm, Minimiser::HornSchunck] {
        tracking_allocates_nothing::<f32, D2>(&[20, 24], &[Boundary::Wall, Boundary::Periodic], minimiser);
        tracking_allocates_nothing::<f64, D3>(&[9, 10, 8], &[Boundary::Wall; 3], minimiser);
    }
}

fn operator_allocates_nothing<T: Real, S: Space>(cells: &[usize], solids: bool) {
    let boundary = [Boundary::Wall; 3];
    let emitters = [Emitter {
        from: 0,
        to: 3,
        supply: Supply::Rate(0.1),
        velocity: Some([0.01; 3]),
    }];
    let problem = Problem {
        steps: 6,
        emitters: &emitters,
        solids,
        buoyancy: [0.0, 1e-3, 0.0],
        ..Problem::new(cells, &boundary[..cells.len()], &[])
    };
    let params = OperatorParams {
        slots: Some(3),
        ..OperatorParams::default()
    };
    let mut memory = Memory::new(OperatorPlan::new::<T, S>(&problem, &params).unwrap().bytes());
    let block = memory.block();
    let count_of = cells.iter().product();
    let smoke = vec![T::from_f64(0.5); count_of];
    let mut solid = vec![false; count_of];
    solid[count_of / 2] = true;
    let mut out = vec![T::ZERO; count_of];
    let before = count();
    let mut operator = Operator::<T, S>::new(&problem, &params, block).unwrap();
    if solids {
        operator.set_solids(&solid).unwrap();
    }
    operator.set_emitter(0, &smoke).unwrap();
    let start = Start {
        density: &smoke,
        velocity: [&[]; 3],
    };
    let mut nothing = |_: usize, _: &mut Given<'_, T>| {};
    operator
        .simulate(&Serial, &mut Silent, &start, &mut nothing, &mut |_, view| {
            view.read_density(&mut out)
        })
        .unwrap();
    let mut covector = |_: usize, given: &mut Given<'_, T>| given.density(&smoke);
    let mut shown = 0;
    operator
        .vjp(&Serial, &mut Silent, &mut nothing, &mut covector, &mut |_, _| {
            shown += 1
        })
        .unwrap();
    operator.gradient().read_density(&mut out);
    assert_eq!((count() - before, shown), (0, 6), "operator on {cells:?}");
}

#[test]
fn nothing_is_allocated_by_the_operator() {
    operator_allocates_nothing::<f32, D2>(&[12, 9], false);
    operator_allocates_nothing::<f64, D2>(&[12, 9], true);
    operator_allocates_nothing::<f64, D3>(&[5, 7, 6], true);
}

#[test]
fn nothing_is_allocated_by_stable_fluids() {
    use crate::stable_fluids::case;
    use thurible_core::stable_fluids::{Control, Pressure, Slots};
    let all = [Control::InitialVelocity, Control::Forces, Control::Templates];
    for (pressure, slots) in [
        (Pressure::GaussSeidel, Slots::Tape),
        (Pressure::Conjugate, Slots::States(2)),
    ] {
        let mut scene = case::Scene::new(&[20, 16], "wp", &all).kept(slots);
        (scene.params.pressure, scene.params.iterations) = (pressure, 3);
        scene.with::<f32, D2, _>(|fluids| {
            let before = count();
            let status = fluids.solve(&Serial, &mut Silent, &mut |_| {});
            case::replay(fluids, |mut moment| {
                core::hint::black_box(moment.density().len() + moment.velocity(0).len());
            });
            assert_eq!(status, Status::MaxIterations);
            assert_eq!(count() - before, 0, "{pressure:?}, {slots:?}");
        });
    }
}

#[test]
fn nothing_is_allocated() {
    let before = count();
    drop(core::hint::black_box(vec![0u8; 100]));
    assert_eq!(count() - before, 1, "the counter does not count");
    for method in [
        Method::Admm,
        Method::Direct,
        Method::Lbfgs,
        Method::Pd,
        Method::Simulate,
        Method::Guide,
        Method::Templates,
    ] {
        let by = |cells: &[usize], ends: &str, steps: usize| {
            let scene = Scene::small(cells, ends, steps);
            let mut scene = Scene {
                params: Params {
                    method,
                    iterations: 3,
                    ..scene.params
                },
                ..scene
            };
            (scene.params.lbfgs.nested, scene.params.pd.gathering) = (true, 0.01);
            scene.with_everything()
        };
        allocates_nothing::<f32, D2>(&by(&[14, 9], "wp", 5));
        allocates_nothing::<f64, D2>(&by(&[8, 8], "ww", 4));
        allocates_nothing::<f64, D2>(&by(&[32, 16], "ww", 4));
        // Smoke that is driven across so flat a box becomes too fast.
        if method != Method::Pd {
            allocates_nothing::<f32, D2>(&by(&[300, 6], "pw", 3));
        }
        allocates_nothing::<f32, D3>(&by(&[6, 7, 8], "wpw", 4));
        allocates_nothing::<f64, D3>(&by(&[5, 5, 5], "ppp", 3));
        allocates_nothing::<f32, D2>(&by(&[33, 20], "wp", 5).among_solids());
        allocates_nothing::<f64, D3>(&by(&[8, 9, 8], "www", 4).among_solids());
        if knows_open_sides(method) {
            allocates_nothing::<f32, D2>(&by(&[33, 20], "ww", 5).in_open_box("oh"));
            allocates_nothing::<f64, D3>(&by(&[8, 9, 8], "www", 4).in_open_box("wlo"));
        }
    }
}
