//! Reading of NumPy arrays without trusting a byte of them.

use std::io::Read;

use super::canvas::in_words;
use super::error::Fault;
use super::header::Header;
use crate::undershoot::{Undershoot, clip, place};

/// More values than this (4096 cubed) fit into no grid.
const MOST_VALUES: usize = 1 << 36;

/// An array with x last in `shape`, and fastest in `values`.
pub(super) struct Array {
    pub shape: Vec<usize>,
    pub values: Vec<f64>,
}

impl Array {
    /// The first value that is NaN or infinite.
    pub(super) fn refuse_not_finite(&self) -> Result<(), Fault> {
        match self.values.iter().position(|value| !value.is_finite()) {
            None => Ok(()),
            Some(index) => {
                let found = format!("holds {} at {}", self.values[index], self.place(index));
                Err(Fault::content(found, "every value must be finite"))
            }
        }
    }

    /// Sets what little of a density is below 0 to 0 and says so, or refuses what is no density.
    pub(super) fn clip(&mut self) -> Result<Option<String>, Fault> {
        let Some(found) = Undershoot::of(&self.values) else {
            return Ok(None);
        };
        if !found.is_small() {
            let [found, remedy] = found.refused(&self.shape);
            return Err(Fault::content(found, remedy));
        }
        clip(&mut self.values);
        Ok(Some(found.taken()))
    }

    /// Where value `index` stands, as NumPy writes it.
    pub(super) fn place(&self, index: usize) -> String {
        place(index, &self.shape)
    }

    /// The shape in words, "60 x 128 x 128", as NumPy orders it.
    pub(super) fn size_in_words(&self) -> String {
        in_words(&self.shape)
    }
}

/// Bytes that are read at a time: whole numbers of any kind.
const PIECE: usize = 1 << 13;

/// Reads one array, as `.npy` files and members of `.npz` files hold it.
pub(super) fn read_array(reader: &mut dyn Read) -> Result<Array, Fault> {
    let header = Header::read(reader)?;
    read_values(reader, &header)
}

/// An entry along the first axis of an array.
#[derive(Clone, Copy)]
pub(super) enum Entry {
    /// Number so much, from 0.
    At(usize),
    /// The last one.
    Last,
}

/// How many entries an array has along its first axis.
pub(super) fn read_steps(reader: &mut dyn Read) -> Result<usize, Fault> {
    Header::read(reader)?.entries().map(|(_, count)| count)
}

/// Reads one entry along the first axis of an array, and no more of the others than it takes to pass them.
pub(super) fn read_entry(reader: &mut dyn Read, entry: Entry) -> Result<Array, Fault> {
    let (header, steps) = Header::read(reader)?.entries()?;
    let entry = match entry {
        Entry::At(entry) => entry.min(steps - 1),
        Entry::Last => steps - 1,
    };
    let step = header
        .shape
        .iter()
        .try_fold(header.kind.bytes, |product, &side| product.checked_mul(side))
        .unwrap_or(usize::MAX);
    let before = (entry as u64).saturating_mul(step as u64);
    std::io::copy(&mut reader.take(before), &mut std::io::sink())?;
    read_values(reader, &header)
}

/// The values after a header.
pub(super) fn read_values(reader: &mut dyn Read, header: &Header) -> Result<Array, Fault> {
    let count = header
        .shape
        .iter()
        .try_fold(1_usize, |product, &side| product.checked_mul(side));
    let Some(count) = count.filter(|&count| count <= MOST_VALUES) else {
        return Err(Fault::content(
            format!("has {} values", in_words(&header.shape)),
            "that is too many",
        ));
    };
    let Header { kind, .. } = *header;
    let mut values = Vec::new();
    let room = values.try_reserve_exact(count);
    room.map_err(|_| {
        Fault::content(
            format!("has {} values", in_words(&header.shape)),
            "the system has not the memory for so many",
        )
    })?;
    let mut piece = Vec::with_capacity(PIECE);
    let mut read = 0;
    while values.len() < count {
        piece.clear();
        let wanted = PIECE.min((count - values.len()) * kind.bytes);
        let taken = reader.take(wanted as u64).read_to_end(&mut piece);
        read += taken.map_err(|error| Fault::content(format!("breaks off ({error})"), "save it again"))?;
        if piece.len() < wanted {
            let found = format!(
                "holds {read} bytes of data where its header promises {}",
                count * kind.bytes
            );
            return Err(Fault::content(found, "it was cut off: save it again"));
        }
        values.extend(piece.chunks_exact(kind.bytes).map(|bytes| kind.value(bytes)));
    }
    if header.columns_first {
        values = rows_first(&values, &header.shape);
    }
    Ok(Array {
        shape: header.shape.clone(),
        values,
    })
}

/// Turns values with the first index fastest into values with the last index fastest.
fn rows_first(values: &[f64], shape: &[usize]) -> Vec<f64> {
    let mut strides = vec![1; shape.len()];
    for axis in 1..shape.len() {
        strides[axis] = strides[axis - 1] * shape[axis - 1];
    }
    let place = |index: usize| {
        let mut rest = index;
        let mut from = 0;
        for (&side, &stride) in shape.iter().zip(&strides).rev() {
            from += rest % side * stride;
            rest /= side;
        }
        from
    };
    (0..values.len()).map(|index| values[place(index)]).collect()
}
