//! An animated PNG that loops, and rests at the keyframes, where they begin.

use png::{EncodingError, Writer};

use super::picture::Picture;
use crate::stay::Stay;

/// A run through all steps takes about this long, in seconds,
const LASTS: f64 = 4.0;
/// within these frames a second.
const SLOWEST: f64 = 8.0;
const FASTEST: f64 = 25.0;

/// Milliseconds that each frame is shown.
pub(super) struct Pace {
    frame: u16,
    steps: usize,
    keyframes: Vec<Stay>,
}

impl Pace {
    pub fn new(steps: usize, keyframes: &[Stay]) -> Self {
        let frequency = (steps as f64 / LASTS).clamp(SLOWEST, FASTEST);
        Self {
            frame: (1000.0 / frequency) as u16,
            steps,
            keyframes: keyframes.to_vec(),
        }
    }

    fn milliseconds(&self, step: usize) -> u16 {
        match step {
            0 => self.frame + 400,
            step if step == self.steps => self.frame + 1200,
            step if self.keyframes.iter().any(|keyframe| keyframe.first == step) => self.frame + 600,
            _ => self.frame,
        }
    }
}

/// Frames that are appended one by one to a list of bytes.
pub(super) struct Animation<'a> {
    writer: Writer<&'a mut Vec<u8>>,
    pace: Pace,
    step: usize,
}

impl<'a> Animation<'a> {
    /// An animation of pictures like `first`, which is not appended yet.
    pub fn new(bytes: &'a mut Vec<u8>, first: &Picture, pace: Pace) -> Result<Self, EncodingError> {
        let frames = u32::try_from(pace.steps + 1).unwrap_or(u32::MAX);
        let mut encoder = first.encoder(bytes);
        encoder.set_animated(frames, 0)?;
        Ok(Self {
            writer: encoder.write_header()?,
            pace,
            step: 0,
        })
    }

    /// Appends the picture of the next step.
    pub fn push(&mut self, picture: &Picture) -> Result<(), EncodingError> {
        self.writer
            .set_frame_delay(self.pace.milliseconds(self.step), 1000)?;
        self.writer.write_image_data(&picture.bytes)?;
        self.step += 1;
        Ok(())
    }

    /// Ends the file; every step must have been pushed.
    pub fn finish(self) -> Result<(), EncodingError> {
        self.writer.finish()
    }
}
