//! The metric, a sum of blurs: symmetric, and the same on any number of threads.

use crate::adjoints::GRIDS;
use crate::fields::naive::Naive;
use crate::fields::random::Random;
use crate::fields::{Memory, assert_close, cast, dot, gap, grid, with_threads};
use thurible_core::Real;
use thurible_core::grid::Grid;
use thurible_core::grid::levels::Levels;
use thurible_core::memory::{Arena, Ledger, Pool};
use thurible_core::operators::blur::{Blur, Metric};

fn blurred<T: Real>(grid: &Grid, metric: Metric, e: &[T], threads: usize) -> Vec<T> {
    let mut memory = Memory::new(1 << 22);
    let levels = Levels::<T>::carve(&mut Arena::new(memory.block()), grid, metric.filters).unwrap();
    let mut ledger = Ledger::new();
    Blur::<T>::carve(&levels, 0, metric, threads, &mut Pool::measuring(&mut ledger));
    let mut work = vec![T::from_f64(f64::NAN); ledger.bytes().unwrap() / T::BYTES];
    let mut out = e.to_vec();
    with_threads(threads, |exec| {
        Blur::carve(&levels, 0, metric, threads, &mut Pool::new(&mut work)).apply(exec, e, &mut out)
    });
    out
}

fn metric_agrees<T: Real>() {
    let mut random = Random::new(3);
    for (cells, ends) in GRIDS {
        let grid = grid(cells, ends);
        for filters in [0, 1, 2, 4] {
            let (e, f): (Vec<T>, Vec<T>) = (random.cells(&grid, 1), random.cells(&grid, 1));
            let whole = Metric {
                filters,
                identity: 1.0,
            };
            let (ce, cf) = (blurred(&grid, whole, &e, 3), blurred(&grid, whole, &f, 3));
            assert_close(
                "C is symmetric",
                dot(&ce, &f),
                dot(&e, &cf),
                dot(&e, &e),
                10.0 * T::EPSILON,
            );
            assert!(
                dot(&e, &ce) >= dot(&e, &e) * (1.0 - 1e-6),
                "C is at least the identity"
            );
            let expected = Naive::new(&grid).metric(filters, &cast(&e));
            assert!(
                gap(&cast(&ce), &expected) <= 20.0 * T::EPSILON,
                "{cells:?} {ends}, {filters} filters"
            );
            let lighter: Vec<f64> = cast(&blurred(
                &grid,
                Metric {
                    filters,
                    identity: 0.25,
                },
                &e,
                3,
            ));
            let missing: Vec<f64> = expected
                .iter()
                .zip(cast::<T, f64>(&e))
                .map(|(ce, e)| ce - 0.75 * e)
                .collect();
            assert!(
                gap(&lighter, &missing) <= 20.0 * T::EPSILON,
                "e weighs 1/4 on {cells:?} {ends}, {filters} filters"
            );
        }
    }
}

#[test]
fn metric_is_symmetric() {
    metric_agrees::<f64>();
    metric_agrees::<f32>();
}

#[test]
fn threads_do_not_change_the_metric() {
    for (cells, ends) in GRIDS {
        let grid = grid(cells, ends);
        let (e, metric): (Vec<f64>, _) = (
            Random::new(5).cells(&grid, 1),
            Metric {
                filters: 2,
                identity: 1.0,
            },
        );
        assert_eq!(
            blurred(&grid, metric, &e, 1),
            blurred(&grid, metric, &e, 3),
            "{cells:?} {ends}"
        );
    }
}
