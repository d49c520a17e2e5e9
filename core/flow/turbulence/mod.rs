//! What is too fine for the grid of a flow, made up on a finer one: wavelet turbulence (Kim, Thuerey, James & Gross 2008; mathematics section 11).
//!
//! ```text
//! v' = Q (U v + a 2^(-5/6) sqrt(2 e) curl N(c)),   e = 1/2 |v - U R v|^2
//! N(c) = sum over octaves b of 2^(-5b/6) 2^-b n(2^b c)
//! ```
//!
//! e is the energy of the finest waves that v holds, of two to four cells, c the texture coordinates, at first the place in cells of v, and n a
//! [`tile`] of noise of waves of two to four of its values: octave b has waves of 2^(1-b) to 2^(2-b) cells of v. There are three octaves, or as
//! many as cells were halved: a grid that is 2^m times as fine holds no more than m with four of its cells a wave. They go on as Kolmogorov's
//! spectrum does: each has 2^(-5/3) of the energy of the one before.
//!
//! The coordinates ride on v. What stretches them would in time smear the noise, so there are two sets of them, each begun anew every [`PERIOD`]
//! steps, and half of that apart; the weight of a set is 0 when it begins anew and 1 in the middle. Two noises that do not know each other and
//! weigh w_0 and w_1 are as strong as one when divided by the root of w_0^2 + w_1^2. Where coordinates are stretched s times, waves are s
//! times as short and their curl as large: an octave is divided by s there, and fades out where a finer cell would hold more than half a value of it.

mod means;
mod potential;
mod stretch;
pub mod tile;

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, VectorMut, reborrow, rows, view};
use crate::flow::resample::{Kind, resample};
use crate::flow::warp::carry_coordinate;
use crate::grid::Grid;
use crate::memory::{Arena, Ledger, Pool, Sharing, TooSmall};
use crate::real::Real;
use potential::{Texture, speed};

/// Steps after which a set of coordinates begins anew.
pub const PERIOD: usize = 20;
/// Octaves at most.
pub const MOST_OCTAVES: usize = 3;

/// How much turbulence, and which.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turbulence {
    /// a: 1 goes on as the spectrum does.
    pub strength: f64,
    /// Which noise.
    pub seed: u64,
}

/// The weights of both sets of coordinates at a step.
#[must_use]
pub fn weights(step: usize) -> [f64; 2] {
    let half = PERIOD / 2;
    let [one, other] = [0, half].map(|late| {
        let age = (step + late) % PERIOD;
        1.0 - age.abs_diff(half) as f64 / half as f64
    });
    let size = libm::sqrt(one * one + other * other);
    [one / size, other / size]
}

