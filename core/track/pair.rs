//! One pair of frames, and what is said of it.

use super::Tracker;
use crate::exec::Exec;
use crate::field::trajectory::{Shape, add};
use crate::field::{Vector, rows, sums, view};
use crate::flow::level::Terms;
use crate::flow::pyramid::{Efforts, Search};
use crate::flow::warp::{Warp, largest, stepping};
use crate::grid::{Grid, Space};
use crate::memory::Pool;
use crate::observe::Observer;
use crate::real::Real;
use crate::solver::FileLayout;
use crate::transport::{Flow, Stop, Transport};

/// What a pair hands out, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// P_k.
    Predicted,
    /// What was added to it.
    Correction,
    /// v_k.
    Velocity,
    /// u_{k-1}, from v_{k-1} to v_k, where the choices ask for forces: of every pair but the first, and one before which frames were passed over.
    Force,
}

/// A flow that is handed out.
#[derive(Clone, Copy, Debug)]
pub struct Faces<'a, T> {
    pub(super) grid: &'a Grid,
    pub(super) v: Vector<'a, T>,
    pub(super) unit: f64,
}

impl<T: Real> Faces<'_, T> {
    /// The values of the component along an axis in the layout of a file: one more than cells along a wall axis.
    #[must_use]
    pub fn len(&self, axis: usize) -> usize {
        FileLayout::new(self.grid, axis).len()
    }

    /// Whether it has no values.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.v[0].is_empty()
    }

    /// The component along an axis, x fastest, in the capture's units. `out` has [`Self::len`] elements.
    pub fn read(&self, axis: usize, out: &mut [T]) {
        let layout = FileLayout::new(self.grid, axis);
        layout.read(self.v[axis], [1, 0], T::from_f64(self.unit), out);
    }
}

/// Who takes what a pair hands out.
pub type Sink<'s, T> = dyn FnMut(Part, Faces<'_, T>) + 's;

/// What is said of a pair.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pair {
    /// The terms of f on the finest grid.
    pub terms: Terms,
    /// Products by A on each grid, finest first.
    pub efforts: Efforts,
    /// Squared distance of phi_{k+1} pulled back by P_k from phi_k, and of that pulled back by v_k.
    pub misfit: [f64; 2],
    /// max |v_k|, in cells a frame.
    pub fastest: f64,
    /// |rho_{k+1} - phi_{k+1}| / |phi_{k+1}| of the first frame carried by the flow; 0 without `readvect`.
    pub readvection: f64,
}

