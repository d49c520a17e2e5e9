//! The capture file: which frames, of what box, tracked how. Where a command names the frames themselves it is made up.

use crate::exit::Failure;
use crate::owned::UNITS;
use crate::scene::{Document, choose, read, shown};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use thurible_core::choices::{Choices, Numbers};
use thurible_core::flow::Minimiser;
use thurible_core::{Boundary, Named, TrackParams};
use toml::{Table, Value};

/// The boundaries that a capture may have.
pub(super) const ENDS: [Boundary; 2] = [Boundary::Wall, Boundary::Periodic];
/// Frames at most.
const MOST_FRAMES: usize = 1_000_000;

/// What is tracked, and how.
#[derive(Clone, Debug)]
pub(crate) struct CaptureScene {
    /// The file, or what stands for it.
    pub document: Document,
    /// `capture.files`: a file, a pattern or a folder.
    pub files: String,
    /// The array in `.npz` files.
    pub name: Option<String>,
    /// Which pixels of pictures are smoke.
    pub ink: Option<String>,
    /// How axes end: one word, or one for each; none where nothing is said.
    pub boundary: Vec<Boundary>,
    /// The longest side of the box.
    pub length: Option<f64>,
    /// The time between frames.
    pub dt: Option<f64>,
    /// What densities are multiplied by; 10 / max where nothing is said.
    pub density_scale: Option<f64>,
    /// The first frame, from 0.
    pub first: usize,
    /// The last one, if not the last of all.
    pub last: Option<usize>,
    /// A file with true velocities.
    pub truth: Option<PathBuf>,
    /// What was made between frames.
    pub emission: Wanted,
    /// A file with the velocity of the first pair.
    pub initial_velocity: Option<PathBuf>,
    /// Acceleration upwards where the density is 1.
    pub buoyancy: f64,
    /// How it is tracked; threads are those of the command line.
    pub params: TrackParams,
}

/// What `capture.emission` says: which array holds what was made between frames.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// What is beside the frames, if anything is.
    #[default]
    Automatic,
    /// Nothing.
    None,
    /// What is in this file.
    File(PathBuf),
}

impl Wanted {
    /// The key's word, or a file relative to `folder`.
    fn of(folder: &Path, word: Option<String>) -> Self {
        match word.as_deref() {
            None | Some("auto") => Self::Automatic,
            Some("none") => Self::None,
            Some(file) => Self::File(folder.join(file)),
        }
    }
}

/// Keys of `[track]` that one method alone hears.
const OF_ONE_METHOD: [(&str, Minimiser); 4] = [
    ("gamma", Minimiser::HornSchunck),
    ("lambda", Minimiser::Admm),
    ("iterations", Minimiser::Admm),
    ("tolerance", Minimiser::Admm),
];

