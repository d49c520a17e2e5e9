//! One grid of the nested iteration, in numbers that it shares with all coarser ones.

use super::{Direct, Setup};
use crate::field::trajectory::Shape;
use crate::field::{VectorMut, reborrow};
use crate::force::time_line::{TimeLine, drag};
use crate::grid::levels::{Levels, MAX_LEVELS};
use crate::grid::{Grid, Space};
use crate::memory::{Ledger, Pool, Sharing};
use crate::method::animation::Animation;
use crate::objective::coarse;
use crate::objective::flow::{self, Evaluation};
use crate::objective::keyframes::Keyframes;
use crate::objective::sweep::{self, densities};
use crate::operators::blur::Metric;
use crate::optimise::quasi_newton;
use crate::optimise::quasi_newton::fields::{Fields, Initial};
use crate::real::Real;
use crate::transport::Stepping;
use core::marker::PhantomData;

/// Elements that one grid takes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sizes<T> {
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
                    setup.keyframes,
                    &mut pool,
                );
            }),
            rest: elements::<T>(|ledger| Self::measure(levels, setup, level, threads, ledger)),
            element: PhantomData,
        }
    }

    /// All of them.
    pub fn all(&self) -> usize {
        self.data.saturating_add(self.rest)
    }

    /// What `rest` is made of.
    pub fn measure(levels: &Levels<'_, T>, setup: &Setup, level: usize, threads: usize, ledger: &mut Ledger) {
        let mut pool = Pool::measuring(ledger);
        pool.group("quasi-Newton", Sharing::Together, |pool| {
            let sweep = sweep_setup(setup, level, 0, threads);
            quasi_newton::fields::take(&levels.grids[level], sweep.slots, setup.history, pool);
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

/// Steps of the scene that are one on grid `level`.
pub(super) fn stride(setup: &Setup, level: usize) -> u32 {
    if level > 0 && setup.halves_time { 2 } else { 1 }
}

/// Slots on grid `level`.
pub(super) fn slots_on(setup: &Setup, level: usize) -> usize {
    (setup.flow.sweep.slots + 1) / stride(setup, level) as usize - 1
}

/// K, nu and r in the scaled numbers of grid `level`: with steps `s` times as long, v of a step is s times as large, w s^2 times, and
/// there are s times fewer of each.
fn weights(setup: &Setup, level: usize) -> [f64; 3] {
    let s = f64::from(stride(setup, level));
    [
        super::STIFFNESS / (s * s),
        setup.flow.viscosity * s,
        setup.flow.force_weight / (s * s * s),
    ]
}

/// Weight of e in the metric on the grids between the coarsest and the finest. What those grids cannot resolve would make them
/// tear the smoke's edge, and the finest grid would inherit it; the coarsest needs the whole metric, to move far smoke at all.
const IDENTITY_BETWEEN: f64 = 0.25;

/// Where the search cuts the series of transport, on the finest grid and on those that it starts from: at so many times the cut
/// of the result, and at no more than this part of max rho_0. A minimum moves by the square of what that leaves out; but J goes in
/// steps of it, which end a search whose tolerance is small, as it is on the coarser grids.
const SEARCH_CUT: [(f64, f64); 2] = [(1e2, 1e-3), (1e1, 1e-4)];

/// Courant number of the search's sub-steps at most: fewer of them need fewer terms in all. Terms grow before they fall, to e^7.5 at
/// worst, which single precision holds to 1e-4 of max rho_0; twenty of them leave 7.5^20 / 20! = 0.13 of what could be worst.
const SEARCH_COURANT: f64 = 3.0;

/// Transport of the search on grid `level` for that of the result.
fn search_stepping(result: Stepping, level: usize) -> Stepping {
    let (times, most) = SEARCH_CUT[usize::from(level > 0)];
    Stepping {
        tolerance: result.tolerance.max(most.min(times * result.tolerance)),
        courant: SEARCH_COURANT,
        ..result
    }
}

/// Transport and metric of the search on grid `level` of `levels`.
fn sweep_setup(setup: &Setup, level: usize, levels: usize, threads: usize) -> sweep::Setup {
    let between = (1..levels.saturating_sub(1)).contains(&level);
    let metric = Metric {
        filters: setup.flow.sweep.metric.filters.saturating_sub(level),
        identity: if between { IDENTITY_BETWEEN } else { 1.0 },
    };
    sweep::Setup {
        slots: slots_on(setup, level),
        metric,
        stepping: search_stepping(setup.flow.sweep.stepping, level),
        threads,
        ..setup.flow.sweep
    }
}

/// Elements of the finest grid's rest in which one iteration finds what the one before left, on whichever grid that is: the data of
/// the grids down to it, and quasi-Newton's fields on it. Behind them is work.
pub(super) fn kept<T: Real>(levels: &Levels<'_, T>, setup: &Setup, threads: &Threads) -> usize {
    let fields = |level: usize| {
        elements::<T>(|ledger| {
            let mut pool = Pool::<T>::measuring(ledger);
            quasi_newton::fields::take(
                &levels.grids[level],
                slots_on(setup, level),
                setup.history,
                &mut pool,
            );
        })
    };
    let coarser = (1..threads.len()).scan(0, |above, level| {
        *above += Sizes::<T>::new(levels, setup, level, 1).data;
        Some(*above + fields(level))
    });
    coarser.fold(fields(0), usize::max)
}

/// Threads on each grid that takes part, finest first.
#[derive(Clone, Debug)]
pub(super) struct Threads(heapless::Vec<usize, MAX_LEVELS>);

impl Threads {
    /// Which grids take part follows from the problem and the pairs alone; on how many threads, from what is planned.
    pub fn new<T: Real>(levels: &Levels<'_, T>, setup: &Setup) -> Self {
        let size = |level: usize, threads: usize| Sizes::<T>::new(levels, setup, level, threads);
        let mut list = heapless::Vec::new();
        let mut threads = setup.flow.sweep.threads;
        let _ = list.push(threads);
        for (level, pair) in levels.grids.windows(2).enumerate() {
            let fits = size(level + 1, 1).all() <= size(level, 1).rest;
            if !(setup.nested && coarse::begins_on(&pair[0], &pair[1]) && fits) {
                break;
            }
            let room = size(level, threads).rest;
            threads = coarse::halvings(threads)
                .find(|&threads| size(level + 1, threads).all() <= room)
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

/// The data of one grid, and the numbers that its work or the coarser grids use.
pub(super) struct LevelMut<'a, T> {
    pub initial: VectorMut<'a, T>,
    pub rho: &'a mut [T],
    pub v: VectorMut<'a, T>,
    pub keyframes: Keyframes<'a, T>,
    pub rest: &'a mut [T],
}

/// A coarser grid before its keyframes are there.
pub(super) struct NextMut<'a, T> {
    pub initial: VectorMut<'a, T>,
    pub rho: &'a mut [T],
    pub v: VectorMut<'a, T>,
    pub densities: &'a mut [T],
    pub rest: &'a mut [T],
}

impl<'a, T: Real> NextMut<'a, T> {
    /// The data of a coarser grid, all but what is left of the pool.
    pub fn carve(grid: &Grid, slots: usize, keyframes: usize, pool: &mut Pool<'a, T>) -> Self {
        let cells = grid.cells();
        Self {
            densities: pool.take("keyframe densities", keyframes * cells),
            rho: pool.take("densities", densities(grid, slots)),
            initial: pool.take_vector("given velocity", grid.dims, cells),
            v: pool.take_vector("velocity", grid.dims, cells * slots),
            rest: &mut [],
        }
    }

    /// The same in the rest of the finer grid.
    pub fn within(grid: &Grid, slots: usize, keyframes: usize, rest: &'a mut [T]) -> Self {
        let mut pool = Pool::new(rest);
        let next = Self::carve(grid, slots, keyframes, &mut pool);
        Self {
            rest: pool.into_rest(),
            ..next
        }
    }

    /// With its keyframes, at the steps of those on another grid.
    pub fn complete(self, keyframes: &Keyframes<'a, T>, stride: u32) -> LevelMut<'a, T> {
        LevelMut {
            initial: self.initial,
            rho: self.rho,
            v: self.v,
            keyframes: keyframes.coarse(stride, self.densities),
            rest: self.rest,
        }
    }
}

/// One grid with all that an iteration on it uses.
pub(super) struct Work<'a, 'm, T> {
    pub evaluation: Evaluation<'a, 'm, T>,
    pub v: VectorMut<'a, T>,
    pub fields: Fields<'a, T>,
    pub line: TimeLine<'a>,
}

impl<'a, T> Work<'a, '_, T> {
    /// Where its trajectories live.
    pub fn shape(&self) -> Shape<'a> {
        let Evaluation {
            levels, level, setup, ..
        } = &self.evaluation;
        Shape {
            grid: &levels.grids[*level],
            slots: setup.sweep.slots,
        }
    }

    /// The first inverse Hessian (K + r S)^-1.
    pub fn initial(&self) -> Initial<'a> {
        Initial {
            line: Some(self.line),
            scale: 1.0 / self.evaluation.setup.force_weight,
        }
    }
}

/// Grid `level` from the finest one, all in between carved one in the rest of the other.
pub(super) fn down<'a, T: Real>(
    levels: &Levels<'_, T>,
    setup: &Setup,
    finest: LevelMut<'a, T>,
    level: usize,
) -> LevelMut<'a, T> {
    let keyframes = finest.keyframes;
    let grids = levels.grids.iter().enumerate().skip(1).take(level);
    grids.fold(finest, |at, (level, grid)| {
        NextMut::within(grid, slots_on(setup, level), keyframes.count(), at.rest)
            .complete(&keyframes, stride(setup, level))
    })
}

