//! States of a search: gone on from elsewhere with the same bits, and refused where they are not what was saved.

use super::case::{Scene, built};
use crate::checkpoint_refusals::pieces;
use crate::fields::{self, Memory, with_threads};
use thurible_core::checkpoint::HEAD;
use thurible_core::stable_fluids::{Adjoint, Control, Pressure, Slots};
use thurible_core::{
    D2, D3, Fluids, FluidsParams, FluidsPlan, Progress, Real, SavedError, Serial, Silent, Space, Status,
};

const ALL: [Control; 3] = [Control::InitialVelocity, Control::Forces, Control::Templates];

/// Calls `work` with a search that has nothing yet, in bytes that hold `fill`.
fn with_empty<T: Real, S: Space, R>(
    scene: &Scene,
    fill: u8,
    work: impl FnOnce(&mut Fluids<'_, T, S>) -> R,
) -> R {
    let problem = scene.problem();
    let mut memory = Memory::filled(built::<T, S>(&problem, &scene.params).unwrap(), fill);
    work(&mut Fluids::new(&problem, &scene.params, memory.block()).unwrap())
}

fn save<T: Real, S: Space>(fluids: &mut Fluids<'_, T, S>) -> Vec<u8> {
    let mut bytes = vec![0xEE; fluids.saved_bytes() + 3];
    fluids.save(&mut bytes).unwrap();
    let behind = bytes.split_off(fluids.saved_bytes());
    assert_eq!(behind, [0xEE; 3], "more was written than was said");
    bytes
}

/// What a search still does, and where it ends, bit by bit. A gradient repeats as many steps as its states make it.
fn rest_of<T: Real, S: Space>(fluids: &mut Fluids<'_, T, S>) -> (Vec<String>, Option<Status>, Vec<u64>) {
    let (mut history, mut status) = (Vec::new(), None);
    while status.is_none() {
        let progress = fluids.step(&Serial, &mut Silent);
        status = progress.status;
        history.push(said(&progress));
    }
    let unknowns = fluids.unknowns().iter().map(|z| z.to_f64().to_bits()).collect();
    (history, status, unknowns)
}

fn said(progress: &Progress) -> String {
    let fact = |name: &str| progress.report.get(name).map(f64::to_bits);
    let facts = ["step", "slope", "gradient_norm", "evaluations"].map(fact);
    format!(
        "{} {:?} {facts:?} {:?}",
        progress.iteration, progress.objective, progress.status
    )
}

fn scene(cells: &[usize], ends: &str, controls: &[Control]) -> Scene {
    let mut scene = Scene::new(cells, ends, controls);
    (scene.params.iterations, scene.params.tolerance) = (5, 1e-12);
    scene.force_weight = 0.01;
    scene
}

/// Saves after every step, and goes on from each of the bytes in another block, planned for other threads and other states.
fn goes_on<T: Real, S: Space>(scene: &Scene, elsewhere: FluidsParams) {
    let mut saved = Vec::new();
    let plan = FluidsPlan::new::<T, S>(&scene.problem(), &scene.params).unwrap();
    let (history, end) = scene.with::<T, S, _>(|fluids| {
        assert_eq!(fluids.saved_bytes(), plan.saved_bytes());
        let mut history = Vec::new();
        loop {
            saved.push(save(fluids));
            let progress = fluids.step(&Serial, &mut Silent);
            history.push(said(&progress));
            if progress.status.is_some() {
                break;
            }
        }
        let unknowns: Vec<u64> = fluids.unknowns().iter().map(|z| z.to_f64().to_bits()).collect();
        (history, unknowns)
    });
    assert!(saved.len() > 3, "{}", saved.len());
    let mut other = Scene::new(&scene.cells, "ww", &[]);
    (other.boundary, other.force_weight) = (scene.boundary.clone(), scene.force_weight);
    other.params = elsewhere;
    for (step, bytes) in saved.iter().enumerate() {
        with_empty::<T, S, _>(&other, 0x5A, |fluids| {
            fluids.restore(bytes).unwrap();
            assert!(
                save(fluids) == *bytes,
                "after {step} steps it is saved as something else"
            );
            let (rest, _, unknowns) = rest_of(fluids);
            assert_eq!(rest, history[step..], "iterations after {step} steps");
            assert!(unknowns == end, "going on after {step} steps gives other bits");
        });
    }
}

#[test]
fn a_search_goes_on_with_the_same_bits() {
    let with = |scene: &Scene, threads, slots| FluidsParams {
        threads,
        slots,
        ..scene.params
    };
    for controls in [&ALL[..1], &ALL[1..2], &ALL[2..], &ALL[..]] {
        let plane = scene(&[12, 9], "wp", controls);
        goes_on::<f32, D2>(&plane, with(&plane, 3, Slots::States(2)));
        let kept = scene(&[8, 10], "ww", controls).kept(Slots::States(3));
        goes_on::<f64, D2>(&kept, with(&kept, 2, Slots::Tape));
        let space = scene(&[6, 5, 7], "pww", controls);
        goes_on::<f64, D3>(&space, with(&space, 1, Slots::States(1)));
    }
    for adjoint in [Adjoint::Exact, Adjoint::SecondSolve] {
        let mut conjugate = scene(&[9, 8], "ww", &ALL);
        (conjugate.params.pressure, conjugate.params.adjoint) = (Pressure::Conjugate, adjoint);
        conjugate.params.cg_iterations = 15;
        goes_on::<f32, D2>(&conjugate, with(&conjugate, 2, Slots::States(2)));
    }
    // More iterations than pairs, and as many pairs as there may be: the head has room for them.
    let mut long = scene(&[10, 8], "ww", &ALL[..1]);
    (long.params.iterations, long.params.history) = (12, 8);
    goes_on::<f64, D2>(&long, with(&long, 1, Slots::Tape));
    (long.params.history, long.params.initial_velocity) = (2, true);
    goes_on::<f64, D2>(&long, with(&long, 1, Slots::Tape));
}

#[test]
fn other_threads_go_on_with_the_same_bits() {
    let mut scene = scene(&[24, 16], "wp", &ALL);
    let (whole, bytes) = scene.with::<f32, D2, _>(|fluids| {
        fluids.step(&Serial, &mut Silent);
        let bytes = save(fluids);
        (rest_of(fluids), bytes)
    });
    scene.params.threads = 3;
    let threaded = with_threads(3, |exec| {
        scene.with::<f32, D2, _>(|fluids| {
            fluids.step(exec, &mut Silent);
            save(fluids)
        })
    });
    assert!(threaded == bytes, "the state knows its threads");
    let there = with_threads(3, |exec| {
        with_empty::<f32, D2, _>(&scene, 0x33, |fluids| {
            fluids.restore(&threaded).unwrap();
            while fluids.step(exec, &mut Silent).status.is_none() {}
            let unknowns = fluids.unknowns().iter();
            unknowns.map(|z| z.to_f64().to_bits()).collect::<Vec<_>>()
        })
    });
    assert!(there == whole.2);
}

#[test]
fn every_changed_byte_is_found() {
    let scene = scene(&[5, 4], "wp", &ALL[..1]);
    let bytes = scene.with::<f32, D2, _>(|fluids| {
        fluids.step(&Serial, &mut Silent);
        save(fluids)
    });
    let expected = bytes.len();
    with_empty::<f32, D2, _>(&scene, 0, |fluids| {
        let before = save(fluids);
        for place in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[place] ^= 1 << (place % 8);
            let error = fluids.restore(&damaged).unwrap_err();
            let right = match place {
                0..8 => error == SavedError::NotSaved,
                8..16 => matches!(error, SavedError::Format { .. }),
                16..24 => matches!(error, SavedError::Length { .. }),
                24..32 => error == SavedError::OtherSolve,
                _ => error == SavedError::Damaged,
            };
            assert!(right, "byte {place}: {error}");
        }
        for given in [0, 7, HEAD - 1, HEAD, expected - 1] {
            let short = SavedError::Length { expected, given };
            assert_eq!(fluids.restore(&bytes[..given]), Err(short));
            assert_eq!(fluids.save(&mut vec![0; given]), Err(short));
        }
        assert!(save(fluids) == before, "refused bytes changed the search");
        assert_eq!(fluids.step(&Serial, &mut Silent).status, Some(Status::NotReady));
        fluids.restore(&bytes).unwrap();
    });
}

