//! The way of an image: chains of the walk, iterations of a baseline.

use super::baselines::{self, Work};
use super::colours::gather;
use super::kernel::Blur;
use super::prior::ImagePrior;
use super::restoration::Restoration;
use super::settings::Restorer;
use super::terrain::{Ground, walk};
use crate::real::Real;

/// Mutations a pixel after which colours are gathered again.
const GATHER: u64 = 10;

impl<T: Real> Restoration<'_, T> {
    /// Goes on: about one chain of the walk, or an iteration of a baseline. Whether it is done.
    pub fn advance(&mut self, most: u64) -> bool {
        if self.over() {
            return true;
        }
        match self.problem.tuning.method {
            Restorer::Walk => self.walk(most),
            method => {
                let buffers = &mut self.buffers;
                let work = Work {
                    problem: &self.problem,
                    blur: Blur {
                        frame: self.problem.frame,
                        values: &*buffers.kernels,
                        which: &*buffers.which,
                    },
                    measured: buffers.measured,
                    residual: buffers.residual,
                    mask: buffers.mask,
                    planes: buffers.planes,
                    work: &mut buffers.work,
                };
                baselines::iterate(method, work, self.iterations == 0);
                self.iterations += 1;
                self.renew();
            }
        }
        self.over()
    }

    fn walk(&mut self, most: u64) {
        let mut left = most;
        let every = GATHER * self.length();
        while left > 0 && !self.course.over() {
            let mut course = self.course;
            let before = course.walked().mutations;
            let count = left.min(every - before % every);
            let buffers = &mut self.buffers;
            let mut ground = Ground {
                blur: Blur {
                    frame: self.problem.frame,
                    values: &*buffers.kernels,
                    which: &*buffers.which,
                },
                mask: buffers.mask,
                residual: buffers.residual,
                planes: buffers.planes,
                clusters: self.clusters,
                tuning: self.problem.tuning,
                eps: self.eps,
            };
            walk(&mut ground, &mut course, count);
            self.eps = ground.eps;
            self.course = course;
            left -= count;
            let now = course.walked().mutations;
            if self.problem.tuning.prior == ImagePrior::Clusters && now.is_multiple_of(every) {
                gather(
                    &mut self.clusters,
                    &self.problem.frame,
                    self.buffers.planes,
                    false,
                );
            }
        }
    }
}
