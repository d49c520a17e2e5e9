//! One grid of the nested iteration, in numbers that it shares with all coarser ones.

use super::{Direct, Settings};
use crate::field::trajectory::Shape;
use crate::field::{VectorMut, reborrow};
use crate::force::time_line::{TimeLine, drag};
use crate::grid::levels::{self, Levels, MAX_LEVELS};
use crate::grid::{Grid, Space};
use crate::memory::{Ledger, Pool, Sharing, pooled};
use crate::objective::coarse;
use crate::objective::flow::{self, Evaluation};
use crate::objective::keyframes::Keyframes;
use crate::objective::sweep::{self, densities};
use crate::operators::blur::Metric;
use crate::optimise::lbfgs::{self, Fields, Initial};
use crate::real::Real;
use crate::transport::Stepping;
use core::marker::PhantomData;

/// Numbers that one grid takes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sizes<T> {
    /// Keyframes, rho, v_0 and v; for the finest grid they are lines of the ledger of their own.
    pub data: usize,
    /// Quasi-Newton's fields and the work of an evaluation.
    pub rest: usize,
    number: PhantomData<T>,
}

impl<T: Real> Sizes<T> {
    /// Those of grid `level` on so many threads.
    #[inline(never)]
    pub fn new(settings: &Settings, level: usize, threads: usize) -> Self {
        let grid = grid_of(settings, level);
        let (cells, slots) = (grid.cells(), slots_on(settings, level));
        let vectors = grid.dims * (pooled(cells) + pooled(cells * slots));
        let mut ledger = Ledger::new();
        Self::requirement(&mut ledger, settings, level, threads);
        Self {
            data: pooled(settings.keyframes * cells) + pooled(densities(&grid, slots)) + vectors,
            rest: ledger.bytes().map_or(usize::MAX / 2, |bytes| bytes / T::BYTES),
            number: PhantomData,
        }
    }

    /// All of them.
    pub fn all(&self) -> usize {
        self.data.saturating_add(self.rest)
    }

    /// The ledger lines of `rest`.
    pub fn requirement(ledger: &mut Ledger, settings: &Settings, level: usize, threads: usize) {
        let (grid, setup) = (
            grid_of(settings, level),
            carrier_setup(settings, level, 0, threads),
        );
        ledger.group("quasi-Newton", Sharing::Together, |ledger| {
            ledger.line(
                "gradients, directions and pairs",
                lbfgs::numbers(&grid, setup.slots, settings.history),
                T::BYTES,
            );
            Evaluation::<T>::requirement(ledger, &grid, &setup);
        });
    }
}

fn grid_of(settings: &Settings, level: usize) -> Grid {
    levels::hierarchy(&settings.grid)[level]
}

/// Steps of the scene that are one on grid `level`.
pub(super) fn stride(settings: &Settings, level: usize) -> u32 {
    if level > 0 && settings.halves_time { 2 } else { 1 }
}

/// Slots on grid `level`.
pub(super) fn slots_on(settings: &Settings, level: usize) -> usize {
    (settings.carrier.slots + 1) / stride(settings, level) as usize - 1
}

