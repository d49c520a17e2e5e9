//! What the page shows of a search that is under way: some steps from first to last, as pictures.

use crate::output::{Body, Frames, OutputError, Samples, Shown, Smoke, full, strip_steps};
use crate::stay::Stay;
use std::path::Path;

/// Some of the first `steps` of `frames`, each with its number, which counts on from `first`, and its PNG file.
pub(super) fn strip(
    frames: &mut dyn Frames,
    first: usize,
    steps: usize,
) -> Result<Vec<(usize, Vec<u8>)>, OutputError> {
    let cells = frames.cells().to_vec();
    let at = frames.keyframe_steps().to_vec();
    let mut samples = Samples::new(frames.precision());
    let body = body(frames, &cells, &mut samples);
    let mut field = |of: Shown| {
        match of {
            Shown::Density(step) => {
                let density = frames.outputs().iter().find(|output| output.name == "density");
                if let Some(density) = density {
                    frames.read(density, step, 0, &mut samples);
                }
            }
            Shown::Target(index) => frames.keyframe(index, &mut samples),
        }
        numbers(&samples)
    };
    let mut largest = |of| Ok::<_, OutputError>(field(of).into_iter().fold(0.0, f32::max));
    let full = full(steps, at.len(), &mut largest)?;
    let picture = |step| {
        let smoke = Smoke::new(&cells, field(Shown::Density(step)), full, body.clone());
        let png = smoke.photograph().to_png();
        Ok((first + step, png.map_err(OutputError::of(Path::new("frame")))?))
    };
    strip_steps(steps, &stays(&at)).into_iter().map(picture).collect()
}

/// Keyframes at steps one after the other are held, or move: one of them is enough to be seen.
fn stays(steps: &[usize]) -> Vec<Stay> {
    let together = steps.chunk_by(|before, after| before + 1 == *after);
    let ends = together.filter_map(|steps| Some((*steps.first()?, *steps.last()?)));
    ends.map(|(first, last)| Stay { first, last }).collect()
}

fn body(frames: &mut dyn Frames, cells: &[usize], samples: &mut Samples) -> Option<Body> {
    frames.given().iter().find(|given| given.name == "solid")?;
    frames.given_field("solid", 0, samples);
    Body::new(cells, &numbers(samples))
}

/// Rounded to 32 bits: enough for pictures.
fn numbers(samples: &Samples) -> Vec<f32> {
    match samples {
        Samples::F32(values) => values.clone(),
        Samples::F64(values) => values.iter().map(|&value| value as f32).collect(),
    }
}
