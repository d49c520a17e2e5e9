//! What is searched for, as one list of numbers z: the velocity at the start, forces, amplitudes, middles and radii of templates.
//!
//! ```text
//! v_0 = given + z/N,   f = z/N^2,   a = z/N^2,   c = c_0 + s_0 z,   s = s_0 exp(z)
//! ```

use super::cells::Cells;
use super::params::{Control, Controls};
use crate::problem::{PACKED, Template};
use crate::real::Real;
use core::ops::Range;

/// Which numbers of the list are what.
#[derive(Clone, Copy, Debug)]
pub struct Unknowns {
    dims: usize,
    /// Cells.
    count: usize,
    /// N.
    pub steps: usize,
    /// What is searched for.
    pub controls: Controls,
    /// Those of templates.
    templates: usize,
}

impl Unknowns {
    /// Those of a search with these templates.
    #[must_use]
    pub fn new(
        cells: &Cells,
        steps: usize,
        controls: Controls,
        templates: impl Iterator<Item = Template>,
    ) -> Self {
        let of_templates = templates
            .map(|template| template.unknowns(cells.dims, steps))
            .sum();
        Self {
            dims: cells.dims,
            count: cells.count(),
            steps,
            controls,
            templates: if controls.has(Control::Templates) {
                of_templates
            } else {
                0
            },
        }
    }

    fn field(&self, control: Control) -> usize {
        if self.controls.has(control) {
            self.dims * self.count
        } else {
            0
        }
    }

    /// How many there are.
    #[must_use]
    pub fn total(&self) -> usize {
        self.field(Control::InitialVelocity) + self.steps * self.field(Control::Forces) + self.templates
    }

    /// Those of component `axis` of the velocity at the start; none where it is not searched for.
    #[must_use]
    pub fn initial(&self, axis: usize) -> Range<usize> {
        self.part(Control::InitialVelocity, 0, axis)
    }

    /// Those of component `axis` of the force of a step; none where forces are not searched for.
    #[must_use]
    pub fn force(&self, step: usize, axis: usize) -> Range<usize> {
        let begin = self.field(Control::InitialVelocity) + step * self.field(Control::Forces);
        self.part(Control::Forces, begin, axis)
    }

    fn part(&self, control: Control, begin: usize, axis: usize) -> Range<usize> {
        let there = self.controls.has(control) && axis < self.dims;
        let len = if there { self.count } else { 0 };
        begin + axis * len..begin + (axis + 1) * len
    }

    /// 1 / N, by which a z is a velocity.
    #[must_use]
    pub fn of_velocity(&self) -> f64 {
        1.0 / self.steps.max(1) as f64
    }

    /// 1 / N^2, by which a z is a force or an amplitude.
    #[must_use]
    pub fn of_force(&self) -> f64 {
        self.of_velocity() * self.of_velocity()
    }

    /// The templates with their unknowns, from their packed numbers.
    pub fn placed<'p>(&self, packed: &'p [f64]) -> impl Iterator<Item = Placed> + use<'p> {
        let mut first = self.total() - self.templates;
        let own = *self;
        packed.as_chunks::<PACKED>().0.iter().map(move |packed| {
            let given = Template::unpack(packed);
            let placed = Placed {
                given,
                first,
                unknowns: own,
            };
            if own.controls.has(Control::Templates) {
                first += given.unknowns(own.dims, own.steps);
            }
            placed
        })
    }
}

/// A template with its unknowns.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// As it is given, in scaled numbers.
    pub given: Template,
    /// Its first unknown.
    pub first: usize,
    unknowns: Unknowns,
}

impl Placed {
    fn searched(&self) -> bool {
        self.unknowns.controls.has(Control::Templates)
    }

    /// Numbers of an amplitude.
    #[must_use]
    pub fn numbers(&self) -> usize {
        self.given.kind.numbers(self.unknowns.dims)
    }

    /// Unknowns that are amplitudes.
    #[must_use]
    pub fn amplitudes(&self) -> usize {
        self.numbers() * self.intervals()
    }

    /// Its intervals.
    #[must_use]
    pub fn intervals(&self) -> usize {
        self.given.intervals(self.unknowns.steps)
    }

    /// Whether its middle and radius are searched for.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.searched() && self.given.moves
    }

    /// The interval that a step belongs to, where it acts.
    #[must_use]
    pub fn interval(&self, step: usize) -> Option<usize> {
        self.given.interval_at(step, self.unknowns.steps)
    }

    fn unknown<T: Real>(&self, z: &[T], which: usize) -> f64 {
        z.get(self.first + which).map_or(0.0, |z| z.to_f64())
    }

    /// The amplitude of an interval.
    #[must_use]
    pub fn amplitude<T: Real>(&self, z: &[T], interval: usize) -> [f64; 3] {
        if !self.searched() {
            return self.given.amplitude;
        }
        let numbers = self.numbers();
        let mut amplitude = [0.0; 3];
        for (which, number) in amplitude.iter_mut().enumerate().take(numbers) {
            *number = self.unknowns.of_force() * self.unknown(z, interval * numbers + which);
        }
        amplitude
    }

    /// The middle and the radius as they are now.
    #[must_use]
    pub fn now<T: Real>(&self, z: &[T]) -> ([f64; 3], f64) {
        let (mut center, mut radius) = (self.given.center, self.given.radius);
        if self.moves() {
            let begin = self.amplitudes();
            for (axis, c) in center.iter_mut().enumerate().take(self.unknowns.dims) {
                *c += self.given.radius * self.unknown(z, begin + axis);
            }
            radius *= libm::exp(self.unknown(z, begin + self.unknowns.dims));
        }
        (center, radius)
    }

    /// What the derivative by the amplitudes, then along each axis by the middle, then by the logarithm of the radius, is multiplied by to be
    /// that by z.
    #[must_use]
    pub fn slope(&self, which: usize) -> f64 {
        match which.checked_sub(self.amplitudes()) {
            None => self.unknowns.of_force(),
            Some(axis) if axis < self.unknowns.dims => self.given.radius,
            Some(_) => 1.0,
        }
    }

    /// Sets its unknowns to where a search begins.
    pub fn begin<T: Real>(&self, z: &mut [T]) {
        let (numbers, amplitudes) = (self.numbers(), self.amplitudes());
        let count = self.given.unknowns(self.unknowns.dims, self.unknowns.steps);
        let own = z.get_mut(self.first..self.first + count).unwrap_or_default();
        own.fill(T::ZERO);
        let begin = self.given.amplitude.iter().take(numbers).cycle();
        for (z, a) in own.iter_mut().take(amplitudes).zip(begin) {
            *z = T::from_f64(a / self.unknowns.of_force());
        }
    }
}
