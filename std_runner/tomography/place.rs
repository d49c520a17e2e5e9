//! The box, in the units of the cameras.

use super::raw::RawBox;
use super::vector::Vector;
use crate::exit::Failure;
use crate::scene::Document;

/// Cells along an axis, at most.
const MOST: i64 = 4096;

/// The box in the units of the cameras.
pub(super) struct Place {
    pub dims: usize,
    pub origin: Vector,
    /// Side of a cell.
    pub side: f64,
    /// Cells along each axis, 1 beyond the dimensions.
    pub cells: Vector,
}

impl Place {
    /// The middle of the box, in the units of the cameras.
    pub fn middle(&self) -> Vector {
        core::array::from_fn(|axis| {
            if axis < self.dims {
                self.origin[axis] + 0.5 * self.side * self.cells[axis]
            } else {
                0.0
            }
        })
    }

    /// A place in cells, from the box's lower corner.
    pub fn in_cells(&self, place: Vector) -> Vector {
        core::array::from_fn(|axis| {
            if axis < self.dims {
                (place[axis] - self.origin[axis]) / self.side
            } else {
                0.0
            }
        })
    }
}

/// The number at `key`, which has to be above 0.
pub(super) fn positive(document: &Document, key: &str, number: f64) -> Result<f64, Failure> {
    if number > 0.0 && number.is_finite() {
        Ok(number)
    } else {
        Err(document.refuse(key, format!("is {number}; write a number above 0")))
    }
}

/// Reads the box, and its cells along x, y (and z).
pub(super) fn place(document: &Document, raw: &RawBox) -> Result<(Place, Vec<usize>), Failure> {
    let dims = raw.cells.len();
    let fits = |&count: &i64| (2..=MOST).contains(&count);
    if !(2..=3).contains(&dims) || !raw.cells.iter().all(fits) {
        let why = format!("is {:?}; write two or three counts from 2 to {MOST}", raw.cells);
        return Err(document.refuse("box.cells", why));
    }
    let length = positive(document, "box.length", raw.length.unwrap_or(1.0))?;
    let given = raw.origin.clone().unwrap_or(vec![0.0; dims]);
    if given.len() != dims || given.iter().any(|x| !x.is_finite()) {
        let why = format!("is {given:?}; write {dims} finite numbers, the lower corner of the box");
        return Err(document.refuse("box.origin", why));
    }
    let cells: Vec<usize> = raw
        .cells
        .iter()
        .filter_map(|&count| usize::try_from(count).ok())
        .collect();
    let of = |values: &mut dyn Iterator<Item = f64>, rest: f64| {
        let mut vector = [rest; 3];
        vector.iter_mut().zip(values).for_each(|(to, from)| *to = from);
        vector
    };
    let place = Place {
        dims,
        origin: of(&mut given.into_iter(), 0.0),
        side: length / cells.iter().copied().max().unwrap_or(1) as f64,
        cells: of(&mut cells.iter().map(|&count| count as f64), 1.0),
    };
    Ok((place, cells))
}
