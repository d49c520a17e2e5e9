//! Smooth synthetic flows, free of divergence on the grid, with a given Courant number.

use core::f64::consts::{PI, TAU};
use thurible_core::grid::{Grid, Side};
use thurible_core::{Real, Space};

/// Modes of the potential.
const MODES: usize = 3;

/// A trajectory of `slots` velocities whose largest Courant number is `courant`: the curl of a potential at the edges,
/// zero on walls.
pub fn synthetic<T: Real, S: Space>(grid: &Grid, slots: usize, courant: f64) -> [Vec<T>; 3] {
    let mut v: [Vec<f64>; 3] = core::array::from_fn(|axis| {
        if axis < S::DIM {
            vec![0.0; grid.cells() * slots]
        } else {
            Vec::new()
        }
    });
    for slot in 0..slots {
        let potential = Potential::new::<S>(grid, slot as f64 / slots as f64);
        for cell in cells(grid) {
            let at = index(grid, slots, slot, cell);
            for (axis, component) in v.iter_mut().enumerate().take(S::DIM) {
                if grid.axis(axis).open_face(cell[axis] as isize).is_some() {
                    component[at] = potential.curl::<S>(grid, axis, cell);
                }
            }
        }
    }
    let largest = (0..slots)
        .map(|slot| courant_of(grid, |axis, cell| v[axis][index(grid, slots, slot, cell)]))
        .fold(0.0, f64::max);
    let scale = if largest > 0.0 { courant / largest } else { 0.0 };
    v.map(|component| component.into_iter().map(|x| T::from_f64(scale * x)).collect())
}

/// max over cells of the sum of |v_f| over the cell's faces / (2 h), for a velocity given at low faces.
pub fn courant_of(grid: &Grid, at: impl Fn(usize, [usize; 3]) -> f64) -> f64 {
    let of = |cell: [usize; 3]| -> f64 {
        let axis = |axis: usize| {
            let high = grid
                .beside(cell, axis, Side::High)
                .map_or(0.0, |high| at(axis, high).abs());
            (at(axis, cell).abs() + high) / (2.0 * grid.h[axis])
        };
        (0..grid.dims).map(axis).sum()
    };
    cells(grid).map(of).fold(0.0, f64::max)
}

/// Where the number of a cell stands in a trajectory.
pub fn index(grid: &Grid, slots: usize, slot: usize, [x, y, z]: [usize; 3]) -> usize {
    ((z * grid.n[1] + y) * slots + slot) * grid.n[0] + x
}

fn cells(grid: &Grid) -> impl Iterator<Item = [usize; 3]> {
    let [nx, ny, nz] = grid.n;
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

/// A potential at the edges at one time: a sum of products of one factor for each axis.
struct Potential {
    /// By the component's axis, the mode, the factor's axis and the place along that.
    factors: [[[Vec<f64>; 3]; MODES]; 3],
}

impl Potential {
    fn new<S: Space>(grid: &Grid, time: f64) -> Self {
        let factor = |along: usize, m: usize, axis: usize, i: usize| {
            let half = if axis == along { 0.5 } else { 0.0 };
            let u = (i as f64 + half) / grid.n[axis] as f64;
            let in_space = if axis >= S::DIM {
                1.0
            } else if axis == along {
                (TAU * m as f64 * u + 1.3 * along as f64).cos()
            } else if grid.axis(axis).is_ring() {
                (TAU * (m as f64 * (u + 0.5 * time) + 0.37 * (axis + along + m) as f64)).sin()
            } else {
                (PI * (m + axis % 2) as f64 * u).sin()
            };
            if axis == 0 {
                in_space * (PI * m as f64 * time + (m + along) as f64).cos() / m as f64
            } else {
                in_space
            }
        };
        let line = |along: usize, m: usize, axis: usize| {
            (0..=grid.n[axis]).map(|i| factor(along, m, axis, i)).collect()
        };
        Self {
            factors: [0, 1, 2].map(|along| [1, 2, 3].map(|m| [0, 1, 2].map(|axis| line(along, m, axis)))),
        }
    }

    /// Component `along`, in the middle of an edge along that axis.
    fn at(&self, along: usize, [x, y, z]: [usize; 3]) -> f64 {
        self.factors[along]
            .iter()
            .map(|[in_x, in_y, in_z]| in_x[x] * in_y[y] * in_z[z])
            .sum()
    }

    /// The curl at the low face of `cell` along `axis`, by differences between the face's edges.
    fn curl<S: Space>(&self, grid: &Grid, axis: usize, cell: [usize; 3]) -> f64 {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        // In 2D the potential has the component along z alone.
        let difference = |along: usize, by: usize| {
            let mut next = cell;
            next[by] += 1;
            if S::DIM == 3 || along == 2 {
                (self.at(along, next) - self.at(along, cell)) / grid.h[by]
            } else {
                0.0
            }
        };
        difference(c, b) - difference(b, c)
    }
}
