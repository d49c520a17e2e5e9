//! The energy of a state and its gradient.

use super::element::CORNERS;
use super::mesh::{Mesh, Spring};
use super::small::{Square, inner};
use super::topology::Topology;
use crate::exec::{Exec, RowBuffers, Slabs, for_slabs};
use crate::real::Real;
use libm::sqrt;

/// Sums over simplices are made in this many parts, whatever the number of threads.
pub const PARTS: usize = 64;

/// Displacements of all vertices, and what acts on them.
#[derive(Clone, Copy)]
pub struct Body<'a, T> {
    pub mesh: &'a Mesh<'a>,
    pub topology: &'a Topology<'a>,
    /// Displacements of free vertices, in their order,
    pub free: &'a [T],
    /// and of held ones.
    pub held: &'a [T],
    /// Mass of each free vertex.
    pub mass: &'a [T],
    /// Where inertia alone would take them, of an implicit step.
    pub target: Option<&'a [T]>,
    /// What the elastic energy is multiplied by: 1 or dt^2.
    pub weight: f64,
    /// Acceleration of a quasi-static problem; that of an implicit step is in its target.
    pub gravity: [f64; 3],
}

impl<T: Real> Body<'_, T> {
    /// The displacement of vertex `vertex`.
    #[inline(always)]
    pub fn moved(&self, vertex: usize) -> [f64; 3] {
        let dims = self.mesh.dims;
        let number = self.topology.place.get(vertex).copied().unwrap_or_default() as usize;
        match number.checked_sub(self.topology.free()) {
            None => vector(self.free, number, dims),
            Some(number) => vector(self.held, number, dims),
        }
    }

    /// The displacements of the corners of a simplex.
    pub fn corners(&self, element: usize) -> [[f64; 3]; CORNERS] {
        let mut moved = [[0.0; 3]; CORNERS];
        for (moved, &corner) in moved.iter_mut().zip(self.mesh.corners_of(element)) {
            *moved = self.moved(corner as usize);
        }
        moved
    }

    /// From one end of a spring to the other, and how long it is.
    pub fn span(&self, spring: &Spring) -> ([f64; 3], f64) {
        let [one, other] = spring.ends.map(|end| {
            let (place, moved) = (self.mesh.place(end as usize), self.moved(end as usize));
            [0, 1, 2].map(|k| place[k] + moved[k])
        });
        let span = [0, 1, 2].map(|k| other[k] - one[k]);
        let length = sqrt(inner(&span, &span));
        let scale = if length > 0.0 { 1.0 / length } else { 0.0 };
        (span.map(|x| x * scale), length)
    }

    /// k (u u^T + max(0, 1 - L/l) (I - u u^T)) of a spring.
    pub fn stiffness(&self, spring: &Spring) -> Square<3> {
        let (along, length) = self.span(spring);
        let across = (1.0 - spring.rest_length / length).max(0.0);
        let mut out = [[0.0; 3]; 3];
        for i in 0..self.mesh.dims.min(3) {
            for k in 0..self.mesh.dims.min(3) {
                let both = along[i] * along[k];
                let rest = if i == k { 1.0 - both } else { -both };
                out[i][k] = spring.stiffness * (both + across * rest);
            }
        }
        out
    }

    /// E; infinite where a simplex is inverted. `sums` has [`PARTS`] numbers.
    pub fn energy(&self, exec: &dyn Exec, sums: &mut [f64]) -> f64 {
        let slabs = Slabs::new(self.mesh.count(), PARTS, 1);
        let parts = sums.get_mut(..slabs.count()).unwrap_or(&mut []);
        let each = Slabs::new(slabs.count(), PARTS, 1);
        for_slabs(exec, each, RowBuffers::fields([parts]), |run| {
            let [sums] = run.fields;
            for (slab, sum) in run.rows.zip(sums) {
                let energies = slabs.rows_of(slab).map(|element| {
                    let moved = self.corners(element);
                    self.mesh.element(element).energy(&self.mesh.material, &moved)
                });
                *sum = energies.sum();
            }
        });
        let elastic: f64 = sums.iter().take(slabs.count()).sum();
        let springs = self.mesh.springs.iter().map(|spring| {
            let stretch = self.span(spring).1 - spring.rest_length;
            0.5 * spring.stiffness * stretch * stretch
        });
        self.weight * (elastic + springs.sum::<f64>()) + self.outer()
    }

    /// What is no strain: 1/2 (x - x~)^T M (x - x~), or -<f, u>.
    fn outer(&self) -> f64 {
        let dims = self.mesh.dims;
        let rows = self.mass.iter().zip(self.free.chunks_exact(dims.max(1)));
        match self.target {
            Some(target) => {
                let squares = rows.zip(target.chunks_exact(dims)).map(|((mass, row), target)| {
                    let difference = row.iter().zip(target).map(|(x, y)| x.to_f64() - y.to_f64());
                    0.5 * mass.to_f64() * difference.map(|x| x * x).sum::<f64>()
                });
                squares.sum()
            }
            None => {
                let works = rows.map(|(mass, row)| {
                    let along = row
                        .iter()
                        .zip(self.gravity)
                        .map(|(x, gravity)| x.to_f64() * gravity);
                    mass.to_f64() * along.sum::<f64>()
                });
                -works.sum::<f64>()
            }
        }
    }

    /// The gradient by the displacement of free vertex `number`.
    pub fn gradient(&self, number: usize) -> [f64; 3] {
        let (mesh, dims) = (self.mesh, self.mesh.dims);
        let vertex = self.topology.vertex.get(number).copied().unwrap_or_default() as usize;
        let mut sum = [0.0; 3];
        for (element, corner) in self.topology.star(vertex, mesh.corners()) {
            let moved = self.corners(element);
            let force = mesh.element(element).force(&mesh.material, &moved, corner);
            sum.iter_mut().zip(force).for_each(|(sum, force)| *sum += force);
        }
        for spring in self
            .topology
            .ties(vertex)
            .iter()
            .filter_map(|&at| mesh.springs.get(at as usize))
        {
            let (along, length) = self.span(spring);
            let sign = if spring.ends[0] as usize == vertex {
                -1.0
            } else {
                1.0
            };
            let pull = sign * spring.stiffness * (length - spring.rest_length);
            sum.iter_mut()
                .zip(along)
                .for_each(|(sum, along)| *sum += pull * along);
        }
        let mass = self.mass.get(number).map_or(0.0, |mass| mass.to_f64());
        let own = vector(self.free, number, dims);
        let target = self.target.map(|target| vector(target, number, dims));
        core::array::from_fn(|k| {
            let outer = target.map_or(-self.gravity[k], |target| own[k] - target[k]);
            self.weight * sum[k] + mass * outer
        })
    }

    /// The volume-weighted sum of F over the simplices of a vertex; 0 where it has none.
    pub fn mean(&self, vertex: usize) -> Square<3> {
        let mut mean = [[0.0; 3]; 3];
        for (element, _) in self.topology.star(vertex, self.mesh.corners()) {
            let moved = self.corners(element);
            let element = self.mesh.element(element);
            let shift = element.shift(&moved);
            for (i, (row, shift)) in mean.iter_mut().zip(shift).enumerate() {
                for (k, (value, shift)) in row.iter_mut().zip(shift).enumerate() {
                    *value += element.volume * (shift + if i == k { 1.0 } else { 0.0 });
                }
            }
        }
        mean
    }
}

/// Vector `number` of a list of them.
#[inline(always)]
pub fn vector<T: Real>(list: &[T], number: usize, dims: usize) -> [f64; 3] {
    let mut out = [0.0; 3];
    let from = list.get(number * dims..(number + 1) * dims).unwrap_or(&[]);
    for (to, from) in out.iter_mut().zip(from) {
        *to = from.to_f64();
    }
    out
}