/// Scalars that no search would write are refused even where the checksum is right, and change nothing.
#[test]
fn scalars_out_of_range_are_refused() {
    let scene = scene(&[5, 4], "wp", &ALL[..1]);
    let bytes = scene.with::<f32, D2, _>(|fluids| {
        fluids.step(&Serial, &mut Silent);
        save(fluids)
    });
    let mut refused = 0;
    for word in 5..HEAD / 8 {
        for value in [9u64, 1 << 40, u64::MAX] {
            let mut forged = bytes.clone();
            forged[word * 8..word * 8 + 8].copy_from_slice(&value.to_le_bytes());
            fields::seal(&mut forged);
            with_empty::<f32, D2, _>(&scene, 0, |fluids| {
                let before = save(fluids);
                match fluids.restore(&forged) {
                    // A number or count like any other: it may end anywhere, but in order.
                    Ok(()) => drop(fluids.step(&Serial, &mut Silent)),
                    Err(error) => {
                        refused += 1;
                        assert_eq!(error, SavedError::Damaged);
                        assert!(save(fluids) == before, "word {word} changed the search");
                    }
                }
            });
        }
    }
    assert!(refused >= 6, "{refused} refusals");
}

#[test]
fn states_of_another_search_are_refused() {
    let scene = || scene(&[8, 8], "wp", &ALL);
    let bytes = scene().with::<f32, D2, _>(save);
    let refuses = |what: &str, change: &dyn Fn(&mut Scene)| {
        let mut other = scene();
        change(&mut other);
        let found = with_empty::<f32, D2, _>(&other, 0, |fluids| fluids.restore(&bytes));
        assert_eq!(found, Err(SavedError::OtherSolve), "{what}");
    };
    refuses("boundary", &|scene| scene.boundary = fields::boundaries("pw"));
    refuses("keyframes", &|scene| scene.keys = vec![2, 5]);
    refuses("force_weight", &|scene| scene.force_weight = 99.0);
    refuses("templates", &|scene| scene.templates[0].radius *= 1.1);
    refuses("controls", &|scene| {
        scene.params.controls = Scene::new(&[8, 8], "wp", &ALL[..2]).params.controls;
    });
    refuses("pressure", &|scene| scene.params.pressure = Pressure::Conjugate);
    refuses("sweeps", &|scene| scene.params.sweeps = 19);
    refuses("cg_iterations", &|scene| scene.params.cg_iterations = 19);
    refuses("cg_tolerance", &|scene| scene.params.cg_tolerance = 1e-3);
    refuses("diffusion", &|scene| scene.params.diffusion = 1e-3);
    refuses("initial_weight", &|scene| scene.params.initial_weight = 1.0);
    refuses("history", &|scene| scene.params.history = 4);
    refuses("tolerance", &|scene| scene.params.tolerance = 1e-3);
    refuses("initial_velocity", &|scene| scene.params.initial_velocity = false);
    let wide = with_empty::<f64, D2, _>(&scene(), 0, |fluids| fluids.restore(&bytes));
    assert_eq!(wide, Err(SavedError::OtherSolve));
    // What changes no bit is no other search.
    let mut more = scene().kept(Slots::States(2));
    (more.params.iterations, more.params.threads) = (99, 4);
    let found = with_empty::<f32, D2, _>(&more, 0, |fluids| fluids.restore(&bytes));
    assert_eq!(found, Ok(()));
}

