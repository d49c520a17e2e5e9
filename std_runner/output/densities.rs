//! The densities of a written `result.npz`, read back one field at a time: pictures need no solver.

use std::collections::BTreeSet;
use std::collections::btree_map::{BTreeMap, Entry};
use std::path::{Path, PathBuf};

use super::OutputError;
use super::middle::middle;
use super::render::{Body, DENSEST};
use crate::exit::Failure;
use crate::keyframes::{Series, array_names, measured};
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

/// The array that has the densities of the steps, in an archive of which `has` says what it has.
pub(crate) fn densities_of(has: impl Fn(&str) -> bool) -> &'static str {
    if !has(DENSITY) && has(GIVEN) {
        GIVEN
    } else {
        DENSITY
    }
}

/// The fields of an archive, as [`write_archive`](super::write_archive) writes them. What another program made of it is read too, and refused where
/// it is not what `report.json` says.
pub(crate) struct Densities {
    path: PathBuf,
    /// What there is, but for arrays of nothing.
    names: BTreeSet<String>,
    /// Those that were asked for so far.
    arrays: BTreeMap<String, Series>,
    /// Cells along x, y (and z).
    pub cells: Vec<usize>,
    /// N.
    pub steps: usize,
    /// The keyframes that are to be shown, ascending.
    pub keyframes: Vec<Pictured>,
    /// The largest density of all steps, by the report.
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
    /// Which flow carries the density of `step` to the next one: that of the step itself; where flows are those of cells (Stable Fluids) that of the next.
    pub fn carrying(&self, step: usize) -> usize {
        step + usize::from(self.centred)
    }

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

/// The density that is drawn as 1, of a result with so many `targets`: the largest of the source; of a source without smoke, that of the targets, and
/// where there are none, that of all `steps`. It is so large that none of these is cut off. `most` is the largest of all steps where somebody says
/// so; it is looked for in `steps` where it counts, since an archive may have changed. `largest` finds that of a field.
pub(crate) fn full<E>(
    targets: usize,
    steps: impl IntoIterator<Item = usize>,
    most: Option<f32>,
    largest: &mut dyn FnMut(Shown) -> Result<f32, E>,
) -> Result<f32, E> {
    let mut full = largest(Shown::Density(0))?;
    if full <= 0.0 {
        for index in 0..targets {
            full = full.max(largest(Shown::Target(index))?);
        }
    }
    if full > 0.0 && most.is_some_and(|most| most <= DENSEST * full) {
        return Ok(full);
    }
    let mut most = 0.0_f32;
    for step in steps {
        most = most.max(largest(Shown::Density(step))?);
    }
    Ok(if full > 0.0 {
        full.max(most / DENSEST)
    } else {
        most
    })
}

/// The array of a component of vectors.
fn component(name: &str, axis: usize) -> String {
    format!("{name}_{}", AXES.get(axis).copied().unwrap_or_default())
}

/// As many numbers in single precision: enough for pictures.
fn rounded(values: Vec<f64>) -> Vec<f32> {
    values.into_iter().map(|value| value as f32).collect()
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
        let names = array_names(path, KEY).map_err(OutputError::unusable)?;
        let names = BTreeSet::from_iter(names);
        // Another program may have left the targets out.
        let has_targets = names.contains(TARGETS);
        let mut densities = Self {
            path: path.to_owned(),
            names,
            arrays: BTreeMap::new(),
            cells,
            steps,
            keyframes: keyframes.into_iter().filter(|_| has_targets).collect(),
            most: most.map(|most| most as f32),
        };
        let name = densities.name();
        let count = densities.array(name)?.count();
        if count != steps + 1 {
            return Err(densities.refuse(&format!(
                "has {count} entries of `{name}` and a report.json of the steps 0 to {steps}"
            )));
        }
        Ok(densities)
    }

