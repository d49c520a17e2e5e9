//! Which problems are refused.

use super::{
    CELLS, MAX_FILTERS, MAX_SMOOTHNESS, MAX_STEPS, Problem, ProblemError, Scheme, Supply, Template,
    TemplateError,
};
use crate::grid::spectrum::MOST_OPEN;

impl Problem<'_> {
    /// Checks every field but the number of axes and whether there are keyframes.
    ///
    /// # Errors
    /// [`ProblemError`] names the first field that is wrong.
    pub fn check(&self) -> Result<(), ProblemError> {
        if !(2..=3).contains(&self.cells.len()) {
            return Err(ProblemError::Dimensions {
                expected: self.cells.len().clamp(2, 3),
                given: self.cells.len(),
            });
        }
        if let Some((axis, &given)) = self.cells.iter().enumerate().find(|(_, n)| !CELLS.contains(n)) {
            return Err(ProblemError::Cells { axis, given });
        }
        if self.boundary.len() != self.cells.len() {
            return Err(ProblemError::Boundary {
                given: self.boundary.len(),
            });
        }
        if !(2..=MAX_STEPS).contains(&self.steps) {
            return Err(ProblemError::Steps { given: self.steps });
        }
        self.check_keyframes()?;
        self.check_emitters()?;
        self.check_templates()?;
        self.check_steps()?;
        self.check_share().map_err(ProblemError::Share)?;
        self.check_numbers()
    }

    fn check_numbers(&self) -> Result<(), ProblemError> {
        let numbers = [
            ("length", self.length),
            ("dt", self.dt),
            ("force_weight", self.force_weight),
            ("advection.tolerance", self.advection.tolerance),
            ("projection.tolerance", self.projection_tolerance),
        ];
        for (field, given) in numbers {
            positive(field, given)?;
        }
        if self.keyframe_weights.len() > self.keyframes.len() {
            let given = self.keyframe_weights.len();
            return Err(ProblemError::Weights { given });
        }
        for &weight in self.keyframe_weights {
            positive("keyframe.weight", weight)?;
        }
        if self.is_open() {
            if self.advection.scheme != Scheme::Limited {
                return Err(ProblemError::OpenScheme);
            }
            let mut axes = self.cells.iter().zip(self.boundary).enumerate();
            let long = axes.find(|(_, (n, end))| end.is_open() && **n > MOST_OPEN);
            if let Some((axis, (&given, _))) = long {
                return Err(ProblemError::OpenCells { axis, given });
            }
            if self.match_mass && !self.keyframes.is_empty() {
                return Err(ProblemError::MassLeaves);
            }
        }
        if self.solids && self.advection.scheme != Scheme::Limited {
            return Err(ProblemError::SolidScheme);
        }
        if let Some(&given) = self.buoyancy.iter().find(|b| !b.is_finite()) {
            return Err(ProblemError::NotFinite {
                field: "buoyancy",
                given,
            });
        }
        not_negative("viscosity", self.viscosity)?;
        if !self.slip && self.viscosity == 0.0 {
            return Err(ProblemError::SticksWithoutViscosity);
        }
        let smoothness = self.smoothness.unwrap_or(0.0);
        if !(0.0..=MAX_SMOOTHNESS).contains(&smoothness) {
            let (field, given, most) = ("smoothness", smoothness, MAX_SMOOTHNESS);
            return Err(ProblemError::NotUpTo { field, given, most });
        }
        match self.filters {
            Some(given) if given > MAX_FILTERS => Err(ProblemError::Filters { given }),
            _ => Ok(()),
        }
    }

    fn check_emitters(&self) -> Result<(), ProblemError> {
        let steps = self.steps;
        for (index, emitter) in self.emitters.iter().enumerate() {
            if emitter.from >= emitter.to || emitter.to > steps {
                return Err(ProblemError::EmitterSteps { index, steps });
            }
            match emitter.supply {
                Supply::Rate(rate) => positive("emitter.rate", rate)?,
                Supply::Target(target) => positive("emitter.target", target)?,
            }
            let velocity = emitter.velocity.unwrap_or_default();
            if let Some(&given) = velocity.iter().find(|v| !v.is_finite()) {
                let field = "emitter.velocity";
                return Err(ProblemError::NotFinite { field, given });
            }
            if matches!(emitter.supply, Supply::Target(_)) && self.match_mass && !self.keyframes.is_empty() {
                return Err(ProblemError::MassUnknown { index });
            }
        }
        Ok(())
    }

    fn check_templates(&self) -> Result<(), ProblemError> {
        let forces = self.release.unwrap_or(self.steps).saturating_sub(1);
        let mut templates = self.templates.iter().enumerate();
        templates.try_for_each(|(index, template)| template.check(index, self, forces))
    }

    /// The release and the schedule.
    fn check_steps(&self) -> Result<(), ProblemError> {
        if let Some(given) = self.release {
            let steps = self.steps;
            if !(2..steps).contains(&given) {
                return Err(ProblemError::Release { given, steps });
            }
            if let Some(&step) = self.keyframes.iter().find(|&&step| step > given) {
                return Err(ProblemError::KeyframeReleased { step, release: given });
            }
        }
        for &(step, factor) in self.schedule {
            positive("schedule", factor)?;
            if step > MAX_STEPS {
                return Err(ProblemError::ScheduleOrder { step });
            }
        }
        match self.schedule.windows(2).find(|pair| pair[0].0 >= pair[1].0) {
            Some(pair) => Err(ProblemError::ScheduleOrder { step: pair[1].0 }),
            None => Ok(()),
        }
    }

    fn check_keyframes(&self) -> Result<(), ProblemError> {
        if let Some(&step) = self
            .keyframes
            .iter()
            .find(|step| !(2..=self.steps).contains(step))
        {
            return Err(ProblemError::Keyframe {
                step,
                steps: self.steps,
            });
        }
        match self.keyframes.windows(2).find(|pair| pair[0] >= pair[1]) {
            Some(pair) => Err(ProblemError::Order { step: pair[1] }),
            None => Ok(()),
        }
    }
}

