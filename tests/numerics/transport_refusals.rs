//! Transport of what is not finite or too fast.

use crate::fields::carry::Carry;
use crate::fields::random::Random;
use crate::fields::{Components, flow, grid, zeros};
use crate::transport::{CONSERVING, GRIDS};
use thurible_core::transport::TooFast;
use thurible_core::{Real, Scheme};

#[test]
fn more_than_64_sub_steps_are_refused() {
    let grid = grid(&[8, 6], "pp");
    let rho: Vec<f64> = Random::new(38).density(&grid);
    for scheme in [Scheme::Quick, Scheme::Central, Scheme::SemiLagrangian] {
        let at = |courant: f64| {
            Carry::new(&grid, scheme, 1e-5)
                .forward(&flow::uniform(&grid, [courant * grid.h[0], 0.0, 0.0]), &rho)
        };
        assert!(at(63.99).is_ok());
        assert_eq!(at(64.01), Err(TooFast));
        assert_eq!(at(1e30), Err(TooFast));
    }
}

fn broken<T: Real>() {
    for (cells, ends) in GRIDS {
        let grid = grid(cells, ends);
        let rho: Vec<T> = Random::new(39).density(&grid);
        for poison in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for axis in 0..grid.dims {
                for at in [grid.cells() - 1, grid.cells() / 2 + 1] {
                    let mut v = zeros::<T>(&grid, 1);
                    v[axis][at] = T::from_f64(poison);
                    let result = Carry::new(&grid, Scheme::Quick, 1e-5).forward(&v, &rho);
                    assert_eq!(
                        result,
                        Err(TooFast),
                        "{poison} at face {at} of axis {axis} on {cells:?} {ends}"
                    );
                }
            }
        }
    }
}

#[test]
fn velocities_that_are_not_finite_are_refused() {
    broken::<f64>();
    broken::<f32>();
}

/// One number that is not finite, in smoke and alone in an empty box, forward and back.
fn poisoned<T: Real>(scheme: Scheme) {
    let mut random = Random::new(41);
    let lost = |numbers: &[T]| numbers.iter().all(|x| x.is_finite());
    for (cells, ends) in GRIDS {
        let grid = grid(cells, ends);
        let (smoke, empty) = (random.density::<T>(&grid), vec![T::ZERO; grid.cells()]);
        let carry = Carry::new(&grid, scheme, 1e-5);
        for (poison, courant) in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY]
            .into_iter()
            .flat_map(|poison| [0.4, 4.6].map(|courant| (poison, courant)))
        {
            let v: Components<T> = flow::rough(&mut random, &grid, 1, courant);
            let with_poison = |field: &[T], at: usize| -> Vec<T> {
                let mut field = field.to_vec();
                field[at] = T::from_f64(poison);
                field
            };
            for at in [0, grid.cells() / 2 + 1, grid.cells() - 1] {
                let what = format!("{poison} at cell {at} of {cells:?} {ends}, {scheme:?} at {courant}");
                for rho in [&smoke, &empty] {
                    let rho = with_poison(rho, at);
                    assert!(
                        !lost(&carry.forward(&v, &rho).unwrap()),
                        "{what}: lost on the way"
                    );
                    let (_, gradient) = carry.backward(&v, &rho, &smoke).unwrap();
                    assert!(
                        !gradient.iter().all(|component| lost(component)),
                        "{what}: lost in the gradient"
                    );
                }
                let (mu, _) = carry.backward(&v, &smoke, &with_poison(&smoke, at)).unwrap();
                assert!(!lost(&mu), "{what}: lost on the way back");
            }
        }
    }
}

#[test]
fn densities_that_are_not_finite_stay_so() {
    for scheme in CONSERVING {
        poisoned::<f64>(scheme);
        poisoned::<f32>(scheme);
    }
}