impl<T: Real, S: Space> Tracker<'_, T, S> {
    /// Finds the flow of the last two frames. What it hands out is handed out once.
    ///
    /// # Errors
    /// [`Stop`]: the observer said stop, or a flow was too fast or not finite. Then the pair is not done, nor can it be tried again.
    pub fn step(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        sink: &mut Sink<'_, T>,
    ) -> Result<Pair, Stop> {
        self.keep();
        self.predict(exec, observer)?;
        sink(Part::Predicted, self.faces(view(&self.v)));
        let mut pair = Pair::default();
        self.pull_back(exec)?;
        pair.misfit[0] = self.misfit(exec);
        self.correct(exec, observer, sink, &mut pair)?;
        sink(Part::Velocity, self.faces(view(&self.v)));
        let Self { levels, v, sums, .. } = self;
        pair.fastest = sums::max_abs(exec, &levels.finest, 1, view(v), sums);
        if !(pair.fastest.is_finite() && pair.terms.data.is_finite()) {
            return Err(Stop::TooFast);
        }
        Stop::heard(observer)?;
        self.pull_back(exec)?;
        pair.misfit[1] = self.misfit(exec);
        self.force(exec, observer, sink)?;
        if self.params.readvect {
            pair.readvection = self.carry(exec)?;
        }
        // Frames of which no flow was asked are passed over.
        self.pairs = self.given.saturating_sub(1);
        Ok(pair)
    }

    fn faces<'a>(&'a self, v: Vector<'a, T>) -> Faces<'a, T> {
        Faces {
            grid: self.grid(),
            v,
            unit: self.unit,
        }
    }

    /// The third frame = W(phi_{k+1}, v).
    fn pull_back(&mut self, exec: &dyn Exec) -> Result<(), Stop> {
        let Self {
            levels,
            params,
            frames: [_, second, pulled],
            v,
            sums,
            region,
            ..
        } = self;
        let grid = &levels.finest;
        let warp = Warp::carve(grid, params.flow.warp, params.threads, &mut Pool::new(region));
        warp.apply(exec, second, view(v), pulled, sums)
    }

    /// |the third frame - phi_k|^2.
    fn misfit(&mut self, exec: &dyn Exec) -> f64 {
        let Self {
            levels,
            frames: [first, _, pulled],
            sums,
            ..
        } = self;
        squared_distance(exec, &levels.finest, [first, pulled], sums)
    }

    /// v_k = P_k + the flow between the first frame and the third.
    fn correct(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        sink: &mut Sink<'_, T>,
        pair: &mut Pair,
    ) -> Result<(), Stop> {
        let Self {
            levels,
            params,
            frames: [first, _, pulled],
            v,
            pyramid,
            sums,
            region,
            unit,
            ..
        } = self;
        let mut search = Search {
            levels,
            params: &params.flow,
            threads: params.threads,
            pyramid,
            sums,
        };
        let (level, terms, efforts) = search.find(exec, observer, [first, pulled], region)?;
        (pair.terms, pair.efforts) = (terms, efforts);
        let grid = &levels.finest;
        let faces = Faces {
            grid,
            v: view(&level.flow),
            unit: *unit,
        };
        sink(Part::Correction, faces);
        add(exec, Shape { grid, slots: 1 }, v, 1.0, 1.0, view(&level.flow));
        Ok(())
    }

    /// Carries the first frame on by v_k: how far it is from phi_{k+1} then.
    fn carry(&mut self, exec: &dyn Exec) -> Result<f64, Stop> {
        let Self {
            levels,
            params,
            frames: [_, second, pulled],
            v,
            carried: [carried, before],
            whole,
            emission,
            sums,
            region,
            density_scale,
            ..
        } = self;
        let grid = &levels.finest;
        core::mem::swap(carried, before);
        let most = largest(exec, grid, before, sums);
        let mut transport =
            Transport::one_way(grid, stepping(), most, params.threads, &mut Pool::new(region));
        let flow = Flow {
            initial: view(v),
            v: view(v),
            along: None,
        };
        let loaded = transport.load(exec, &flow, 1, 0, sums);
        loaded.map_err(|_| Stop::TooFast)?;
        transport.forward(exec, before, carried);
        let unit = T::from_f64(1.0 / *density_scale);
        let given = if *emission {
            rows::add_difference(carried, unit, whole, second);
            &**whole
        } else {
            &**second
        };
        // The third frame is free: phi_{k+1} as it was given.
        rows::scale(pulled, unit, given);
        let squares = squared_distance(exec, grid, [carried, pulled], sums);
        let own = squared_size(exec, grid, pulled, sums);
        Ok(libm::sqrt(squares / own.max(f64::MIN_POSITIVE)))
    }
}

fn squared_distance<T: Real>(exec: &dyn Exec, grid: &Grid, [x, y]: [&[T]; 2], sums: &mut [f64]) -> f64 {
    let n = grid.n[0];
    sums::total(exec, grid, sums, |row| {
        let span = row * n..(row + 1) * n;
        rows::sum_square_gaps(rows::part(x, span.clone()), rows::part(y, span))
    })
}

fn squared_size<T: Real>(exec: &dyn Exec, grid: &Grid, x: &[T], sums: &mut [f64]) -> f64 {
    let n = grid.n[0];
    sums::total(exec, grid, sums, |row| {
        rows::sum_squares(rows::part(x, row * n..(row + 1) * n))
    })
}
