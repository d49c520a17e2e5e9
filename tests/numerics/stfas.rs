//! STFAS: how fast V-cycles converge, that they converge to a fixed point, and what a solve says of itself.

use crate::fields::random::Random;
use crate::fields::spacetime::{Case, setup};
use crate::fields::{Components, add_scaled_all, flow, grid, largest_of, with_threads};
use core::ops::ControlFlow;
use thurible_core::nso::colours::Colours;
use thurible_core::nso::{Ended, Setup, Shape, Split};
use thurible_core::{D2, D3, Event, NsoParams, Observer, Real, Serial, Silent, Space};

/// A synthetic problem, whose target is a swirling flow.
#[derive(Clone, Copy)]
struct Scene<'a> {
    cells: &'a [usize],
    ends: &'a str,
    slots: usize,
    courant: f64,
    kappa: f64,
    colours: Colours,
    /// Kinematic viscosity over squared cell size, nu / h^2.
    viscosity: f64,
}

impl<'a> Scene<'a> {
    /// Courant number 1, kappa 1, red-black, no viscosity.
    fn new(cells: &'a [usize], ends: &'a str, slots: usize) -> Self {
        Scene {
            cells,
            ends,
            slots,
            courant: 1.0,
            kappa: 1.0,
            colours: Colours::RedBlack,
            viscosity: 0.0,
        }
    }

    fn case<T: Real>(&self) -> Case<T> {
        let grid = grid(self.cells, self.ends);
        Case::towards(&grid, self.slots, flow::swirl(&grid, self.slots, self.courant))
    }

    fn setup(&self) -> Setup {
        let h = grid(self.cells, self.ends).h[0];
        let params = NsoParams {
            tolerance: 0.0,
            colours: self.colours,
            ..NsoParams::default()
        };
        Setup {
            params,
            viscosity: self.viscosity * h * h,
            ..setup(self.kappa, self.slots)
        }
    }

    /// What a V-cycle leaves of the residual: the mean of the last three of six.
    fn factor<S: Space>(&self) -> f64 {
        let list = self.case::<f64>().residuals::<S>(&Serial, &self.setup(), 6);
        let factor = (list[6] / list[3]).cbrt();
        let Scene {
            cells,
            ends,
            slots,
            courant,
            kappa,
            colours,
            viscosity,
        } = self;
        println!(
            "STFAS on {cells:?} {ends} x {slots}, Courant {courant}, kappa {kappa}, viscosity {viscosity}, {colours:?}: {factor:.3} a cycle"
        );
        factor
    }

    #[track_caller]
    fn converges_by<S: Space>(&self, most: f64) {
        let factor = self.factor::<S>();
        assert!(factor <= most, "a V-cycle leaves {factor:.3}, more than {most}");
    }
}

#[test]
fn two_dimensions() {
    for (cells, slots) in [([32, 32], 19), ([32, 32], 39), ([64, 64], 19)] {
        Scene::new(&cells, "ww", slots).converges_by::<D2>(0.15);
    }
    for ends in ["wp", "pp"] {
        Scene::new(&[24, 40], ends, 15).converges_by::<D2>(0.15);
    }
}

#[test]
fn sizes_that_do_not_halve() {
    for cells in [[96, 60], [50, 50], [33, 47], [64, 8], [4, 128]] {
        Scene::new(&cells, "ww", 11).converges_by::<D2>(0.15);
    }
    for (cells, ends) in [
        ([33, 47], "wp"),
        ([33, 47], "pp"),
        ([5, 5], "pp"),
        ([47, 10], "pw"),
    ] {
        Scene::new(&cells, ends, 11).converges_by::<D2>(0.15);
    }
}

#[test]
fn viscous_flows() {
    for viscosity in [0.01, 1.0, 100.0] {
        Scene {
            viscosity,
            ..Scene::new(&[32, 32], "ww", 15)
        }
        .converges_by::<D2>(0.25);
        Scene {
            viscosity,
            ..Scene::new(&[24, 40], "wp", 15)
        }
        .converges_by::<D2>(0.25);
        Scene {
            viscosity,
            ..Scene::new(&[16, 16, 16], "www", 9)
        }
        .converges_by::<D3>(0.35);
        Scene {
            viscosity,
            colours: Colours::PowerOfTwo,
            ..Scene::new(&[32, 32], "ww", 15)
        }
        .converges_by::<D2>(0.25);
    }
}

#[test]
fn three_dimensions() {
    Scene::new(&[16, 16, 16], "www", 15).converges_by::<D3>(0.15);
    Scene::new(&[24, 16, 8], "wpw", 9).converges_by::<D3>(0.15);
    Scene::new(&[17, 12, 15], "www", 9).converges_by::<D3>(0.15);
    Scene::new(&[4, 4, 32], "wpw", 5).converges_by::<D3>(0.15);
    Scene::new(&[9, 7, 10], "ppp", 9).converges_by::<D3>(0.15);
}

#[test]
fn fast_flows() {
    let fast = Scene {
        courant: 2.2,
        ..Scene::new(&[64, 64], "ww", 19)
    };
    fast.converges_by::<D2>(0.45);
    Scene {
        cells: &[32, 32],
        ..fast
    }
    .converges_by::<D2>(0.45);
    Scene {
        courant: 3.0,
        ..Scene::new(&[16, 16, 16], "www", 11)
    }
    .converges_by::<D3>(0.45);
}

#[test]
fn the_papers_colours() {
    for courant in [1.0, 2.2] {
        Scene {
            courant,
            colours: Colours::PowerOfTwo,
            ..Scene::new(&[32, 32], "ww", 19)
        }
        .converges_by::<D2>(0.45);
    }
    Scene {
        colours: Colours::PowerOfTwo,
        ..Scene::new(&[12, 12, 12], "wwp", 9)
    }
    .converges_by::<D3>(0.3);
    Scene {
        colours: Colours::PowerOfTwo,
        ..Scene::new(&[15, 9], "pp", 9)
    }
    .converges_by::<D2>(0.4);
}

/// At rest the factor depends neither on the number of steps nor on the weights.
#[test]
fn at_rest_the_factor_is_the_same_for_all_weights_and_steps() {
    for (cells, slots) in [([32, 32], 3), ([32, 32], 19), ([32, 32], 79), ([64, 64], 19)] {
        for kappa in [1e-3, 1.0, 100.0] {
            Scene {
                kappa,
                courant: 1e-4,
                ..Scene::new(&cells, "ww", slots)
            }
            .converges_by::<D2>(0.1);
        }
    }
}

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
            let (shape, params) = (
                Shape { lanes, split },
                NsoParams {
                    tolerance: 0.0,
                    colours,
                    ..NsoParams::default()
                },
            );
            let setup = Setup {
                shape,
                params,
                threads,
                ..setup(0.5, 4)
            };
            with_threads(threads, |exec| case.residuals::<S>(exec, &setup, 1));
            let bits = bits(&case);
            assert!(
                bits == *first.get_or_insert(bits.clone()),
                "{cells:?} {ends} {colours:?}: {shape:?} on {threads} threads changes the result"
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
