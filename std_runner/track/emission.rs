//! What was made between two frames, which no flow carried there: an array beside them, or one of its own.

use super::files::refused;
use super::scene::{CaptureScene, Wanted};
use crate::exit::Failure;
use crate::keyframes::{Series, ends_with};
use crate::undershoot::place;
use std::path::Path;

/// The key that names it.
const KEY: &str = "capture.emission";
/// Its array in an archive.
const NAME: &str = "emission";

/// What was made, pair by pair.
pub(super) struct Emission {
    series: Series,
}

impl Emission {
    /// Opens what `scene` asks for, of frames of `cells`; `beside` is the archive with the frames that holds some.
    pub fn open(
        scene: &CaptureScene,
        beside: Option<&Path>,
        cells: &[usize],
        steps: usize,
    ) -> Result<Option<Self>, Failure> {
        let path = match (&scene.emission, beside) {
            (Wanted::File(path), _) => path.as_path(),
            (Wanted::Automatic, Some(path)) => path,
            _ => return Ok(None),
        };
        let single = ends_with(path, "npy");
        let series = Series::open(path, (!single).then_some(NAME), KEY);
        let series = series.map_err(|error| refused(&scene.document, KEY, &error))?;
        let cells: Vec<usize> = cells.iter().rev().copied().collect();
        if series.shape() != cells || series.count() < steps {
            let found = format!(
                "holds {} steps of {:?} cells where {steps} of {cells:?} are needed",
                series.count(),
                series.shape()
            );
            return Err(refuse(
                scene,
                path,
                &found,
                "give what was made between the same frames",
            ));
        }
        Ok(Some(Self { series }))
    }

    /// What was made in step `step` of the files, checked.
    pub fn read(&mut self, scene: &CaptureScene, step: usize) -> Result<Vec<f64>, Failure> {
        let made = self.series.read(step);
        let made = made.map_err(|error| refused(&scene.document, KEY, &error))?;
        match made.iter().position(|value| !value.is_finite() || *value < 0.0) {
            None => Ok(made),
            Some(at) => {
                let found = format!(
                    "holds {} at {} of step {step}",
                    made.get(at).copied().unwrap_or_default(),
                    place(at, self.series.shape())
                );
                Err(refuse(
                    scene,
                    self.series.path(),
                    &found,
                    "what is made is finite and never negative",
                ))
            }
        }
    }
}

fn refuse(scene: &CaptureScene, path: &Path, found: &str, remedy: &str) -> Failure {
    Failure::Input(format!(
        "{}: `{KEY}` file `{}` {found}; {remedy}, or leave it out by {KEY} = \"none\"",
        scene.document.place(KEY),
        path.display()
    ))
}
