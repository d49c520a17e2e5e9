//! An entry of the catalogue.

use super::bench::{Bench, Halt};
use super::sheet::Sheet;
use crate::quoted::Scale;

/// How a figure is made.
type Make = fn(&mut Bench<'_>, &mut Sheet) -> Result<(), Halt>;

/// A figure or a table of the thesis.
pub(crate) struct Figure {
    /// Name on the command line.
    pub name: &'static str,
    /// Heading on the page.
    pub title: &'static str,
    /// What is run, and where it differs from the thesis.
    pub text: &'static str,
    /// What the thesis says of its own.
    pub thesis: &'static str,
    /// What it takes at full size.
    cost: Cost,
    /// Makes it.
    pub make: Make,
}

/// What a figure takes at full size on two cores, about, with what it shares with other figures.
#[derive(Clone, Copy)]
pub(super) struct Cost {
    pub seconds: f64,
    pub mebibytes: f64,
    /// With how many axes both grow.
    pub axes: i32,
}

/// The cost of a plane, and of a box.
pub(super) const fn plane(seconds: f64, mebibytes: f64) -> Cost {
    Cost {
        seconds,
        mebibytes,
        axes: 2,
    }
}

pub(super) const fn room(seconds: f64, mebibytes: f64) -> Cost {
    Cost {
        seconds,
        mebibytes,
        axes: 3,
    }
}

impl Figure {
    pub(super) const fn new(
        (name, title): (&'static str, &'static str),
        text: &'static str,
        thesis: &'static str,
        cost: Cost,
        make: Make,
    ) -> Self {
        Self {
            name,
            title,
            text,
            thesis,
            cost,
            make,
        }
    }

    /// Seconds and bytes that it takes at a scale, about.
    pub fn expected(&self, scale: Scale) -> [f64; 2] {
        let Cost {
            seconds,
            mebibytes,
            axes,
        } = self.cost;
        let part = (scale.divisor() as f64).powi(axes).recip();
        [
            (seconds * part).max(1.0),
            (mebibytes * part).max(0.5) * 1_048_576.0,
        ]
    }
}
