//! The data term 1/2 sum_i W_i <e_i, C e_i> of a trajectory of densities (paper eq. 5, mathematics section 4), with e_i = rho_i - rho*_i
//! where the keyframe's region is 1, and less of it elsewhere.

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{rows, sums};
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::memory::{Pool, Sharing};
use crate::objective::script::{Script, Wanted};
use crate::operators::blur::{Blur, Metric};
use crate::real::Real;

/// The workspace of the data term.
#[derive(Debug)]
pub struct DataTerm<'a, T> {
    error: &'a mut [T],
    image: &'a mut [T],
    blur: Blur<'a, T>,
}

impl<'a, T: Real> DataTerm<'a, T> {
    /// Takes its workspace from a pool. The grid is number `level` of the hierarchy.
    pub fn carve(
        hierarchy: &'a Levels<'_, T>,
        level: usize,
        metric: Metric,
        threads: usize,
        pool: &mut Pool<'a, T>,
    ) -> Self {
        pool.group("metric of the data term", Sharing::Together, |pool| {
            let blur = Blur::carve(hierarchy, level, metric, threads, pool);
            let cells = blur.grid().cells();
            let [error, image] = pool.line("error and its image", |pool| {
                [(); 2].map(|()| pool.take("field", cells))
            });
            Self { error, image, blur }
        })
    }

    /// A field to work in until the next [`Self::evaluate`].
    pub fn field(&mut self) -> &mut [T] {
        self.error
    }

    /// The grid.
    #[must_use]
    pub fn grid(&self) -> &'a Grid {
        self.blur.grid()
    }

    /// W/2 <e, C e> for e = R (rho - target) with region R and weight W; [`Self::image`] is W R C e afterwards. `sums` holds one number a
    /// row.
    pub fn evaluate(&mut self, exec: &dyn Exec, rho: &[T], wanted: &Wanted<'_, T>, sums: &mut [f64]) -> f64 {
        let grid = self.grid();
        let n = grid.n[0];
        let Wanted {
            target,
            region,
            weight,
        } = *wanted;
        let span = |row: usize| row * n..(row + 1) * n;
        for_rows(
            exec,
            grid.rows(),
            RowBuffers::fields([&mut *self.error]),
            |task| {
                let ([error], span) = (task.fields, span(task.row));
                error.copy_from_slice(&rho[span.clone()]);
                rows::sub(error, &target[span.clone()]);
                if !region.is_empty() {
                    rows::multiply(error, &region[span]);
                }
            },
        );
        self.blur.apply(exec, self.error, self.image);
        let error = &*self.error;
        let sums = &mut sums[..grid.rows()];
        let buffers = RowBuffers::fields([&mut *self.image]).with_sums(&mut *sums);
        for_rows(exec, grid.rows(), buffers, |task| {
            let ([image], span) = (task.fields, span(task.row));
            task.sums[0] = rows::dot(&error[span.clone()], image);
            if weight != 1.0 {
                rows::scale_in_place(image, T::from_f64(weight));
            }
            if !region.is_empty() {
                rows::multiply(image, &region[span]);
            }
        });
        0.5 * weight * sums::add_up(exec, grid, sums)
    }

    /// W R C e of the last [`Self::evaluate`], minus which mu is.
    #[must_use]
    pub fn image(&self) -> &[T] {
        self.image
    }

    /// The data term of a trajectory of densities, of the keyframes at `last` or before.
    pub fn total(
        &mut self,
        exec: &dyn Exec,
        rho: &[T],
        script: &Script<'_, T>,
        last: usize,
        sums: &mut [f64],
    ) -> f64 {
        let cells = self.grid().cells();
        let there = script.steps().enumerate().take_while(|(_, step)| *step <= last);
        there.fold(0.0, |sum, (index, step)| {
            let rho = &rho[step * cells..][..cells];
            sum + self.evaluate(exec, rho, &script.wanted(index, cells), sums)
        })
    }
}
