//! `result.npz`: every array of a result, streamed step by step.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use thurible_core::{Output, Place, Real};

use super::npz::{Npz, write_npz};
use super::{Frames, GivenValues, OutputError, Precision, Samples};

/// Numbers that are written at a time.
const PIECE: usize = 1 << 12;

const AXES: [&str; 3] = ["x", "y", "z"];

/// Writes `path`, holding one field in memory at a time.
pub(crate) fn write_archive(path: &Path, frames: &mut dyn Frames) -> Result<(), OutputError> {
    write_npz(path, |npz| {
        let samples = Samples::new(frames.precision());
        Archive { npz, path, samples }.write(frames)
    })
}

/// An array whose values are in a file of their own, one entry after the other.
pub(crate) struct Packed<'a> {
    pub name: &'a str,
    /// Entries that are taken; `None` where there is one and no axis for it.
    pub count: Option<usize>,
    /// Their shape, x last.
    pub shape: &'a [usize],
    pub values: &'a Path,
}

/// Writes `path` from arrays of `precision` that were written before, by copying.
pub(crate) fn pack_archive(
    path: &Path,
    precision: Precision,
    arrays: &[Packed<'_>],
) -> Result<(), OutputError> {
    write_npz(path, |npz| {
        let samples = Samples::new(precision);
        let mut archive = Archive { npz, path, samples };
        arrays.iter().try_for_each(|array| archive.copy(array))
    })
}

struct Archive<'a, 'z> {
    npz: &'a mut Npz<'z>,
    path: &'a Path,
    /// The one field that is in memory.
    samples: Samples,
}

impl Archive<'_, '_> {
    fn write(&mut self, frames: &mut dyn Frames) -> Result<(), OutputError> {
        let cells = frames.cells().to_vec();
        for output in frames.outputs() {
            let count = output.count(frames.steps());
            for axis in 0..output.components(cells.len()) {
                let (name, grid) = (array_name(output, axis), elements(frames, output, axis));
                self.series(&name, count, &grid, &mut |step, out| {
                    frames.read(output, step, axis, out)
                })?;
            }
        }
        let keyframes = frames.keyframe_steps();
        self.npz.begin("keyframe_step", "<i8", &[keyframes.len()])?;
        let whole: Vec<i64> = keyframes
            .iter()
            .map(|&step| i64::try_from(step).unwrap_or(i64::MAX))
            .collect();
        self.npz.put(|file| push(file, &whole, i64::to_le_bytes))?;
        self.series("keyframe_density", keyframes.len(), &cells, &mut |index, out| {
            frames.keyframe(index, out)
        })?;
        for given in frames.given() {
            match given.values {
                GivenValues::Cells => self.field(given.name, &cells, &mut |out| {
                    frames.given_field(given.name, 0, out)
                })?,
                GivenValues::Fields(count) => self.series(given.name, count, &cells, &mut |index, out| {
                    frames.given_field(given.name, index, out)
                })?,
                GivenValues::Faces(count, axis) => {
                    let grid = faces(frames, axis);
                    self.series(given.name, count, &grid, &mut |index, out| {
                        frames.given_field(given.name, index, out)
                    })?;
                }
                GivenValues::Numbers(values) => {
                    self.npz.begin(given.name, "<f8", &[values.len()])?;
                    self.npz.put(|file| push(file, &values, f64::to_le_bytes))?;
                }
            }
        }
        Ok(())
    }

    /// An array from a file of its values.
    fn copy(&mut self, array: &Packed<'_>) -> Result<(), OutputError> {
        let (kind, bytes) = self.kind();
        let shape: Vec<usize> = array
            .count
            .into_iter()
            .chain(array.shape.iter().copied())
            .collect();
        self.npz.begin(array.name, kind, &shape)?;
        let expected = shape.iter().product::<usize>();
        let file = File::open(array.values).map_err(OutputError::unread(array.values))?;
        let mut values = file.take((expected * bytes) as u64);
        let copied = self.npz.put(|file| io::copy(&mut values, file))?;
        let found = copied as usize / bytes;
        if found == expected {
            return Ok(());
        }
        let (path, array) = (self.path.to_owned(), array.name.to_owned());
        Err(OutputError::Size {
            path,
            array,
            found,
            expected,
        })
    }

    /// The type of the values as NumPy names it, and its bytes.
    fn kind(&self) -> (&'static str, usize) {
        match self.samples {
            Samples::F32(_) => ("<f4", size_of::<f32>()),
            Samples::F64(_) => ("<f8", size_of::<f64>()),
        }
    }

    /// One field of `grid` values.
    fn field(
        &mut self,
        name: &str,
        grid: &[usize],
        field: &mut dyn FnMut(&mut Samples),
    ) -> Result<(), OutputError> {
        self.array(name, grid.iter().rev().copied().collect(), 1, &mut |_, out| {
            field(out)
        })
    }

    /// `count` fields of `grid` values, each asked for when its turn comes.
    fn series(
        &mut self,
        name: &str,
        count: usize,
        grid: &[usize],
        field: &mut dyn FnMut(usize, &mut Samples),
    ) -> Result<(), OutputError> {
        let mut shape = vec![count];
        shape.extend(grid.iter().rev());
        self.array(name, shape, count, field)
    }

    /// An array of this shape, written as `count` parts.
    fn array(
        &mut self,
        name: &str,
        shape: Vec<usize>,
        count: usize,
        field: &mut dyn FnMut(usize, &mut Samples),
    ) -> Result<(), OutputError> {
        let (kind, _) = self.kind();
        self.npz.begin(name, kind, &shape)?;
        let expected: usize = shape.iter().product::<usize>() / count.max(1);
        for index in 0..count {
            field(index, &mut self.samples);
            if self.samples.len() != expected {
                let (path, array) = (self.path.to_owned(), format!("{name}[{index}]"));
                return Err(OutputError::Size {
                    path,
                    array,
                    found: self.samples.len(),
                    expected,
                });
            }
            self.npz.put(|file| match &self.samples {
                Samples::F32(values) => push(file, values, f32::to_le_bytes),
                Samples::F64(values) => push(file, values, f64::to_le_bytes),
            })?;
        }
        Ok(())
    }
}

/// An array in memory, in parts that follow each other along its first axis.
pub(crate) struct Plain<'a, T> {
    pub name: String,
    pub shape: Vec<usize>,
    pub parts: Vec<&'a [T]>,
}

