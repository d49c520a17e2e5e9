//! What is given: the frames and their truth, looked at once before anything is tracked.

use super::emission::Emission;
use super::files::{self, Found, KEY, TRUTH, refused};
use super::scene::CaptureScene;
use crate::change::{self, Change};
use crate::channels::has_channels;
use crate::exit::Failure;
use crate::keyframes::{Frames, Series, ends_with};
use crate::plan::size_in_words;
use crate::undershoot::{Undershoot, place};
use core::ops::RangeInclusive;
use thurible_core::Boundary;
use thurible_core::track::FULL;

/// The densest smoke that can be tracked, from and to: far enough from what single precision does not hold.
const TRACKED: [f64; 2] = [1e-30, 1e30];
/// As how much the densest may count by a scale that is given.
const COUNTED: RangeInclusive<f64> = 1e-6..=1e6;

/// Frames that can be tracked.
pub(crate) struct Given {
    frames: Frames,
    /// True velocities, component by component, if there are any.
    truth: Vec<Series>,
    /// What was made between frames, if that is known.
    emission: Option<Emission>,
    /// The first frame among those of the files.
    first: usize,
    /// N: one less than frames.
    pub pairs: usize,
    pub cells: Vec<usize>,
    pub boundary: Vec<Boundary>,
    pub length: f64,
    pub dt: f64,
    pub density_scale: f64,
    /// What the user should know of the frames.
    pub remarks: Vec<String>,
}

/// What densities are multiplied by.
fn scaled(scene: &CaptureScene, largest: f64) -> Result<f64, Failure> {
    let automatic = FULL / largest;
    let Some(scale) = scene.density_scale else {
        return Ok(automatic);
    };
    let counted = scale * largest;
    if COUNTED.contains(&counted) {
        return Ok(scale);
    }
    let why = format!(
        "is {scale:e}, by which the densest smoke counts as {counted:.1e}; the weights are made for {FULL}, and {:e} to {:e} can be tracked: write {automatic:.1e}, or leave it out",
        COUNTED.start(),
        COUNTED.end()
    );
    Err(scene.document.refuse("capture.density_scale", why))
}

impl Given {
    /// Finds and checks everything that a capture names.
    pub fn open(scene: &CaptureScene) -> Result<Self, Failure> {
        let Found {
            frames,
            truth,
            emission,
            known,
        } = files::find(scene)?;
        let (first, pairs) = range(scene, &frames)?;
        let mut given = Self {
            frames,
            truth: Vec::new(),
            emission: None,
            first,
            pairs,
            cells: Vec::new(),
            boundary: Vec::new(),
            length: scene.length.or(known.length).unwrap_or(1.0),
            dt: scene.dt.or(known.dt).unwrap_or(1.0),
            density_scale: 1.0,
            remarks: [scene.unheard(), known.remarks].concat(),
        };
        let is_result = known.boundary.is_some();
        let largest = given.look(scene, is_result)?;
        given.density_scale = scaled(scene, largest)?;
        given.emission = Emission::open(scene, emission.as_deref(), &given.cells, first + pairs)?;
        for step in 0..pairs {
            given.emission(scene, step)?;
        }
        given.boundary = scene.ends(given.cells.len(), known.boundary.as_deref())?;
        if let Some(archive) = scene.truth.as_ref().or(truth.as_ref()) {
            given.truth = files::truth(scene, archive, given.cells.len())?;
            given.check_truth(scene)?;
        }
        Ok(given)
    }

    /// Frame `index`, from 0.
    pub fn frame(&mut self, scene: &CaptureScene, index: usize) -> Result<Vec<f64>, Failure> {
        let read = self.frames.read(self.first + index);
        read.map(|frame| frame.values)
            .map_err(|error| refused(&scene.document, KEY, &error))
    }

    /// Whether it is known what was made between frames.
    pub fn has_emission(&self) -> bool {
        self.emission.is_some()
    }

    /// What was made between the frames of pair `index`, if that is known.
    pub fn emission(&mut self, scene: &CaptureScene, index: usize) -> Result<Option<Vec<f64>>, Failure> {
        let step = self.first + index;
        let emission = self.emission.as_mut();
        emission.map(|emission| emission.read(scene, step)).transpose()
    }

