//! The densities of a written `result.npz`, read back one field at a time: pictures need no solver.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::OutputError;
use super::render::Body;
use crate::exit::Failure;
use crate::keyframes::{Measured, Measurements, has_array, measured};
use crate::stay::Stay;

/// What messages call the file.
const KEY: &str = "result";
/// The densities of all steps.
const DENSITY: &str = "density";
/// The same of what was given frame by frame: those of a track that carries none itself.
const GIVEN: &str = "captured";
/// The targets of the keyframes.
const TARGETS: &str = "keyframe_density";
/// The array of the solid cells, of results that have any.
const SOLID: &str = "solid";
/// The ends of the names of vectors' components.
const AXES: [&str; 3] = ["x", "y", "z"];

/// The array of the archive at `path` that has the densities of its steps.
pub(crate) fn densities_of(path: &Path) -> &'static str {
    if !has_array(path, DENSITY) && has_array(path, GIVEN) {
        GIVEN
    } else {
        DENSITY
    }
}

/// The fields of an archive, as [`write_archive`](super::write_archive) writes them. What another program made of it is read too, and refused where
/// it is not what `report.json` says.
pub(crate) struct Densities {
    path: PathBuf,
    /// Those that were asked for so far, by name.
    arrays: BTreeMap<String, Measurements>,
    /// Cells along x, y (and z).
    pub cells: Vec<usize>,
    /// N.
    pub steps: usize,
    /// The keyframes that are to be shown, ascending.
    pub keyframes: Vec<Pictured>,
    /// The largest density of all steps, where that is known.
    most: Option<f32>,
}

/// A keyframe of the scene, and where the archive has what is shown of it.
pub(crate) struct Pictured {
    /// All its steps.
    pub stay: Stay,
    /// The one whose density is shown.
    pub step: usize,
    /// Place of its target among those of the archive, which has one for each step.
    pub target: usize,
}

/// Where the vectors of a result are.
pub(crate) struct Places {
    /// Faces more than cells, by axis.
    pub beyond: Vec<usize>,
    /// Whether they are at the centres of the cells and not on faces.
    pub centred: bool,
}

impl Places {
    /// How many there are of component `axis` along x, y (and z).
    fn counts(&self, cells: &[usize], axis: usize) -> Vec<usize> {
        let mut counts = cells.to_vec();
        if let (false, Some(count)) = (self.centred, counts.get_mut(axis)) {
            *count += self.beyond.get(axis).copied().unwrap_or_default();
        }
        counts
    }
}

/// A field of a result that pictures show.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shown {
    /// The density of a step.
    Density(usize),
    /// A target, by its number.
    Target(usize),
}

/// The density that is drawn as 1, of a result with so many `targets`, of which no step has more than `most`: the largest of the source; of a source
/// without smoke, that of the targets, and where there are none, that of all steps. It is half of that at least, since what is twice as dense as
/// what is drawn as 1 is drawn as no denser. `largest` finds that of a field.
pub(crate) fn full<E>(
    targets: usize,
    most: f32,
    largest: &mut dyn FnMut(Shown) -> Result<f32, E>,
) -> Result<f32, E> {
    let mut full = largest(Shown::Density(0))?;
    if full <= 0.0 {
        for index in 0..targets {
            full = full.max(largest(Shown::Target(index))?);
        }
    }
    Ok(if full > 0.0 { full.max(0.5 * most) } else { most })
}

impl Densities {
    /// Opens `path`, which holds densities 0 ..= `steps`, none above `most` where that is known, and the targets of `keyframes`.
    pub fn open(
        path: &Path,
        cells: Vec<usize>,
        steps: usize,
        keyframes: Vec<Pictured>,
        most: Option<f64>,
    ) -> Result<Self, OutputError> {
        // A source without smoke has no targets where there are no keyframes.
        let has_targets = has_array(path, TARGETS);
        let mut densities = Self {
            path: path.to_owned(),
            arrays: BTreeMap::new(),
            cells,
            steps,
            keyframes: keyframes.into_iter().filter(|_| has_targets).collect(),
            most: most.map(|most| most as f32),
        };
        let name = densities_of(path);
        let count = densities.array(name)?.count();
        if count != steps + 1 {
            return Err(densities.refuse(&format!(
                "has {count} entries of `{name}` and a report.json of the steps 0 to {steps}"
            )));
        }
        densities.density(0)?;
        Ok(densities)
    }

    /// The density of a step, rounded to 32 bits: enough for pictures.
    pub fn density(&mut self, step: usize) -> Result<Vec<f32>, OutputError> {
        self.field(densities_of(&self.path), step, &self.cells.clone())
    }

    /// A target, rounded to 32 bits.
    pub fn target(&mut self, index: usize) -> Result<Vec<f32>, OutputError> {
        self.field(TARGETS, index, &self.cells.clone())
    }

    /// The solid cells as 1, others as 0, if there are any.
    pub fn solid(&mut self) -> Result<Option<Vec<f32>>, OutputError> {
        if !has_array(&self.path, SOLID) {
            return Ok(None);
        }
        let solid = measured(KEY, &self.path, Some(SOLID)).map_err(OutputError::unusable)?;
        self.checked(SOLID, solid, &self.cells).map(Some)
    }

