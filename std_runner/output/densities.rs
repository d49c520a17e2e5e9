//! The densities of a written `result.npz`, read back one field at a time: pictures need no solver.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use zip::ZipArchive;

use super::render::Body;
use super::{OutputError, Precision};
use crate::stay::Stay;

/// The array of the solid cells, of results that have any.
const SOLID: &str = "solid.npy";
/// The ends of the names of vectors' components.
const AXES: [&str; 3] = ["x", "y", "z"];

/// An archive that [`write_archive`](super::write_archive) wrote.
pub(crate) struct Densities {
    archive: ZipArchive<BufReader<File>>,
    path: PathBuf,
    precision: Precision,
    /// Cells along x, y (and z).
    pub cells: Vec<usize>,
    /// N.
    pub steps: usize,
    /// The keyframes that are to be shown, ascending.
    pub keyframes: Vec<Pictured>,
}

/// A keyframe of the scene, and where the archive has what is shown of it.
pub(crate) struct Pictured {
    /// All its steps.
    pub stay: Stay,
    /// The one whose density is shown.
    pub step: usize,
    /// Place of its target among those of the archive, which has one for each step.
    pub target: usize,
}

/// A field of a result that pictures show.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shown {
    /// The density of a step.
    Density(usize),
    /// A target, by its number.
    Target(usize),
}

/// The density that is drawn as 1, of a result of so many `steps` and `targets`: the largest of the source; of a source without smoke, that of
/// the targets, and where there are none, that of the last step. `largest` finds that of a field.
pub(crate) fn full<E>(
    steps: usize,
    targets: usize,
    largest: &mut dyn FnMut(Shown) -> Result<f32, E>,
) -> Result<f32, E> {
    let mut full = largest(Shown::Density(0))?;
    if full <= 0.0 {
        for index in 0..targets {
            full = full.max(largest(Shown::Target(index))?);
        }
    }
    if full <= 0.0 {
        full = largest(Shown::Density(steps))?;
    }
    Ok(full)
}

impl Densities {
    /// Opens `path`, which holds densities 0 ..= `steps` and the targets of `keyframes`, of `cells` numbers each.
    pub fn open(
        path: &Path,
        precision: Precision,
        cells: Vec<usize>,
        steps: usize,
        keyframes: Vec<Pictured>,
    ) -> Result<Self, OutputError> {
        let file = File::open(path).map_err(OutputError::unread(path))?;
        let archive = ZipArchive::new(BufReader::new(file)).map_err(OutputError::unread(path))?;
        Ok(Self {
            archive,
            path: path.to_owned(),
            precision,
            cells,
            steps,
            keyframes,
        })
    }

    /// The density of a step, rounded to 32 bits: enough for pictures.
    pub fn density(&mut self, step: usize) -> Result<Vec<f32>, OutputError> {
        self.field("density.npy", step)
            .map_err(OutputError::unread(&self.path))
    }

    /// A target, rounded to 32 bits.
    pub fn target(&mut self, index: usize) -> Result<Vec<f32>, OutputError> {
        self.field("keyframe_density.npy", index)
            .map_err(OutputError::unread(&self.path))
    }

    /// Whether it has an array.
    fn has(&self, array: &str) -> bool {
        self.archive.file_names().flatten().any(|name| name == array)
    }

    /// The solid cells as 1, others as 0, if there are any.
    pub fn solid(&mut self) -> Result<Option<Vec<f32>>, OutputError> {
        if !self.has(SOLID) {
            return Ok(None);
        }
        let solid = self.field(SOLID, 0).map_err(OutputError::unread(&self.path))?;
        Ok(Some(solid))
    }

    /// Their body.
    pub fn body(&mut self) -> Result<Option<Body>, OutputError> {
        let solid = self.solid()?;
        Ok(solid.and_then(|solid| Body::new(&self.cells, &solid)))
    }

    /// See [`full`].
    pub fn full(&mut self) -> Result<f32, OutputError> {
        let targets = self.keyframes.len();
        full(self.steps, targets, &mut |of| {
            let field = match of {
                Shown::Density(step) => self.density(step)?,
                Shown::Target(index) => {
                    let target = self.keyframes.get(index).map_or(0, |keyframe| keyframe.target);
                    self.target(target)?
                }
            };
            Ok(field.into_iter().fold(0.0, f32::max))
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it has vectors of this name, as `velocity` or `force`.
    pub fn has_vectors(&self, name: &str) -> bool {
        let axes = AXES.iter().take(self.cells.len());
        axes.into_iter()
            .all(|axis| self.has(&format!("{name}_{axis}.npy")))
    }

    /// Component `axis` of a step of the vectors `name`, on `count` faces.
    pub fn vectors(
        &mut self,
        name: &str,
        axis: usize,
        step: usize,
        count: usize,
    ) -> Result<Vec<f32>, OutputError> {
        let axis = AXES.get(axis).copied().unwrap_or_default();
        self.numbers(&format!("{name}_{axis}.npy"), step, count)
            .map_err(OutputError::unread(&self.path))
    }

    fn field(&mut self, name: &str, index: usize) -> io::Result<Vec<f32>> {
        self.numbers(name, index, self.cells.iter().product())
    }

    /// Entry `index` of an array whose entries are `count` numbers.
    fn numbers(&mut self, name: &str, index: usize, count: usize) -> io::Result<Vec<f32>> {
        let mut member = self.archive.by_name_seek(name)?;
        let mut start = [0; 10];
        member.read_exact(&mut start)?;
        let head = start.len() + usize::from(u16::from_le_bytes([start[8], start[9]]));
        let mut seek = |size: usize| member.seek(SeekFrom::Start((head + index * count * size) as u64));
        match self.precision {
            Precision::F32 => seek(4).and_then(|_| numbers(&mut member, count, f32::from_le_bytes)),
            Precision::F64 => {
                seek(8).and_then(|_| numbers(&mut member, count, |bytes| f64::from_le_bytes(bytes) as f32))
            }
        }
    }
}

fn numbers<const N: usize>(
    source: &mut impl Read,
    count: usize,
    number: impl Fn([u8; N]) -> f32,
) -> io::Result<Vec<f32>> {
    let mut bytes = [0; N];
    (0..count)
        .map(|_| source.read_exact(&mut bytes).map(|()| number(bytes)))
        .collect()
}