    /// Whether there is truth.
    pub fn has_truth(&self) -> bool {
        !self.truth.is_empty()
    }

    /// The true velocity of pair `index` along an axis, in the capture's units.
    pub fn truth(&mut self, scene: &CaptureScene, index: usize, axis: usize) -> Result<Vec<f64>, Failure> {
        let Some(series) = self.truth.get_mut(axis) else {
            return Ok(Vec::new());
        };
        series
            .read(self.first + index)
            .map_err(|error| refused(&scene.document, TRUTH, &error))
    }

    /// Reads every frame once; the largest density of all. A result of the program has no colours.
    fn look(&mut self, scene: &CaptureScene, is_result: bool) -> Result<f64, Failure> {
        let refuse = |frames: &Frames, index: usize, found: &str, remedy: &str| {
            refused(&scene.document, KEY, &frames.refuse(index, found, remedy))
        };
        let (mut largest, mut before): (f64, Vec<f64>) = (0.0, Vec::new());
        let mut negative: Option<(usize, usize, f64)> = None;
        for index in self.first..=self.first + self.pairs {
            let frame = self
                .frames
                .read(index)
                .map_err(|error| refused(&scene.document, KEY, &error))?;
            if self.cells.is_empty() {
                if frame.values.is_empty() {
                    let found = format!("has frames of {} cells", size_in_words(&frame.cells));
                    let remedy = "a frame has a cell along each axis at least; save it again";
                    return Err(refuse(&self.frames, index, &found, remedy));
                }
                if !(2..=3).contains(&frame.cells.len()) {
                    let found = format!("has frames of {} axes", frame.cells.len());
                    let remedy =
                        "a frame has the axes [y, x] or [z, y, x], after time where one array holds all";
                    return Err(refuse(&self.frames, index, &found, remedy));
                }
                if !is_result && !is_volume(&self.frames, index) && has_channels(&frame.cells) {
                    let found = format!(
                        "has {} values along its last axis, which looks like colour",
                        frame.cells[0]
                    );
                    let remedy = "give one channel, as frames[..., 0] or frames[..., :3].mean(axis=-1)";
                    return Err(refuse(&self.frames, index, &found, remedy));
                }
                self.cells.clone_from(&frame.cells);
            }
            if frame.cells != self.cells {
                let found = format!(
                    "has {} cells where the frames before have {}",
                    size_in_words(&frame.cells),
                    size_in_words(&self.cells)
                );
                return Err(refuse(&self.frames, index, &found, "give frames of one size"));
            }
            let shape: Vec<usize> = self.cells.iter().rev().copied().collect();
            if let Some(at) = frame.values.iter().position(|value| !value.is_finite()) {
                let found = format!("holds {} at {}", frame.values[at], place(at, &shape));
                return Err(refuse(&self.frames, index, &found, "every value must be finite"));
            }
            let too_large = |value: &f64| value.abs() > TRACKED[1];
            if let Some(at) = frame.values.iter().position(too_large) {
                let found = format!("holds {:e} at {}", frame.values[at], place(at, &shape));
                let remedy = "numbers up to 1e30 can be tracked: give densities in another unit";
                return Err(refuse(&self.frames, index, &found, remedy));
            }
            if let Some(found) = Undershoot::of(&frame.values) {
                if !found.is_small() {
                    let [found, remedy] = found.refused(&shape);
                    return Err(refuse(&self.frames, index, &found, &remedy));
                }
                let (count, frames, least) = negative.unwrap_or((0, 0, 0.0));
                negative = Some((count + found.count, frames + 1, found.least.min(least)));
            }
            largest = frame.values.iter().copied().fold(largest, f64::max);
            if index > self.first {
                self.compare(scene, index, &before, &frame.values)?;
            }
            before = frame.values;
        }
        if let Some((count, frames, least)) = negative {
            self.remarks.push(format!(
                "{count} values in {frames} frames are below 0, the least {least:.3e}; they stay as they are"
            ));
        }
        if largest >= TRACKED[0] {
            return Ok(largest);
        }
        if largest > 0.0 {
            let found = format!("and all others hold no more than {largest:e}");
            let remedy = "smoke of 1e-30 and more can be tracked: give densities in another unit";
            return Err(refuse(&self.frames, self.first, &found, remedy));
        }
        let remedy = "give frames with smoke in them";
        Err(refuse(
            &self.frames,
            self.first,
            "and all others have no smoke anywhere",
            remedy,
        ))
    }

