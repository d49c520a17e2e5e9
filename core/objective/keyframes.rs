//! The keyframes of a problem and the data term that they make (paper eq. 5, mathematics section 4).

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::rows;
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::memory::{Pool, Sharing};
use crate::operators::blur::{Blur, Metric};
use crate::real::Real;
use core::num::NonZeroU32;

/// Targets rho*_i with their steps i.
#[derive(Clone, Copy, Debug)]
pub struct Keyframes<'a, T> {
    /// Steps of the scene, ascending.
    steps: &'a [u32],
    /// How many of them are one step here.
    stride: NonZeroU32,
    /// One field of cells for each.
    densities: &'a [T],
}

impl<'a, T> Keyframes<'a, T> {
    /// Targets one after the other, at `steps` of the scene.
    #[must_use]
    pub fn new(steps: &'a [u32], densities: &'a [T]) -> Self {
        Self {
            steps,
            stride: NonZeroU32::MIN,
            densities,
        }
    }

    /// The same steps with other densities, where `stride` steps of the scene, which divides all of these, are one; 0 counts as 1.
    #[must_use]
    pub fn coarse<'c>(&self, stride: u32, densities: &'c [T]) -> Keyframes<'c, T>
    where
        'a: 'c,
    {
        Keyframes {
            steps: self.steps,
            stride: NonZeroU32::new(stride).unwrap_or(NonZeroU32::MIN),
            densities,
        }
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.steps.len()
    }

    /// Their steps, ascending.
    pub fn steps(&self) -> impl ExactSizeIterator<Item = usize> + use<'_, T> {
        self.steps.iter().map(|step| self.here(*step))
    }

    /// The keyframe at `step`, if there is one.
    #[must_use]
    pub fn at(&self, step: usize) -> Option<usize> {
        self.steps.binary_search_by_key(&step, |at| self.here(*at)).ok()
    }

    /// The first keyframe not before `step`, or the last one, and how many steps the way to it takes from the keyframe before.
    ///
    /// Keyframes at consecutive steps are one stay, as where a shape is held: of each of them the way is that to the first.
    #[must_use]
    pub fn next(&self, step: usize) -> (usize, usize) {
        let before = |at: &u32| self.here(*at) < step;
        let last = self.count().saturating_sub(1);
        let index = self.steps.partition_point(before).min(last);
        let first = self.stay_begins(index);
        let left = first.checked_sub(1).map_or(0, |before| self.step(before));
        (index, self.step(first) - left)
    }

    /// The first keyframe of the stay that `index` is in.
    fn stay_begins(&self, index: usize) -> usize {
        let (mut first, mut end) = (0, index);
        while first < end {
            let middle = usize::midpoint(first, end);
            if self.step(middle) + (index - middle) < self.step(index) {
                first = middle + 1;
            } else {
                end = middle;
            }
        }
        first
    }

    /// The step of keyframe `index`.
    fn step(&self, index: usize) -> usize {
        self.steps.get(index).map_or(0, |at| self.here(*at))
    }

    /// Where a step of the scene is here.
    fn here(&self, step: u32) -> usize {
        (step / self.stride) as usize
    }

    /// The target of keyframe `index`.
    #[must_use]
    pub fn density(&self, index: usize, cells: usize) -> &'a [T] {
        &self.densities[index * cells..(index + 1) * cells]
    }
}

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

    /// The grid.
    #[must_use]
    pub fn grid(&self) -> &'a Grid {
        self.blur.grid()
    }

    /// 1/2 <e, C e> for e = rho - target; [`Self::image`] is C e afterwards. `sums` holds one number a row.
    pub fn evaluate(&mut self, exec: &dyn Exec, rho: &[T], target: &[T], sums: &mut [f64]) -> f64 {
        let grid = self.grid();
        let n = self.grid().n[0];
        for_rows(
            exec,
            grid.rows(),
            RowBuffers::fields([&mut *self.error]),
            |task| {
                let [error] = task.fields;
                let span = task.row * n..(task.row + 1) * n;
                error.copy_from_slice(&rho[span.clone()]);
                rows::sub(error, &target[span]);
            },
        );
        self.blur.apply(exec, self.error, self.image);
        let (error, image) = (&*self.error, &*self.image);
        let sums = &mut sums[..grid.rows()];
        for_rows(exec, grid.rows(), RowBuffers::<T, 0>::sums(&mut *sums), |task| {
            let span = task.row * n..(task.row + 1) * n;
            task.sums[0] = rows::dot(&error[span.clone()], &image[span]);
        });
        0.5 * sums.iter().sum::<f64>()
    }

    /// C e of the last [`Self::evaluate`].
    #[must_use]
    pub fn image(&self) -> &[T] {
        self.image
    }

    /// The data term of a whole trajectory of densities.
    pub fn total(
        &mut self,
        exec: &dyn Exec,
        rho: &[T],
        keyframes: &Keyframes<'_, T>,
        sums: &mut [f64],
    ) -> f64 {
        let cells = self.grid().cells();
        let steps = keyframes.steps().enumerate();
        steps.fold(0.0, |sum, (index, step)| {
            sum + self.evaluate(
                exec,
                &rho[step * cells..][..cells],
                keyframes.density(index, cells),
                sums,
            )
        })
    }
}
