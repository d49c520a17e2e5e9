//! What is drawn over the smoke of a plane: arrows of a field, and streaklines of the flow.

use clap::ValueEnum;

use super::render::{Field, Over, Streaks, arrow_side};
use super::{Densities, OutputError, Places};

/// What arrows show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Vectors {
    /// The force that turns the flow of a step into that of the next one.
    Force,
    /// The flow of a step.
    Velocity,
}

impl Vectors {
    /// The name of its arrays.
    pub fn name(self) -> &'static str {
        match self {
            Self::Force => "force",
            Self::Velocity => "velocity",
        }
    }

    /// How many steps fewer there are than densities.
    fn fewer(self) -> usize {
        match self {
            Self::Force => 2,
            Self::Velocity => 1,
        }
    }
}

/// How a plane of a result lies on its grid.
pub(super) struct Plane<'a> {
    pub densities: &'a mut Densities,
    pub places: &'a Places,
    /// Cells a step that a velocity of 1 is.
    pub scale: f32,
}

impl Plane<'_> {
    fn cells(&self) -> [usize; 2] {
        core::array::from_fn(|axis| self.densities.cells.get(axis).copied().unwrap_or(1))
    }

    /// A field at the centres of the cells, times `scale`.
    fn field(&mut self, of: Vectors, step: usize, scale: f32) -> Result<Field, OutputError> {
        let values = self.densities.at_centres(of.name(), step, self.places, scale)?;
        let cells = self.cells();
        Ok(Field { cells, values })
    }

    /// How many steps a field has. Where flows are those of cells there is one more of each.
    fn count(&self, of: Vectors) -> usize {
        let carrying = self.places.carrying(self.densities.steps);
        carrying.saturating_sub(of.fewer() - 1)
    }

    /// The largest mean over squares of `side` cells, of all steps.
    pub fn strongest(&mut self, of: Vectors, side: usize) -> Result<f32, OutputError> {
        let mut most: f32 = 0.0;
        for step in 0..self.count(of) {
            most = most.max(self.field(of, step, 1.0)?.strongest(side));
        }
        Ok(most)
    }
}

/// What is asked for, and how far it is.
#[derive(Default)]
pub(super) struct Lines {
    arrows: Option<Vectors>,
    streaklines: bool,
    /// The size of the longest arrow of all steps.
    strongest: Option<f32>,
    streaks: Option<Streaks>,
}

impl Lines {
    /// What is asked for.
    pub fn new(arrows: Option<Vectors>, streaklines: bool) -> Self {
        Self {
            arrows,
            streaklines,
            ..Self::default()
        }
    }

    /// What is drawn over a step, in a picture in which a cell has so many `pixels`.
    pub fn at(&mut self, plane: &mut Plane<'_>, step: usize, pixels: f32) -> Result<Over, OutputError> {
        Ok(Over {
            arrows: match self.arrows {
                Some(of) => self.arrows(plane, of, step, pixels)?,
                None => None,
            },
            streaks: if self.streaklines {
                Some(self.followed(plane, step)?)
            } else {
                None
            },
        })
    }

    /// The arrows of a step, if it has any, and the size of the longest of all steps.
    fn arrows(
        &mut self,
        plane: &mut Plane<'_>,
        of: Vectors,
        step: usize,
        pixels: f32,
    ) -> Result<Option<(Field, f32)>, OutputError> {
        let strongest = match self.strongest {
            Some(known) => known,
            None => {
                let side = arrow_side(plane.cells(), pixels);
                *self.strongest.insert(plane.strongest(of, side)?)
            }
        };
        if step >= plane.count(of) || strongest <= 0.0 {
            return Ok(None);
        }
        Ok(Some((plane.field(of, step, 1.0)?, strongest)))
    }

    /// The streaklines of a step: they are followed from the step that was last asked for, or from where that does not matter any more.
    fn followed(&mut self, plane: &mut Plane<'_>, step: usize) -> Result<Streaks, OutputError> {
        let before = self.streaks.take().filter(|streaks| streaks.step() <= step);
        let mut now = before.unwrap_or_else(|| Streaks::new(plane.cells()));
        now.begin_at(Streaks::begins(step));
        let repeats = core::array::from_fn(|axis| plane.places.beyond.get(axis) == Some(&0));
        while now.step() < step {
            let flow = plane.field(Vectors::Velocity, plane.places.carrying(now.step()), plane.scale)?;
            now.follow(&flow, repeats);
        }
        self.streaks = Some(now.clone());
        Ok(now)
    }
}
