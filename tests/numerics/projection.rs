//! The projection Q onto flows without divergence.

use crate::fields;
use crate::fields::naive::Naive;
use crate::fields::random::Random;
use crate::fields::{
    Components, Memory, add_scaled_all, assert_close, dot_all, flow, gap, grid, largest, largest_of, slot,
    slot_of_all, view_mut, with_threads,
};
use core::ops::ControlFlow;
use thurible_core::grid::Grid;
use thurible_core::grid::levels::Levels;
use thurible_core::memory::{Arena, Ledger, Pool};
use thurible_core::poisson::Projection;
use thurible_core::{Event, Observer, Real};

pub const GRIDS: [(&[usize], &str); 14] = [
    (&[300, 5], "ww"),
    (&[5, 514], "wp"),
    (&[4, 3, 257], "wpp"),
    (&[128, 4], "ww"),
    (&[4, 4, 60], "wpw"),
    (&[16, 16], "ww"),
    (&[33, 47], "ww"),
    (&[9, 14], "wp"),
    (&[5, 4], "pp"),
    (&[64, 8], "ww"),
    (&[30, 9], "pw"),
    (&[6, 5, 7], "www"),
    (&[9, 8, 5], "pwp"),
    (&[7, 7, 5], "ppp"),
];

/// Boxes with long axes.
const LONG: [(&[usize], &str); 6] = [
    (&[4096, 16], "ww"),
    (&[4096, 16], "pw"),
    (&[16, 4096], "ww"),
    (&[512, 16, 16], "www"),
    (&[8, 400, 5], "wpw"),
    (&[300, 270], "ww"),
];

/// Counts pieces of work and stops after `most`.
pub struct Cycles {
    count: usize,
    most: usize,
}

