//! What every format is given, and what it does with it.

use super::orient::{Orientation, Up};
use super::source::{Frame, Source};
use super::vdb::Codec;
use crate::output::OutputError;
use core::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// The name of files, before their number.
pub(super) const SMOKE: &str = "smoke";
/// Which dt are taken for the length of a frame: those of so many frames a second.
const FILMED: RangeInclusive<f64> = 10.0..=240.0;

/// By how much a rate may be off and is still taken for the one beside it: a dt of few digits is, 24000/1001 is not 24, a thousandth away.
const NEAR: f64 = 9e-4;

/// How fast it plays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimeScale {
    /// Frames a second; a frame is a step.
    pub fps: f64,
    /// What a velocity of the result is in length a second.
    pub factor: f64,
}

impl TimeScale {
    /// Frames a second where neither the user nor the result's dt says.
    pub const FILM: f64 = 24.0;

    /// That of steps of `dt`, played as asked for, or in real time where a step is as long as a film's frame.
    pub fn of(dt: f64, fps: Option<f64>) -> Self {
        let real = 1.0 / dt;
        let whole = if (real - real.round()).abs() < NEAR * real {
            real.round()
        } else {
            real
        };
        match fps {
            None if FILMED.contains(&whole) => Self {
                fps: whole,
                factor: 1.0,
            },
            given => {
                let fps = given.unwrap_or(Self::FILM);
                let factor = dt * fps;
                // A dt that was written with few digits is still that of whole frames.
                let near = (factor - 1.0).abs() < NEAR;
                Self {
                    fps,
                    factor: if near { 1.0 } else { factor },
                }
            }
        }
    }
}

/// How volumes are written.
pub(super) struct Manner {
    pub orientation: Orientation,
    pub up: Up,
    pub time: TimeScale,
    /// The frame that shows step 0.
    pub first_frame: usize,
    pub half: bool,
    pub codec: Codec,
}

impl Manner {
    /// The frame that shows a step.
    pub fn frame(&self, step: usize) -> usize {
        step + self.first_frame
    }

    /// The name of the file of a step.
    pub fn numbered(&self, step: usize, ending: &str) -> String {
        format!("{SMOKE}.{:04}.{ending}", self.frame(step))
    }

    pub fn up_word(&self) -> &'static str {
        match self.up {
            Up::Y => "y",
            Up::Z => "z",
        }
    }
}

/// A format that is being written.
pub(super) trait Sink {
    /// The files and folders that it writes, which those of an earlier export make room for.
    fn parts(&self) -> Vec<PathBuf>;

    /// Writes a step.
    fn step(&mut self, folder: &Path, source: &mut Source, frame: &Frame) -> Result<(), OutputError>;

    /// Bytes of arrays that are written behind the last one of `steps`.
    fn later(&self, _: &RangeInclusive<usize>) -> u64 {
        0
    }

    /// Writes what is said of all `steps`.
    fn finish(
        &mut self,
        folder: &Path,
        source: &mut Source,
        steps: RangeInclusive<usize>,
    ) -> Result<(), OutputError>;
}
