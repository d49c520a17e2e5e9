//! Priors on the cells of a grid, and how exactly a sample changes them.
//!
//! A prior is a sum of terms, each of which reads a few cells. A sample changes the 2^d cells of its footprint, and so the terms that
//! read one of them: those of the cells around, a patch of 4^d or 6^d cells. On the patch a term at place i reads i + offset for a few
//! offsets. Where an offset runs over the end of the patch's row it reads another outermost cell; both have weight 0, so the
//! sample changes nothing there, and no loop has to stop at the ends of rows.

mod patch;
mod terms;
mod whole;

pub use patch::Spot;
pub use whole::whole;

use super::{Cells, Footprint};
use crate::real::Real;
use crate::words::named;
use patch::Patch;

/// What is charged beside the distance from the measurements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Prior {
    /// Nothing.
    #[default]
    None,
    /// 1/2 sum of squares of the Laplacian of 2d + 1 points, neighbours beyond the box left out.
    L2,
    /// Total variation: sum of the lengths of the vectors of forward differences, 0 at the far edge.
    Tv,
    /// Sum of absolute differences over all pairs of cells that touch, be it at a corner.
    Sad,
    /// `Tv` of what other cameras would see, pixels in place of cells.
    ImageTv,
    /// `Sad` of what other cameras would see.
    ImageSad,
}

named!(Prior {
    None = "none",
    L2 = "l2",
    Tv = "tv",
    Sad = "sad",
    ImageTv = "image_tv",
    ImageSad = "image_sad",
});

impl Prior {
    /// What it is on pictures, where it is one of pictures.
    #[must_use]
    pub fn on_images(self) -> Option<Self> {
        match self {
            Self::ImageTv => Some(Self::Tv),
            Self::ImageSad => Some(Self::Sad),
            _ => None,
        }
    }

    /// Whether it reads cells.
    #[must_use]
    pub fn on_cells(self) -> bool {
        self != Self::None && self.on_images().is_none()
    }
}

/// By how much Gamma changes with a sample of +`mass` and of -`mass`.
#[inline(always)]
pub fn change<T: Real, const D: usize>(
    prior: Prior,
    cells: &Cells<D>,
    field: &[T],
    footprint: &Footprint<D>,
    mass: f64,
) -> [f64; 2] {
    change_at(prior, cells, field, &Spot::from(footprint), mass)
}

/// The same of a sample whose cells may lie beyond the edge, where nothing is added.
#[inline(always)]
pub fn change_at<T: Real, const D: usize>(
    prior: Prior,
    cells: &Cells<D>,
    field: &[T],
    spot: &Spot<D>,
    mass: f64,
) -> [f64; 2] {
    match (prior, D) {
        (Prior::None | Prior::ImageTv | Prior::ImageSad, _) => [0.0; 2],
        (Prior::L2, 2) => terms::l2(&Patch::<D, 6, 36>::around(cells, field, spot), mass),
        (Prior::L2, _) => terms::l2(&Patch::<D, 6, 216>::around(cells, field, spot), mass),
        (Prior::Tv, 1) => terms::tv(&Patch::<D, 4, 4>::around(cells, field, spot), mass),
        (Prior::Tv, 2) => terms::tv(&Patch::<D, 4, 16>::around(cells, field, spot), mass),
        (Prior::Tv, _) => terms::tv(&Patch::<D, 4, 64>::around(cells, field, spot), mass),
        (Prior::Sad, 1) => terms::sad(&Patch::<D, 4, 4>::around(cells, field, spot), mass),
        (Prior::Sad, 2) => terms::sad(&Patch::<D, 4, 16>::around(cells, field, spot), mass),
        (Prior::Sad, _) => terms::sad(&Patch::<D, 4, 64>::around(cells, field, spot), mass),
    }
}