impl Observer for Cycles {
    fn on(&mut self, event: Event) -> ControlFlow<()> {
        self.count += usize::from(event == Event::Work);
        if self.count >= self.most {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// How a projection went: what it says is left, and its pieces of work.
pub struct Done {
    pub divergence: Option<f64>,
    pub cycles: usize,
}

/// Projects `v` (and changes `p` along).
pub fn project<T: Real>(
    grid: &Grid,
    slots: usize,
    v: &mut Components<T>,
    p: Option<&mut [T]>,
    tolerance: f64,
    most: usize,
) -> Done {
    let mut sums = vec![0.0; 2 * grid.rows()];
    let mut memory = Memory::new(1 << 21);
    let levels = Levels::<T>::carve(&mut Arena::new(memory.block()), grid, 0).unwrap();
    let mut ledger = Ledger::new();
    Projection::<T>::carve(&levels, 0, slots, 2, &mut Pool::measuring(&mut ledger));
    let mut numbers = vec![T::from_f64(1e30); ledger.elements(T::BYTES)];
    let (flow, cycles) = with_threads(2, |exec| {
        let mut projection = Projection::carve(&levels, 0, slots, 2, &mut Pool::new(&mut numbers));
        let mut observed = Cycles { count: 0, most };
        let flow = projection.project(exec, &mut observed, &mut view_mut(v), p, tolerance, &mut sums);
        (flow, observed.count)
    });
    Done {
        divergence: flow.continue_value(),
        cycles,
    }
}

/// max |div v| over all slots.
pub fn divergence<T: Real>(grid: &Grid, slots: usize, v: &Components<T>) -> f64 {
    largest((0..slots).flat_map(|k| Naive::new(grid).divergence(&slot_of_all(grid, slots, k, v))))
}

fn reaches<T: Real>(tolerance: f64, grids: &[(&[usize], &str)], counts: &[usize]) {
    let mut random = Random::new(51);
    for &(cells, ends) in grids {
        let grid = grid(cells, ends);
        for &slots in counts {
            let what = format!("{} on {cells:?} {ends}, {slots} slots", T::NAME);
            let mut v: Components<T> = random.faces(&grid, slots);
            let (before, speed) = (divergence(&grid, slots, &v), largest_of(&v));
            let done = project(&grid, slots, &mut v, None, tolerance, usize::MAX);
            let (after, floor) = (divergence(&grid, slots, &v), 4.0 * T::EPSILON * speed / grid.h[0]);
            assert!(
                after <= 1.1 * (tolerance * before).max(floor),
                "{what}: {before:e} to {after:e}"
            );
            assert_close(&what, done.divergence.unwrap(), after, after.max(floor), 1.0);
            // What is measured while rows are written is what is measured of all of them afterwards.
            let measured = project(&grid, slots, &mut v, None, f64::MAX, usize::MAX);
            assert_eq!(done.divergence, measured.divergence, "{what}");
            for (axis, component) in v.iter().enumerate().take(grid.dims) {
                let naive = Naive::new(&grid);
                let walls = (0..slots)
                    .flat_map(|k| fields::places(&grid).map(move |at| (k, at)))
                    .filter(|&(_, at)| naive.wall(at, axis));
                assert!(
                    walls
                        .into_iter()
                        .all(|(k, at)| component[fields::index(&grid, slots, k, at)] == T::ZERO),
                    "{what}: flow through a wall"
                );
            }
        }
    }
}

#[test]
fn reaches_its_tolerance() {
    for tolerance in [1e-5, 1e-12] {
        reaches::<f64>(tolerance, &GRIDS, &[1, 5, 17, 35]);
        reaches::<f32>(tolerance, &GRIDS, &[1, 5, 17, 35]);
        reaches::<f64>(tolerance, &LONG, &[3]);
        reaches::<f32>(tolerance, &LONG, &[3]);
    }
}

#[test]
fn orthogonal_idempotent_and_symmetric() {
    let mut random = Random::new(52);
    for (cells, ends) in GRIDS {
        let (grid, slots) = (grid(cells, ends), 3);
        let what = format!("{cells:?} {ends}");
        let [v, u]: [Components<f64>; 2] = core::array::from_fn(|_| random.faces(&grid, slots));
        let [qv, qu] = [&v, &u].map(|v| {
            let mut q = v.clone();
            project(&grid, slots, &mut q, None, 1e-13, usize::MAX);
            q
        });
        let (norm, rest) = (dot_all(&v, &v), add_scaled_all(&v, -1.0, &qv));
        assert!(
            dot_all(&rest, &rest) > 0.05 * norm && dot_all(&qv, &qv) > 0.05 * norm,
            "{what}: nothing was projected"
        );
        assert_close(
            &format!("orthogonal, {what}"),
            dot_all(&qv, &rest),
            0.0,
            norm,
            1e-11,
        );
        assert_close(
            &format!("symmetric, {what}"),
            dot_all(&qv, &u),
            dot_all(&v, &qu),
            norm,
            1e-11,
        );
        let mut again = qv.clone();
        project(&grid, slots, &mut again, None, 1e-13, usize::MAX);
        assert!(
            largest_of(&add_scaled_all(&again, -1.0, &qv)) < 1e-11,
            "idempotent, {what}"
        );
    }
}

#[test]
fn keeps_flows_without_divergence_and_takes_gradients_away() {
    let mut random = Random::new(53);
    for (cells, ends) in GRIDS.into_iter().chain(LONG) {
        let grid = grid(cells, ends);
        let smooth: Components<f64> = flow::rough(&mut random, &grid, 1, 1.0);
        let mut v = smooth.clone();
        project(&grid, 1, &mut v, None, 1e-10, usize::MAX);
        assert!(
            largest_of(&add_scaled_all(&v, -1.0, &smooth)) <= 1e-12 * largest_of(&smooth),
            "{cells:?} {ends}"
        );
        let potential: Vec<f64> = random.cells(&grid, 1);
        let gradient = Naive::new(&grid).gradient(&potential);
        let mut v = gradient.clone();
        project(&grid, 1, &mut v, None, 1e-12, usize::MAX);
        assert!(
            largest_of(&v) < 1e-9 * largest_of(&gradient),
            "{cells:?} {ends}: {:e}",
            largest_of(&v)
        );
    }
}

fn keeps_means<T: Real>() {
    let mut random = Random::new(54);
    for (cells, ends) in GRIDS {
        let (grid, slots) = (grid(cells, ends), 2);
        let mut v: Components<T> = random.faces(&grid, slots);
        let before = v.clone();
        project(&grid, slots, &mut v, None, 1e-6, usize::MAX);
        for (axis, k) in (0..grid.dims)
            .filter(|&a| grid.axis(a).is_ring())
            .flat_map(|a| (0..slots).map(move |k| (a, k)))
        {
            let mean =
                |v: &Components<T>| slot(&grid, slots, k, &v[axis]).iter().sum::<f64>() / grid.cells() as f64;
            assert_close(
                &format!("mean flow on {cells:?} {ends}"),
                mean(&v),
                mean(&before),
                1.0,
                20.0 * T::EPSILON,
            );
        }
    }
}

#[test]
fn keeps_the_mean_flow_along_periodic_axes() {
    keeps_means::<f64>();
    keeps_means::<f32>();
}

#[test]
fn the_potential_goes_along() {
    let mut random = Random::new(55);
    for (cells, ends) in GRIDS {
        let (grid, slots) = (grid(cells, ends), 19);
        let (mut v, mut p): (Components<f64>, Vec<f64>) =
            (random.faces(&grid, slots), random.cells(&grid, slots));
        let before = without_pressure(&grid, slots, &v, &p);
        project(&grid, slots, &mut v, Some(&mut p), 1e-9, usize::MAX);
        for (x, y) in before.iter().zip(without_pressure(&grid, slots, &v, &p)) {
            assert!(
                gap(x, &y) < 1e-11 / grid.h[0],
                "v - grad p changes on {cells:?} {ends}"
            );
        }
    }
}

/// v - grad p, slot after slot.
fn without_pressure(grid: &Grid, slots: usize, v: &Components<f64>, p: &[f64]) -> Vec<Vec<f64>> {
    let of = |k| {
        let gradient = Naive::new(grid).gradient(&slot(grid, slots, k, p));
        add_scaled_all(&slot_of_all(grid, slots, k, v), -1.0, &gradient).concat()
    };
    (0..slots).map(of).collect()
}
