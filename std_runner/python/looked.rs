//! Frames that are looked at before they are tracked.

use crate::place::Number;
use crate::tracking::Job;
use crate::words::refused;
use pyo3::prelude::*;
use thurible::change::{self, Change};
use thurible::undershoot::Undershoot;
use thurible_core::track::FULL;

impl Job<'_> {
    /// What densities are multiplied by, of frames that are densities.
    pub fn scale<T: Number>(&self, frames: &[T]) -> PyResult<f64> {
        if let Some(index) = frames.iter().position(|value| !value.is_finite()) {
            return Err(refused(
                "frames",
                format!("value {index} is not finite; every value must be"),
            ));
        }
        if let Some(found) = Undershoot::of(frames)
            && !found.is_small()
        {
            let [found, remedy] = found.refused(&self.shape);
            return Err(refused("frames", format!("{found}; {remedy}")));
        }
        let largest = frames.iter().map(|value| value.to_f64()).fold(0.0, f64::max);
        if largest > 0.0 {
            Ok(self.density_scale.unwrap_or(FULL / largest))
        } else {
            Err(refused(
                "frames",
                "have no smoke anywhere; give frames with smoke in them",
            ))
        }
    }

    /// Refuses a frame that has lost all smoke; what no flow does of a frame beside the one before.
    pub fn compare<T: Number>(&self, frames: &[T]) -> PyResult<Vec<String>> {
        let cells: usize = self.cells.iter().product();
        let pairs = frames.chunks_exact(cells).zip(frames.chunks_exact(cells).skip(1));
        let mut remarks = Vec::new();
        for (first, (before, now)) in pairs.enumerate() {
            let Some(change) = change::between(before, now) else {
                continue;
            };
            let names = [
                format!("frames[{}:]", first + 1),
                "options={\"levels\": ..}".into(),
            ];
            let sentence = change.sentence([first, first + 1], names.each_ref().map(String::as_str));
            if change == Change::Lost {
                let why = format!("{sentence}; give frames[:{}], or replace it", first + 1);
                return Err(refused("frames", why));
            }
            remarks.push(sentence);
        }
        Ok(remarks)
    }
}
