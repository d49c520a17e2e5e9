//! STFAS: what a solve says of itself, and that it does not depend on how memory is used.

use crate::fields::random::Random;
use crate::fields::spacetime::{Case, setup};
use crate::fields::{Components, add_scaled_all, grid, largest_of, with_threads};
use crate::stfas::Scene;
use core::ops::ControlFlow;
use thurible_core::nso::colours::Colours;
use thurible_core::nso::{Ended, Setup, SmootherMemory, Split};
use thurible_core::{D2, D3, Event, NsoParams, Observer, Real, Serial, Silent, Space};

/// Bits of a state.
fn bits<T: Real>(case: &Case<T>) -> Vec<u64> {
    let vectors = case.v.iter().chain(&case.w).flatten();
    vectors
        .chain(&case.p)
        .chain(&case.pbar)
        .map(|x| x.to_f64().to_bits())
        .collect()
}

fn shapes_agree<T: Real, S: Space>(list: &[(&[usize], &str)]) {
    let mut random = Random::new(71);
    for ((cells, ends), colours) in list
        .iter()
        .flat_map(|&g| [(g, Colours::RedBlack), (g, Colours::PowerOfTwo)])
    {
        let grid = grid(cells, ends);
        let case = Case::<T>::random(&mut random, &grid, 4, 0.5 * grid.h[0]);
        let mut first = None;
        let planes = |planes| (Split::Planes(planes), 1);
        let slabs = |threads| (Split::Slabs, threads);
        let lanes = [32, 16, 8, 4, 1]
            .into_iter()
            .flat_map(|lanes| [(lanes, planes(3)), (lanes, slabs(2))]);
        let splits = [planes(1), planes(2), planes(8), planes(1000), slabs(1), slabs(3)];
        for (lanes, (split, threads)) in lanes.chain(splits.map(|split| (8, split))) {
            let mut case = case.clone();
            let (memory, params) = (
                SmootherMemory { lanes, split },
                NsoParams {
                    tolerance: 0.0,
                    colours,
                    ..NsoParams::default()
                },
            );
            let setup = Setup {
                memory,
                params,
                threads,
                ..setup(0.5, 4)
            };
            with_threads(threads, |exec| case.residuals::<S>(exec, &setup, 1));
            let bits = bits(&case);
            assert!(
                bits == *first.get_or_insert(bits.clone()),
                "{cells:?} {ends} {colours:?}: {memory:?} on {threads} threads changes the result"
            );
        }
    }
}

#[test]
fn use_of_the_memory_does_not_change_a_bit() {
    shapes_agree::<f32, D2>(&[
        (&[40, 29], "ww"),
        (&[7, 11], "pp"),
        (&[6, 12], "wp"),
        (&[70, 5], "pw"),
    ]);
    shapes_agree::<f64, D2>(&[(&[19, 8], "wp"), (&[6, 5], "pp"), (&[34, 5], "ww")]);
    shapes_agree::<f32, D3>(&[(&[34, 4, 13], "wpw"), (&[5, 4, 9], "pwp")]);
    shapes_agree::<f64, D3>(&[(&[5, 4, 6], "ppp")]);
}

#[test]
fn a_solution_stays_where_it_is() {
    let scene = Scene::new(&[24, 24], "wp", 9);
    let mut case = scene.case::<f64>();
    let list = case.residuals::<D2>(&Serial, &scene.setup(), 25);
    let solved = case.clone();
    let after = case.residuals::<D2>(&Serial, &scene.setup(), 1);
    assert!(
        list[25] < 1e-13 * list[0] && after[1] < 1e-13 * list[0],
        "{:e} of {:e}",
        after[1],
        list[0]
    );
    let moved = |x: &Components<f64>, y: &Components<f64>| largest_of(&add_scaled_all(x, -1.0, y));
    assert!(moved(&case.v, &solved.v) < 1e-13 && moved(&case.w, &solved.w) < 1e-13);
    // The coarse grids must not pull a solution away even where they see other equations.
    let norm = solved.equations(1.0, 0.0).residual().norm(solved.grid.h[0]);
    assert!(norm < 1e-13 * list[0], "the second implementation sees {norm:e}");
    let means = case
        .equations(1.0, 0.0)
        .p
        .iter()
        .chain(&case.equations(1.0, 0.0).pbar)
        .map(|p| p.iter().sum::<f64>().abs())
        .fold(0.0, f64::max);
    assert!(means < 1e-10, "pressures have means up to {means:e}");
}

fn solved<T: Real>(case: &mut Case<T>, params: NsoParams) -> (Ended, Vec<f64>) {
    let setup = Setup {
        params,
        ..setup(1.0, case.slots)
    };
    case.run::<D2, _>(&setup, |nso| {
        let info = nso.solve(&Serial, &mut Silent);
        (info.ended, info.residuals.to_vec())
    })
}

#[test]
fn a_solve_stops_at_its_tolerance_or_cap() {
    let scene = Scene::new(&[20, 20], "ww", 9);
    for tolerance in [1e-3, 1e-5] {
        let params = NsoParams {
            tolerance,
            ..NsoParams::default()
        };
        for (ended, list) in [
            solved(&mut scene.case::<f32>(), params),
            solved(&mut scene.case::<f64>(), params),
        ] {
            assert_eq!(ended, Ended::Converged);
            let (last, before) = list.split_last().unwrap();
            assert!(
                *last < tolerance && before.iter().all(|r| *r >= tolerance),
                "{tolerance:e}: {list:?}"
            );
        }
    }
    let capped = NsoParams {
        tolerance: 1e-12,
        cycles: 3,
        ..NsoParams::default()
    };
    let (ended, list) = solved(&mut scene.case::<f64>(), capped);
    assert_eq!((ended, list.len()), (Ended::Cycles, 4));
}

#[test]
fn nan_is_never_convergence() {
    let scene = Scene::new(&[12, 10], "wp", 5);
    for poison in [f64::NAN, f64::INFINITY] {
        for place in 0..5 {
            let mut case = scene.case::<f32>();
            let poison = poison as f32;
            match place {
                0 => case.target[0][77] = poison,
                1 => case.target[1][599] = poison,
                2 => case.v0[1][50] = poison,
                3 => (case.v[0][77], case.target[0][77]) = (poison, poison),
                _ => (case.w[1][300], case.target[0][5]) = (poison, poison),
            }
            let (ended, list) = solved(
                &mut case,
                NsoParams {
                    tolerance: 1e30,
                    ..NsoParams::default()
                },
            );
            assert_eq!(ended, Ended::NotFinite, "{poison} at place {place}: {list:?}");
        }
    }
}

struct Stop(usize);

impl Observer for Stop {
    fn on(&mut self, _event: Event) -> ControlFlow<()> {
        self.0 -= 1;
        if self.0 == 0 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

#[test]
fn a_stop_within_a_cycle_leaves_a_better_state() {
    let scene = Scene::new(&[20, 20], "ww", 9);
    for after in [1, 3, 7, 12, 17] {
        let mut case = scene.case::<f64>();
        let before = case.equations(1.0, 0.0).residual().norm(case.grid.h[0]);
        let ended = case.run::<D2, _>(&scene.setup(), |nso| nso.solve(&Serial, &mut Stop(after)).ended);
        let left = case.equations(1.0, 0.0).residual().norm(case.grid.h[0]);
        assert_eq!(ended, Ended::Cancelled);
        assert!(
            left < 2.0 * before,
            "stopped at {after}: {before:e} became {left:e}"
        );
    }
}
