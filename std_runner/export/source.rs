//! The result that is exported, read one step at a time.

use super::orient::{Lattice, Orientation};
use crate::exit::Failure;
use crate::keyframes::{Series, ShapeError, VELOCITY, has_array};
use crate::output::{densities_of, middle};
use crate::report::{ARCHIVE, Said};
use std::path::{Path, PathBuf};

/// What messages call the file.
const KEY: &str = "result";

/// A component of the velocity on the faces across an axis.
pub(super) struct Faces {
    pub values: Vec<f64>,
    /// Faces along x, y, z.
    counts: [usize; 3],
}

impl Faces {
    /// All of them: along the axis of a ring the first ones stand behind the last cells again.
    fn whole(values: Vec<f64>, mut counts: [usize; 3], ring: Option<usize>) -> Self {
        let Some(axis) = ring else {
            return Self { values, counts };
        };
        let width: usize = counts.iter().take(axis).product();
        let lines = values.chunks_exact((width * counts[axis]).max(1));
        let closed = lines.flat_map(|line| line.iter().chain(line.iter().take(width)));
        let values = closed.copied().collect();
        counts[axis] += 1;
        Self { values, counts }
    }

    /// Their places in a file.
    pub fn lattice(&self, orientation: &Orientation) -> Lattice {
        orientation.lattice(self.counts)
    }
}

/// A step.
pub(super) struct Frame {
    pub step: usize,
    /// x fastest, as all fields here.
    pub density: Vec<f64>,
    /// The velocity in the middle of cells, by axis; none where the result has none.
    pub velocity: Vec<Vec<f64>>,
    /// The velocity as the result has it, where that is asked for.
    pub faces: Vec<Faces>,
}

/// A result folder.
pub(super) struct Source {
    folder: PathBuf,
    pub said: Said,
    density: Series,
    velocity: Vec<Series>,
}

impl Source {
    /// Opens the result in `folder`.
    pub fn open(folder: &Path) -> Result<Self, Failure> {
        let said = Said::of(folder)?;
        let path = folder.join(ARCHIVE);
        let open = |name: &str| Series::open(&path, Some(name), KEY).map_err(|error| unread(folder, &error));
        let density = open(densities_of(|name| has_array(&path, name)))?;
        let names = VELOCITY.iter().take(said.cells.len());
        let velocity = if names.clone().all(|name| has_array(&path, name)) {
            names.map(|name| open(name)).collect::<Result<_, _>>()?
        } else {
            Vec::new()
        };
        let source = Self {
            folder: folder.to_owned(),
            said,
            density,
            velocity,
        };
        source.check()?;
        Ok(source)
    }

    /// Refuses arrays of other cells than the report's.
    fn check(&self) -> Result<(), Failure> {
        let cells: Vec<usize> = self.said.cells.iter().rev().copied().collect();
        let wrong = |what: &str, found: &[usize]| {
            self.refuse(&format!(
                "has {what} of {found:?} cells and a report.json of {cells:?}; export the folder as it was written"
            ))
        };
        if self.density.shape() != cells {
            return Err(wrong("density", self.density.shape()));
        }
        for (axis, series) in self.velocity.iter().enumerate() {
            let mut rest = series.shape().to_vec();
            let own = rest.len().wrapping_sub(axis + 1);
            let found = rest.get_mut(own).map(|own| core::mem::replace(own, 0));
            let mut expected = cells.clone();
            let count = expected.get_mut(own).map(|own| core::mem::replace(own, 0));
            if rest != expected || !(found == count || found == count.map(|count| count + 1)) {
                return Err(wrong(VELOCITY[axis], series.shape()));
            }
        }
        Ok(())
    }

    /// The archive.
    pub fn archive(&self) -> PathBuf {
        self.folder.join(ARCHIVE)
    }

    /// The last step.
    pub fn steps(&self) -> usize {
        self.density.count() - 1
    }

    /// Whether it has a flow.
    pub fn has_flow(&self) -> bool {
        !self.velocity.is_empty()
    }

