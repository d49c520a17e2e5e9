//! Captures of our own: smoke simulated on twice the cells in four times the steps, and restricted to the frames and the flow that a tracker is
//! to find. The simulation runs in stretches, so that no more of it is in memory than some frames.

use super::bench::{Bench, Halt, Made};
use super::doors::{Free, marked};
use super::fields::{faces, half_of_cells, half_of_faces};
use crate::destination::Destination;
use crate::exit::{DONE, Failure};
use crate::keyframes::{Series, ShapeError, VELOCITY};
use crate::output::{Precision, Store};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Steps of the simulation a frame.
pub(super) const STEPS: usize = 4;
/// Frames of a stretch.
const STRETCH: usize = 5;
/// The archive of frames and flows, and that of the density at the beginning.
const ARCHIVE: &str = "truth.npz";
const SOURCE: &str = "source.npz";

/// What is to be captured.
pub(super) struct Play {
    /// The name of its folder.
    pub name: &'static str,
    /// Cells of a frame along x, y (and z).
    pub cells: Vec<usize>,
    pub frames: usize,
    /// Acceleration upwards where the density is 1, in cells and steps of the simulation.
    pub buoyancy: f64,
    pub viscosity: f64,
    /// Other tables of the scene, in all stretches,
    pub tables: String,
    /// and in the first alone.
    pub stir: String,
    /// The density at the beginning, on the cells of the simulation; empty where only emitters make smoke.
    pub source: Vec<f64>,
    /// Whether that is the shape of emitters instead.
    pub emits: bool,
}

/// Frames and the flow between them, in cells and steps of the simulation.
#[derive(Clone)]
pub(super) struct Capture {
    pub made: Rc<Made>,
    pub cells: Vec<usize>,
    pub frames: usize,
    pub length: f64,
    pub buoyancy: f64,
    pub viscosity: f64,
}

impl Capture {
    /// The array `density`, and `velocity_x` and so on.
    pub fn archive(&self) -> PathBuf {
        self.made.folder.join(ARCHIVE)
    }

    /// What `thurible track` is told of the box.
    pub fn sets(&self) -> Vec<String> {
        vec![
            format!("capture.length={:?}", self.length),
            format!("capture.dt={:?}", STEPS as f64),
        ]
    }

    /// The side of a cell.
    pub fn cell(&self) -> f64 {
        self.length / self.cells.iter().copied().max().unwrap_or(1) as f64
    }

    /// A scene in its box with a step a frame, with `tables` in it.
    pub fn scene(&self, steps: usize, tables: &str) -> String {
        let head = head(&self.cells, self.length, (steps, STEPS as f64));
        // A scene has a source, though its flow goes on from a result.
        let sides: Vec<f64> = self
            .cells
            .iter()
            .map(|&count| count as f64 * self.cell())
            .collect();
        format!(
            "{head}[source]\nbox = {{ min = {:?}, max = {sides:?} }}\n[flow]\nbuoyancy = {:?}\nviscosity = {:?}\n{tables}",
            vec![0.0; sides.len()],
            self.buoyancy,
            self.viscosity
        )
    }

    /// The size as rows have it.
    pub fn size(&self) -> String {
        size(&self.cells, self.frames)
    }
}

/// "32 x 32 x 64, 60 frames"
pub(super) fn size(cells: &[usize], frames: usize) -> String {
    format!("{}, {frames} frames", crate::report::product(cells))
}

/// The beginning of a scene.
fn head(cells: &[usize], length: f64, (steps, dt): (usize, f64)) -> String {
    format!(
        "[grid]\ncells = {cells:?}\nlength = {length:?}\n[time]\nsteps = {steps}\ndt = {dt:?}\n[output]\nframes = false\n"
    )
}

impl Play {
    /// Cells of the simulation.
    pub fn fine(&self) -> Vec<usize> {
        self.cells.iter().map(|count| 2 * count).collect()
    }

    fn length(&self) -> f64 {
        self.fine().into_iter().max().unwrap_or(1) as f64
    }

    fn capture(&self, made: Rc<Made>) -> Capture {
        Capture {
            made,
            cells: self.cells.clone(),
            frames: self.frames,
            length: self.length(),
            buoyancy: self.buoyancy,
            viscosity: self.viscosity,
        }
    }

    /// The scene of a stretch of `steps` from frame `begin` on.
    fn scene(&self, begin: usize, steps: usize) -> String {
        let stir = if begin == 0 { self.stir.as_str() } else { "" };
        let head = head(&self.fine(), self.length(), (steps, 1.0));
        let source = if self.source.is_empty() || self.emits {
            String::new()
        } else {
            format!("[source]\nfile = \"{SOURCE}\"\nname = \"density\"\n")
        };
        format!(
            "{head}{source}[flow]\nbuoyancy = {:?}\nviscosity = {:?}\n{}{stir}",
            self.buoyancy, self.viscosity, self.tables
        )
    }
}

