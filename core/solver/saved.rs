//! Saving a solver and going on from what was saved.

use super::{SavedError, Solver};
use crate::checkpoint::{Damaged, FORMAT, HEAD, Label, MAGIC, Mix, Record};
use crate::grid::{Boundary, Space};
use crate::memory::Layout;
use crate::method::params::Params;
use crate::method::registry;
use crate::problem::{Advection, Problem};
use crate::real::Real;

impl<T: Real, S: Space> Solver<'_, T, S> {
    /// Bytes that [`Self::save`] writes: [`Plan::saved_bytes`](super::Plan::saved_bytes).
    #[must_use]
    pub fn saved_bytes(&self) -> usize {
        self.saved_bytes
    }

    /// Writes the whole state as plain bytes, densities included, into the first [`Self::saved_bytes`] of `bytes`. Nothing is
    /// changed: the solver is borrowed to write because one list of its state serves for [`Self::restore`] too.
    ///
    /// # Errors
    /// [`SavedError::Length`] when `bytes` are too few.
    pub fn save(&mut self, bytes: &mut [u8]) -> Result<(), SavedError> {
        let (expected, given) = (self.saved_bytes, bytes.len());
        let short = SavedError::Length { expected, given };
        let mut record = Record::write(bytes.get_mut(..expected).ok_or(short)?);
        self.record(&mut record).map_err(|Damaged| short)?;
        debug_assert_eq!(record.bytes(), expected, "planned and saved bytes differ");
        record.seal(self.fingerprint);
        Ok(())
    }

    /// Goes on from what a solver of the same problem, method and choices saved: every later step gives the bits that it would
    /// have given there. Threads, ceiling and iterations may be others. Nothing is changed where the bytes are refused.
    ///
    /// # Errors
    /// [`SavedError`].
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), SavedError> {
        let (expected, given) = (self.saved_bytes, bytes.len());
        let length = SavedError::Length { expected, given };
        let label = Label::of(bytes).filter(|_| given >= HEAD).ok_or(length)?;
        match label {
            Label { magic, .. } if magic != MAGIC => Err(SavedError::NotSaved),
            Label { format, .. } if format != FORMAT => Err(SavedError::Format { given: format }),
            Label { fingerprint, .. } if fingerprint != self.fingerprint => Err(SavedError::OtherSolve),
            Label { bytes: said, .. } if given != expected || said != expected as u64 => Err(length),
            label if !label.fits(bytes) => Err(SavedError::Damaged),
            _ => self
                .record(&mut Record::read(bytes))
                .map_err(|Damaged| SavedError::Damaged),
        }
    }

    /// Passes over all state: scalars, which are all checked before anything is changed, then fields.
    fn record(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        let (mut mass, mut missing, mut prepared) = (self.mass, self.missing, self.prepared);
        let (mut objective, mut finished) = (self.objective, self.finished);
        record.real(&mut mass)?;
        record.count(&mut missing, self.keyframe_steps.len())?;
        record.option(&mut prepared, |record, change| record.real(change))?;
        objective.record(record)?;
        record.flag(&mut finished)?;
        let method = self.engine.get_mut();
        let mut largest = method.parts().setup.sweep.largest;
        record.real(&mut largest)?;
        method.scalars(record)?;
        method.parts().setup.sweep.largest = largest;
        (self.mass, self.missing, self.prepared) = (mass, missing, prepared);
        (self.objective, self.finished) = (objective, finished);
        let mut visit = |field: &mut [T]| record.elements(field);
        // What is kept is only shown: nothing can be too small.
        let _ = method.layout(&mut Layout::kept(&mut visit));
        record.elements(self.targets);
        Ok(())
    }
}

/// All that the bits of a step follow from, but for the densities, in one word.
pub(super) fn fingerprint<T: Real, S: Space>(problem: &Problem<'_>, params: &Params) -> u64 {
    let mut mix = Mix::new();
    mix.word(T::BYTES as u64);
    mix.word(S::DIM as u64);
    mix_problem(&mut mix, problem);
    // Threads and ceiling change no bit but by the choices that they come to; iterations only say when to stop.
    mix.word(params.method as u64);
    registry::mix::<T, S>(params, &mut mix);
    mix.finish()
}

fn mix_problem(mix: &mut Mix, problem: &Problem<'_>) {
    // Every field by name: a new one does not compile until it is mixed in.
    let Problem {
        cells,
        boundary,
        length,
        dt,
        steps,
        keyframes,
        force_weight,
        viscosity,
        filters: _,
        match_mass,
        advection,
        projection_tolerance,
    } = problem;
    cells.iter().for_each(|&n| mix.word(n as u64));
    boundary
        .iter()
        .for_each(|&end| mix.word(u64::from(end == Boundary::Periodic)));
    mix.word(*steps as u64);
    mix.word(keyframes.len() as u64);
    keyframes.iter().for_each(|&step| mix.word(step as u64));
    mix.word(problem.filters() as u64);
    mix.word(u64::from(*match_mass));
    let Advection { scheme, tolerance } = advection;
    mix.word(*scheme as u64);
    [
        length,
        dt,
        force_weight,
        viscosity,
        tolerance,
        projection_tolerance,
    ]
    .into_iter()
    .for_each(|&number| mix.real(number));
}
