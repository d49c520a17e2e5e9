//! A Navier-Stokes problem (NSO) with a synthetic target, alone in its memory.

use super::flow;
use super::prepared::{in_block, no_memory};
use thurible::exit::Failure;
use thurible_core::exec::ranks::Alone;
use thurible_core::field::VectorMut;
use thurible_core::grid::Grid;
use thurible_core::grid::levels::Levels;
use thurible_core::grid::solids::Surfaces;
use thurible_core::memory::{Arena, TooSmall};
use thurible_core::memory::{Ledger, Pool, Sharing};
use thurible_core::nso::damping::LocalDamping;
use thurible_core::nso::level::State;
use thurible_core::nso::surroundings::Surroundings;
use thurible_core::nso::{Bases, Finest, Nso, Setup, SmootherMemory, Workspace};
use thurible_core::poisson::Projection;
use thurible_core::{Boundary, Colours, Exec, Norm, NsoParams, Real, Serial, Silent, Space};

/// Solid cells in the box.
#[derive(Clone, Copy, Debug)]
pub enum Obstacle {
    /// A disc or ball beside the middle, of so many cells of radius.
    Ball(f64),
    /// A plate of one cell across x, from these cells along x on: from one part of the other sides to another.
    Plate(usize, [f64; 2]),
}

impl Obstacle {
    /// Whether the centre of a cell is inside.
    fn has(self, grid: &Grid, cell: [usize; 3]) -> bool {
        match self {
            Self::Ball(radius) => {
                let along = |axis: usize| cell[axis] as f64 + 0.5 - 0.47 * grid.n[axis] as f64;
                (0..grid.dims).map(|axis| along(axis).powi(2)).sum::<f64>() < radius * radius
            }
            Self::Plate(at, [from, to]) => {
                let part = |axis: usize| (cell[axis] as f64 + 0.5) / grid.n[axis] as f64;
                cell[0] == at && (1..grid.dims).all(|axis| (from..to).contains(&part(axis)))
            }
        }
    }
}

/// What is posed.
#[derive(Clone, Debug)]
pub struct Case {
    /// Cells along each axis.
    pub cells: Vec<usize>,
    /// Steps N; there are N - 1 slots.
    pub steps: usize,
    /// K / r in units of dt and length.
    pub kappa: f64,
    /// Largest Courant number of the target.
    pub courant: f64,
    /// The smoother's colours.
    pub colours: Colours,
    /// In which units max |f| is measured.
    pub norm: Norm,
    /// Where the smoother leaves terms out, at kappa = 1.
    pub damping: LocalDamping<f64>,
    /// What the smoother's blocks know beyond their cells.
    pub surroundings: Surroundings<f64>,
    /// What is in the way.
    pub obstacle: Option<Obstacle>,
}

impl Case {
    /// A box with walls, kappa = 1, red-black, all four equations as accelerations.
    pub fn new(cells: &[usize], steps: usize, courant: f64) -> Self {
        Self {
            cells: cells.to_vec(),
            steps,
            kappa: 1.0,
            courant,
            colours: Colours::RedBlack,
            norm: Norm::Scaled,
            damping: LocalDamping::USUAL,
            surroundings: Surroundings::WITH_MASS,
            obstacle: None,
        }
    }

    /// The grid.
    pub fn grid(&self) -> Grid {
        Grid::new(&self.cells, &vec![Boundary::Wall; self.cells.len()])
    }

    fn setup<T: Real, S: Space>(&self, threads: usize) -> Setup {
        let params = NsoParams {
            tolerance: 0.0,
            cycles: 1,
            colours: self.colours,
            norm: self.norm,
            ..NsoParams::default()
        };
        let memory = SmootherMemory::all::<T, S>(&self.grid())
            .next()
            .unwrap_or(SmootherMemory::LEAST);
        Setup {
            kappa: self.kappa,
            viscosity: 0.0,
            slots: self.steps - 1,
            threads,
            params,
            damping: self.damping,
            surroundings: self.surroundings,
            memory,
            projection_tolerance: 0.0,
        }
    }

    /// Bytes of the unknowns v, w, p, pbar of the finest level.
    pub fn state_bytes<T: Real, S: Space>(&self) -> usize {
        2 * (1 + S::DIM) * self.grid().cells() * (self.steps - 1) * T::BYTES
    }