/// Those that only a prediction from the pair before hears.
const OF_PREDICTION: [&str; 3] = ["predict", "buoyancy", "initial_velocity"];

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFile {
    capture: Option<RawCapture>,
    track: Option<Value>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCapture {
    files: Option<String>,
    name: Option<String>,
    ink: Option<String>,
    boundary: Option<Value>,
    length: Option<f64>,
    dt: Option<f64>,
    density_scale: Option<Value>,
    first: Option<i64>,
    last: Option<Value>,
    truth: Option<String>,
    emission: Option<String>,
}

impl CaptureScene {
    /// Reads a capture file, or makes one up for a folder, a pattern or a file of frames; then `changes`, as `--set` has them, each with the
    /// option that it came from.
    pub fn load(path: &Path, changes: &[(String, String)]) -> Result<Self, Failure> {
        let is_file = path.extension().is_some_and(|extension| extension == "toml");
        let mut document = if is_file {
            Document::read(path)?
        } else {
            let name = path
                .file_name()
                .map_or_else(|| ".".into(), |name| name.to_string_lossy());
            let text = format!("[capture]\nfiles = {}\n", Value::String(name.into_owned()));
            Document::parse(path, text)?
        };
        for (option, assignment) in changes {
            match assignment.split_once('=') {
                Some((key, value)) if !option.starts_with("--set") => {
                    let number = value.parse::<f64>().map(Value::Float);
                    let value = number.unwrap_or_else(|_| Value::String(value.into()));
                    document.replace(option.clone(), key, value)?;
                }
                _ => document.set(assignment)?,
            }
        }
        Self::of(document)
    }

    /// Checks a document that is complete.
    fn of(document: Document) -> Result<Self, Failure> {
        let raw: RawFile = read(&document, "", Value::Table(document.table().clone()))?;
        let capture = raw.capture.unwrap_or_default();
        let remedy = "write files = \"frames/*.npy\", or the name of an .npz that holds `density`";
        let files = document.required("capture.files", capture.files, remedy)?;
        let positive = |key: &str, given: Option<f64>| match given {
            Some(given) if given > 0.0 && !UNITS.contains(&given) => {
                let (least, most) = (UNITS.start(), UNITS.end());
                Err(document.outside(key, given, format!("a number from {least:e} to {most:e}")))
            }
            Some(given) => document.number(key, given, Numbers::Positive).map(Some),
            None => Ok(None),
        };
        let mut track: Table = raw
            .track
            .map_or(Ok(Table::new()), |raw| read(&document, "track", raw))?;
        let buoyancy = take_number(&document, &mut track, "buoyancy")?.unwrap_or(0.0);
        let initial_velocity = initial_velocity(&document, &mut track)?;
        Ok(Self {
            boundary: boundary(&document, capture.boundary)?,
            length: positive("capture.length", capture.length)?,
            dt: positive("capture.dt", capture.dt)?,
            density_scale: density_scale(&document, capture.density_scale)?,
            first: capture.first.map_or(Ok(0), |first| {
                document.whole("capture.first", first, 0..=MOST_FRAMES)
            })?,
            last: last(&document, capture.last)?,
            truth: capture.truth.map(|truth| document.folder().join(truth)),
            emission: Wanted::of(document.folder(), capture.emission),
            initial_velocity,
            buoyancy,
            params: params(&document, track)?,
            name: capture.name,
            ink: capture.ink,
            files,
            document,
        })
    }

    /// Says which keys are given that the chosen method does not hear.
    pub fn unheard(&self) -> Vec<String> {
        let given = self.document.table().get("track").and_then(Value::as_table);
        let chosen = self.params.flow.minimiser;
        let has = |key: &str| given.is_some_and(|given| given.contains_key(key));
        let others = OF_ONE_METHOD
            .iter()
            .filter(|(key, method)| *method != chosen && has(key));
        let said = |(key, method): &(&str, Minimiser)| {
            format!(
                "`track.{key}` is for {} alone, and does nothing with {}",
                method.name(),
                chosen.name()
            )
        };
        let alone = OF_PREDICTION
            .iter()
            .filter(|key| self.params.independent && has(key));
        let alone = alone.map(|key| {
            format!("`track.{key}` is for flows that are predicted, and does nothing where every pair is on its own (`track.independent`)")
        });
        others.map(said).chain(alone).collect()
    }

    /// How each of `axes` axes ends, `otherwise` where the file says nothing.
    pub fn ends(&self, axes: usize, otherwise: Option<&[Boundary]>) -> Result<Vec<Boundary>, Failure> {
        match (self.boundary.as_slice(), otherwise) {
            ([], Some(known)) if known.len() == axes => Ok(known.to_vec()),
            ([], _) => Ok(vec![Boundary::Wall; axes]),
            ([one], _) => Ok(vec![*one; axes]),
            (each, _) if each.len() == axes => Ok(each.to_vec()),
            (each, _) => {
                let why = format!(
                    "names {} axes, and the frames have {axes}; name one way for each axis, or one for all",
                    each.len()
                );
                Err(self.document.refuse("capture.boundary", why))
            }
        }
    }
}

/// One word, or a list of them.
fn boundary(document: &Document, raw: Option<Value>) -> Result<Vec<Boundary>, Failure> {
    let key = "capture.boundary";
    let word = |key: &str, word: &Value| match word.as_str() {
        Some(word) => document.one_of(key, word, &ENDS),
        None => Err(document.outside(key, shown(word), "\"wall\" or \"periodic\"")),
    };
    match raw {
        None => Ok(Vec::new()),
        Some(Value::Array(ends)) => ends
            .iter()
            .enumerate()
            .map(|(axis, end)| word(&format!("{key}[{axis}]"), end))
            .collect(),
        Some(one) => Ok(vec![word(key, &one)?]),
    }
}

fn density_scale(document: &Document, raw: Option<Value>) -> Result<Option<f64>, Failure> {
    let key = "capture.density_scale";
    let number = match raw {
        None => return Ok(None),
        Some(Value::String(word)) if word == "auto" => return Ok(None),
        Some(Value::Float(number)) => number,
        Some(Value::Integer(number)) => number as f64,
        Some(other) => return Err(document.outside(key, shown(&other), "\"auto\" or a number above 0")),
    };
    document.number(key, number, Numbers::Positive).map(Some)
}

fn last(document: &Document, raw: Option<Value>) -> Result<Option<usize>, Failure> {
    match raw {
        None => Ok(None),
        Some(Value::String(word)) if word == "end" => Ok(None),
        Some(other @ Value::String(_)) => {
            let wanted = format!("\"end\" or a whole number from 1 to {MOST_FRAMES}");
            Err(document.outside("capture.last", shown(&other), wanted))
        }
        Some(other) => document
            .whole_value("capture.last", &other, 1..=MOST_FRAMES)
            .map(Some),
    }
}

/// Takes a number out of the table `track`.
fn take_number(document: &Document, track: &mut Table, name: &str) -> Result<Option<f64>, Failure> {
    let key = format!("track.{name}");
    track
        .remove(name)
        .map(|value| document.number(&key, read(document, &key, value)?, Numbers::Finite))
        .transpose()
}

/// `"rest"`, or `{ file = "x.npz" }`.
fn initial_velocity(document: &Document, track: &mut Table) -> Result<Option<PathBuf>, Failure> {
    let key = "track.initial_velocity";
    match track.remove("initial_velocity") {
        None => Ok(None),
        Some(Value::String(word)) if word == "rest" => Ok(None),
        Some(Value::Table(mut table)) => {
            document.only(key, &table, &["file"])?;
            let remedy = "name the .npz that holds velocity_x, velocity_y (and velocity_z)";
            let file = document.required(&format!("{key}.file"), table.remove("file"), remedy)?;
            let file: String = read(document, &format!("{key}.file"), file)?;
            Ok(Some(document.folder().join(file)))
        }
        Some(other) => Err(document.outside(key, shown(&other), "\"rest\" or { file = \"x.npz\" }")),
    }
}

/// The choices of `[track]`, on top of the defaults of its method.
fn params(document: &Document, mut track: Table) -> Result<TrackParams, Failure> {
    let minimiser = match track.get("method") {
        Some(Value::String(word)) => document.word("track.method", word)?,
        _ => Minimiser::default(),
    };
    for automatic in ["cg_tolerance", "cg_iterations"] {
        if track.get(automatic).and_then(Value::as_str) == Some("auto") {
            track.remove(automatic);
        }
    }
    let mut params = TrackParams::of(minimiser);
    let mut known: Vec<&str> = params.table().iter().map(|choice| choice.name).collect();
    known.extend(["initial_velocity", "buoyancy"]);
    document.only("track", &track, &known)?;
    choose(document, "track", Some(Value::Table(track)), &mut params)?;
    params
        .check()
        .map_err(|error| document.refuse("track", format!("is refused: {error}; change it")))?;
    Ok(params)
}