impl<'m, T: Real, S: Space> Direct<'m, T, S> {
    /// The hierarchy, and the finest grid with everything else in its rest.
    pub(super) fn finest<'a>(
        &'a mut self,
        keyframes: &Keyframes<'a, T>,
    ) -> (&'a Levels<'m, T>, LevelMut<'a, T>) {
        let keyframes = *keyframes;
        let Animation {
            levels,
            initial,
            rho,
            v,
            ..
        } = &mut self.animation;
        let at = LevelMut {
            initial: reborrow(initial),
            rho,
            v: reborrow(v),
            keyframes,
            rest: self.rest,
        };
        (levels, at)
    }

    /// Grid `level`, to iterate on.
    pub(super) fn work<'a>(&'a mut self, level: usize, keyframes: &Keyframes<'a, T>) -> Work<'a, 'm, T> {
        let (count, threads) = (self.threads.len(), self.threads.on(level));
        let Self {
            animation,
            rest,
            pivots,
            setup,
            ..
        } = self;
        let Animation {
            levels,
            v,
            initial,
            rho,
            sums,
            ..
        } = animation;
        let finest = LevelMut {
            initial: reborrow(initial),
            rho,
            v: reborrow(v),
            keyframes: *keyframes,
            rest,
        };
        let LevelMut {
            initial: [x, y, z],
            rho,
            v,
            keyframes,
            rest,
        } = down(levels, setup, finest, level);
        let slots = slots_on(setup, level);
        let mut pool = Pool::new(rest);
        let fields = quasi_newton::fields::take(&levels.grids[level], slots, setup.history, &mut pool);
        let [stiffness, viscosity, force_weight] = weights(setup, level);
        let evaluation = Evaluation {
            levels,
            level,
            setup: flow::Setup {
                sweep: sweep_setup(setup, level, count, threads),
                viscosity,
                force_weight,
                ..setup.flow
            },
            initial: [&*x, &*y, &*z],
            rho,
            keyframes,
            region: pool.into_rest(),
            sums,
        };
        let line = TimeLine::new(
            stiffness / force_weight,
            drag(&levels.grids[level], viscosity),
            &mut pivots[..slots],
        );
        Work {
            evaluation,
            v,
            fields,
            line,
        }
    }
}
