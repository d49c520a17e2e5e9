//! The header of a NumPy array: how its numbers are stored, and its shape.

use std::io::{ErrorKind, Read};

use half::f16;

use super::error::Fault;

/// Headers longer than this are no headers.
const LONGEST_HEADER: usize = 1 << 16;

/// Takes the first axis off; its length.
fn steps(header: &mut Header) -> Result<usize, Fault> {
    let steps = if header.shape.is_empty() {
        0
    } else {
        header.shape.remove(0)
    };
    if steps == 0 {
        return Err(Fault::content(
            "has an array without steps",
            "give an array whose first axis is time, as results of thurible have it",
        ));
    }
    if header.columns_first {
        return Err(Fault::content(
            "has an array in Fortran order, whose steps do not lie one after the other",
            "save numpy.ascontiguousarray of it",
        ));
    }
    Ok(steps)
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

/// Takes axes of length 1 off the end of a shape, while it has more than so many axes.
pub(super) fn drop_ones(shape: &mut Vec<usize>, axes: usize) {
    while shape.len() > axes && shape.last() == Some(&1) {
        shape.pop();
    }
}

/// What an array's header says.
pub(super) struct Header {
    pub kind: Kind,
    pub columns_first: bool,
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

    /// The same without axes of length 1 at the end, beyond the first two: channels, where there is one.
    pub(super) fn without_ones(mut self) -> Self {
        drop_ones(&mut self.shape, 2);
        self
    }

    /// Bytes of the values.
    pub(super) fn bytes(&self) -> u64 {
        let count = self
            .shape
            .iter()
            .try_fold(self.kind.bytes, |product, &side| product.checked_mul(side));
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
            // NumPy under Python 2 wrote `16L`.
            .map(|side| side.trim_end_matches('L').parse().map_err(|_| broken()))
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
    pub bytes: usize,
    big_endian: bool,
}

impl Kind {
    fn parse(text: &str) -> Result<Self, Fault> {
        let mut letters = text.chars();
        let (order, letter) = (letters.next().unwrap_or(' '), letters.next().unwrap_or(' '));
        let bytes = letters.as_str().parse().unwrap_or(0);
        let known = matches!(
            (letter, bytes),
            ('f', 2 | 4 | 8) | ('i' | 'u', 1 | 2 | 4 | 8) | ('b', 1)
        );
        if !known || !matches!(order, '<' | '>' | '|' | '=') {
            let remedy = "save it as float16, float32 or float64 (integers and booleans will do), by array.astype('float32')";
            return Err(Fault::content(format!("holds values of type '{text}'"), remedy));
        }
        Ok(Self {
            letter,
            bytes,
            big_endian: order == '>',
        })
    }

    /// Its letter and bytes.
    pub(super) fn name(self) -> String {
        format!("{}{}", self.letter, self.bytes)
    }

    /// The number in `bytes`, which are `self.bytes` of them.
    pub(super) fn value(self, bytes: &[u8]) -> f64 {
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
            ('f', 2) => f16::from_bits(word as u16).to_f64(),
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
