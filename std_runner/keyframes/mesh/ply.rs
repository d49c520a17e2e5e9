//! PLY, in words and binary: `x`, `y`, `z` of the vertices and the lists of corners of the faces.

use super::surface::Surface;
use crate::keyframes::error::Fault;

/// Reads points and faces.
pub(super) fn read(bytes: &[u8]) -> Result<Surface, Fault> {
    let (elements, mut source) = head(bytes)?;
    let mut surface = Surface::default();
    let mut row = Row::default();
    for element in &elements {
        let place = |name: &str| {
            element
                .properties
                .iter()
                .position(|property| property.name == name)
        };
        let axes = ["x", "y", "z"].map(place);
        let corners = place("vertex_indices").or_else(|| place("vertex_index"));
        // What has no properties takes no bytes, however many of it there are.
        let count = if element.properties.is_empty() {
            0
        } else {
            element.count
        };
        for _ in 0..count {
            row.read(element, corners, &mut source)?;
            match (element.name.as_str(), axes) {
                ("vertex", [Some(x), Some(y), Some(z)]) => {
                    surface
                        .points
                        .push([x, y, z].map(|place| row.values.get(place).copied().unwrap_or(f64::NAN)));
                }
                ("vertex", _) => return Err(Fault::content("has points without x, y and z", AGAIN)),
                ("face", _) => surface.polygon(&row.corners)?,
                _ => {}
            }
        }
    }
    Ok(surface)
}

const AGAIN: &str = "export it again as PLY";

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

struct Property {
    name: String,
    kind: Kind,
    /// Of a list: how the number of its values is stored.
    counted: Option<Kind>,
}

/// How a number is stored.
#[derive(Clone, Copy)]
struct Kind {
    bytes: usize,
    letter: char,
}

impl Kind {
    fn parse(word: &str) -> Option<Self> {
        let (letter, bytes) = match word {
            "char" | "int8" => ('i', 1),
            "uchar" | "uint8" => ('u', 1),
            "short" | "int16" => ('i', 2),
            "ushort" | "uint16" => ('u', 2),
            "int" | "int32" => ('i', 4),
            "uint" | "uint32" => ('u', 4),
            "float" | "float32" => ('f', 4),
            "double" | "float64" => ('f', 8),
            _ => return None,
        };
        Some(Self { bytes, letter })
    }
}

/// The elements that the head names, and what follows it.
fn head(bytes: &[u8]) -> Result<(Vec<Element>, Source<'_>), Fault> {
    let broken = |what: &str| Fault::content(format!("is no PLY that can be read ({what})"), AGAIN);
    let (mut elements, mut rest, mut format) = (Vec::<Element>::new(), bytes, None);
    loop {
        let end = rest
            .iter()
            .position(|&byte| byte == b'\n')
            .ok_or_else(|| broken("its head has no end"))?;
        let (line, after) = rest.split_at(end);
        rest = after.get(1..).unwrap_or_default();
        let line = String::from_utf8_lossy(line);
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words.as_slice() {
            ["end_header"] => break,
            ["format", word, ..] => format = Some(word.to_string()),
            ["element", name, count] => elements.push(Element {
                name: (*name).to_owned(),
                count: count.parse().map_err(|_| broken("a count is none"))?,
                properties: Vec::new(),
            }),
            ["property", kind @ .., name] => {
                let parse =
                    |word: &str| Kind::parse(word).ok_or_else(|| broken("a property has an unknown type"));
                let (counted, kind) = match kind {
                    [kind] => (None, parse(kind)?),
                    ["list", counted, kind] => (Some(parse(counted)?), parse(kind)?),
                    _ => return Err(broken("a property has an unknown type")),
                };
                let element = elements
                    .last_mut()
                    .ok_or_else(|| broken("a property belongs to nothing"))?;
                element.properties.push(Property {
                    name: (*name).to_owned(),
                    kind,
                    counted,
                });
            }
            ["ply"] | ["comment" | "obj_info", ..] | [] => {}
            _ => return Err(broken("its head has an unknown line")),
        }
    }
    let source = match format.as_deref() {
        Some("ascii") => Source::Words(rest),
        Some("binary_little_endian") => Source::Bytes { rest, big: false },
        Some("binary_big_endian") => Source::Bytes { rest, big: true },
        _ => return Err(broken("its format is unknown")),
    };
    Ok((elements, source))
}

/// What is left of the values.
enum Source<'a> {
    Words(&'a [u8]),
    Bytes { rest: &'a [u8], big: bool },
}

impl Source<'_> {
    fn next(&mut self, kind: Kind) -> Result<f64, Fault> {
        let short = || Fault::content("ends before its last value", "it was cut off: export it again");
        match self {
            Self::Words(rest) => {
                let left = rest.trim_ascii_start();
                let end = left
                    .iter()
                    .position(u8::is_ascii_whitespace)
                    .unwrap_or(left.len());
                let (word, after) = left.split_at(end);
                *rest = after;
                if word.is_empty() {
                    return Err(short());
                }
                let word = String::from_utf8_lossy(word);
                word.parse()
                    .map_err(|_| Fault::content(format!("holds `{word:.20}`, which is no number"), AGAIN))
            }
            Self::Bytes { rest, big } => {
                let (word, after) = rest.split_at_checked(kind.bytes).ok_or_else(short)?;
                *rest = after;
                let mut raw = [0; 8];
                for (index, &byte) in word.iter().enumerate() {
                    let place = if *big { kind.bytes - 1 - index } else { index };
                    if let Some(slot) = raw.get_mut(place) {
                        *slot = byte;
                    }
                }
                let whole = u64::from_le_bytes(raw);
                let spare = 64 - 8 * kind.bytes as u32;
                Ok(match (kind.letter, kind.bytes) {
                    ('f', 4) => f64::from(f32::from_bits(whole as u32)),
                    ('f', _) => f64::from_bits(whole),
                    ('i', _) => ((whole << spare) as i64 >> spare) as f64,
                    _ => whole as f64,
                })
            }
        }
    }
}

/// One vertex, face or whatever else.
#[derive(Default)]
struct Row {
    /// A value for each property; that of a list is its last one.
    values: Vec<f64>,
    /// The list of corners.
    corners: Vec<u32>,
}

impl Row {
    fn read(
        &mut self,
        element: &Element,
        corners: Option<usize>,
        source: &mut Source<'_>,
    ) -> Result<(), Fault> {
        self.values.clear();
        self.corners.clear();
        for (index, property) in element.properties.iter().enumerate() {
            let Some(counted) = property.counted else {
                self.values.push(source.next(property.kind)?);
                continue;
            };
            let count = source.next(counted)?;
            // Each value takes bytes, so that a count that is too large ends with the file.
            for _ in 0..count.clamp(0.0, 4e9) as u64 {
                let value = source.next(property.kind)?;
                if corners == Some(index) {
                    let whole = (0.0..4e9).contains(&value) && value.fract() == 0.0;
                    self.corners.push(if whole { value as u32 } else { u32::MAX });
                }
            }
            self.values.push(count);
        }
        Ok(())
    }
}
