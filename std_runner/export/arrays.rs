//! All arrays of a result, whatever they are, with the names of their axes.

use super::source::{Source, unread};
use crate::exit::Failure;
use crate::keyframes::{Series, array_names};
use core::ops::Range;
use core::ops::RangeInclusive;

const KEY: &str = "result";
/// What the names of arrays begin with that belong to no step, but to a template of the force.
const TEMPLATE: &str = "template_";
/// The names of axes, and of faces across them.
const AXES: [&str; 3] = ["x", "y", "z"];
const FACES: [&str; 3] = ["x_face", "y_face", "z_face"];

/// What the first axis of an array counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Counts {
    /// Densities: step k is at time k dt.
    Time,
    /// What goes from a step to the next.
    Flow,
    /// Forces: number k turns flow k into flow k + 1.
    Force,
    Keyframe,
    /// No time.
    Nothing,
}

impl Counts {
    /// The name of the axis.
    pub fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Flow => "flow_time",
            Self::Force => "force_time",
            Self::Keyframe => "keyframe",
            Self::Nothing => "",
        }
    }
}

/// An array.
pub(super) struct Held {
    pub name: String,
    /// Its values' type, as f4.
    pub kind: String,
    pub counts: Counts,
    /// The names of its axes.
    pub dimensions: Vec<String>,
    series: Series,
}

impl Held {
    /// The shape of an entry.
    pub fn shape(&self) -> &[usize] {
        self.series.shape()
    }

    /// Whether it is one number, without an axis.
    pub fn is_number(&self) -> bool {
        self.series.is_number()
    }

    /// The shape of so many entries as one array.
    pub fn whole(&self, entries: usize) -> Vec<usize> {
        whole(&self.series, entries)
    }

    /// The entries that belong to `steps`.
    pub fn entries(&self, steps: &RangeInclusive<usize>) -> Range<usize> {
        let count = self.series.count();
        match self.counts {
            Counts::Keyframe | Counts::Nothing => 0..count,
            _ => (*steps.start()).min(count)..(steps.end() + 1).min(count),
        }
    }

    /// An entry, in the bytes of the file.
    pub fn bytes(&mut self, source: &Source, entry: usize) -> Result<Vec<u8>, Failure> {
        let values = self.series.read(entry);
        let values = values.map_err(|error| unread(&source.archive(), &error))?;
        Ok(encoded(&self.kind, &values))
    }
}

/// All of a result that hold anything.
pub(super) fn arrays(source: &Source) -> Result<Vec<Held>, Failure> {
    let path = source.archive();
    let failed = |error| unread(&path, &error);
    let mut all = Vec::new();
    for name in array_names(&path, KEY).map_err(failed)? {
        if !is_plain(&name) {
            return Err(source.refuse(&format!(
                "has an array called {name:?}, and a file of that name may be anywhere; call it by letters, digits and _"
            )));
        }
        let series = Series::open_any(&path, &name, KEY).map_err(failed)?;
        let kind = match series.kind() {
            // Numbers of 16 bits are read by fewer programs.
            kind if kind == "f2" => "f4".to_owned(),
            kind => kind,
        };
        let counts = counts(source, &name, &series);
        all.push(Held {
            dimensions: dimensions(source, &name, &series, counts),
            name,
            kind,
            counts,
            series,
        });
    }
    Ok(all)
}

/// Whether `name` is a file's own name on every system, and never a way to another folder.
fn is_plain(name: &str) -> bool {
    let fits = |letter: char| letter.is_alphanumeric() || "_- +.".contains(letter);
    name.chars().all(fits) && !name.starts_with(['.', ' ']) && !name.ends_with(['.', ' ']) && !name.is_empty()
}

fn whole(series: &Series, entries: usize) -> Vec<usize> {
    let first = (!series.is_number()).then_some(entries);
    first.into_iter().chain(series.shape().iter().copied()).collect()
}

fn counts(source: &Source, name: &str, series: &Series) -> Counts {
    let cells: Vec<usize> = source.said.cells.iter().rev().copied().collect();
    let (count, steps) = (series.count(), source.steps());
    if name.starts_with("keyframe_") {
        Counts::Keyframe
    } else if series.is_number() || name.starts_with(TEMPLATE) || whole(series, count) == cells {
        Counts::Nothing
    } else if count == steps + 1 {
        Counts::Time
    } else if count == steps {
        Counts::Flow
    } else if count + 1 == steps {
        Counts::Force
    } else {
        Counts::Nothing
    }
}

/// The names of all axes; those that are neither of cells nor of faces are the array's own.
fn dimensions(source: &Source, name: &str, series: &Series, counts: Counts) -> Vec<String> {
    let cells = &source.said.cells;
    let whole = whole(series, series.count());
    let leading = usize::from(counts != Counts::Nothing);
    let grid = whole.get(leading..).unwrap_or(&[]);
    let mut names: Vec<String> = (0..leading).map(|_| counts.name().to_owned()).collect();
    let is_grid = grid.len() == cells.len() && !name.starts_with(TEMPLATE);
    for (place, &size) in grid.iter().enumerate() {
        let axis = grid.len() - 1 - place;
        let (found, across) = (
            cells.get(axis).copied(),
            AXES.get(axis).copied().unwrap_or_default(),
        );
        let is_across = name.ends_with(&format!("_{across}")) && !source.said.centred;
        // Between walls there is a face more than there are cells.
        let beyond = usize::from(!source.said.repeats(axis));
        let own = match found {
            Some(count) if is_grid && is_across && size == count + beyond => FACES[axis].into(),
            Some(count) if is_grid && size == count => across.into(),
            _ => format!("{name}_{place}"),
        };
        names.push(own);
    }
    names
}

/// Bytes of a number of a kind.
pub(super) fn number_bytes(kind: &str) -> usize {
    kind.get(1..).and_then(|size| size.parse().ok()).unwrap_or(8)
}

/// The bytes of values of a kind, little-endian.
pub(super) fn encoded(kind: &str, values: &[f64]) -> Vec<u8> {
    match kind {
        "f4" => values.iter().flat_map(|&x| (x as f32).to_le_bytes()).collect(),
        "f8" => values.iter().flat_map(|&x| x.to_le_bytes()).collect(),
        "b1" | "u1" => values.iter().map(|&x| x as u8).collect(),
        "i1" => values.iter().map(|&x| x as i8 as u8).collect(),
        "u2" => values.iter().flat_map(|&x| (x as u16).to_le_bytes()).collect(),
        "i2" => values.iter().flat_map(|&x| (x as i16).to_le_bytes()).collect(),
        "u4" => values.iter().flat_map(|&x| (x as u32).to_le_bytes()).collect(),
        "i4" => values.iter().flat_map(|&x| (x as i32).to_le_bytes()).collect(),
        "u8" => values.iter().flat_map(|&x| (x as u64).to_le_bytes()).collect(),
        _ => values.iter().flat_map(|&x| (x as i64).to_le_bytes()).collect(),
    }
}
