//! The Navier-Stokes problem: run by the core, and its residual in a plain second implementation (section 5).

use super::naive::{Naive, Solid};
use super::random::Random;
use super::{Components, Memory, index, largest, places, slot, slot_of_all, view_mut, zeros};
use thurible_core::exec::ranks::Alone;
use thurible_core::grid::Grid;
use thurible_core::grid::levels::Levels;
use thurible_core::grid::solids::Surfaces;
use thurible_core::memory::Arena;
use thurible_core::memory::{Ledger, Pool};
use thurible_core::nso::damping::LocalDamping;
use thurible_core::nso::level::State;
use thurible_core::nso::surroundings::Surroundings;
use thurible_core::nso::{Bases, Finest, Nso, Setup, SmootherMemory, Split, Workspace};
use thurible_core::{Exec, NsoParams, Real, Space};

/// The unknowns and data of a Navier-Stokes problem, trajectories all but v_0.
#[derive(Clone, Debug)]
pub struct Case<T> {
    pub grid: Grid,
    pub slots: usize,
    pub v: Components<T>,
    pub w: Components<T>,
    /// Pressures of equation c.
    pub p: Vec<T>,
    /// Pressures of equation a.
    pub pbar: Vec<T>,
    /// The velocity before slot 1.
    pub v0: Components<T>,
    pub target: Components<T>,
    /// Which cells are solid, if any are.
    pub solid: Option<Solid>,
}

/// One thread, all lanes, a few planes at a time; tolerance 0, so that only the cap on cycles ends a solve.
pub fn setup(kappa: f64, slots: usize) -> Setup {
    Setup {
        kappa,
        viscosity: 0.0,
        slots,
        threads: 1,
        params: NsoParams {
            tolerance: 0.0,
            ..NsoParams::default()
        },
        damping: LocalDamping::USUAL,
        surroundings: Surroundings::WITH_MASS,
        memory: SmootherMemory {
            lanes: 16,
            split: Split::Planes(2),
        },
        projection_tolerance: 0.0,
    }
}

impl<T: Real> Case<T> {
    /// v = target, everything else 0: how the very first solve begins.
    pub fn towards(grid: &Grid, slots: usize, target: Components<T>) -> Self {
        let cells = || vec![T::ZERO; grid.cells() * slots];
        Case {
            grid: *grid,
            slots,
            v: target.clone(),
            w: zeros(grid, slots),
            p: cells(),
            pbar: cells(),
            v0: zeros(grid, 1),
            target,
            solid: None,
        }
    }

    /// Random numbers everywhere, velocities and forces from -`size` to `size`.
    pub fn random(random: &mut Random, grid: &Grid, slots: usize, size: f64) -> Self {
        let mut faces = |slots: usize| {
            random
                .faces::<T>(grid, slots)
                .map(|c| c.iter().map(|x| T::from_f64(x.to_f64() * size)).collect())
        };
        let (v, w, v0, target) = (faces(slots), faces(slots), faces(1), faces(slots));
        let mut cells = || {
            random
                .cells(grid, slots)
                .iter()
                .map(|x: &T| T::from_f64(x.to_f64() * size * grid.h[0]))
                .collect()
        };
        Case {
            grid: *grid,
            slots,
            v,
            w,
            p: cells(),
            pbar: cells(),
            v0,
            target,
            solid: None,
        }
    }

    /// The same among solid cells, at whose closed faces nothing flows.
    pub fn among(mut self, solid: Option<Solid>) -> Self {
        let naive = Naive::among(&self.grid, solid);
        self.solid = solid;
        for (slots, field) in [
            (self.slots, &mut self.v),
            (self.slots, &mut self.w),
            (self.slots, &mut self.target),
            (1, &mut self.v0),
        ] {
            for (axis, component) in field.iter_mut().enumerate().take(self.grid.dims) {
                for at in places(&self.grid).filter(|&at| naive.wall(at, axis)) {
                    (0..slots).for_each(|k| component[index(&self.grid, slots, k, at)] = T::ZERO);
                }
            }
        }
        self
    }