    /// Their body.
    pub fn body(&mut self) -> Result<Option<Body>, OutputError> {
        let solid = self.solid()?;
        Ok(solid.and_then(|solid| Body::new(&self.cells, &solid)))
    }

    /// See [`full`].
    pub fn full(&mut self) -> Result<f32, OutputError> {
        let most = match self.most {
            Some(most) => most,
            None => (0..=self.steps).try_fold(0.0_f32, |most, step| {
                Ok(self.density(step)?.into_iter().fold(most, f32::max))
            })?,
        };
        self.most = Some(most);
        full(self.keyframes.len(), most, &mut |of| {
            let field = match of {
                Shown::Density(step) => self.density(step)?,
                Shown::Target(index) => {
                    let target = self.keyframes.get(index).map_or(0, |keyframe| keyframe.target);
                    self.target(target)?
                }
            };
            Ok(field.into_iter().fold(0.0, f32::max))
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it has vectors of this name, as `velocity` or `force`.
    pub fn has_vectors(&self, name: &str) -> bool {
        let mut axes = AXES.iter().take(self.cells.len());
        axes.all(|axis| has_array(&self.path, &format!("{name}_{axis}")))
    }

    /// Component `axis` of a step of the vectors `name`, where they are.
    pub fn vectors(
        &mut self,
        name: &str,
        axis: usize,
        step: usize,
        places: &Places,
    ) -> Result<Vec<f32>, OutputError> {
        let counts = places.counts(&self.cells, axis);
        let axis = AXES.get(axis).copied().unwrap_or_default();
        self.field(&format!("{name}_{axis}"), step, &counts)
    }

    /// The vectors `name` of a step at the centres of the cells: of those on faces, the mean of the two of each cell.
    pub fn at_centres<const D: usize>(
        &mut self,
        name: &str,
        step: usize,
        places: &Places,
    ) -> Result<Vec<[f32; D]>, OutputError> {
        let mut vectors = vec![[0.0; D]; self.cells.iter().product()];
        for axis in 0..D {
            let read = self.vectors(name, axis, step, places)?;
            if places.centred {
                for (vector, value) in vectors.iter_mut().zip(read) {
                    vector[axis] = value;
                }
                continue;
            }
            // Cells before `axis`, along it, and faces along it.
            let stride: usize = self.cells.iter().take(axis).product();
            let (along, faces) = (self.cells[axis], self.cells[axis] + places.beyond[axis]);
            for (cell, vector) in vectors.iter_mut().enumerate() {
                let (before, at, after) = (cell % stride, cell / stride % along, cell / (stride * along));
                let face = |at: usize| read.get((after * faces + at % faces) * stride + before);
                let ends = [face(at), face(at + 1)];
                vector[axis] = 0.5 * ends.into_iter().flatten().sum::<f32>();
            }
        }
        Ok(vectors)
    }

    fn array(&mut self, name: &str) -> Result<&Measurements, OutputError> {
        if !self.arrays.contains_key(name) {
            let opened = Measurements::open(KEY, &self.path, Some(name)).map_err(OutputError::unusable)?;
            self.arrays.insert(name.to_owned(), opened);
        }
        self.arrays.get(name).ok_or_else(|| self.refuse("cannot be read"))
    }

    /// Entry `index` of an array whose entries are fields of `counts` numbers along x, y (and z).
    fn field(&mut self, name: &str, index: usize, counts: &[usize]) -> Result<Vec<f32>, OutputError> {
        let array = self.array(name)?;
        let count = array.count();
        if index >= count {
            return Err(self.refuse(&format!(
                "has {count} entries of `{name}`, and number {index} is needed"
            )));
        }
        let read = array.read(index).map_err(OutputError::unusable)?;
        self.checked(name, read, counts)
    }

    /// The numbers of a field of `counts` along x, y (and z).
    fn checked(&self, name: &str, read: Measured, counts: &[usize]) -> Result<Vec<f32>, OutputError> {
        let shape: Vec<usize> = counts.iter().rev().copied().collect();
        if read.shape != shape {
            return Err(self.refuse(&format!(
                "has `{name}` of {:?} and a report.json by which that is of {shape:?}",
                read.shape
            )));
        }
        Ok(read.values.into_iter().map(|value| value as f32).collect())
    }

    fn refuse(&self, found: &str) -> OutputError {
        OutputError::Source(Failure::Input(format!(
            "{} {found}; name the folder as it was written, or solve it again",
            self.path.display()
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_drawn_as_full_is_the_source_unless_smoke_becomes_twice_as_dense() {
        // Of the source, of targets, of all steps.
        for (source, targets, most, expected) in [
            (1.0, &[1.4][..], 1.3, 1.0),
            (1.0, &[], 2.0, 1.0),
            (1.0, &[], 3.0, 1.5),
            (0.02, &[], 1.0, 0.5),
            (0.0, &[0.5, 0.8], 1.2, 0.8),
            (0.0, &[], 1.6, 1.6),
            (0.0, &[], 0.0, 0.0),
        ] {
            let Ok(found) = full(targets.len(), most, &mut |of| {
                Ok::<_, core::convert::Infallible>(match of {
                    Shown::Density(step) => [source][step],
                    Shown::Target(index) => targets[index],
                })
            });
            assert_eq!(found, expected, "{source}, {targets:?}, {most}");
        }
    }
}
