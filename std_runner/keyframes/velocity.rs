//! An initial velocity from a file, laid out as a result is.

use std::path::Path;

use super::error::Fault;
use super::note::Note;
use super::npy::{Array, Entry};
use super::npz;
use super::{Canvas, ShapeError};

/// Reads `velocity_x`, `velocity_y` (and `velocity_z`) of a `.npz` file, one list of faces an axis, x fastest.
///
/// A component has one face more than cells along its own axis if that axis is a wall. A leading axis of length 1
/// (one step of a result) is allowed.
///
/// # Errors
/// A file that cannot be read, lacks a component, has another size, or holds a value that is not finite.
pub fn read_velocity(path: &Path, canvas: &Canvas) -> Result<Vec<Vec<f64>>, ShapeError> {
    let component =
        |axis: usize| component(path, axis, canvas).map_err(|fault| fault.of("initial_velocity", path));
    (0..canvas.dimensions()).map(component).collect()
}

fn component(path: &Path, axis: usize, canvas: &Canvas) -> Result<Vec<f64>, Fault> {
    if path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("npy"))
    {
        return Err(Fault::content(
            "is one array",
            "save velocity_x, velocity_y (and velocity_z) together by numpy.savez",
        ));
    }
    let (name, expected) = faces(axis, canvas);
    let array = npz::read(path, Some(name))?;
    let one_step = array.shape.len() == expected.len() + 1 && array.shape.first() == Some(&1);
    if array.shape.get(usize::from(one_step)..) != Some(expected.as_slice()) {
        let found = format!("has {name} of shape ({})", array.size_in_words());
        let remedy =
            format!("its faces on this grid are {expected:?}; save one step of a result with the same cells");
        return Err(Fault::content(found, remedy));
    }
    array.refuse_not_finite()?;
    Ok(array.values)
}

/// The name of a velocity's component and its shape, x last.
fn faces(axis: usize, canvas: &Canvas) -> (&'static str, Vec<usize>) {
    let name = ["velocity_x", "velocity_y", "velocity_z"]
        .get(axis)
        .copied()
        .unwrap_or_default();
    let mut shape = canvas.cells.clone();
    if let Some(faces) = shape.get_mut(axis) {
        *faces += usize::from(!canvas.repeats(axis));
    }
    shape.reverse();
    (name, shape)
}

/// The densities and the flow of an earlier result, read one step at a time.
pub struct Earlier<'a> {
    path: &'a Path,
    canvas: &'a Canvas,
    /// `captured`, what was photographed or simulated, where a result has it; else `density`.
    name: &'static str,
    /// Its densities.
    pub densities: usize,
    /// The steps of its flow.
    pub flows: usize,
}

impl<'a> Earlier<'a> {
    /// That of the `result.npz` at `path`, on the cells of `canvas`.
    ///
    /// # Errors
    /// A file that cannot be read, or without density or velocity.
    pub fn open(path: &'a Path, canvas: &'a Canvas) -> Result<Self, ShapeError> {
        let open = || {
            let name = if npz::holds(path, "captured")? {
                "captured"
            } else {
                "density"
            };
            Ok(Self {
                path,
                canvas,
                name,
                densities: npz::steps(path, Some(name))?,
                flows: npz::steps(path, Some("velocity_x"))?,
            })
        };
        open().map_err(|fault: Fault| fault.of("result", path))
    }

    /// Density `step`, or the last one. What transport has undershot becomes 0, of which a sentence is added to `notes`.
    ///
    /// # Errors
    /// As [`read_velocity`], or a density that is none.
    pub fn density(&self, step: Option<usize>, notes: &mut Vec<Note>) -> Result<Vec<f64>, ShapeError> {
        let shape = self.canvas.cells.iter().rev().copied().collect();
        let read = self.entry(self.name, step, shape).and_then(|mut array| {
            if let Some(text) = array.clip()? {
                let which = step.map_or("the last".into(), |step| format!("the {step}."));
                notes.push(Note::remark(format!(
                    "{which} density of `{}` {text}",
                    self.path.display()
                )));
            }
            Ok(array.values)
        });
        read.map_err(|fault| fault.of("result", self.path))
    }

    /// A component of velocity `step`, or of the last one.
    ///
    /// # Errors
    /// As [`read_velocity`].
    pub fn velocity(&self, step: Option<usize>, axis: usize) -> Result<Vec<f64>, ShapeError> {
        let (name, shape) = faces(axis, self.canvas);
        self.entry(name, step, shape)
            .map(|array| array.values)
            .map_err(|fault| fault.of("result", self.path))
    }

    /// Entry `step` of the array `name`, whose entries have the shape `expected`.
    fn entry(&self, name: &str, step: Option<usize>, expected: Vec<usize>) -> Result<Array, Fault> {
        let array = npz::read_entry(self.path, Some(name), step.map_or(Entry::Last, Entry::At))?;
        if array.shape != expected {
            let found = format!("has {name} with steps of shape ({})", array.size_in_words());
            return Err(Fault::content(
                found,
                format!("on this grid it is {expected:?}; give a result with the same cells and boundary"),
            ));
        }
        array.refuse_not_finite()?;
        Ok(array)
    }
}
