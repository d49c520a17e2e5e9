//! Limited transport: nothing leaves the range of the densities, and edges stay sharper than by first order.

use crate::fields::carry::Carry;
use crate::fields::random::Random;
use crate::fields::{Components, flow, grid, places};
use crate::transport::GRIDS;
use thurible_core::{Real, Scheme};

fn stays_in_range<T: Real>() {
    let mut random = Random::new(51);
    for (cells, ends) in GRIDS {
        let grid = grid(cells, ends);
        let carry = Carry::new(&grid, Scheme::Limited, 1e-5);
        for courant in [0.3, 0.5, 0.97, 5.0] {
            let v: Components<T> = flow::rough(&mut random, &grid, 1, courant);
            // Cells that are full or empty, whose edges a scheme without limits overshoots.
            let mut rho: Vec<T> = random.density::<T>(&grid);
            for x in &mut rho {
                *x = if *x > T::HALF { T::ONE } else { T::ZERO };
            }
            for _ in 0..5 {
                rho = carry.forward(&v, &rho).unwrap();
                let values = || rho.iter().map(|x| x.to_f64());
                let (least, most) = (values().fold(1.0, f64::min), values().fold(0.0, f64::max));
                assert!(
                    least >= -4.0 * T::EPSILON && most <= 1.0 + 20.0 * T::EPSILON,
                    "{cells:?} {ends} at {courant}: {least:e} .. 1 + {:e}",
                    most - 1.0
                );
            }
        }
    }
}

#[test]
fn no_value_leaves_the_range() {
    stays_in_range::<f64>();
    stays_in_range::<f32>();
}

#[test]
fn a_disc_is_carried_around_with_its_edge() {
    let n = 32;
    let grid = grid(&[n, n], "pp");
    let disc: Vec<f64> = places(&grid)
        .map(|[x, y, _]| f64::from((x as f64 - 15.5).hypot(y as f64 - 15.5) < 8.0))
        .collect();
    let v = flow::uniform(&grid, [grid.h[0], 0.5 * grid.h[1], 0.0]);
    let carried = |scheme| {
        let carry = Carry::new(&grid, scheme, 1e-6);
        let mut rho = disc.clone();
        for _ in 0..2 * n {
            rho = carry.forward(&v, &rho).unwrap();
        }
        let off: f64 = rho
            .iter()
            .zip(&disc)
            .map(|(x, y): (&f64, &f64)| (x - y).abs())
            .sum();
        (
            off / disc.iter().sum::<f64>(),
            rho.iter().copied().fold(f64::INFINITY, f64::min),
        )
    };
    let [(limited, least), (quick, under), (traced, _)] =
        [Scheme::Limited, Scheme::Quick, Scheme::SemiLagrangian].map(carried);
    assert!(
        limited < quick && limited < traced / 2.0,
        "{limited}, {quick}, {traced}"
    );
    assert!(least > -1e-12 && under < -0.01, "{least:e}, {under:e}");
}
