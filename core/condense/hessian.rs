//! The Hessian in block rows: a block of d x d numbers for each pair of free vertices that are joined.

use super::body::Body;
use super::element::LARGEST;
use super::small::Square;
use super::topology::Topology;
use crate::exec::{Exec, for_uneven};
use crate::real::Real;

/// The Hessian.
#[derive(Clone, Copy)]
pub struct Hessian<'a, T> {
    pub topology: &'a Topology<'a>,
    pub values: &'a [T],
    pub dims: usize,
}

impl<'a, T: Real> Hessian<'a, T> {
    /// The blocks of a row with their columns.
    #[inline(always)]
    pub fn row(&self, number: usize) -> impl Iterator<Item = (usize, &'a [T])> + use<'a, T> {
        let square = self.dims * self.dims;
        let begin = self.topology.row_begin.get(number).copied().unwrap_or_default() as usize;
        let values = self.values.get(begin * square..).unwrap_or(&[]);
        let columns = self.topology.row(number).iter();
        columns
            .zip(values.chunks_exact(square.max(1)))
            .map(|(&column, block)| (column as usize, block))
    }

    /// The block of row `row` and column `column`, where they are joined.
    pub fn block(&self, row: usize, column: usize) -> Option<&'a [T]> {
        let at = self.topology.row(row).binary_search(&(column as u32)).ok()?;
        let square = self.dims * self.dims;
        let begin = (*self.topology.row_begin.get(row)? as usize + at) * square;
        self.values.get(begin..begin + square)
    }
}

/// Writes the Hessian of a state, each element's block projected to positive semidefinite; without the springs that a basis does not know,
/// unless `all`. Of a `colour` its rows alone are written.
pub fn assemble<T: Real>(
    exec: &dyn Exec,
    body: &Body<'_, T>,
    all: bool,
    colour: Option<usize>,
    values: &mut [T],
) {
    let (begin, colours) = (body.topology.row_begin, body.topology.colour);
    let square = body.mesh.dims * body.mesh.dims;
    for_uneven(exec, begin, square, values, |number, row| {
        let own = colours.get(number).map(|&own| own as usize);
        if colour.is_none() || colour == own {
            fill(body, all, number, row);
        }
    });
}

/// One block row: the simplices of the vertex in their order, its springs, its mass.
fn fill<T: Real>(body: &Body<'_, T>, all: bool, number: usize, row: &mut [T]) {
    let (mesh, dims) = (body.mesh, body.mesh.dims);
    let columns = body.topology.row(number);
    let vertex = body.topology.vertex.get(number).copied().unwrap_or_default() as usize;
    row.fill(T::ZERO);
    let mut add = |other: u32, value: &dyn Fn(usize, usize) -> f64| {
        let place = body
            .topology
            .place
            .get(other as usize)
            .copied()
            .unwrap_or(u32::MAX);
        let Ok(at) = columns.binary_search(&place) else {
            return;
        };
        for (i, row) in row.chunks_exact_mut(dims).skip(at * dims).take(dims).enumerate() {
            for (k, to) in row.iter_mut().enumerate() {
                *to = T::from_f64(to.to_f64() + body.weight * value(i, k));
            }
        }
    };
    for (element, corner) in body.topology.star(vertex, mesh.corners()) {
        let moved = body.corners(element);
        let hessian = mesh.element(element).hessian(&mesh.material, &moved);
        for (other, &column) in mesh.corners_of(element).iter().enumerate() {
            add(column, &|i, k| {
                part(&hessian, corner * dims + i, other * dims + k)
            });
        }
    }
    for spring in body
        .topology
        .ties(vertex)
        .iter()
        .filter_map(|&at| mesh.springs.get(at as usize))
    {
        if all || spring.in_basis {
            let stiffness = body.stiffness(spring);
            for end in spring.ends {
                let sign = if end as usize == vertex { 1.0 } else { -1.0 };
                add(end, &|i, k| sign * stiffness[i][k]);
            }
        }
    }
    if body.target.is_some() {
        let mass = body.mass.get(number).map_or(0.0, |mass| mass.to_f64()) / body.weight;
        add(vertex as u32, &|i, k| if i == k { mass } else { 0.0 });
    }
}

fn part(hessian: &Square<LARGEST>, row: usize, column: usize) -> f64 {
    hessian
        .get(row)
        .and_then(|row| row.get(column))
        .copied()
        .unwrap_or(0.0)
}