    /// Poses the problem with v = t, w = p = pbar = 0 and hands it to `work`.
    ///
    /// # Errors
    /// [`Failure`]: there is no memory for it.
    pub fn pose<T: Real, S: Space, R>(
        &self,
        exec: &dyn Exec,
        work: impl FnOnce(&mut Nso<'_, T, S>) -> R,
    ) -> Result<R, Failure> {
        let (grid, setup) = (self.grid(), self.setup::<T, S>(exec.threads()));
        let len = grid.cells() * setup.slots;
        let numbers =
            3 * S::DIM * len + 2 * len + S::DIM * grid.cells() + self.pool_len::<T, S>(&grid, &setup);
        let bytes = T::BYTES * numbers + (1 << 23);
        in_block(bytes, |block| {
            self.pose_in(&mut Arena::new(block), &grid, &setup, work)
                .map_err(|TooSmall { .. }| no_memory(bytes))
        })
    }

    fn pose_in<T: Real, S: Space, R>(
        &self,
        arena: &mut Arena<'_>,
        grid: &Grid,
        setup: &Setup,
        work: impl FnOnce(&mut Nso<'_, T, S>) -> R,
    ) -> Result<R, TooSmall> {
        let (cells, len) = (grid.cells(), grid.cells() * setup.slots);
        let mut levels = self.bare(grid);
        levels.fill(arena)?;
        if let Some(obstacle) = self.obstacle {
            levels.set_solids(&Alone, |cell| {
                obstacle.has(grid, grid.cell_at(cell / grid.n[0], cell % grid.n[0]))
            });
        }
        let bases = Bases::<T>::carve::<S>(arena, &levels)?;
        let mut target = flow::synthetic::<T, S>(grid, setup.slots, self.courant);
        let workspace = arena.take("workspace", self.pool_len::<T, S>(grid, setup))?;
        let mut sums = vec![0.0; (2 * grid.rows()).max(grid.rows() * setup.slots)];
        if self.obstacle.is_some() {
            around_solids(&levels, setup, &mut target, self.courant, workspace, &mut sums);
        }
        let v = copied(arena.take_vector("field", S::DIM, len)?, &target);
        let a = copied(arena.take_vector("field", S::DIM, len)?, &target);
        drop(target);
        let state = State {
            v,
            w: arena.take_vector("field", S::DIM, len)?,
            p: arena.take("field", len)?,
            pbar: arena.take("field", len)?,
        };
        let finest = Finest {
            state,
            v0: arena.take_vector("field", S::DIM, cells)?,
            target: a,
            lift: Default::default(),
            spare: Default::default(),
        };
        let space = Workspace::carve(&levels, &bases, setup, &mut Pool::new(workspace));
        Ok(work(&mut Nso::<T, S>::new(
            &levels, &bases, finest, setup, space, &mut sums,
        )))
    }

    fn bare<'m, T: Real>(&self, grid: &Grid) -> Levels<'m, T> {
        Levels::bare(grid, 0).with_surfaces(Surfaces {
            obstacles: self.obstacle.is_some(),
            stick: false,
        })
    }

    fn pool_len<T: Real, S: Space>(&self, grid: &Grid, setup: &Setup) -> usize {
        let levels = self.bare::<T>(grid);
        let bases = Bases::bare(&levels.grids);
        let mut ledger = Ledger::new();
        ledger.group("in turn", Sharing::InTurn, |ledger| {
            Workspace::<T, S>::carve(&levels, &bases, setup, &mut Pool::measuring(ledger));
            Projection::carve(&levels, 0, setup.slots, 1, &mut Pool::measuring(ledger));
        });
        ledger.elements(T::BYTES)
    }
}

/// Projects a flow around the solids, and scales it to this Courant number again.
fn around_solids<T: Real>(
    levels: &Levels<'_, T>,
    setup: &Setup,
    flow: &mut [Vec<T>; 3],
    courant: f64,
    workspace: &mut [T],
    sums: &mut [f64],
) {
    let (grid, slots) = (&levels.finest, setup.slots);
    let mut v = flow.each_mut().map(|component| &mut component[..]);
    let mut pool = Pool::new(workspace);
    let mut projection = Projection::carve(levels, 0, slots, 1, &mut pool);
    let _ = projection.project(&Serial, &mut Silent, &mut v, None, 1e-12, sums);
    let of_slot = |slot: usize| {
        flow::courant_of(grid, |axis, cell| {
            v[axis][flow::index(grid, slots, slot, cell)].to_f64()
        })
    };
    let scale = T::from_f64(courant / (0..slots).map(of_slot).fold(0.0, f64::max));
    v.iter_mut()
        .for_each(|component| component.iter_mut().for_each(|x| *x = *x * scale));
}

fn copied<'m, T: Real>(mut to: VectorMut<'m, T>, from: &[Vec<T>; 3]) -> VectorMut<'m, T> {
    to.iter_mut()
        .zip(from)
        .for_each(|(to, from)| to.copy_from_slice(from));
    to
}