impl Template {
    /// Checks template `index` of a problem with so many forces.
    ///
    /// # Errors
    /// [`ProblemError`].
    pub fn check(&self, index: usize, problem: &Problem<'_>, forces: usize) -> Result<(), ProblemError> {
        if self.from >= self.to.min(forces) || self.to > problem.steps {
            let error = TemplateError::Steps { forces };
            return Err(ProblemError::Template { index, error });
        }
        if self.interval == 0 {
            let error = TemplateError::Interval;
            return Err(ProblemError::Template { index, error });
        }
        positive("template.radius", self.radius)?;
        positive("template.size", self.size)?;
        if let Some(&given) = self.amplitude.iter().find(|a| !a.is_finite()) {
            let field = "template.amplitude";
            return Err(ProblemError::NotFinite { field, given });
        }
        let longest = problem.cells.iter().copied().max().unwrap_or(1) as f64;
        let sides = problem.cells.iter().map(|&n| n as f64 / longest * problem.length);
        let mut along = self.center.iter().zip(sides).enumerate();
        match along.find(|(_, (x, side))| !(0.0..=*side).contains(*x)) {
            None => Ok(()),
            Some((axis, (&given, _))) => {
                let error = TemplateError::Outside { axis, given };
                Err(ProblemError::Template { index, error })
            }
        }
    }
}

/// Refuses what is not positive and finite.
///
/// # Errors
/// [`ProblemError::NotPositive`].
pub fn positive(field: &'static str, given: f64) -> Result<(), ProblemError> {
    if given > 0.0 && given.is_finite() {
        Ok(())
    } else {
        Err(ProblemError::NotPositive { field, given })
    }
}

/// Refuses what is negative or not finite.
///
/// # Errors
/// [`ProblemError::Negative`].
pub fn not_negative(field: &'static str, given: f64) -> Result<(), ProblemError> {
    if given >= 0.0 && given.is_finite() {
        Ok(())
    } else {
        Err(ProblemError::Negative { field, given })
    }
}
