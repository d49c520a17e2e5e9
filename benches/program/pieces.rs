//! The transport and the projection alone, in f32 on synthetic flows.

use super::flow;
use super::prepared::{in_block, no_memory};
use thurible::exit::Failure;
use thurible_core::grid::Grid;
use thurible_core::grid::levels::Levels;
use thurible_core::memory::Arena;
use thurible_core::memory::{Ledger, Pool};
use thurible_core::operators::blur::{Blur, Metric};
use thurible_core::poisson::Projection;
use thurible_core::transport::{Flow, Transport};
use thurible_core::{Advection, Boundary, Exec, Scheme, Space};

/// The Courant number of the flows: one sub-step a step.
const COURANT: f64 = 0.999;

/// A box with walls and how many slots its trajectories have.
#[derive(Clone, Debug)]
pub struct Trajectories {
    /// The grid.
    pub grid: Grid,
    /// Slots N - 1.
    pub slots: usize,
}

/// The fields that a [`Transport`] reads and writes.
pub struct Carried<'a> {
    /// The velocities.
    pub flow: Flow<'a, f32>,
    /// rho_0 .. rho_N, the first of which is given.
    pub rho: &'a mut [f32],
    /// Sums of rows.
    pub sums: &'a mut [f64],
}

impl Trajectories {
    /// Those of a box.
    pub fn new(cells: &[usize], slots: usize) -> Self {
        Self {
            grid: Grid::new(cells, &vec![Boundary::Wall; cells.len()]),
            slots,
        }
    }

    /// Hands a transport, a flow that is nowhere faster than one cell a step, and room for all densities to `work`.
    pub fn transport<S: Space, R>(
        &self,
        exec: &dyn Exec,
        scheme: Scheme,
        work: impl FnOnce(&mut Transport<'_, f32>, Carried<'_>) -> R,
    ) -> R {
        let grid = &self.grid;
        let field = flow::synthetic::<f32, S>(grid, self.slots, COURANT);
        let rest: [Vec<f32>; 3] = core::array::from_fn(|axis| vec![0.0; field[axis].len() / self.slots]);
        let stepping = Advection {
            scheme,
            ..Advection::default()
        }
        .into();
        let mut ledger = Ledger::new();
        Transport::<f32>::carve(
            grid,
            stepping,
            1.0,
            exec.threads(),
            &mut Pool::measuring(&mut ledger),
        );
        let mut memory = vec![0f32; ledger.elements(size_of::<f32>())];
        let mut pool = Pool::new(&mut memory);
        let mut transport = Transport::carve(grid, stepping, 1.0, exec.threads(), &mut pool);
        let mut rho = blob(grid);
        rho.resize((self.slots + 2) * grid.cells(), 0.0);
        let flow = Flow {
            initial: rest.each_ref().map(|component| &component[..]),
            v: field.each_ref().map(|component| &component[..]),
            along: None,
        };
        work(
            &mut transport,
            Carried {
                flow,
                rho: &mut rho,
                sums: &mut vec![0.0; grid.rows()],
            },
        )
    }

    /// Hands a projection, a flow with divergence and sums of rows to `work`.
    ///
    /// # Errors
    /// [`Failure`]: there is no memory for the coarser grids.
    pub fn projection<S: Space, R>(
        &self,
        exec: &dyn Exec,
        work: impl FnOnce(&mut Projection<'_, f32>, &[Vec<f32>; 3], &mut [f64]) -> R,
    ) -> Result<R, Failure> {
        let (grid, slots) = (&self.grid, self.slots);
        self.with_levels(0, |levels| {
            let mut ledger = Ledger::new();
            Projection::<f32>::carve(
                levels,
                0,
                slots,
                exec.threads(),
                &mut Pool::measuring(&mut ledger),
            );
            let mut memory = vec![0f32; ledger.elements(size_of::<f32>())];
            let mut projection =
                Projection::carve(levels, 0, slots, exec.threads(), &mut Pool::new(&mut memory));
            work(
                &mut projection,
                &divergent::<S>(grid, slots),
                &mut vec![0.0; 2 * grid.rows()],
            )
        })
    }

    /// Hands the metric of `filters` filters and a field of cells to `work`.
    ///
    /// # Errors
    /// [`Failure`]: there is no memory for the coarser grids.
    pub fn blur<R>(
        &self,
        exec: &dyn Exec,
        filters: usize,
        work: impl FnOnce(&mut Blur<'_, f32>, &[f32]) -> R,
    ) -> Result<R, Failure> {
        self.with_levels(filters, |levels| {
            let mut ledger = Ledger::new();
            let metric = Metric {
                filters,
                identity: 1.0,
            };
            Blur::<f32>::carve(
                levels,
                0,
                metric,
                exec.threads(),
                &mut Pool::measuring(&mut ledger),
            );
            let mut memory = vec![0f32; ledger.elements(size_of::<f32>())];
            work(
                &mut Blur::carve(levels, 0, metric, exec.threads(), &mut Pool::new(&mut memory)),
                &blob(&self.grid),
            )
        })
    }

    fn with_levels<R>(&self, filters: usize, work: impl FnOnce(&Levels<'_, f32>) -> R) -> Result<R, Failure> {
        let mut ledger = Ledger::new();
        let mut measure = Arena::measuring(&mut ledger);
        let _ = Levels::<f32>::carve(&mut measure, &self.grid, filters);
        let bytes = ledger.bytes().unwrap_or(usize::MAX / 2);
        in_block(bytes, |block| {
            Ok(work(
                &Levels::carve(&mut Arena::new(block), &self.grid, filters).map_err(|_| no_memory(bytes))?,
            ))
        })
    }
}

/// A smooth blob in the middle.
fn blob(grid: &Grid) -> Vec<f32> {
    let [nx, ny, nz] = grid.n;
    let away = |i: usize, n: usize| ((i as f64 + 0.5) / n as f64 - 0.5) * if n == 1 { 0.0 } else { 6.0 };
    let value = |x, y, z| (-(away(x, nx).powi(2) + away(y, ny).powi(2) + away(z, nz).powi(2))).exp() as f32;
    (0..nz)
        .flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| value(x, y, z))))
        .collect()
}

/// A smooth flow with every component scaled differently, so that it is not free of divergence.
fn divergent<S: Space>(grid: &Grid, slots: usize) -> [Vec<f32>; 3] {
    let mut v = flow::synthetic::<f32, S>(grid, slots, 1.0);
    for (component, scale) in v.iter_mut().zip([1.0, 0.5, 0.25]) {
        component.iter_mut().for_each(|x| *x *= scale);
    }
    v
}
