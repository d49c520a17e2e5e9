//! All pictures of a result: a file per step, the animation, and what the report shows.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::animation::{Animation, Pace};
use super::file::{create_folder, write_bytes};
use super::picture::Picture;
use super::render::{Body, Smoke};
use super::{Densities, OutputError, Pictured};
use crate::bytes::are_free;
use crate::stay::Stay;

/// Pictures in the strip of the report, about.
const STRIP: usize = 8;

/// Bytes for each pixel and each cell of a picture in the making, and for its encoder, about.
const PIXEL: usize = 40;
const CELL: usize = 112;
const ENCODER: usize = 1 << 20;
/// Pixels to a byte of a PNG file, at least; and how often the page holds a file while it is put together, about.
const PACKED: usize = 2;
const COPIES: usize = 5;
/// Pixels to a byte of a picture of smoke, usually.
const USUALLY_PACKED: usize = 16;

/// The file of the animation.
pub(crate) const ANIMATION: &str = "animation.png";

/// Where the pictures of steps are.
const FRAMES: &str = "frames";

/// The file of the picture of a step.
pub(crate) fn frame(step: usize) -> PathBuf {
    Path::new(FRAMES).join(format!("frame_{step:04}.png"))
}

/// PNG files in memory, for the report.
#[derive(Default)]
pub(crate) struct Gallery {
    /// Some steps from first to last, keyframes among them.
    pub strip: Vec<(usize, Vec<u8>)>,
    /// What was asked for and what came of it.
    pub keyframes: Vec<KeyframePictures>,
    /// The animation, if there is one.
    pub animation: Option<Vec<u8>>,
}

/// One keyframe in three pictures, of one of its steps.
pub(crate) struct KeyframePictures {
    pub stay: Stay,
    pub step: usize,
    pub target: Vec<u8>,
    pub reached: Vec<u8>,
    pub difference: Vec<u8>,
}

impl Gallery {
    /// Whether the system has the memory to draw `densities`, about.
    pub fn has_room(densities: &Densities, images: bool) -> bool {
        let (cells, pixels) = (
            densities.cells.iter().product::<usize>(),
            Smoke::pixels(&densities.cells),
        );
        let making = rayon::current_num_threads().max(1) * (CELL * cells + PIXEL * pixels + ENCODER);
        let files = STRIP + 4 * densities.keyframes.len() + if images { densities.steps + 1 } else { 0 };
        are_free(making + files * (pixels / PACKED) * COPIES)
    }

    /// Bytes that pictures of `steps` steps and so many keyframes take on a disc, about: on the page, where four letters stand for three bytes, and with
    /// `images` as files and in the animation, which is on the page too.
    pub fn bytes(cells: &[usize], steps: usize, keyframes: usize, images: bool) -> usize {
        let files = if images { steps + 1 } else { 0 };
        let on_the_page = 4 * (STRIP + 4 * keyframes + files) / 3;
        (on_the_page + 2 * files) * (Smoke::pixels(cells) / USUALLY_PACKED)
    }

    /// Draws everything; with `images`, writes `frames/frame_0000.png` and so on and `animation.png` too.
    pub fn draw(folder: &Path, densities: Densities, images: bool) -> Result<Self, OutputError> {
        let mut studio = Studio::new(folder, densities)?;
        let count = studio.densities.keyframes.len();
        let keyframes = (0..count)
            .map(|index| studio.keyframe(index))
            .collect::<Result<_, _>>()?;
        if images {
            studio.every_step(keyframes)
        } else {
            studio.some_steps(keyframes)
        }
    }
}

/// Turns steps into pictures.
struct Studio<'a> {
    folder: &'a Path,
    densities: Densities,
    /// The density that is drawn brightest.
    full: f32,
    body: Option<Body>,
}

impl<'a> Studio<'a> {
    fn new(folder: &'a Path, mut densities: Densities) -> Result<Self, OutputError> {
        let (full, body) = (densities.full()?, densities.body()?);
        Ok(Self {
            folder,
            densities,
            full,
            body,
        })
    }

    fn smoke(&mut self, step: usize) -> Result<Smoke, OutputError> {
        let density = self.densities.density(step)?;
        Ok(self.about_the_body(density))
    }

    fn about_the_body(&self, density: Vec<f32>) -> Smoke {
        Smoke::new(&self.densities.cells, density, self.full, self.body.clone())
    }

    fn keyframe(&mut self, index: usize) -> Result<KeyframePictures, OutputError> {
        let Pictured { stay, step, target } = self.densities.keyframes[index];
        let target = self.densities.target(target)?;
        let target = self.about_the_body(target);
        let reached = self.smoke(step)?;
        Ok(KeyframePictures {
            stay,
            step,
            target: self.encode(&target.photograph())?,
            reached: self.encode(&reached.photograph())?,
            difference: self.encode(&reached.minus(&target).chart())?,
        })
    }

    fn encode(&self, picture: &Picture) -> Result<Vec<u8>, OutputError> {
        picture
            .to_png()
            .map_err(OutputError::of(&self.folder.join("report.html")))
    }

