//! Every operator against its adjoint, <A x, y> = <x, A* y>, and the identities of self-advection.

use crate::fields::carry::Carry;
use crate::fields::naive::Naive;
use crate::fields::random::Random;
use crate::fields::{
    Components, add_scaled_all, assert_close, cast, dot, dot_all, flow, gap, grid, slot, slot_of_all, view,
    view_mut, with_threads, zeros,
};
use thurible_core::field::Block;
use thurible_core::grid::Grid;
use thurible_core::operators::self_advection::Fluid;
use thurible_core::operators::{divergence, self_advection};
use thurible_core::{D2, D3, Named, Real, Scheme, Space};

pub const GRIDS: [(&[usize], &str); 8] = [
    (&[12, 12], "ww"),
    (&[13, 7], "ww"),
    (&[9, 14], "wp"),
    (&[5, 4], "pp"),
    (&[600, 5], "pw"),
    (&[6, 5, 7], "www"),
    (&[5, 6, 4], "pwp"),
    (&[7, 7, 5], "ppp"),
];

pub const SLOTS: usize = 3;

fn div<T: Real>(grid: &Grid, v: &Components<T>) -> Vec<T> {
    let mut out = vec![T::ZERO; grid.cells() * SLOTS];
    for (row, out) in out.chunks_exact_mut(grid.n[0] * SLOTS).enumerate() {
        for block in Block::all(grid, SLOTS) {
            divergence::add_divergence(
                &block,
                row,
                T::ONE,
                view(v),
                &mut out[block.span_in_row()],
                &mut vec![T::ZERO; block.len()],
            );
        }
    }
    out
}

fn grad<T: Real>(grid: &Grid, p: &[T]) -> Components<T> {
    let mut out = zeros(grid, SLOTS);
    for (axis, out) in out.iter_mut().enumerate().take(grid.dims) {
        for (row, out) in out.chunks_exact_mut(grid.n[0] * SLOTS).enumerate() {
            for block in Block::all(grid, SLOTS) {
                divergence::add_gradient(
                    &block,
                    row,
                    axis,
                    T::ONE,
                    p,
                    &mut out[block.span_in_row()],
                    &mut vec![T::ZERO; block.len()],
                );
            }
        }
    }
    out
}

/// Adv[v], J(v) d or J(v)^T d, with viscosity, by the core on two threads.
fn advected<T: Real>(
    grid: &Grid,
    viscosity: f64,
    v: &Components<T>,
    d: Option<&Components<T>>,
    transposed: bool,
) -> Components<T> {
    fn of<T: Real, S: Space>(
        fluid: Fluid<'_>,
        v: &Components<T>,
        d: Option<&Components<T>>,
        transposed: bool,
    ) -> Components<T> {
        let mut out = zeros(fluid.grid, SLOTS);
        let mut scratch = vec![T::ZERO; 2 * self_advection::scratch_per_thread(fluid.grid, SLOTS)];
        with_threads(2, |exec| match (d, transposed) {
            (None, _) => {
                self_advection::apply::<T, S>(exec, fluid, view(v), view_mut(&mut out), &mut scratch)
            }
            (Some(d), false) => self_advection::apply_derivative::<T, S>(
                exec,
                fluid,
                view(v),
                view(d),
                view_mut(&mut out),
                &mut scratch,
            ),
            (Some(d), true) => self_advection::apply_adjoint::<T, S>(
                exec,
                fluid,
                view(v),
                view(d),
                view_mut(&mut out),
                &mut scratch,
            ),
        });
        out
    }
    let fluid = Fluid {
        grid,
        slots: SLOTS,
        viscosity,
        solids: thurible_core::grid::solids::Solids::default(),
    };
    if grid.dims == 2 {
        of::<T, D2>(fluid, v, d, transposed)
    } else {
        of::<T, D3>(fluid, v, d, transposed)
    }
}

/// The norm of a vector field.
fn norm<T: Real>(v: &Components<T>) -> f64 {
    dot_all(v, v).sqrt()
}

fn gradient_is_minus_the_transpose<T: Real>() {
    let mut random = Random::new(1);
    for (cells, ends) in GRIDS {
        let grid = grid(cells, ends);
        let (v, p): (Components<T>, Vec<T>) = (random.faces(&grid, SLOTS), random.cells(&grid, SLOTS));
        let (dv, gp) = (div(&grid, &v), grad(&grid, &p));
        assert_close(
            &format!("{cells:?} {ends}"),
            dot(&dv, &p),
            -dot_all(&v, &gp),
            norm(&v) * norm(&gp),
            4.0 * T::EPSILON,
        );
        let naive = Naive::new(&grid);
        for k in 0..SLOTS {
            let (v, p) = (slot_of_all(&grid, SLOTS, k, &v), slot(&grid, SLOTS, k, &p));
            let unit = 20.0 * T::EPSILON / grid.h[0];
            assert!(
                gap(&slot(&grid, SLOTS, k, &dv), &naive.divergence(&v)) <= unit,
                "divergence on {cells:?} {ends}"
            );
            let expected = naive.gradient(&p);
            slot_of_all(&grid, SLOTS, k, &gp)
                .iter()
                .zip(&expected)
                .for_each(|(g, e)| assert!(gap(g, e) <= unit, "gradient on {cells:?} {ends}"));
        }
    }
}