impl Bench<'_> {
    /// The capture of a play, simulated if it has not been yet.
    pub(super) fn capture(&mut self, play: &Play) -> Result<Capture, Halt> {
        let name = format!("{}/truth", play.name);
        if !self.has(&name) {
            let filmed = self.film(play, &name);
            let film = filmed.inspect_err(|halt| self.remember(&name, halt))?;
            self.once(&name, |_, _| film.end())?;
        }
        let made = self.once(&name, |_, _| Ok(DONE))?;
        Ok(play.capture(made))
    }

    /// Simulates stretch after stretch.
    fn film(&mut self, play: &Play, name: &str) -> Result<Film, Halt> {
        let beside = self.place(&format!("{}/source", play.name));
        if !play.source.is_empty() {
            let source: [(&str, &[usize], &[f64]); 1] = [("density", &play.fine(), &play.source)];
            self.write_arrays(&format!("{}/source", play.name), SOURCE, &source)?;
        }
        let mut film = Film::begin(&play.cells, &self.place(name))?;
        let (mut begin, mut before) = (0, None::<Rc<Made>>);
        while begin + 1 < play.frames {
            let frames = STRETCH.min(play.frames - 1 - begin);
            let from = before
                .as_ref()
                .map(|made| (made.folder.as_path(), STEPS * STRETCH));
            // The step after the last one has the flow that the next stretch begins with.
            let free = Free {
                text: play.scene(begin, STEPS * frames + 1),
                beside: &beside,
                from,
                reference: None,
            };
            let made = self.simulate(&format!("{}/from_{begin}", play.name), &free)?;
            film.take(play, &made, begin == 0, frames)?;
            if let Some(before) = before.replace(made) {
                self.forget_arrays(&before)?;
            }
            begin += frames;
        }
        before.map_or(Ok(()), |before| self.forget_arrays(&before))?;
        Ok(film)
    }
}

/// A capture that grows.
pub(super) struct Film {
    destination: Destination,
    store: Store,
    density: usize,
    velocity: Vec<usize>,
    frames: usize,
}

impl Film {
    /// An empty one of frames of `cells`.
    pub fn begin(cells: &[usize], folder: &Path) -> Result<Self, Halt> {
        let destination = Bench::data(folder, &[ARCHIVE])?;
        let mut store = Store::new(&destination)?;
        let reversed = |counts: &[usize]| counts.iter().rev().copied().collect::<Vec<_>>();
        let density = store.begin("density", reversed(cells))?;
        let velocity = VELOCITY
            .iter()
            .take(cells.len())
            .enumerate()
            .map(|(axis, name)| store.begin(name, reversed(&faces(cells, axis))));
        let velocity = velocity.collect::<Result<_, Failure>>()?;
        Ok(Self {
            destination,
            store,
            density,
            velocity,
            frames: 0,
        })
    }

    /// Adds `frames` frames and what carries to each of them, of the first stretch the frame before them too.
    fn take(&mut self, play: &Play, made: &Made, first: bool, frames: usize) -> Result<(), Halt> {
        let fine = play.fine();
        let mut density = open(made, "density")?;
        for frame in usize::from(!first)..=frames {
            let values = half_of_cells(&read(&mut density, STEPS * frame)?, &fine);
            self.store.push(self.density, &single(&values))?;
            self.frames += 1;
        }
        for (axis, &array) in self.velocity.iter().enumerate() {
            let mut flow = open(made, VELOCITY.get(axis).copied().unwrap_or_default())?;
            for frame in 0..frames {
                let mut mean: Vec<f64> = Vec::new();
                for step in STEPS * frame..STEPS * (frame + 1) {
                    let faces = half_of_faces(&read(&mut flow, step)?, &fine, axis);
                    mean.resize(faces.len(), 0.0);
                    mean.iter_mut()
                        .zip(&faces)
                        .for_each(|(mean, value)| *mean += value / STEPS as f64);
                }
                self.store.push(array, &single(&mean))?;
            }
        }
        Ok(())
    }

    /// Adds a frame, and the flow that follows it where there is one.
    pub fn push(&mut self, density: &[f64], flow: &[Vec<f64>]) -> Result<(), Halt> {
        self.store.push(self.density, &single(density))?;
        self.frames += 1;
        for (&array, faces) in self.velocity.iter().zip(flow) {
            self.store.push(array, &single(faces))?;
        }
        Ok(())
    }

    /// Writes it.
    pub fn end(mut self) -> Result<u8, Halt> {
        self.store.flush()?;
        let (store, frames) = (&self.store, self.frames);
        self.destination.fill(marked(|folder| {
            let count = |name: &str| if name == "density" { frames } else { frames - 1 };
            store.pack(&folder.join(ARCHIVE), Precision::F32, count)
        }))?;
        Ok(DONE)
    }
}

/// In single precision, as captures are.
pub(super) fn single(values: &[f64]) -> Vec<f32> {
    values.iter().map(|&value| value as f32).collect()
}

/// An array of a run.
pub(super) fn open(made: &Made, name: &str) -> Result<Series, Halt> {
    array(&made.archive(), name)
}

/// The components of the flow in an archive.
pub(super) fn flow(archive: &Path) -> Result<Vec<Series>, Halt> {
    VELOCITY.into_iter().map(|name| array(archive, name)).collect()
}

/// An array of an archive.
pub(super) fn array(archive: &Path, name: &str) -> Result<Series, Halt> {
    Series::open(archive, Some(name), "result").map_err(unread)
}

/// An entry of an array.
pub(super) fn read(series: &mut Series, entry: usize) -> Result<Vec<f64>, Halt> {
    series.read(entry).map_err(unread)
}

pub(super) fn unread(error: ShapeError) -> Halt {
    Halt::Broken(error.failure(error.to_string()))
}