    /// The array of the densities.
    fn name(&self) -> &'static str {
        densities_of(|name| self.names.contains(name))
    }

    /// The density of a step, rounded to 32 bits: enough for pictures.
    pub fn density(&mut self, step: usize) -> Result<Vec<f32>, OutputError> {
        self.pictured(self.name(), step)
    }

    /// A target, rounded to 32 bits.
    pub fn target(&mut self, index: usize) -> Result<Vec<f32>, OutputError> {
        self.pictured(TARGETS, index)
    }

    /// The solid cells as 1, others as 0, if there are any.
    pub fn solid(&mut self) -> Result<Option<Vec<f32>>, OutputError> {
        if !self.names.contains(SOLID) {
            return Ok(None);
        }
        let solid = measured(KEY, &self.path, Some(SOLID)).map_err(OutputError::unusable)?;
        self.check_shape(SOLID, &solid.shape, &self.cells)?;
        Ok(Some(rounded(solid.values)))
    }

    /// Their body.
    pub fn body(&mut self) -> Result<Option<Body>, OutputError> {
        let solid = self.solid()?;
        Ok(solid.and_then(|solid| Body::new(&self.cells, &solid)))
    }

    /// See [`full`].
    pub fn full(&mut self) -> Result<f32, OutputError> {
        let (targets, steps, most) = (self.keyframes.len(), 0..=self.steps, self.most);
        full(targets, steps, most, &mut |of| {
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
        (0..self.cells.len()).all(|axis| self.names.contains(&component(name, axis)))
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
        self.field(&component(name, axis), step, &counts).map(rounded)
    }

    /// The vectors `name` of a step at the centres of the cells, times `scale`: of those on faces, the mean of the two of each cell.
    pub fn at_centres<const D: usize>(
        &mut self,
        name: &str,
        step: usize,
        places: &Places,
        scale: f32,
    ) -> Result<Vec<[f32; D]>, OutputError> {
        let in_space = |counts: &[usize]| core::array::from_fn(|axis| counts.get(axis).copied().unwrap_or(1));
        let cells = in_space(&self.cells);
        let mut vectors = vec![[0.0; D]; cells.iter().product()];
        for axis in 0..D {
            let counts = places.counts(&self.cells, axis);
            let mut values = self.field(&component(name, axis), step, &counts)?;
            if !places.centred {
                values = middle(&values, cells, in_space(&counts), axis);
            }
            for (vector, value) in vectors.iter_mut().zip(values) {
                vector[axis] = scale * value as f32;
            }
        }
        Ok(vectors)
    }

    /// A field of cells, rounded to 32 bits.
    fn pictured(&mut self, name: &str, index: usize) -> Result<Vec<f32>, OutputError> {
        let cells = self.cells.clone();
        self.field(name, index, &cells).map(rounded)
    }

    fn array(&mut self, name: &str) -> Result<&mut Series, OutputError> {
        match self.arrays.entry(name.to_owned()) {
            Entry::Occupied(opened) => Ok(opened.into_mut()),
            Entry::Vacant(place) => {
                let opened = Series::open(&self.path, Some(name), KEY).map_err(OutputError::unusable)?;
                Ok(place.insert(opened))
            }
        }
    }

    /// Entry `index` of an array whose entries are fields of `counts` numbers along x, y (and z), all of which single precision holds.
    fn field(&mut self, name: &str, index: usize, counts: &[usize]) -> Result<Vec<f64>, OutputError> {
        let array = self.array(name)?;
        let (count, shape) = (array.count(), array.shape().to_vec());
        if index >= count {
            return Err(self.refuse(&format!(
                "has {count} entries of `{name}`, and number {index} is needed"
            )));
        }
        self.check_shape(name, &shape, counts)?;
        let read = self.array(name)?.read(index).map_err(OutputError::unusable)?;
        match read.iter().find(|&&value| !(value as f32).is_finite()) {
            None => Ok(read),
            Some(value) => Err(self.refuse(&format!("holds {value:e} in entry {index} of `{name}`"))),
        }
    }

    /// Refuses entries of another shape than that of `counts` numbers along x, y (and z).
    fn check_shape(&self, name: &str, found: &[usize], counts: &[usize]) -> Result<(), OutputError> {
        let shape: Vec<usize> = counts.iter().rev().copied().collect();
        if found == shape {
            return Ok(());
        }
        Err(self.refuse(&format!(
            "has `{name}` of {found:?} and a report.json by which that is of {shape:?}"
        )))
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
        // Of the source, of targets, of the other steps, by the report.
        for (source, targets, later, said, expected) in [
            (1.0, &[1.4][..], 1.3, Some(1.3), 1.0),
            (1.0, &[], 2.0, None, 1.0),
            (1.0, &[], 3.0, Some(3.0), 1.5),
            // What the report says of smoke that is no longer there.
            (1.0, &[], 0.5, Some(3.0), 1.0),
            (0.02, &[], 1.0, Some(1.0), 0.5),
            (0.0, &[0.5, 0.8], 1.2, None, 0.8),
            (0.0, &[], 1.6, Some(9.0), 1.6),
            (0.0, &[], 0.0, None, 0.0),
        ] {
            let Ok(found) = full(targets.len(), 0..=1, said, &mut |of| {
                Ok::<_, core::convert::Infallible>(match of {
                    Shown::Density(step) => [source, later][step],
                    Shown::Target(index) => targets[index],
                })
            });
            assert_eq!(found, expected, "{source}, {targets:?}, {later}, {said:?}");
        }
    }
}
