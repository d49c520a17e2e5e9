//! How many elements each grid takes, and which grids take part.

use super::level::NextMut;
use super::setup::{Setup, slots_on, sweep_setup};
use crate::grid::levels::{Levels, MAX_LEVELS};
use crate::memory::{Ledger, Pool, Sharing};
use crate::objective::coarse;
use crate::objective::flow::{self, Evaluation};
use crate::optimise::quasi_newton;
use crate::real::Real;
use core::marker::PhantomData;

/// Elements that one grid takes.
#[derive(Clone, Copy, Debug)]
pub struct Sizes<T> {
    /// Keyframes, rho, v_0 and v; for the finest grid they are buffers of their own.
    pub data: usize,
    /// Quasi-Newton's fields and the work of an evaluation.
    pub rest: usize,
    element: PhantomData<T>,
}

impl<T: Real> Sizes<T> {
    /// Those of grid `level` on `threads` threads.
    #[inline(never)]
    pub fn new(levels: &Levels<'_, T>, setup: &Setup, level: usize, threads: usize) -> Self {
        Self {
            data: elements::<T>(|ledger| {
                let mut pool = Pool::<T>::measuring(ledger);
                NextMut::carve(
                    &levels.grids[level],
                    slots_on(setup, level),
                    setup.fields,
                    &mut pool,
                );
            }),
            rest: elements::<T>(|ledger| Self::measure(levels, setup, level, threads, ledger)),
            element: PhantomData,
        }
    }

    /// All of them.
    pub fn all(&self) -> usize {
        self.with(0)
    }

    /// All of them, where coarser grids need so many of the rest.
    pub fn with(&self, coarser: usize) -> usize {
        self.data.saturating_add(self.rest.max(coarser))
    }

    /// What `rest` is made of.
    pub fn measure(levels: &Levels<'_, T>, setup: &Setup, level: usize, threads: usize, ledger: &mut Ledger) {
        let mut pool = Pool::measuring(ledger);
        pool.group("quasi-Newton", Sharing::Together, |pool| {
            let sweep = sweep_setup(setup, level, 0, threads);
            let grid = &levels.grids[level];
            quasi_newton::fields::take(grid, sweep.slots, setup.history, pool);
            let flow = flow::Setup { sweep, ..setup.flow };
            flow::priced(grid, &flow, pool);
            Evaluation::measure(levels, level, &sweep, pool);
        });
    }
}

/// Elements of what `measure` writes into a ledger.
fn elements<T: Real>(measure: impl FnOnce(&mut Ledger)) -> usize {
    let mut ledger = Ledger::new();
    measure(&mut ledger);
    ledger.elements(T::BYTES)
}

/// Threads on each grid that takes part, finest first.
#[derive(Clone, Debug)]
pub struct Threads(heapless::Vec<usize, MAX_LEVELS>);

impl Threads {
    /// Which grids take part follows from the problem and the pairs alone; on how many threads, from what is planned.
    pub fn new<T: Real>(levels: &Levels<'_, T>, setup: &Setup) -> Self {
        let count = if levels.finest.is_part() {
            taking_part(&whole(levels, setup), setup)
        } else {
            taking_part(levels, setup)
        };
        let mut list = heapless::Vec::new();
        let mut threads = setup.flow.sweep.threads;
        let _ = list.push(threads);
        for level in 1..count {
            let size = |level: usize, threads: usize| Sizes::<T>::new(levels, setup, level, threads);
            let coarser = coarser(levels, setup, count, level);
            let room = size(level - 1, threads).rest.max(size(level, 1).with(coarser));
            threads = coarse::halvings(threads)
                .find(|&threads| size(level, threads).with(coarser) <= room)
                .unwrap_or(1);
            let _ = list.push(threads);
        }
        Self(list)
    }

    /// Grids that take part.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Threads on grid `level`.
    pub fn on(&self, level: usize) -> usize {
        self.0[level]
    }
}

/// The same grids where one program has all of each. They take much of a stack, and are gone when they are counted.
#[inline(never)]
fn whole<T: Real>(levels: &Levels<'_, T>, setup: &Setup) -> Levels<'static, T> {
    Levels::bare(&levels.finest.whole(), levels.filters()).with_surfaces(setup.flow.sweep.surfaces)
}

/// Grids that take part where one program has all of each: the next one has room in the work of the one before.
fn taking_part<T: Real>(levels: &Levels<'_, T>, setup: &Setup) -> usize {
    let size = |level: usize| Sizes::<T>::new(levels, setup, level, 1);
    let pairs = levels.grids.windows(2).enumerate();
    let coarser = pairs.take_while(|(level, pair)| {
        setup.nested && coarse::begins_on(&pair[0], &pair[1]) && size(level + 1).all() <= size(*level).rest
    });
    1 + coarser.count()
}

/// Elements of the rest of grid `level` that the `count` grids after it need, on one thread each: none after the last.
pub fn coarser<T: Real>(levels: &Levels<'_, T>, setup: &Setup, count: usize, level: usize) -> usize {
    (level + 1..count).rev().fold(0, |coarser, level| {
        Sizes::<T>::new(levels, setup, level, 1).with(coarser)
    })
}