    /// The steps of the keyframes.
    fn stays(&self) -> Vec<Stay> {
        self.densities
            .keyframes
            .iter()
            .map(|keyframe| keyframe.stay)
            .collect()
    }

    fn some_steps(&mut self, keyframes: Vec<KeyframePictures>) -> Result<Gallery, OutputError> {
        let mut strip = Vec::new();
        for step in strip_steps(self.densities.steps, &self.stays()) {
            let picture = self.smoke(step)?.photograph();
            strip.push((step, self.encode(&picture)?));
        }
        Ok(Gallery {
            strip,
            keyframes,
            animation: None,
        })
    }

    fn every_step(&mut self, keyframes: Vec<KeyframePictures>) -> Result<Gallery, OutputError> {
        let (steps, at) = (self.densities.steps, self.stays());
        let (shown, path) = (strip_steps(steps, &at), self.folder.join(ANIMATION));
        let folder = self.folder.join(FRAMES);
        create_folder(&folder)?;
        remove_frames_after(steps, &folder)?;
        let mut bytes = Vec::new();
        let mut strip = Vec::new();
        let first = self.smoke(0)?.photograph();
        let mut animation =
            Animation::new(&mut bytes, &first, Pace::new(steps, &at)).map_err(OutputError::of(&path))?;
        let together = rayon::current_num_threads().max(1);
        for begin in (0..=steps).step_by(together) {
            let batch = (begin..=steps)
                .take(together)
                .map(|step| Ok((step, self.smoke(step)?)))
                .collect::<Result<Vec<_>, _>>()?;
            let drawn: Vec<_> = batch
                .into_par_iter()
                .map(|(step, smoke)| develop(step, &smoke, self.folder))
                .collect();
            for drawn in drawn {
                let (step, picture, png) = drawn?;
                animation.push(&picture).map_err(OutputError::of(&path))?;
                if shown.contains(&step) {
                    strip.push((step, png));
                }
            }
        }
        animation.finish().map_err(OutputError::of(&path))?;
        write_bytes(&path, &bytes)?;
        Ok(Gallery {
            strip,
            keyframes,
            animation: Some(bytes),
        })
    }
}

/// Draws a step and writes its file.
fn develop(step: usize, smoke: &Smoke, folder: &Path) -> Result<(usize, Picture, Vec<u8>), OutputError> {
    let path = folder.join(frame(step));
    let picture = smoke.photograph();
    let png = picture.to_png().map_err(OutputError::of(&path))?;
    write_bytes(&path, &png)?;
    Ok((step, picture, png))
}

/// Steps from first to last, evenly, moved to the keyframes that they are closest to: of each at least one step, the first if none is
/// there anyway.
pub(crate) fn strip_steps(steps: usize, keyframes: &[Stay]) -> BTreeSet<usize> {
    let mut chosen: BTreeSet<usize> = (0..STRIP).map(|index| index * steps / (STRIP - 1)).collect();
    let is_keyframe = |step: usize| keyframes.iter().any(|keyframe| keyframe.contains(step));
    for keyframe in keyframes {
        if chosen.range(keyframe.steps()).next().is_some() {
            continue;
        }
        let movable = |step: &&usize| **step != 0 && **step != steps && !is_keyframe(**step);
        let nearest = chosen
            .iter()
            .filter(movable)
            .min_by_key(|step| step.abs_diff(keyframe.first))
            .copied();
        if let Some(nearest) = nearest {
            chosen.remove(&nearest);
        }
        chosen.insert(keyframe.first);
    }
    chosen
}

/// Removes the frames that an earlier, longer result left behind.
fn remove_frames_after(steps: usize, folder: &Path) -> Result<(), OutputError> {
    for entry in fs::read_dir(folder).map_err(OutputError::of(folder))? {
        let path = entry.map_err(OutputError::of(folder))?.path();
        let name = path
            .file_name()
            .and_then(|name| name.to_str())
            .unwrap_or_default();
        let step = name
            .strip_prefix("frame_")
            .and_then(|rest| rest.strip_suffix(".png"))
            .and_then(|step| step.parse().ok());
        if step.is_some_and(|step: usize| step > steps) {
            fs::remove_file(&path).map_err(OutputError::of(&path))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_strip_shows_both_ends_and_every_keyframe() {
        let steps: Vec<usize> = strip_steps(60, &[20, 40, 60].map(Stay::at)).into_iter().collect();
        assert!(
            [0, 20, 40, 60].iter().all(|step| steps.contains(step)) && steps.len() <= 9,
            "{steps:?}"
        );
        assert_eq!(
            strip_steps(3, &[Stay::at(3)]).into_iter().collect::<Vec<_>>(),
            [0, 1, 2, 3]
        );
    }

    #[test]
    fn a_keyframe_that_is_held_takes_no_more_room_than_others() {
        let shown = |first, last| strip_steps(1000, &[Stay { first, last }]);
        let evenly = strip_steps(1000, &[]);
        assert_eq!(shown(2, 1000), evenly);
        // Its first step takes the place of the nearest one.
        let moved = shown(300, 400);
        assert!(moved.contains(&300) && !moved.contains(&285), "{moved:?}");
        assert_eq!(moved.len(), evenly.len());
    }
}
