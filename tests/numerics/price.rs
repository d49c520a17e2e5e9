//! The price of a force's curl: symmetric, what it should be, and roughly undone for the first inverse Hessian.

use crate::fields::random::Random;
use crate::fields::{Components, assert_close, dot_all, flow, grid, view, view_mut, zeros};
use thurible_core::force::{price, scratch_per_thread};
use thurible_core::grid::Grid;
use thurible_core::operators::self_advection::{self, Fluid};
use thurible_core::{D2, D3, Real, Serial, Space};

const SLOTS: usize = 3;

/// Work on fields of `grid` with s = `cells` cell sizes.
struct Prices<'g> {
    grid: &'g Grid,
    cells: f64,
}

impl Prices<'_> {
    fn fluid(&self) -> Fluid<'_> {
        let s = self.cells * self.grid.h[0];
        Fluid {
            grid: self.grid,
            slots: SLOTS,
            viscosity: s * s,
            solids: thurible_core::grid::solids::Solids::default(),
        }
    }

    fn apply<T: Real, S: Space>(&self, w: &Components<T>) -> Components<T> {
        let mut out = zeros(self.grid, SLOTS);
        let mut scratch = vec![T::ZERO; scratch_per_thread(self.grid, SLOTS)];
        price::apply::<T, S>(&Serial, self.fluid(), view(w), view_mut(&mut out), &mut scratch);
        out
    }

    fn solve<T: Real, S: Space>(&self, y: &Components<T>) -> Components<T> {
        let (mut x, mut work) = (zeros(self.grid, SLOTS), zeros(self.grid, SLOTS));
        let mut scratch = vec![T::ZERO; scratch_per_thread(self.grid, SLOTS)];
        price::solve::<T, S>(
            &Serial,
            self.fluid(),
            view(y),
            view_mut(&mut x),
            view_mut(&mut work),
            &mut scratch,
        );
        x
    }
}

fn is_symmetric_and_roughly_undone<S: Space>(cells: &[usize], ends: &str) {
    let mut random = Random::new(61);
    let grid = grid(cells, ends);
    let [a, b]: [Components<f64>; 2] = [1, 2].map(|_| flow::rough(&mut random, &grid, SLOTS, 1.0));
    for cells in [0.5, 2.5, 8.0] {
        let prices = Prices { grid: &grid, cells };
        let what = format!("{:?} {ends}, {cells} cells", grid.n);
        let [of_a, of_b] = [&a, &b].map(|x| prices.apply::<f64, S>(x));
        let scale = dot_all(&of_a, &of_a) + dot_all(&b, &b);
        assert_close(
            &format!("price, {what}"),
            dot_all(&of_a, &b),
            dot_all(&a, &of_b),
            scale,
            1e-13,
        );
        let [back_a, back_b] = [&a, &b].map(|x| prices.solve::<f64, S>(x));
        let scale = dot_all(&back_a, &back_a) + dot_all(&b, &b);
        assert_close(
            &format!("solve, {what}"),
            dot_all(&back_a, &b),
            dot_all(&a, &back_b),
            scale,
            1e-13,
        );
        // Of a flow without divergence B q(B) leaves between 0.4 and 1.6 of every part.
        let left = prices.apply::<f64, S>(&back_a);
        let ratio = dot_all(&left, &a) / dot_all(&a, &a);
        assert!((0.4..=1.6).contains(&ratio), "{what}: {ratio}");
        let left: f64 = left
            .iter()
            .flatten()
            .zip(a.iter().flatten())
            .map(|(x, y)| (x - y).powi(2))
            .sum::<f64>()
            .sqrt();
        assert!(left <= 0.61 * dot_all(&a, &a).sqrt(), "{what}: {left}");
    }
}

#[test]
fn symmetric_and_roughly_undone() {
    is_symmetric_and_roughly_undone::<D2>(&[12, 9], "ww");
    is_symmetric_and_roughly_undone::<D2>(&[8, 10], "wp");
    is_symmetric_and_roughly_undone::<D3>(&[5, 6, 4], "pww");
}

fn is_that_of_viscosity<S: Space>(cells: &[usize], ends: &str) {
    let mut random = Random::new(62);
    let grid = grid(cells, ends);
    let prices = Prices {
        grid: &grid,
        cells: 1.5,
    };
    let w: Components<f64> = random.faces(&grid, SLOTS);
    let rest = zeros::<f64>(&grid, SLOTS);
    let mut drag = zeros(&grid, SLOTS);
    let mut scratch = vec![0.0; scratch_per_thread(&grid, SLOTS)];
    self_advection::apply_derivative::<f64, S>(
        &Serial,
        prices.fluid(),
        view(&rest),
        view(&w),
        view_mut(&mut drag),
        &mut scratch,
    );
    let priced = prices.apply::<f64, S>(&w);
    for ((priced, drag), w) in priced
        .iter()
        .flatten()
        .zip(drag.iter().flatten())
        .zip(w.iter().flatten())
    {
        assert!(
            (priced - (w + drag)).abs() < 1e-12 * (1.0 + drag.abs()),
            "{cells:?} {ends}: {priced} {drag} {w}"
        );
    }
}

#[test]
fn the_price_is_that_of_viscosity() {
    is_that_of_viscosity::<D2>(&[10, 7], "wp");
    is_that_of_viscosity::<D2>(&[40, 6], "pw");
    is_that_of_viscosity::<D2>(&[2, 3], "ww");
    is_that_of_viscosity::<D3>(&[5, 6, 4], "www");
    is_that_of_viscosity::<D3>(&[6, 3, 5], "pwp");
    is_that_of_viscosity::<D3>(&[35, 3, 2], "wpw");
}
