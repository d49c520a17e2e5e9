//! What every method works on: the densities and velocities of all steps, in one layout.

use super::output::Stored;
use crate::exec::Exec;
use crate::field::{VectorMut, rows, sums, view};
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::memory::{Layout, Ledger, Pool, Sharing, TooSmall};
use crate::objective::flow::{self, Evaluation};
use crate::objective::script::Script;
use crate::objective::sweep::{self, densities};
use crate::observe::Silent;
use crate::poisson::Projection;
use crate::real::Real;
use crate::transport::Flow;

/// Densities and velocities on the finest grid, the hierarchy of grids, and sums over rows.
#[derive(Debug)]
pub struct Animation<'m, T> {
    /// The hierarchy, with its tables.
    pub levels: Levels<'m, T>,
    /// rho_0 .. rho_N, one element for each cell, step by step.
    pub rho: &'m mut [T],
    /// v_1 .. v_{N-1} at faces.
    pub v: VectorMut<'m, T>,
    /// The given velocity v_0 at faces.
    pub initial: VectorMut<'m, T>,
    /// Sums over the rows of the grid.
    pub sums: &'m mut [f64],
    /// Time levels of v: N - 1.
    pub slots: usize,
}

impl<'m, T: Real> Animation<'m, T> {
    /// One without buffers, which [`Self::layout`] counts and carves.
    #[must_use]
    pub fn new(grid: &Grid, setup: &sweep::Setup) -> Self {
        Self {
            levels: Levels::bare(grid, setup.metric.filters).with_surfaces(setup.surfaces),
            rho: &mut [],
            v: Default::default(),
            initial: Default::default(),
            sums: &mut [],
            slots: setup.slots,
        }
    }

    /// Its buffers, with `sums` elements for sums over rows.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn layout(&mut self, layout: &mut Layout<'_, 'm, T>, sums: usize) -> Result<(), TooSmall> {
        let grid = self.levels.finest;
        let cells = grid.cells();
        let parts = grid.parts();
        layout.keep_fields(
            "densities rho_0 .. rho_N",
            &mut self.rho,
            (densities(&grid, self.slots) / cells.max(1), cells),
            parts,
        )?;
        layout.tables(|arena| self.levels.fill(arena))?;
        layout.keep_vector("velocity v", &mut self.v, (grid.dims, cells * self.slots), parts)?;
        layout.keep_vector("given velocity v_0", &mut self.initial, (grid.dims, cells), parts)?;
        layout.work("sums of rows", &mut self.sums, sums)
    }

    /// The finest grid.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.levels.finest
    }

    /// Its velocities, as transport takes them.
    #[must_use]
    pub fn flow(&self) -> Flow<'_, T> {
        Flow {
            initial: view(&self.initial),
            v: view(&self.v),
            along: None,
        }
    }

    /// rho_step.
    #[must_use]
    pub fn density(&self, step: usize) -> Stored<'_, T> {
        Stored::of_cells(self.rho, step, self.grid().cells())
    }

    /// v_step.
    #[must_use]
    pub fn velocity(&self, step: usize) -> Stored<'_, T> {
        match step.checked_sub(1) {
            None => Stored {
                components: view(&self.initial),
                slots: 1,
                slot: 0,
            },
            Some(slot) => Stored {
                components: view(&self.v),
                slots: self.slots,
                slot,
            },
        }
    }

    /// The objective as a function of a flow on the finest grid, with `region` to work in, and v beside it.
    pub fn evaluation<'a>(
        &'a mut self,
        setup: flow::Setup,
        script: &Script<'a, T>,
        region: &'a mut [T],
    ) -> (Evaluation<'a, 'm, T>, &'a mut VectorMut<'m, T>) {
        let (script, mut pool) = (*script, Pool::new(region));
        let [priced, divided] = flow::priced(&self.levels.finest, &setup, &mut pool);
        let evaluation = Evaluation {
            priced,
            divided,
            levels: &self.levels,
            level: 0,
            setup,
            initial: view(&self.initial),
            rho: self.rho,
            script,
            region: pool.into_rest(),
            sums: self.sums,
        };
        (evaluation, &mut self.v)
    }

    /// What [`Self::project_initial`] takes of a region, planned for `threads`.
    pub fn measure_initial(&self, threads: usize, ledger: &mut Ledger) {
        GivenFlow::carve(&self.levels, threads, &mut Pool::measuring(ledger));
    }

    /// Projects v_0 in a `region` that was planned for it; the change relative to max |v_0|.
    pub fn project_initial(&mut self, exec: &dyn Exec, setup: &flow::Setup, region: &mut [T]) -> f64 {
        let mut given = GivenFlow::carve(&self.levels, setup.sweep.threads, &mut Pool::new(region));
        given.project(exec, &mut self.initial, setup.projection_tolerance, self.sums)
    }
}

/// The workspace of projecting v_0.
struct GivenFlow<'a, T> {
    grid: &'a Grid,
    copy: VectorMut<'a, T>,
    projection: Projection<'a, T>,
}

impl<'a, T: Real> GivenFlow<'a, T> {
    fn carve(levels: &'a Levels<'_, T>, threads: usize, pool: &mut Pool<'a, T>) -> Self {
        let grid = &levels.finest;
        pool.group("projection of v_0", Sharing::Together, |pool| Self {
            grid,
            copy: pool.take_vector("copy", grid.dims, grid.cells()),
            projection: Projection::carve(levels, 0, 1, threads, pool),
        })
    }

    /// Projects `given`, a field of one time level; by how much that changed it, relative to its largest element. `sums` holds two
    /// elements a row.
    fn project(
        &mut self,
        exec: &dyn Exec,
        given: &mut VectorMut<'_, T>,
        tolerance: f64,
        sums: &mut [f64],
    ) -> f64 {
        let grid = self.grid;
        let speed = sums::max_abs(exec, grid, 1, view(given), sums);
        if speed == 0.0 {
            return 0.0;
        }
        for (copy, given) in self.copy.iter_mut().zip(&*given) {
            copy.copy_from_slice(given);
        }
        let _ = self
            .projection
            .project(exec, &mut Silent, given, None, tolerance, sums);
        let (copy, given) = (view(&self.copy), view(given));
        let change = sums::largest(exec, grid, sums, |row| {
            rows::largest((0..grid.dims).map(|axis| {
                let [copy, given] = [copy, given].map(|field| sums::row(grid, 1, field[axis], row));
                rows::max_gap(copy, given, T::ONE)
            }))
        });
        change / speed
    }
}
