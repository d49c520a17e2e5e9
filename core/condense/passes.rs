//! The pieces of an iteration: energy, gradient, Hessian, basis, direction.

use super::band::{Factor, factorise, row_of};
use super::basis::{Build, Noise};
use super::block::{Pass, turn_of};
use super::condenser::Condenser;
use super::hessian::{Hessian, assemble};
use super::settings::{Block, Update};
use super::small::{Square, product, rotation, times, transposed};
use crate::exec::{Exec, RowBuffers, Slabs, for_rows, for_slabs};
use crate::real::Real;

impl<T: Real, const D: usize> Condenser<'_, T, D> {
    /// E at the state, or at the trial.
    pub(super) fn energy_of(&mut self, exec: &dyn Exec, trial: bool) -> f64 {
        let sums = core::mem::take(&mut self.buffers.sums);
        let free: &[T] = if trial {
            self.buffers.trial
        } else {
            self.buffers.displacement
        };
        let energy = self.body(free).energy(exec, sums);
        self.buffers.sums = sums;
        energy
    }

    /// Makes the gradient.
    pub(super) fn fill_gradient(&mut self, exec: &dyn Exec) {
        let gradient = core::mem::take(&mut self.buffers.gradient);
        let body = self.body(self.buffers.displacement);
        let free = self.topology.free();
        for_slabs(
            exec,
            Slabs::new(free, free, 1),
            RowBuffers::fields([&mut *gradient]),
            |run| {
                let [out] = run.fields;
                for (number, out) in run.rows.zip(out.chunks_exact_mut(D)) {
                    let value = body.gradient(number);
                    out.iter_mut()
                        .zip(value)
                        .for_each(|(to, from)| *to = T::from_f64(from));
                }
            },
        );
        self.buffers.gradient = gradient;
    }

    /// |g| / (V n Y), over dt^2 of an implicit step; max |g| of a rod in parts of what it was at the beginning of the step.
    pub(super) fn residual(&self) -> f64 {
        let gradient = self.buffers.gradient.iter().map(|value| value.to_f64());
        if D == 1 {
            let most = gradient.fold(0.0, |most: f64, value| {
                if value.abs() > most || value.is_nan() {
                    value.abs()
                } else {
                    most
                }
            });
            return if self.first > 0.0 { most / self.first } else { most };
        }
        libm::sqrt(gradient.map(|value| value * value).sum()) / self.scale
    }

    /// Makes the Hessian, or its rows of a colour.
    pub(super) fn fill_hessian(&mut self, exec: &dyn Exec, all: bool, colour: Option<usize>) {
        let values = core::mem::take(&mut self.buffers.hessian);
        assemble(exec, &self.body(self.buffers.displacement), all, colour, values);
        self.buffers.hessian = values;
    }

    pub(super) fn hessian(&self) -> Hessian<'_, T> {
        Hessian {
            topology: &self.topology,
            values: &*self.buffers.hessian,
            dims: D,
        }
    }

    /// Builds the basis, or H0's factor, at the present state.
    pub(super) fn build_here(&mut self, exec: &dyn Exec) {
        self.fill_hessian(exec, false, None);
        let factor = core::mem::take(&mut self.buffers.factor);
        let basis = core::mem::take(&mut self.buffers.basis);
        let build = Build {
            hessian: self.hessian(),
            columns: self.columns(),
            band: self.topology.band(D),
        };
        let noise = Noise {
            sigma: self.params.noise,
            seed: self.params.seed,
            build: self.builds,
        };
        match (self.params.method.keeps_basis(), self.params.block) {
            (false, _) => build.factorise(factor),
            (true, Block::Vertex) => build.run::<D>(exec, factor, basis, noise),
            (true, Block::Scalar) => build.run::<1>(exec, factor, basis, noise),
        }
        (self.buffers.factor, self.buffers.basis) = (factor, basis);
        if self.params.turns() {
            let built = core::mem::take(&mut self.buffers.built);
            self.fill_turns(exec, built, |_, turn| turn);
            self.buffers.built = built;
        }
        self.builds += 1;
    }

    /// Writes a matrix for each free vertex, made of its rotation.
    fn fill_turns(
        &self,
        exec: &dyn Exec,
        out: &mut [T],
        made: impl Fn(usize, Square<D>) -> Square<D> + Sync,
    ) {
        let rows = self.topology.free();
        for_rows(exec, rows, RowBuffers::fields([out]), |task| {
            let [out] = task.fields;
            let vertex = self
                .topology
                .free_vertices()
                .get(task.row)
                .copied()
                .unwrap_or_default();
            let turn = made(task.row, self.turn(vertex as usize));
            for (to, from) in out.iter_mut().zip(turn.as_flattened()) {
                *to = T::from_f64(*from);
            }
        });
    }

    /// R_j at the present state.
    pub(super) fn turn(&self, vertex: usize) -> Square<D> {
        let mean = self.body(self.buffers.displacement).mean(vertex);
        let mut own = [[0.0; D]; D];
        for (to, from) in own.iter_mut().zip(&mean) {
            to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
        }
        rotation(&own)
    }

    /// Finds the direction at the present state, whose gradient there is; <g, d>.
    pub(super) fn find_direction(&mut self, exec: &dyn Exec, method: Update, colour: Option<usize>) -> f64 {
        if method.reads_hessian() {
            // A block of `plain` reads its own row alone, what follows a block those of its members.
            self.fill_hessian(exec, true, colour.filter(|_| method == Update::Plain));
        }
        self.direct(exec, method, colour)
    }

    /// The same by the Hessian that is there.
    pub(super) fn direct(&mut self, exec: &dyn Exec, method: Update, colour: Option<usize>) -> f64 {
        if method != Update::Plain && self.params.turns() {
            let turns = core::mem::take(&mut self.buffers.turns);
            let built = &*self.buffers.built;
            self.fill_turns(exec, turns, |row, turn| {
                product(&turn, &transposed(&turn_of(built, row)))
            });
            self.buffers.turns = turns;
        }
        match method {
            Update::Newton | Update::Chord | Update::Warped => self.solve(method),
            _ => self.pass(exec, method, colour),
        }
        let both = self.buffers.gradient.iter().zip(&*self.buffers.direction);
        both.map(|(g, d)| g.to_f64() * d.to_f64()).sum()
    }

    /// -H^-1 g, -H0^-1 g or -R H0^-1 R^T g.
    fn solve(&mut self, method: Update) {
        let (size, band) = (self.topology.free() * D, self.topology.band(D));
        let factor = core::mem::take(&mut self.buffers.factor);
        if method == Update::Newton {
            let hessian = self.hessian();
            factorise(factor, size, band, |k, row| row_of(&hessian, band, k, row));
        }
        let buffers = &mut self.buffers;
        let warps = method == Update::Warped;
        for (to, from) in buffers.direction.iter_mut().zip(&*buffers.gradient) {
            *to = -*from;
        }
        if warps {
            turn_all::<T, D>(buffers.turns, buffers.direction, true);
        }
        Factor {
            values: &*factor,
            band,
        }
        .solve::<1>(buffers.direction, 0);
        if warps {
            turn_all::<T, D>(buffers.turns, buffers.direction, false);
        }
        buffers.factor = factor;
    }

    /// The moves of all blocks, or of those of a colour.
    fn pass(&mut self, exec: &dyn Exec, method: Update, colour: Option<usize>) {
        let direction = core::mem::take(&mut self.buffers.direction);
        let blocks = core::mem::take(&mut self.buffers.blocks);
        let buffers = &self.buffers;
        let free = self.topology.free();
        let pass = Pass {
            update: method,
            hessian: self.hessian(),
            gradient: &*buffers.gradient,
            basis: &*buffers.basis,
            columns: self.columns(),
            turns: if self.params.turns() { &*buffers.turns } else { &[] },
        };
        let (colours, block) = (self.topology.colour, self.params.block);
        for_slabs(
            exec,
            Slabs::new(free, free, 1),
            RowBuffers::fields([&mut *direction]).with_scratch(&mut *blocks),
            |run| {
                let [out] = run.fields;
                for (number, out) in run.rows.zip(out.chunks_exact_mut(D)) {
                    let own = colours.get(number).copied().unwrap_or_default() as usize;
                    if colour.is_some_and(|colour| colour != own) {
                        out.fill(T::ZERO);
                    } else if block == Block::Vertex {
                        pass.vertex::<D, D>(number, run.scratch, out);
                    } else {
                        pass.vertex::<D, 1>(number, run.scratch, out);
                    }
                }
            },
        );
        (self.buffers.direction, self.buffers.blocks) = (direction, blocks);
    }
}

/// Turns the vectors of a list, or turns them back.
fn turn_all<T: Real, const D: usize>(turns: &[T], list: &mut [T], back: bool) {
    for (number, row) in list.chunks_exact_mut(D).enumerate() {
        let turn: Square<D> = turn_of(turns, number);
        let turn = if back { transposed(&turn) } else { turn };
        let mut old = [0.0; D];
        old.iter_mut()
            .zip(&*row)
            .for_each(|(to, from)| *to = from.to_f64());
        let new = times(&turn, &old);
        row.iter_mut()
            .zip(new)
            .for_each(|(to, from)| *to = T::from_f64(from));
    }
}