    /// Cells along x, y, z; a plane is one thick.
    pub fn cells(&self) -> [usize; 3] {
        let mut cells = [1; 3];
        cells
            .iter_mut()
            .zip(&self.said.cells)
            .for_each(|(to, &from)| *to = from);
        cells
    }

    /// The sides of the box.
    pub fn sides(&self) -> [f64; 3] {
        self.cells().map(|count| count as f64 * self.said.side())
    }

    /// Bytes that a step takes, with `faces` the velocity's own faces too, with `packed` an entry of an array as it is written.
    pub fn bytes(&self, faces: bool, packed: bool) -> usize {
        let counts: Vec<usize> = self
            .velocity
            .iter()
            .map(|one| one.shape().iter().product())
            .collect();
        let cells: usize = self.said.cells.iter().product();
        let fields = cells * (1 + counts.len());
        let read = counts.iter().copied().max().unwrap_or(cells);
        let size = if self.said.double { 8 } else { 4 };
        // A ring has a layer of faces more in the file.
        let least = self.said.cells.iter().copied().min().unwrap_or(1).max(1);
        let layers = counts.iter().sum::<usize>().div_ceil(least);
        let kept = if faces {
            counts.iter().sum::<usize>() + layers
        } else {
            0
        };
        // Doubles, and an eighth more for masks and what is being written.
        8 * (fields + read + kept) + cells + if packed { size * read } else { 0 }
    }

    /// A step; the last one has the velocity that led to it.
    pub fn frame(&mut self, step: usize, with_faces: bool) -> Result<Frame, Failure> {
        let density = self.density.read(step);
        let density = density.map_err(|error| unread(&self.folder, &error))?;
        self.refuse_not_finite("density", step, &density)?;
        let (mut velocity, mut faces) = (Vec::new(), Vec::new());
        let cells = self.cells();
        for axis in 0..self.velocity.len() {
            let Some(series) = self.velocity.get_mut(axis) else {
                continue;
            };
            let read = series.read(step.min(series.count() - 1));
            let own = series.shape().iter().rev().nth(axis).copied().unwrap_or(0);
            let values = read.map_err(|error| unread(&self.folder, &error))?;
            self.refuse_not_finite(VELOCITY[axis], step, &values)?;
            let centred = self.said.centred && own == cells[axis];
            let mut counts = cells;
            counts[axis] = own;
            velocity.push(if centred {
                values.clone()
            } else {
                middle(&values, cells, counts, axis)
            });
            if with_faces {
                let is_ring = !centred && own == cells[axis];
                faces.push(Faces::whole(values, counts, is_ring.then_some(axis)));
            }
        }
        Ok(Frame {
            step,
            density,
            velocity,
            faces,
        })
    }

    fn refuse_not_finite(&self, name: &str, step: usize, values: &[f64]) -> Result<(), Failure> {
        match values.iter().find(|value| !value.is_finite()) {
            None => Ok(()),
            Some(value) => {
                let remedy = match step {
                    0 => "solve it again",
                    _ => "export the steps before it with --steps",
                };
                let found = format!("holds {value} in {name} of step {step}; {remedy}");
                Err(self.refuse(&found))
            }
        }
    }

    /// A refusal of the folder.
    pub fn refuse(&self, why: &str) -> Failure {
        Failure::Input(format!("{} {why}", self.folder.display()))
    }
}

pub(super) fn unread(folder: &Path, error: &ShapeError) -> Failure {
    error.failure(format!("{}: {error}", folder.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_is_closed_by_the_faces_that_it_begins_with() {
        let values: Vec<f64> = (0..12).map(f64::from).collect();
        let Faces {
            values: closed,
            counts,
        } = Faces::whole(values.clone(), [2, 3, 2], Some(1));
        assert_eq!(counts, [2, 4, 2]);
        assert_eq!(
            closed,
            [
                0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 0.0, 1.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 6.0, 7.0
            ]
        );
        let open = Faces::whole(values.clone(), [2, 3, 2], None);
        assert_eq!((open.values, open.counts), (values, [2, 3, 2]));
    }
}
