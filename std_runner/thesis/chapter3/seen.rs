//! What cameras saw, beside what they would see of a reconstruction; one of them may have measured nothing.

use super::super::bench::{Bench, Halt, Made};
use super::super::pictures::plane;
use super::super::truth::unread;
use crate::keyframes::Measurements;
use crate::output::Tone;
use crate::report::Shot;
use crate::tomography::Rig;
use std::path::{Path, PathBuf};

/// A view that is compared with what was seen there.
pub(super) struct Novel {
    /// The pictures taken there,
    pub pictures: PathBuf,
    /// and what names it to `thurible tomography`.
    pub assignment: String,
}

/// The array of the second of a rig's cameras.
pub(super) const NEXT: &str = "camera_1";

impl Bench<'_> {
    /// A camera half way between the first two of `rig`, among twice as many.
    pub(super) fn between(&mut self, whose: &str, views: &Made, rig: Rig) -> Result<Novel, Halt> {
        let count = 2 * rig.views;
        let elevation = rig.rise();
        let rig = Rig { views: count, ..rig };
        let folder = format!("views_{count}");
        let more = self.photograph(&format!("{whose}/{folder}"), rig)?;
        let pictures = more.folder.join("pictures.npz");
        let azimuth = 180.0 / count as f64;
        let pitch = pitch(&views.folder)?;
        // The folders stand side by side, and paths start at the file of views.
        let file = format!("../{folder}/pictures.npz");
        let assignment = format!(
            "novel=[{{azimuth={azimuth:?},elevation={elevation:?},pitch={pitch},file={file:?},array={NEXT:?}}}]"
        );
        Ok(Novel { pictures, assignment })
    }
}

/// How wide a pixel of a folder of views is, as its file says it.
fn pitch(folder: &Path) -> Result<String, Halt> {
    let path = folder.join("views.toml");
    let text = std::fs::read_to_string(&path)
        .map_err(|error| Halt::Failed(format!("cannot read {}: {error}", path.display())))?;
    let pitch = text.lines().find_map(|line| line.strip_prefix("pitch = "));
    pitch
        .map(str::to_owned)
        .ok_or_else(|| Halt::Failed(format!("{} has no pitch", path.display())))
}

/// What a camera saw, if it is to be shown first, and what it would see of a reconstruction; each an array of its archive.
pub(super) fn photographs(
    (archive, camera): (&Path, &str),
    (made, array): (&Made, &str),
    first: bool,
    name: &str,
) -> Result<Vec<Shot>, Halt> {
    let read = |archive: &Path, array: &str| {
        let all = Measurements::open("result", archive, Some(array));
        all.and_then(|all| all.read(0)).map_err(unread)
    };
    let seen = read(archive, camera)?;
    let shown = read(&made.archive(), array)?;
    let full = seen.values.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let width = seen.shape.last().copied().unwrap_or(1);
    let picture = |caption: &str, values: &[f64]| {
        let upright: Vec<f64> = values.chunks_exact(width).rev().flatten().copied().collect();
        plane(caption, &upright, width, full, Tone::Light)
    };
    let mut shots = Vec::new();
    if first {
        shots.push(picture("photograph", &seen.values)?);
    }
    shots.push(picture(name, &shown.values)?);
    Ok(shots)
}