/// Piece by piece the same bytes go out and come in, and every call that is refused is told.
#[test]
fn any_piece_may_be_refused() {
    let scene = scene(&[14, 9], "wp", &ALL);
    scene.with::<f64, D2, _>(|fluids| {
        fluids.step(&Serial, &mut Silent);
        let whole = save(fluids);
        let mut calls = 0;
        loop {
            let mut sink = pieces(&[], calls);
            match fluids.save_to(&mut sink) {
                Ok(()) => break assert!(sink.bytes == whole),
                Err(error) => assert_eq!(error, SavedError::Refused),
            }
            calls += 1;
        }
        assert!(calls > 10, "{calls}");
        let rest = rest_of(fluids);
        // Half of a state is none: there is no going on from it.
        assert!(fluids.restore_from(&mut pieces(&whole, calls - 1)).is_err());
        assert_eq!(fluids.step(&Serial, &mut Silent).status, Some(Status::NotReady));
        for left in (0..calls).step_by(7) {
            let refused =
                with_empty::<f64, D2, _>(&scene, 0, |fluids| fluids.restore_from(&mut pieces(&whole, left)));
            assert_eq!(refused, Err(SavedError::Refused), "after {left} pieces");
        }
        with_empty::<f64, D2, _>(&scene, 0, |fluids| {
            fluids.restore_from(&mut pieces(&whole, calls)).unwrap();
            assert!(rest_of(fluids) == rest);
        });
    });
}
