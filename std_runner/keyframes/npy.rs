//! Reading of NumPy arrays without trusting a byte of them.

use std::io::{ErrorKind, Read};

use super::canvas::in_words;
use super::error::Fault;
use crate::undershoot::{Undershoot, clip, place};

/// Headers longer than this are no headers.
const LONGEST_HEADER: usize = 1 << 16;
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
    steps(&mut Header::parse(&header_text(reader)?)?)
}

/// Takes the first axis off; its length.
fn steps(header: &mut Header) -> Result<usize, Fault> {
    let steps = if header.shape.is_empty() {
        0
    } else {
        header.shape.remove(0)
    };
    if steps == 0 || header.columns_first {
        return Err(Fault::content(
            "has an array without steps, or with its axes reversed",
            "give an array whose first axis is time, as results of thurible have it",
        ));
    }
    Ok(steps)
}

/// Reads one entry along the first axis of an array, and no more of the others than it takes to pass them.
pub(super) fn read_entry(reader: &mut dyn Read, entry: Entry) -> Result<Array, Fault> {
    let mut header = Header::parse(&header_text(reader)?)?;
    let steps = steps(&mut header)?;
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

/// The text of the header, a Python dictionary.
fn header_text(reader: &mut dyn Read) -> Result<String, Fault> {
    let broken = || Fault::content("is no NumPy array", "save it by numpy.save");
    let mut start = [0; 8];
    reader.read_exact(&mut start).map_err(|error| {
        if error.kind() == ErrorKind::UnexpectedEof {
            broken()
        } else {
            Fault::Read(error)
        }
    })?;
    if !start.starts_with(b"\x93NUMPY") {
        return Err(broken());
    }
    let mut length = [0; 4];
    let used = if start[6] == 1 { 2 } else { 4 };
    reader.read_exact(&mut length[..used]).map_err(|_| broken())?;
    let length = u32::from_le_bytes(length) as usize;
    if length > LONGEST_HEADER {
        return Err(broken());
    }
    let mut text = vec![0; length];
    reader.read_exact(&mut text).map_err(|_| broken())?;
    String::from_utf8(text).map_err(|_| broken())
}

/// What an array's header says.
pub(super) struct Header {
    kind: Kind,
    columns_first: bool,
    pub shape: Vec<usize>,
}

impl Header {
    /// Reads the header at the start of an array.
    pub(super) fn read(reader: &mut dyn Read) -> Result<Self, Fault> {
        Self::parse(&header_text(reader)?)
    }

    /// The header of an entry along the first axis, and how many entries there are.
    pub(super) fn entries(mut self) -> Result<(Self, usize), Fault> {
        let count = steps(&mut self)?;
        Ok((self, count))
    }

    /// Bytes of the values.
    pub(super) fn bytes(&self) -> u64 {
        let count = self.shape.iter().try_fold(self.kind.bytes, |product, &side| product.checked_mul(side));
        count.map_or(u64::MAX, |count| count as u64)
    }

    /// Reads `{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), }`.
    fn parse(text: &str) -> Result<Self, Fault> {
        let broken = || Fault::content("has a header that is not NumPy's", "save it by numpy.save");
        let after = |key: &str| {
            text.split_once(key)
                .map(|(_, rest)| rest.trim_start_matches([' ', ':']))
                .ok_or_else(broken)
        };
        let kind = after("'descr'")?;
        let Some(kind) = kind
            .strip_prefix('\'')
            .and_then(|rest| rest.split_once('\''))
            .map(|(kind, _)| kind)
        else {
            return Err(Fault::content(
                "is a table of records",
                "save one plain array of numbers",
            ));
        };
        let columns_first = after("'fortran_order'")?.starts_with("True");
        let shape = after("'shape'")?
            .strip_prefix('(')
            .and_then(|rest| rest.split_once(')'))
            .ok_or_else(broken)?
            .0;
        let sides = shape.split(',').map(str::trim).filter(|side| !side.is_empty());
        let shape = sides
            .map(|side| side.parse().map_err(|_| broken()))
            .collect::<Result<Vec<usize>, Fault>>()?;
        Ok(Self {
            kind: Kind::parse(kind)?,
            columns_first,
            shape,
        })
    }
}

/// How a number is stored.
#[derive(Clone, Copy)]
pub(super) struct Kind {
    letter: char,
    bytes: usize,
    big_endian: bool,
}

impl Kind {
    fn parse(text: &str) -> Result<Self, Fault> {
        let mut letters = text.chars();
        let (order, letter) = (letters.next().unwrap_or(' '), letters.next().unwrap_or(' '));
        let bytes = letters.as_str().parse().unwrap_or(0);
        let known = matches!(
            (letter, bytes),
            ('f', 4 | 8) | ('i' | 'u', 1 | 2 | 4 | 8) | ('b', 1)
        );
        if !known || !matches!(order, '<' | '>' | '|' | '=') {
            let remedy =
                "save it as float32 or float64 (integers and booleans will do), by array.astype('float32')";
            return Err(Fault::content(format!("holds values of type '{text}'"), remedy));
        }
        Ok(Self {
            letter,
            bytes,
            big_endian: order == '>',
        })
    }

    /// The number in `bytes`, which are `self.bytes` of them.
    fn value(self, bytes: &[u8]) -> f64 {
        let mut raw = [0; 8];
        for (index, &byte) in bytes.iter().take(8).enumerate() {
            let place = if self.big_endian {
                bytes.len() - 1 - index
            } else {
                index
            };
            raw[place] = byte;
        }
        let word = u64::from_le_bytes(raw);
        match (self.letter, self.bytes) {
            ('f', 4) => f64::from(f32::from_bits(word as u32)),
            ('f', _) => f64::from_bits(word),
            ('i', bytes) => {
                let spare = 64 - 8 * bytes as u32;
                ((word << spare) as i64 >> spare) as f64
            }
            _ => word as f64,
        }
    }
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
