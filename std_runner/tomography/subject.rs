//! What is photographed: the densities of a result or of a file.

use crate::exit::Failure;
use crate::keyframes::{Measured, Measurements, ends_with};
use crate::report::Said;
use crate::undershoot::Undershoot;
use core::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// The largest density, whose sums along rays are numbers in single precision.
const MOST: f64 = 1e30;

/// How much cameras are raised where nothing is said, in degrees.
const RISE: f64 = 15.0;

/// What is photographed, and how.
#[derive(Clone)]
pub(crate) struct Rig {
    /// A result folder, or a file with an array of densities.
    pub result: PathBuf,
    /// The array of a file.
    pub array: String,
    pub views: usize,
    pub folder: PathBuf,
    pub pinhole: bool,
    /// How much cameras are raised in 3D, in degrees.
    pub elevation: Option<f64>,
    /// Pixels across and down.
    pub size: Option<(usize, usize)>,
    pub frames: Option<RangeInclusive<usize>>,
    /// Standard deviation of noise, in parts of the brightest pixel.
    pub noise: f64,
    pub seed: u64,
    /// Whether a file of views that was changed since it was written may go.
    pub force: bool,
}

impl Rig {
    /// How much cameras are raised in 3D, in degrees.
    pub fn rise(&self) -> f64 {
        self.elevation.unwrap_or(RISE)
    }
}

/// The density that is photographed.
pub(super) struct Subject {
    held: Measurements,
    pub length: f64,
    pub dt: f64,
    /// Cells along x, y (and z).
    pub cells: Vec<usize>,
}

fn failed(error: crate::keyframes::ShapeError) -> Failure {
    error.failure(error.to_string())
}

impl Subject {
    /// What `rig` names.
    pub fn of(rig: &Rig) -> Result<Self, Failure> {
        let folder = rig.result.is_dir();
        let path = if folder {
            rig.result.join("result.npz")
        } else {
            rig.result.clone()
        };
        let single = ends_with(&path, "npy");
        let array = (!single).then(|| rig.array.clone());
        let said = folder.then(|| Said::of(&rig.result)).transpose()?;
        let [length, dt] = said.map_or([1.0; 2], |said| [said.length, said.dt]);
        let held = Measurements::open("result", &path, array.as_deref()).map_err(failed)?;
        let first = held.read(0).map_err(failed)?;
        let cells: Vec<usize> = first.shape.iter().rev().copied().collect();
        if !(2..=3).contains(&cells.len()) || cells.iter().any(|&count| count < 2) {
            return Err(Failure::Input(format!(
                "{}: `{}` has entries of shape {:?}; give densities whose first axis is time, of two or three axes more",
                path.display(),
                rig.array,
                first.shape
            )));
        }
        Ok(Self {
            length,
            dt,
            held,
            cells,
        })
    }

    /// How many frames it has.
    pub fn frames(&self) -> usize {
        self.held.count()
    }

    /// The file.
    pub fn path(&self) -> &Path {
        self.held.path()
    }

    /// The density of a frame.
    pub fn density(&self, frame: usize) -> Result<Vec<f32>, Failure> {
        let Measured { values, shape, .. } = self.held.read(frame).map_err(failed)?;
        let told = |found: String, remedy: &str| {
            let array = self.held.name().map_or(String::new(), |name| format!(", {name}"));
            Failure::Input(format!(
                "{}{array}[{frame}] {found}; {remedy}",
                self.path().display()
            ))
        };
        // Transport may undershoot; a camera sees no less than nothing.
        if let Some(found) = Undershoot::of(&values).filter(|found| !found.is_small()) {
            let [found, remedy] = found.refused(&shape);
            return Err(told(found, &remedy));
        }
        let largest = values.iter().copied().fold(0.0, f64::max);
        if largest > MOST {
            let remedy = "cameras see densities up to 1e30: give them in another unit";
            return Err(told(format!("holds {largest:e}"), remedy));
        }
        Ok(values.into_iter().map(|value| value.max(0.0) as f32).collect())
    }
}
