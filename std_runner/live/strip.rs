//! What the page shows of a search that is under way: some steps from first to last, as pictures.

use crate::output::{Body, Frames, OutputError, Samples, Shown, Smoke, full, strip_steps};
use crate::stay::Stay;
use std::collections::BTreeSet;
use std::path::Path;

/// A flow under way, of which densities are shown.
pub(crate) trait Played {
    /// Cells along x, y (and z).
    fn cells(&self) -> Vec<usize>;
    /// The steps of the keyframes, ascending.
    fn keyframe_steps(&self) -> Vec<usize>;
    /// The solid cells, if there are any.
    fn body(&mut self) -> Option<Body>;
    /// The density that is drawn as full, of a flow of so many steps.
    fn full(&mut self, steps: usize) -> f32;
    /// Hands out the densities of `chosen` steps, ascending.
    ///
    /// # Errors
    /// That of `each`.
    fn play(
        &mut self,
        chosen: &BTreeSet<usize>,
        each: &mut dyn FnMut(usize, Vec<f32>) -> Result<(), OutputError>,
    ) -> Result<(), OutputError>;
}

/// Some of the first `steps` of what is played, each with its number, which counts on from `first`, and its PNG file.
pub(super) fn strip(
    played: &mut dyn Played,
    first: usize,
    steps: usize,
) -> Result<Vec<(usize, Vec<u8>)>, OutputError> {
    let (cells, body, full) = (played.cells(), played.body(), played.full(steps));
    let chosen = strip_steps(steps, &stays(&played.keyframe_steps()));
    let mut pictures = Vec::with_capacity(chosen.len());
    played.play(&chosen, &mut |step, density| {
        let smoke = Smoke::new(&cells, density, full, body.clone());
        let png = smoke.photograph().to_png();
        pictures.push((first + step, png.map_err(OutputError::of(Path::new("frame")))?));
        Ok(())
    })?;
    Ok(pictures)
}

/// Keyframes at steps one after the other are held, or move: one of them is enough to be seen.
fn stays(steps: &[usize]) -> Vec<Stay> {
    let together = steps.chunk_by(|before, after| before + 1 == *after);
    let ends = together.filter_map(|steps| Some((*steps.first()?, *steps.last()?)));
    ends.map(|(first, last)| Stay { first, last }).collect()
}

/// A flow of which all steps are held.
pub(crate) struct Held<'a>(pub &'a mut dyn Frames);

impl Held<'_> {
    fn field(&self, of: Shown, samples: &mut Samples) -> Vec<f32> {
        match of {
            Shown::Density(step) => {
                let density = self.0.outputs().iter().find(|output| output.name == "density");
                if let Some(density) = density {
                    self.0.read(density, step, 0, samples);
                }
            }
            Shown::Target(index) => self.0.keyframe(index, samples),
        }
        numbers(samples)
    }

    fn samples(&self) -> Samples {
        Samples::new(self.0.precision())
    }
}

impl Played for Held<'_> {
    fn cells(&self) -> Vec<usize> {
        self.0.cells().to_vec()
    }

    fn keyframe_steps(&self) -> Vec<usize> {
        self.0.keyframe_steps().to_vec()
    }

    fn body(&mut self) -> Option<Body> {
        self.0.given().iter().find(|given| given.name == "solid")?;
        let mut samples = self.samples();
        self.0.given_field("solid", 0, &mut samples);
        Body::new(self.0.cells(), &numbers(&samples))
    }

    fn full(&mut self, steps: usize) -> f32 {
        let keyframes = self.0.keyframe_steps();
        let (targets, seen, mut samples) = (
            keyframes.len(),
            strip_steps(steps, &stays(keyframes)),
            self.samples(),
        );
        let mut largest = |of| {
            let field = self.field(of, &mut samples);
            field.into_iter().fold(0.0, f32::max)
        };
        let Ok(full) = full(targets, seen, None, &mut |of| {
            Ok::<_, core::convert::Infallible>(largest(of))
        });
        full
    }

    fn play(
        &mut self,
        chosen: &BTreeSet<usize>,
        each: &mut dyn FnMut(usize, Vec<f32>) -> Result<(), OutputError>,
    ) -> Result<(), OutputError> {
        let mut samples = self.samples();
        let mut all = chosen.iter();
        all.try_for_each(|&step| each(step, self.field(Shown::Density(step), &mut samples)))
    }
}

/// Rounded to 32 bits: enough for pictures.
fn numbers(samples: &Samples) -> Vec<f32> {
    match samples {
        Samples::F32(values) => values.clone(),
        Samples::F64(values) => values.iter().map(|&value| value as f32).collect(),
    }
}