/// K, nu and r in the scaled numbers of grid `level`: with steps `s` times as long, v of a step is s times as large, w s^2 times, and
/// there are s times fewer of each.
fn weights(settings: &Settings, level: usize) -> [f64; 3] {
    let s = f64::from(stride(settings, level));
    [
        super::STIFFNESS / (s * s),
        settings.viscosity * s,
        settings.force_weight / (s * s * s),
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
fn carrier_setup(settings: &Settings, level: usize, levels: usize, threads: usize) -> sweep::Setup {
    let between = (1..levels.saturating_sub(1)).contains(&level);
    let metric = Metric {
        filters: settings.carrier.metric.filters.saturating_sub(level),
        identity: if between { IDENTITY_BETWEEN } else { 1.0 },
    };
    sweep::Setup {
        slots: slots_on(settings, level),
        metric,
        stepping: search_stepping(settings.carrier.stepping, level),
        threads,
        ..settings.carrier
    }
}

/// Numbers of the finest grid's rest in which one iteration finds what another left, on whichever grid: the data of the grids down
/// to that one and quasi-Newton's fields there. Behind them is work.
pub(super) fn live<T: Real>(settings: &Settings) -> usize {
    let fields = |level: usize| {
        lbfgs::numbers(
            &grid_of(settings, level),
            slots_on(settings, level),
            settings.history,
        )
    };
    let coarser = (1..Threads::new::<T>(settings).len()).scan(0, |above, level| {
        *above += Sizes::<T>::new(settings, level, 1).data;
        Some(*above + fields(level))
    });
    coarser.fold(fields(0), usize::max)
}

/// Threads on each grid that takes part, finest first.
#[derive(Clone, Debug)]
pub(super) struct Threads(heapless::Vec<usize, MAX_LEVELS>);

impl Threads {
    /// Which grids take part follows from the problem and the pairs alone; on how many threads, from what is planned.
    pub fn new<T: Real>(settings: &Settings) -> Self {
        let grids = levels::hierarchy(&settings.grid);
        let mut list = heapless::Vec::new();
        let _ = list.push(settings.carrier.threads);
        for (level, pair) in grids.windows(2).enumerate() {
            let (room, alone) = (
                Sizes::<T>::new(settings, level, 1).rest,
                Sizes::<T>::new(settings, level + 1, 1).all(),
            );
            if !(settings.params.nested && coarse::begins_on(&pair[0], &pair[1]) && alone <= room) {
                break;
            }
            let room = Sizes::<T>::new(settings, level, list[level]).rest;
            let fewer = coarse::halvings(list[level]);
            let threads = fewer
                .into_iter()
                .find(|&threads| Sizes::<T>::new(settings, level + 1, threads).all() <= room)
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
    /// Carved from the rest of the finer grid.
    pub fn carve(grid: &Grid, slots: usize, keyframes: usize, rest: &'a mut [T]) -> Self {
        let cells = grid.cells();
        let mut pool = Pool::new(rest);
        let (densities, rho) = (pool.take(keyframes * cells), pool.take(densities(grid, slots)));
        let (initial, v) = (
            pool.take_vector(grid.dims, cells),
            pool.take_vector(grid.dims, cells * slots),
        );
        Self {
            initial,
            rho,
            v,
            densities,
            rest: pool.into_rest(),
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
            slots: setup.carrier.slots,
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
    settings: &Settings,
    finest: LevelMut<'a, T>,
    level: usize,
) -> LevelMut<'a, T> {
    let keyframes = finest.keyframes;
    let grids = levels.grids.iter().enumerate().skip(1).take(level);
    grids.fold(finest, |at, (level, grid)| {
        NextMut::carve(grid, slots_on(settings, level), keyframes.count(), at.rest)
            .complete(&keyframes, stride(settings, level))
    })
}

impl<'m, T: Real, S: Space> Direct<'m, T, S> {
    /// The hierarchy, and the finest grid with everything else in its rest.
    pub(super) fn finest<'a>(
        &'a mut self,
        keyframes: &Keyframes<'a, T>,
    ) -> (&'a Levels<'m, T>, LevelMut<'a, T>) {
        let keyframes = *keyframes;
        let at = LevelMut {
            initial: reborrow(&mut self.initial),
            rho: self.rho,
            v: reborrow(&mut self.v),
            keyframes,
            rest: self.rest,
        };
        (&self.levels, at)
    }

    /// Grid `level`, to iterate on.
    pub(super) fn work<'a>(&'a mut self, level: usize, keyframes: &Keyframes<'a, T>) -> Work<'a, 'm, T> {
        let (slots, history) = (slots_on(&self.settings, level), self.settings.history);
        let (count, threads) = (self.threads.len(), self.threads.on(level));
        let Self {
            levels,
            v,
            initial,
            rho,
            rest,
            pivots,
            sums,
            settings,
            ..
        } = self;
        let keyframes = *keyframes;
        let finest = LevelMut {
            initial: reborrow(initial),
            rho,
            v: reborrow(v),
            keyframes,
            rest,
        };
        let LevelMut {
            initial: [x, y, z],
            rho,
            v,
            keyframes,
            rest,
        } = down(levels, settings, finest, level);
        let mut pool = Pool::new(rest);
        let fields = lbfgs::take(&levels.grids[level], slots, history, &mut pool);
        let (initial, region) = ([&*x, &*y, &*z], pool.into_rest());
        let ([stiffness, viscosity, force_weight], projection_tolerance) =
            (weights(settings, level), settings.projection_tolerance);
        let setup = flow::Setup {
            carrier: carrier_setup(settings, level, count, threads),
            viscosity,
            force_weight,
            projection_tolerance,
        };
        let evaluation = Evaluation {
            levels,
            level,
            setup,
            initial,
            rho,
            keyframes,
            region,
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
