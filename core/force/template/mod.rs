//! Forces that are sums of templates, and the adjoint of that: what a covector of the force is for amplitudes, middles and radii.

mod dual;
mod pattern;

pub use pattern::Pattern;

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, VectorMut, reborrow, sums};
use crate::grid::solids::{Solids, closed};
use crate::grid::{Grid, Side};
use crate::problem::Template;
use crate::real::Real;
use core::ops::Range;
use dual::{Dual, Number, PARTS};

/// A template on the faces of a grid, and in which slots of a trajectory it acts.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'g> {
    /// The grid.
    pub grid: &'g Grid,
    /// The solid cells in it: at closed faces there is no force.
    pub solids: Solids<'g>,
    /// Slots of the trajectory.
    pub slots: usize,
    /// When it acts, in scaled numbers.
    pub template: Template,
    /// What it is where its amplitude is 1.
    pub pattern: Pattern,
}

/// The amplitude by the number of the interval.
pub type Amplitude<'a> = dyn Fn(usize) -> [f64; 3] + Sync + 'a;

impl<'g> Placed<'g> {
    /// `template`, which is in scaled numbers, in a trajectory of so many slots.
    #[must_use]
    pub fn new(grid: &'g Grid, solids: Solids<'g>, slots: usize, template: Template) -> Self {
        Self {
            grid,
            solids,
            slots,
            pattern: Pattern::new(&template, grid.dims),
            template,
        }
    }

    /// Numbers of an amplitude.
    fn numbers(&self) -> usize {
        self.pattern.kind.numbers(self.grid.dims)
    }

    /// Whether the faces of a row across `axis` have a cell below them; of the first face of a row along x that is told by its place.
    fn has_faces(&self, row: usize, axis: usize) -> bool {
        axis == 0 || self.grid.neighbour(row, axis, Side::Low).is_some()
    }

    /// The open faces of a row across `axis`: their places in the row, and where they are.
    fn faces(&self, row: usize, axis: usize) -> impl Iterator<Item = (usize, [f64; 3])> {
        let (grid, there) = (self.grid, self.has_faces(row, axis));
        let first = usize::from(axis == 0 && !grid.axis(0).is_ring());
        let bits = self.solids.row(grid.n[0], row);
        let open = move |&x: &usize| bits.get(x).is_none_or(|bits| bits & closed(axis) == 0);
        let place = move |x: usize| {
            let cell = grid.cell_at(row, x);
            let at = core::array::from_fn(|of| {
                // Layers outside lie before the box begins.
                let inside = grid.in_whole(of, cell[of]) as f64 - grid.layers(of, Side::Low) as f64;
                inside + if of == axis { 0.0 } else { 0.5 }
            });
            let [[x, y, z], [hx, hy, hz]] = [at, grid.h];
            [x * hx, y * hy, z * hz]
        };
        let end = if there { grid.n[0] } else { 0 };
        (first..end).filter(open).map(move |x| (x, place(x)))
    }