/// Where the energy is computed.
struct Energy<'p, T> {
    energy: &'p mut [T],
    own: [&'p mut [T]; means::FIELDS],
    work: [&'p mut [T]; 2],
}

/// Where the noise is computed.
struct Noise<'p, T> {
    psi: VectorMut<'p, T>,
    stretch: [&'p mut [T]; 2],
    scratch: &'p mut [T],
}

/// The noise of a flow on a grid, and the coordinates that ride on it.
#[derive(Debug)]
pub struct Detail<'m, T> {
    /// The captured grid, in cells.
    grid: Grid,
    doublings: usize,
    given: Turbulence,
    tile: &'m mut [T],
    drift: [VectorMut<'m, T>; 2],
    step: usize,
}

impl<'m, T: Real> Detail<'m, T> {
    /// One without buffers, of a flow on `captured` that goes to cells halved so often.
    #[must_use]
    pub fn new(captured: &Grid, doublings: usize, given: Turbulence) -> Self {
        Self {
            grid: captured.closed().of_cells(captured.closed().n),
            doublings,
            given,
            tile: &mut [],
            drift: Default::default(),
            step: 0,
        }
    }

    /// Takes what is kept from step to step.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn layout(&mut self, arena: &mut Arena<'m>) -> Result<(), TooSmall> {
        self.tile = arena.take("tile of noise", tile::len(self.grid.dims))?;
        for drift in &mut self.drift {
            *drift = arena.take_vector("texture coordinates", self.grid.dims, self.grid.cells())?;
        }
        Ok(())
    }

    /// What its phases take of a pool each, one after the other.
    pub fn measure(&self, fine: &Grid, threads: usize, ledger: &mut Ledger) {
        self.of_noise(&mut Pool::measuring(ledger));
        self.of_amplitude(fine, &mut Pool::measuring(ledger));
        self.of_potential(fine, threads, &mut Pool::measuring(ledger));
        self.of_carrying(&mut Pool::measuring(ledger));
    }

    fn of_noise<'p>(&self, pool: &mut Pool<'p, T>) -> [&'p mut [T]; tile::FIELDS] {
        let len = tile::len(self.grid.dims);
        pool.line("noise", |pool| {
            [(); tile::FIELDS].map(|()| pool.take("a tile", len))
        })
    }

    fn of_amplitude<'p>(&self, fine: &Grid, pool: &mut Pool<'p, T>) -> Energy<'p, T> {
        let (coarse, cells) = (self.grid.cells(), fine.cells());
        pool.group("energy of the finest waves", Sharing::Together, |pool| Energy {
            energy: pool.take("energy", coarse),
            own: pool.line("captured fields", |pool| {
                [(); means::FIELDS].map(|()| pool.take("a field", coarse))
            }),
            work: [(); 2].map(|()| pool.take("a resampling's", cells)),
        })
    }

    fn of_potential<'p>(&self, fine: &Grid, threads: usize, pool: &mut Pool<'p, T>) -> Noise<'p, T> {
        let corners: usize = potential::corners(fine).iter().product();
        let scratch = threads * (self.grid.dims + 1) * self.grid.n[0];
        let cells = self.grid.cells();
        pool.group("potential of the noise", Sharing::Together, |pool| Noise {
            psi: pool.take_vector("potential", potential::components(fine.dims), corners),
            stretch: [(); 2].map(|()| pool.take("stretch", cells)),
            scratch: pool.take("rows", scratch),
        })
    }

    fn of_carrying<'p>(&self, pool: &mut Pool<'p, T>) -> [&'p mut [T]; 3] {
        let cells = self.grid.cells();
        pool.line("coordinates on their way", |pool| {
            [(); 3].map(|()| pool.take("carried", cells))
        })
    }

    /// Fills the tile, and begins both sets of coordinates.
    pub fn begin(&mut self, exec: &dyn Exec, pool: &mut Pool<'_, T>) {
        let work = self.of_noise(pool);
        tile::fill(exec, self.grid.dims, self.given.seed, self.tile, work);
        self.drift
            .iter_mut()
            .flatten()
            .for_each(|component| component.fill(T::ZERO));
        self.step = 0;
    }

    /// `amplitude` = sqrt(2 e) at the cells of `fine`, e resampled by cubics.
    pub fn amplitude(
        &self,
        exec: &dyn Exec,
        v: Vector<'_, T>,
        fine: &Grid,
        amplitude: &mut [T],
        pool: &mut Pool<'_, T>,
    ) {
        let Energy { energy, own, work } = self.of_amplitude(fine, pool);
        means::unresolved(exec, &self.grid, v, energy, own);
        let kind = (Kind::Cells, 1.0);
        resample(exec, [&self.grid, fine], kind, energy, amplitude, work);
        let buffers = RowBuffers::fields([amplitude]);
        for_rows(exec, fine.rows(), buffers, |task| {
            let [out] = task.fields;
            for out in out {
                let twice = *out + *out;
                *out = if twice > T::ZERO { twice.sqrt() } else { T::ZERO };
            }
        });
    }

    /// `v`, a flow on `fine`, gets the noise of the step, as strong as `amplitude` says.
    pub fn add(
        &self,
        exec: &dyn Exec,
        fine: &Grid,
        amplitude: &[T],
        v: &mut VectorMut<'_, T>,
        threads: usize,
        pool: &mut Pool<'_, T>,
    ) {
        let Noise {
            mut psi,
            mut stretch,
            scratch,
        } = self.of_potential(fine, threads, pool);
        for (drift, out) in self.drift.iter().zip(stretch.iter_mut()) {
            stretch::fill(exec, &self.grid, view(drift), out);
        }
        let finer = 1.0 / (1usize << self.doublings) as f64;
        let octaves = self.doublings.min(MOST_OCTAVES);
        let speeds: [f64; MOST_OCTAVES] = core::array::from_fn(speed);
        let texture = Texture {
            grid: &self.grid,
            tile: self.tile,
            drift: self.drift.each_ref().map(view),
            stretch: stretch.each_ref().map(|field| &**field),
            weights: weights(self.step),
            speeds: rows::part(&speeds, 0..octaves),
            finer,
        };
        potential::fill(exec, &texture, fine, reborrow(&mut psi), scratch);
        let s = self.given.strength * speed(1);
        potential::add_curl(exec, fine, (s, finer), (view(&psi), amplitude), v);
    }

    /// Lets the coordinates ride on `v`, which has `h` for a cell, for a step.
    pub fn carry(&mut self, exec: &dyn Exec, v: Vector<'_, T>, h: f64, pool: &mut Pool<'_, T>) {
        let [there, back, out] = self.of_carrying(pool);
        self.step += 1;
        for (set, drift) in self.drift.iter_mut().enumerate() {
            let anew = (self.step + set * PERIOD / 2).is_multiple_of(PERIOD);
            for (axis, drift) in drift.iter_mut().enumerate().take(self.grid.dims) {
                if anew {
                    drift.fill(T::ZERO);
                    continue;
                }
                let work = [&mut *there, &mut *back, &mut *out];
                carry_coordinate(exec, &self.grid, (v, 1.0 / h), (axis, drift), work);
            }
        }
    }
}