#[test]
fn gradient_and_divergence() {
    gradient_is_minus_the_transpose::<f64>();
    gradient_is_minus_the_transpose::<f32>();
}

fn self_advection_agrees<T: Real>() {
    let mut random = Random::new(2);
    for ((cells, ends), share) in GRIDS.into_iter().flat_map(|grid| [(grid, 0.0), (grid, 0.1)]) {
        let grid = grid(cells, ends);
        let viscosity = share * grid.h[0];
        let [v, d, m]: [Components<T>; 3] = core::array::from_fn(|_| random.faces(&grid, SLOTS));
        let unit = T::EPSILON / grid.h[0];
        let (jd, jm) = (
            advected(&grid, viscosity, &v, Some(&d), false),
            advected(&grid, viscosity, &v, Some(&m), true),
        );
        assert_close(
            "J and its adjoint",
            dot_all(&jd, &m),
            dot_all(&d, &jm),
            norm(&jd) * norm(&m),
            10.0 * T::EPSILON,
        );
        let (adv, alone) = (
            advected(&grid, viscosity, &v, None, false),
            advected(&grid, 0.0, &v, None, false),
        );
        assert_close(
            "energy",
            dot_all(&v, &alone),
            0.0,
            norm(&v) * norm(&alone),
            10.0 * T::EPSILON,
        );
        assert!(
            viscosity == 0.0 || dot_all(&v, &adv) > 0.0,
            "viscosity takes no energy"
        );
        let naive = Naive {
            viscosity,
            ..Naive::new(&grid)
        };
        for k in 0..SLOTS {
            let (v, m) = (slot_of_all(&grid, SLOTS, k, &v), slot_of_all(&grid, SLOTS, k, &m));
            for (found, expected) in [(&adv, naive.advection(&v)), (&jm, naive.adjoint(&v, &m))] {
                let found = slot_of_all(&grid, SLOTS, k, found);
                found.iter().zip(&expected).for_each(|(x, y)| {
                    assert!(gap(x, y) <= 40.0 * unit, "{cells:?} {ends}: {:e}", gap(x, y))
                });
            }
        }
        let adv_d = advected(&grid, 0.0, &d, None, false);
        for t in [1.0, -0.5, 8.0] {
            let moved = advected(&grid, viscosity, &add_scaled_all(&v, t, &d), None, false);
            let expected = add_scaled_all(&add_scaled_all(&adv, t, &jd), t * t, &adv_d);
            let scale = unit * (1.0 + t.abs()) * (1.0 + t.abs());
            moved.iter().zip(&expected).for_each(|(x, y)| {
                assert!(
                    gap(&cast(x), &cast(y)) <= 60.0 * scale,
                    "not quadratic on {cells:?} {ends} at {t}"
                )
            });
        }
    }
}

#[test]
fn self_advection_keeps_energy_and_is_exactly_quadratic() {
    self_advection_agrees::<f64>();
    self_advection_agrees::<f32>();
}

fn transport_agrees<T: Real>(scheme: Scheme) {
    let mut random = Random::new(4);
    for (cells, ends) in GRIDS.into_iter().filter(|(cells, _)| cells[0] < 100) {
        let grid = grid(cells, ends);
        for courant in [0.6, 2.5, 9.5] {
            let v: Components<T> = flow::rough(&mut random, &grid, 1, courant);
            let (rho, mu): (Vec<T>, Vec<T>) = (random.density(&grid), random.cells(&grid, 1));
            for longest in [1.0, 3.0] {
                let carry = Carry::new(&grid, scheme, 10.0 * T::EPSILON).in_substeps_of(longest);
                let (forward, (back, _)) = (
                    carry.forward(&v, &rho).unwrap(),
                    carry.backward(&v, &rho, &mu).unwrap(),
                );
                let scale = dot(&rho, &rho) + dot(&mu, &mu) + dot(&forward, &forward) + dot(&back, &back);
                let what = format!("{scheme:?} on {cells:?} {ends} at {courant} in sub-steps of {longest}");
                assert_close(
                    &what,
                    dot(&forward, &mu),
                    dot(&rho, &back),
                    scale,
                    20.0 * T::EPSILON,
                );
            }
        }
    }
}

#[test]
fn transport_of_density() {
    // Limited transport is no linear map, but homogeneous of degree 1: A[rho] is its own derivative at rho along rho.
    for &scheme in Scheme::ALL {
        transport_agrees::<f64>(scheme);
        transport_agrees::<f32>(scheme);
    }
}
