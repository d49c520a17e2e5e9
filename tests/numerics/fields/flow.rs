//! Fields without divergence: curls of potentials at nodes (2D) or edges (3D).

use super::naive::Naive;
use super::random::Random;
use super::{Components, cast_all, index, places, slot_of_all, zeros};
use thurible_core::Real;
use thurible_core::grid::Grid;

/// v = curl psi in every slot. `psi(c, i, k)` is component c of the potential at edge i (2D: node i, c = 2), and is taken as
/// 0 on walls, so that no flow passes them.
pub fn curl(grid: &Grid, slots: usize, psi: impl Fn(usize, [usize; 3], usize) -> f64) -> Components<f64> {
    let mut v = zeros(grid, slots);
    let potential = |c: usize, mut at: [usize; 3], k: usize| {
        for a in (0..grid.dims).filter(|&a| a != c) {
            if !grid.axis(a).is_ring() && (at[a] == 0 || at[a] == grid.n[a]) {
                return 0.0;
            }
            at[a] %= grid.n[a];
        }
        psi(c, at, k)
    };
    for (axis, v) in v.iter_mut().enumerate().take(grid.dims) {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        for k in 0..slots {
            for at in places(grid) {
                let slope = |of: usize, along: usize| {
                    let mut next = at;
                    next[along] += 1;
                    (potential(of, next, k) - potential(of, at, k)) / grid.h[along]
                };
                let first = if b < grid.dims { slope(c, b) } else { 0.0 };
                let second = if c < grid.dims { slope(b, c) } else { 0.0 };
                let used = |of: usize| grid.dims == 3 || of == 2;
                v[index(grid, slots, k, at)] =
                    if used(c) { first } else { 0.0 } - if used(b) { second } else { 0.0 };
            }
        }
    }
    v
}

/// The Courant number of a trajectory for steps of length 1.
pub fn courant<T: Real>(grid: &Grid, slots: usize, v: &Components<T>) -> f64 {
    super::largest((0..slots).map(|k| Naive::new(grid).courant(&slot_of_all(grid, slots, k, v))))
}

pub fn scaled<T: Real>(grid: &Grid, slots: usize, v: &Components<f64>, to: f64) -> Components<T> {
    let now = courant(grid, slots, v);
    cast_all(
        &v.each_ref()
            .map(|component| component.iter().map(|x| x * to / now).collect()),
    )
}

/// Rough: random potentials, scaled to a Courant number.
pub fn rough<T: Real>(random: &mut Random, grid: &Grid, slots: usize, to: f64) -> Components<T> {
    let psi: Vec<f64> = random.cells(grid, 3 * slots);
    let v = curl(grid, slots, |c, at, k| psi[index(grid, 3 * slots, 3 * k + c, at)]);
    scaled(grid, slots, &v, to)
}

/// Smooth and changing in time: a few waves, scaled to a Courant number.
pub fn swirl<T: Real>(grid: &Grid, slots: usize, to: f64) -> Components<T> {
    let tau = core::f64::consts::TAU;
    let psi = |c: usize, at: [usize; 3], k: usize| {
        let t = k as f64 / slots as f64;
        let wave = |m: usize| {
            let factor = |a: usize| {
                let half = if a == c { 0.5 } else { 0.0 };
                let u = (at[a] as f64 + half) / grid.n[a] as f64;
                let m = m as f64;
                if a == c {
                    (tau * u * m + 1.3 * c as f64).cos()
                } else if grid.axis(a).is_ring() {
                    (tau * (u * m + 0.37 * ((a + c) as f64 + m) + t * m * 0.5)).sin()
                } else {
                    (tau * 0.5 * u * (m + (a % 2) as f64)).sin()
                }
            };
            let space: f64 = (0..grid.dims).map(factor).product();
            space * (tau * t * 0.5 * m as f64 + (m + c) as f64).cos() / m as f64
        };
        (1..4).map(wave).sum()
    };
    scaled(grid, slots, &curl(grid, slots, psi), to)
}

/// The same velocity at every face that is not a wall.
pub fn uniform(grid: &Grid, velocity: [f64; 3]) -> Components<f64> {
    Naive::new(grid).at_faces(|axis, _| velocity[axis])
}
