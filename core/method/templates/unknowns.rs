//! From the unknowns z of a search to amplitudes, middles and radii, and back for gradients.
//!
//! ```text
//! amplitude   a = z / N^2                                 a force that moves smoke through the box while it acts
//! middle      c = m + H tanh(atanh((c_0 - m) / H) + s_0 z / H)      m the middle of the box, H = 0.6 of its side
//! radius      s = s_0 exp(log 4 tanh(z / log 4))          from a quarter to four times s_0
//! ```
//!
//! So all z are about as large, middles stay in the box or close to it, and radii are of the size that was asked for.

use crate::grid::Grid;
use crate::problem::Template;
use crate::real::Real;

/// H in parts of a side of the box.
const REACH: f64 = 0.6;
/// The logarithm of how many times larger or smaller a radius may become.
const STRETCH: f64 = 2.0 * core::f64::consts::LN_2;

/// Where the unknowns of a template stand among all, and what they are scaled by.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The template as it was given, in scaled numbers.
    pub given: Template,
    /// Its first unknown among all.
    pub first: usize,
    /// Sides of the box.
    sides: [f64; 3],
    dims: usize,
    slots: usize,
}

/// The places of `templates` in an animation of so many slots.
pub fn places<'g>(
    templates: impl Iterator<Item = Template> + 'g,
    grid: &'g Grid,
    slots: usize,
) -> impl Iterator<Item = Place> + 'g {
    let whole = grid.whole();
    let sides = core::array::from_fn(|axis| {
        let [n, h] = [
            whole.n.get(axis).map_or(1.0, |&n| n as f64),
            grid.h.get(axis).copied().unwrap_or(1.0),
        ];
        n * h
    });
    templates.scan(0, move |first, given| {
        let place = Place {
            given,
            first: *first,
            sides,
            dims: grid.dims,
            slots,
        };
        *first += given.unknowns(grid.dims, slots);
        Some(place)
    })
}

impl Place {
    /// What an amplitude's z is multiplied by: 1 / N^2.
    fn unit(&self) -> f64 {
        let steps = (self.slots + 1) as f64;
        1.0 / (steps * steps)
    }

    /// How many unknowns are amplitudes.
    fn amplitudes(&self) -> usize {
        self.given.kind.numbers(self.dims) * self.given.intervals(self.slots)
    }

    /// Its unknowns among all.
    fn range(&self) -> core::ops::Range<usize> {
        self.first..self.first + self.given.unknowns(self.dims, self.slots)
    }

    /// Number `which` of its unknowns; 0 where there is none.
    fn unknown<T: Real>(&self, z: &[T], which: usize) -> f64 {
        z.get(self.first + which).map_or(0.0, |z| z.to_f64())
    }

    /// The amplitude of an interval.
    pub fn amplitude<T: Real>(&self, z: &[T], interval: usize) -> [f64; 3] {
        let numbers = self.given.kind.numbers(self.dims);
        let number = |which: usize| self.unit() * self.unknown(z, interval * numbers + which);
        core::array::from_fn(|which| if which < numbers { number(which) } else { 0.0 })
    }

    /// The template with its middle and radius as they are now.
    pub fn template<T: Real>(&self, z: &[T]) -> Template {
        let mut now = self.given;
        if now.moves {
            let begin = self.amplitudes();
            let along = now.center.iter_mut().zip(self.sides).enumerate().take(self.dims);
            along.for_each(|(axis, (c, side))| *c = self.moved(*c, side, self.unknown(z, begin + axis))[0]);
            now.radius *= self.stretched(self.unknown(z, begin + self.dims))[0];
        }
        now
    }

    /// Where z takes a middle that began at `begin`, and the derivative of that.
    fn moved(&self, begin: f64, side: f64, z: f64) -> [f64; 2] {
        let (middle, reach) = (0.5 * side, REACH * side);
        let there = libm::tanh(libm::atanh((begin - middle) / reach) + self.given.radius * z / reach);
        [middle + reach * there, self.given.radius * (1.0 - there * there)]
    }

    /// What z multiplies a radius by, and the derivative of the logarithm of that.
    fn stretched(&self, z: f64) -> [f64; 2] {
        let part = libm::tanh(z / STRETCH);
        [libm::exp(STRETCH * part), 1.0 - part * part]
    }

    /// What the derivative by number `which` (amplitudes, middle, logarithm of the radius) is multiplied by to be that by its z.
    pub fn slope<T: Real>(&self, z: &[T], which: usize) -> f64 {
        let Some(axis) = which.checked_sub(self.amplitudes()) else {
            return self.unit();
        };
        let z = self.unknown(z, which);
        match self.given.center.iter().zip(self.sides).take(self.dims).nth(axis) {
            Some((&begin, side)) => self.moved(begin, side, z)[1],
            None => self.stretched(z)[1],
        }
    }

    /// Sets its unknowns to where a search begins.
    pub fn begin<T: Real>(&self, z: &mut [T]) {
        let numbers = self.given.kind.numbers(self.dims);
        let amplitudes = self.amplitudes();
        let own = z.get_mut(self.range()).unwrap_or_default();
        own.fill(T::ZERO);
        let begin = self.given.amplitude.iter().take(numbers).cycle();
        let own = own.iter_mut().take(amplitudes);
        own.zip(begin)
            .for_each(|(z, a)| *z = T::from_f64(a / self.unit()));
    }

    /// Leaves `keep` of its amplitudes.
    pub fn weaken<T: Real>(&self, z: &mut [T], keep: f64) {
        let amplitudes = self.amplitudes();
        let own = z.get_mut(self.range()).unwrap_or_default().iter_mut();
        own.take(amplitudes)
            .for_each(|z| *z = T::from_f64(z.to_f64() * keep));
    }
}