/// Writes arrays as they are into the archive `path`.
pub(crate) fn write_arrays<T: Real>(path: &Path, arrays: &[Plain<'_, T>]) -> Result<(), OutputError> {
    let kind = if T::BYTES == 4 { "<f4" } else { "<f8" };
    write_npz(path, |npz| {
        arrays.iter().try_for_each(|array| {
            npz.begin(&array.name, kind, &array.shape)?;
            npz.put(|file| array.parts.iter().try_for_each(|part| put(file, part)))
        })
    })
}

fn put<T: Real>(file: &mut dyn Write, values: &[T]) -> io::Result<()> {
    let mut bytes = Vec::with_capacity(PIECE * T::BYTES);
    for values in values.chunks(PIECE) {
        bytes.resize(values.len() * T::BYTES, 0);
        for (bytes, value) in bytes.chunks_exact_mut(T::BYTES).zip(values) {
            value.write(bytes);
        }
        file.write_all(&bytes)?;
    }
    Ok(())
}

/// The name of the array of a component.
pub(crate) fn array_name(output: &Output, axis: usize) -> String {
    match (output.place, AXES.get(axis)) {
        (Place::Faces, Some(axis)) => format!("{}_{axis}", output.name),
        _ => output.name.into(),
    }
}

/// Elements of the component along `axis`, along x, y (and z).
fn elements(frames: &dyn Frames, output: &Output, axis: usize) -> Vec<usize> {
    match output.place {
        Place::Cells => frames.cells().to_vec(),
        Place::Faces => faces(frames, axis),
    }
}

/// The faces across `axis`, along x, y (and z).
fn faces(frames: &dyn Frames, axis: usize) -> Vec<usize> {
    let mut counts = frames.cells().to_vec();
    let wall = !frames.periodic().get(axis).copied().unwrap_or(false);
    counts
        .iter_mut()
        .skip(axis)
        .take(1)
        .for_each(|count| *count += usize::from(wall));
    counts
}

/// Writes `values` through a small buffer.
pub(super) fn push<T: Copy, const N: usize>(
    sink: &mut (impl Write + ?Sized),
    values: &[T],
    bytes: impl Fn(T) -> [u8; N],
) -> io::Result<()> {
    let mut buffer = [[0; N]; 512];
    for chunk in values.chunks(buffer.len()) {
        buffer
            .iter_mut()
            .zip(chunk)
            .for_each(|(place, &value)| *place = bytes(value));
        sink.write_all(buffer[..chunk.len()].as_flattened())?;
    }
    Ok(())
}