    /// Calls `work` with the problem as the core solves it.
    pub fn run<S: Space, R>(&mut self, setup: &Setup, work: impl FnOnce(&mut Nso<'_, T, S>) -> R) -> R {
        let (grid, slots) = (self.grid, self.slots);
        let mut memory = Memory::new(1 << 22);
        let mut arena = Arena::new(memory.block());
        let mut levels = Levels::<T>::bare(&grid, 0).with_surfaces(Surfaces {
            obstacles: self.solid.is_some(),
            stick: false,
        });
        levels.fill(&mut arena).unwrap();
        if let Some(solid) = self.solid {
            levels.set_solids(&Alone, |cell| {
                solid(&grid, grid.cell_at(cell / grid.n[0], cell % grid.n[0]))
            });
        }
        let bases = Bases::<T>::carve::<S>(&mut arena, &levels).unwrap();
        let mut ledger = Ledger::new();
        let mut measure = Pool::measuring(&mut ledger);
        Workspace::<T, S>::carve(&levels, &bases, setup, &mut measure);
        let mut elements = vec![T::from_f64(f64::NAN); ledger.elements(T::BYTES)];
        let mut pool = Pool::new(&mut elements);
        let workspace = Workspace::carve(&levels, &bases, setup, &mut pool);
        let mut sums = vec![f64::NAN; grid.rows() * slots.max(2)];
        let mut spare = zeros(&grid, slots);
        let finest = Finest {
            state: State {
                v: view_mut(&mut self.v),
                w: view_mut(&mut self.w),
                p: &mut self.p,
                pbar: &mut self.pbar,
            },
            v0: view_mut(&mut self.v0),
            target: view_mut(&mut self.target),
            lift: Default::default(),
            spare: view_mut(&mut spare),
        };
        let mut nso = Nso::<T, S>::new(&levels, &bases, finest, setup, workspace, &mut sums);
        work(&mut nso)
    }

    /// Residuals before the first and after each of `cycles` V-cycles.
    pub fn residuals<S: Space>(&mut self, exec: &dyn Exec, setup: &Setup, cycles: usize) -> Vec<f64> {
        self.run::<S, _>(setup, |nso| {
            let mut list = vec![nso.residual(exec)];
            for _ in 0..cycles {
                assert!(nso.vcycle(exec, &mut thurible_core::Silent).is_continue());
                list.push(nso.residual(exec));
            }
            list
        })
    }

    /// Slot by slot, in double precision.
    pub fn equations(&self, kappa: f64, viscosity: f64) -> Equations {
        let (grid, slots) = (&self.grid, self.slots);
        let vectors = |v: &Components<T>| {
            (0..slots)
                .map(|k| slot_of_all(grid, slots, k, v))
                .collect::<Vec<_>>()
        };
        let scalars = |p: &[T]| (0..slots).map(|k| slot(grid, slots, k, p)).collect::<Vec<_>>();
        let scaled = |mut v: Vec<Components<f64>>| {
            v.iter_mut().flatten().flatten().for_each(|x| *x *= kappa);
            v
        };
        let nothing = Residual {
            a: scaled(vectors(&self.target)),
            b: vec![vec![0.0; grid.cells()]; slots],
            c: vec![zeros(grid, 1); slots],
            d: vec![vec![0.0; grid.cells()]; slots],
        };
        Equations {
            naive: Naive {
                viscosity,
                ..Naive::among(grid, self.solid)
            },
            kappa,
            v: vectors(&self.v),
            w: vectors(&self.w),
            p: scalars(&self.p),
            pbar: scalars(&self.pbar),
            v0: slot_of_all(grid, 1, 0, &self.v0),
            rhs: nothing,
        }
    }
}

/// Values of the equations a to d in every slot: residuals or right-hand sides.
#[derive(Clone, Debug)]
pub struct Residual {
    /// Equation a: stationarity in the velocity, at faces.
    pub a: Vec<Components<f64>>,
    /// Equation b: divergence of the velocity, at cells.
    pub b: Vec<Vec<f64>>,
    /// Equation c: balance of momentum, at faces.
    pub c: Vec<Components<f64>>,
    /// Equation d: divergence of the force, at cells.
    pub d: Vec<Vec<f64>>,
}

impl Residual {
    /// max |f| with b and d counted `unit` times.
    pub fn norm(&self, unit: f64) -> f64 {
        let momentum = self.a.iter().chain(&self.c).flatten().flatten().copied();
        largest(momentum.chain(self.b.iter().chain(&self.d).flatten().map(|x| unit * x)))
    }
}

/// The problem slot by slot.
pub struct Equations {
    pub naive: Naive,
    /// Penalty over force weight, K / r.
    pub kappa: f64,
    pub v: Vec<Components<f64>>,
    pub w: Vec<Components<f64>>,
    /// Pressures of equation c.
    pub p: Vec<Vec<f64>>,
    /// Pressures of equation a.
    pub pbar: Vec<Vec<f64>>,
    /// The velocity before slot 1.
    pub v0: Components<f64>,
    pub rhs: Residual,
}

impl Equations {
    /// Right-hand side minus left-hand side.
    pub fn residual(&self) -> Residual {
        let (naive, slots) = (&self.naive, self.v.len());
        let mut out = self.rhs.clone();
        for k in 0..slots {
            let (adv, back) = (naive.advection(&self.v[k]), naive.adjoint(&self.v[k], &self.w[k]));
            let (grad_p, grad_pbar) = (naive.gradient(&self.p[k]), naive.gradient(&self.pbar[k]));
            let before = if k == 0 { &self.v0 } else { &self.v[k - 1] };
            for axis in 0..naive.grid.dims {
                for at in places(&naive.grid) {
                    let i = naive.id(at);
                    if naive.wall(at, axis) {
                        (out.a[k][axis][i], out.c[k][axis][i]) = (0.0, 0.0);
                        continue;
                    }
                    let after = if k + 1 < slots {
                        self.w[k + 1][axis][i]
                    } else {
                        0.0
                    };
                    let (v, w) = (self.v[k][axis][i], self.w[k][axis][i]);
                    out.a[k][axis][i] -= self.kappa * v - after + w + back[axis][i] + grad_pbar[axis][i];
                    out.c[k][axis][i] -= v - before[axis][i] + adv[axis][i] - w + grad_p[axis][i];
                }
            }
            for (out, of) in [(&mut out.b[k], &self.v[k]), (&mut out.d[k], &self.w[k])] {
                out.iter_mut()
                    .zip(naive.divergence(of))
                    .for_each(|(out, x)| *out -= x);
            }
        }
        out
    }
}

/// The numbers of slots as a trajectory.
pub fn trajectory<T: Real>(grid: &Grid, slots: &[Vec<f64>]) -> Vec<T> {
    let mut out = vec![T::ZERO; slots.len() * grid.cells()];
    for (k, field) in slots.iter().enumerate() {
        for (at, &x) in places(grid).zip(field) {
            out[index(grid, slots.len(), k, at)] = T::from_f64(x);
        }
    }
    out
}

/// The vectors of slots as a trajectory.
pub fn trajectories<T: Real>(grid: &Grid, slots: &[Components<f64>]) -> Components<T> {
    core::array::from_fn(|a| {
        if a < grid.dims {
            trajectory(grid, &slots.iter().map(|v| v[a].clone()).collect::<Vec<_>>())
        } else {
            Vec::new()
        }
    })
}