    /// Refuses a frame that has lost all smoke, and remarks on what no flow does.
    fn compare(
        &mut self,
        scene: &CaptureScene,
        index: usize,
        before: &[f64],
        now: &[f64],
    ) -> Result<(), Failure> {
        let Some(change) = change::between(before, now) else {
            return Ok(());
        };
        if change == Change::Lost {
            let remedy = "replace it, or end before it by capture.last";
            let found = "has no smoke anywhere, and the frame before has some";
            let error = self.frames.refuse(index, found, remedy);
            return Err(refused(&scene.document, KEY, &error));
        }
        let (_, number) = self.frames.place(index);
        let number = number.unwrap_or(index);
        let frames = [number.saturating_sub(1), number];
        self.remarks
            .push(change.sentence(frames, ["capture.first", "track.levels"]));
        Ok(())
    }

    /// Refuses truth of other faces, of fewer steps, or with what is no number.
    fn check_truth(&mut self, scene: &CaptureScene) -> Result<(), Failure> {
        for (axis, series) in self.truth.iter().enumerate() {
            let expected = self.faces(axis);
            let enough = series.count() >= self.first + self.pairs;
            if series.shape() != expected || !enough {
                let found = format!(
                    "`capture.truth` file `{}` holds {} steps of {:?} faces where {} of {expected:?} are needed",
                    series.path().display(),
                    series.count(),
                    series.shape(),
                    self.first + self.pairs
                );
                let remedy = "give velocities of the same frames, and say `capture.boundary` as it was";
                return Err(Failure::Input(format!(
                    "{}: {found}; {remedy}",
                    scene.document.place("capture.truth")
                )));
            }
        }
        self.check_values_of_truth(scene)
    }

    /// Refuses truth with a value that is not finite in a step that is tracked.
    fn check_values_of_truth(&mut self, scene: &CaptureScene) -> Result<(), Failure> {
        for axis in 0..self.truth.len() {
            for index in 0..self.pairs {
                let truth = self.truth(scene, index, axis)?;
                if truth.iter().all(|value| value.is_finite()) {
                    continue;
                }
                let path = self.truth[axis].path().display();
                return Err(Failure::Input(format!(
                    "{}: `capture.truth` file `{path}` has a value that is not finite in step {}; correct it, or leave it out",
                    scene.document.place("capture.truth"),
                    self.first + index
                )));
            }
        }
        Ok(())
    }

    /// Faces along z, y, x across an axis.
    pub fn faces(&self, axis: usize) -> Vec<usize> {
        let mut shape = self.cells.clone();
        if let (Some(count), Some(end)) = (shape.get_mut(axis), self.boundary.get(axis)) {
            *count += usize::from(*end != Boundary::Periodic);
        }
        shape.reverse();
        shape
    }
}

/// Whether a frame is a file of a volume, which has no channels.
fn is_volume(frames: &Frames, index: usize) -> bool {
    let (path, _) = frames.place(index);
    ends_with(path, "vdb")
}

/// The first frame that is tracked, and how many pairs follow.
fn range(scene: &CaptureScene, frames: &Frames) -> Result<(usize, usize), Failure> {
    let count = frames.count();
    let last = scene.last.unwrap_or(count.saturating_sub(1));
    if last >= count {
        let why = format!(
            "is {last}, but the last of {count} frames is {}; lower it",
            count.saturating_sub(1)
        );
        return Err(scene.document.refuse("capture.last", why));
    }
    if last <= scene.first {
        let found = if count == 1 {
            "holds a single frame".to_owned()
        } else {
            format!("leaves the frames {} to {last}", scene.first)
        };
        let remedy = "a flow needs two frames at least; give more, or change capture.first and capture.last";
        return Err(scene.document.refuse(KEY, format!("{found}; {remedy}")));
    }
    Ok((scene.first, last - scene.first))
}
