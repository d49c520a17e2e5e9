//! The densities and the flow of an earlier result, read one step at a time.

use std::path::Path;

use super::canvas::in_words;
use super::error::Fault;
use super::frames::has_array;
use super::note::Note;
use super::npy::Array;
use super::series::Series;
use super::velocity::faces;
use super::{Canvas, ShapeError};

/// What messages call the file.
const KEY: &str = "result";

/// The arrays of a result.
pub struct Earlier {
    canvas: Canvas,
    density: Series,
    velocity: Vec<Series>,
    /// Steps that hold: all, or those before a simulation was stopped.
    steps: usize,
}

impl Earlier {
    /// Those of the `result.npz` at `path`, on the cells of `canvas`. Its densities are `captured`, what was photographed or simulated, where it has
    /// that.
    ///
    /// # Errors
    /// A file that cannot be read, or without density or velocity.
    pub fn open(path: &Path, canvas: Canvas) -> Result<Self, ShapeError> {
        let open = |name: &str| Series::open(path, Some(name), KEY);
        let density = if has_array(path, "captured") {
            "captured"
        } else {
            "density"
        };
        let axes = 0..canvas.dimensions();
        Ok(Self {
            density: open(density)?,
            velocity: axes
                .map(|axis| open(faces(axis, &canvas).0))
                .collect::<Result<_, _>>()?,
            canvas,
            steps: usize::MAX,
        })
    }

    /// The same up to a step, where one is given, behind which nothing was simulated.
    #[must_use]
    pub fn until(mut self, step: Option<usize>) -> Self {
        self.steps = step.unwrap_or(self.steps);
        self
    }

    /// The same on the cells that it has, where the box has as many axes.
    #[must_use]
    pub fn as_it_is(mut self) -> Self {
        let cells: Vec<usize> = self.density.shape().iter().rev().copied().collect();
        if cells.len() == self.canvas.cells.len() {
            self.canvas.cells = cells;
        }
        self
    }

    /// The cells that it is read on.
    #[must_use]
    pub fn canvas(&self) -> &Canvas {
        &self.canvas
    }

    /// How many densities there are.
    #[must_use]
    pub fn densities(&self) -> usize {
        self.density.count().min(self.steps.saturating_add(1))
    }

    /// How many steps of the flow.
    #[must_use]
    pub fn flows(&self) -> usize {
        let flows = self.velocity.iter().map(Series::count).min().unwrap_or(0);
        flows.min(self.steps)
    }

    /// Density `step`, or the last one, as it is.
    ///
    /// # Errors
    /// A file that cannot be read, another size, a value that is not finite.
    pub fn frame(&mut self, step: Option<usize>) -> Result<Vec<f64>, ShapeError> {
        self.array_of_density(step)
            .map(|array| array.values)
            .map_err(|fault| fault.of(KEY, self.density.path()))
    }

    /// The same as a density. What transport has undershot becomes 0, of which a sentence is added to `notes`.
    ///
    /// # Errors
    /// As [`Self::frame`], or a density that is none.
    pub fn density(&mut self, step: Option<usize>, notes: &mut Vec<Note>) -> Result<Vec<f64>, ShapeError> {
        let read = self.array_of_density(step).and_then(|mut array| {
            let said = array.clip()?;
            Ok((array.values, said))
        });
        let path = self.density.path();
        let (values, said) = read.map_err(|fault| fault.of(KEY, path))?;
        if let Some(text) = said {
            let which = step.map_or("the last".into(), |step| format!("the {step}."));
            notes.push(Note::remark(format!(
                "{which} density of `{}` {text}",
                path.display()
            )));
        }
        Ok(values)
    }

    /// A component of velocity `step`, or of the last one.
    ///
    /// # Errors
    /// As [`Self::frame`].
    pub fn velocity(&mut self, step: Option<usize>, axis: usize) -> Result<Vec<f64>, ShapeError> {
        let (name, shape) = faces(axis, &self.canvas);
        let Some(series) = self.velocity.get_mut(axis) else {
            return Ok(Vec::new());
        };
        let read = entry(series, name, step, shape).map(|array| array.values);
        read.map_err(|fault| fault.of(KEY, series.path()))
    }

    fn array_of_density(&mut self, step: Option<usize>) -> Result<Array, Fault> {
        let shape = self.canvas.cells.iter().rev().copied().collect();
        entry(&mut self.density, "density", step, shape)
    }
}

/// Entry `step` of `series`, whose entries have the shape `expected`, or its last one; `name` is for messages.
fn entry(series: &mut Series, name: &str, step: Option<usize>, expected: Vec<usize>) -> Result<Array, Fault> {
    if series.shape() != expected {
        let found = format!("has {name} with steps of shape ({})", in_words(series.shape()));
        return Err(Fault::content(
            found,
            format!("on this grid it is {expected:?}; give a result with the same cells and boundary"),
        ));
    }
    let array = series.array(step.unwrap_or(series.count().saturating_sub(1)))?;
    array.refuse_not_finite()?;
    Ok(array)
}