    /// The densities of the two cells at face `x` of a row of faces across `axis`, in the step after each slot, as one factor; 1 where smoke
    /// does not matter.
    fn smoke<'r, T: Real>(
        &self,
        rho: &'r [T],
        axis: usize,
        row: usize,
        x: usize,
    ) -> impl Fn(usize) -> f64 + use<'r, T> {
        let (grid, cells) = (self.grid, self.grid.cells());
        let low = match axis {
            0 => Some(row * grid.n[0] + x.checked_sub(1).unwrap_or(grid.n[0] - 1)),
            _ => grid
                .neighbour(row, axis, Side::Low)
                .map(|row| row * grid.n[0] + x),
        };
        let here = row * grid.n[0] + x;
        let matters = self.template.kind.on_smoke();
        move |slot| {
            let at = |cell: usize| rho.get((slot + 1) * cells + cell).map_or(0.0, |rho| rho.to_f64());
            match low {
                Some(low) if matters => 0.5 * (at(low) + at(here)),
                _ => 1.0,
            }
        }
    }

    /// `out += a_k f` in the slots of `range` in which it acts, where field k + 1 of `rho` is the density in slot k. The first slot of `out` is
    /// number `first` of the trajectory.
    pub fn add<T: Real>(
        &self,
        exec: &dyn Exec,
        amplitude: &Amplitude<'_>,
        rho: &[T],
        (range, first): (Range<usize>, usize),
        out: &mut VectorMut<'_, T>,
    ) {
        let (grid, n) = (self.grid, self.grid.n[0]);
        let acts = self.template.slots(self.slots);
        let slots = acts.start.max(range.start)..acts.end.min(range.end);
        if slots.is_empty() {
            return;
        }
        for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(out)), |task| {
            for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
                for (x, place) in self.faces(task.row, axis) {
                    let field = self.pattern.at::<f64>(axis, place);
                    let smoke = self.smoke(rho, axis, task.row, x);
                    let faces = out.get_mut((slots.start - first) * n + x..).unwrap_or_default();
                    for (slot, face) in slots.clone().zip(faces.iter_mut().step_by(n.max(1))) {
                        let force = product(amplitude(self.interval(slot)), field);
                        *face += T::from_f64(force * smoke(slot));
                    }
                }
            }
        });
    }

    /// The number of the interval that a slot in which it acts belongs to.
    fn interval(&self, slot: usize) -> usize {
        slot.saturating_sub(self.template.from) / self.template.interval.max(1)
    }

    /// What the covector `b` of the force is for the numbers of the template, in the order of [`Template::unknowns`]: for each amplitude
    /// <b, f>, then <b, df/dc> along each axis and <b, df/d log s>. `each` hears them by their places. `sums` has an element for each of
    /// them and each row; `rho` is as in [`Self::add`].
    pub fn adjoint<T: Real>(
        &self,
        exec: &dyn Exec,
        amplitude: &Amplitude<'_>,
        rho: &[T],
        b: Vector<'_, T>,
        sums: &mut [f64],
        each: &mut dyn FnMut(usize, f64),
    ) {
        if self.template.moves {
            self.gather::<T, Dual>(exec, amplitude, rho, b, sums, each);
        } else {
            self.gather::<T, f64>(exec, amplitude, rho, b, sums, each);
        }
    }

    fn gather<T: Real, N: Number>(
        &self,
        exec: &dyn Exec,
        amplitude: &Amplitude<'_>,
        rho: &[T],
        b: Vector<'_, T>,
        sums: &mut [f64],
        each: &mut dyn FnMut(usize, f64),
    ) {
        let grid = self.grid;
        let count = self.template.unknowns(grid.dims, self.slots);
        let sums = sums.get_mut(..count * grid.rows()).unwrap_or_default();
        for_rows(
            exec,
            grid.rows(),
            RowBuffers::<f64, 0>::sums(&mut *sums),
            |task| {
                task.sums.fill(0.0);
                for (axis, b) in b.into_iter().enumerate().take(grid.dims) {
                    let b = sums::row(grid, self.slots, b, task.row);
                    for (x, place) in self.faces(task.row, axis) {
                        let smoke = self.smoke(rho, axis, task.row, x);
                        let covector = |slot: usize| {
                            b.get(slot * grid.n[0] + x).map_or(0.0, |b| b.to_f64()) * smoke(slot)
                        };
                        self.add_face(self.pattern.at::<N>(axis, place), amplitude, &covector, task.sums);
                    }
                }
            },
        );
        (0..count).for_each(|which| each(which, sums.iter().skip(which).step_by(count.max(1)).sum()));
    }

    /// Adds what one face contributes, of which `covector` is known by the slot.
    fn add_face<N: Number>(
        &self,
        field: [N; 3],
        amplitude: &Amplitude<'_>,
        covector: &dyn Fn(usize) -> f64,
        sums: &mut [f64],
    ) {
        let numbers = self.numbers();
        let (of_amplitudes, of_place) = sums
            .split_at_mut_checked(numbers * self.template.intervals(self.slots))
            .unwrap_or_default();
        let mut slots = self.template.slots(self.slots);
        for (interval, sums) in of_amplitudes.chunks_exact_mut(numbers.max(1)).enumerate() {
            let held = slots.by_ref().take(self.template.interval.max(1));
            let covector = held.fold(0.0, |sum, slot| sum + covector(slot));
            sums.iter_mut()
                .zip(field)
                .for_each(|(sum, field)| *sum += covector * field.value());
            if of_place.is_empty() {
                continue;
            }
            let terms = field.into_iter().zip(amplitude(interval));
            let moved = terms.fold([0.0; PARTS], |mut sum, (field, a)| {
                sum.iter_mut()
                    .zip(field.by())
                    .for_each(|(sum, by)| *sum += a * by);
                sum
            });
            let [along @ .., radius] = moved;
            let moved = along.into_iter().take(self.grid.dims).chain([radius]);
            of_place
                .iter_mut()
                .zip(moved)
                .for_each(|(sum, moved)| *sum += covector * moved);
        }
    }

    /// `mu += s (d force / d rho)^T b` for the density in slot `slot`, where the template acts on smoke.
    pub fn add_to_density<T: Real>(
        &self,
        exec: &dyn Exec,
        amplitude: &Amplitude<'_>,
        (s, b): (f64, Vector<'_, T>),
        slot: usize,
        mu: &mut [T],
    ) {
        if !self.template.kind.on_smoke() || !self.template.slots(self.slots).contains(&slot) {
            return;
        }
        let (grid, n) = (self.grid, self.grid.n[0]);
        let amplitude = amplitude(self.interval(slot)).map(|a| 0.5 * s * a);
        for_rows(exec, grid.rows(), RowBuffers::fields([mu]), |task| {
            let [mu] = task.fields;
            for (axis, b) in b.into_iter().enumerate().take(grid.dims) {
                // Both faces of a cell: the low ones are those of its own row.
                let mut add = |row: usize, shift: usize| {
                    let b = sums::row(grid, self.slots, b, row);
                    for (x, place) in self.faces(row, axis) {
                        let force = product(amplitude, self.pattern.at::<f64>(axis, place));
                        let b = b.get(slot * n + x).map_or(0.0, |b| b.to_f64());
                        if let Some(mu) = mu.get_mut((x + shift) % n.max(1)) {
                            *mu += T::from_f64(force * b);
                        }
                    }
                };
                add(task.row, 0);
                match axis {
                    0 => add(task.row, n - 1),
                    _ => grid
                        .neighbour(task.row, axis, Side::High)
                        .into_iter()
                        .for_each(|high| add(high, 0)),
                }
            }
        });
    }
}

/// Sum of products.
fn product(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b)
}
