//! The steps of a written result, exposed one at a time: the memory of one field and one picture, whatever the number of steps.

use std::path::Path;

use super::exr::exr;
use super::lines::{Lines, Plane, Vectors};
use super::render::{Body, Drift, Film, Shot, Smoke};
use super::{Densities, OutputError, Pictured, Places};
use crate::report::Said;
use crate::stay::Stay;

/// What a force changes of the largest velocity in a step, in parts of it, where nothing steers: a simulation leaves some 1e-5.
const UNSTEERED: f64 = 1e-4;

/// A result folder whose steps can be drawn.
pub(crate) struct Reel {
    densities: Densities,
    full: f32,
    body: Option<Body>,
    flow: Flow,
    drift: Option<Drift>,
    keyframes: Vec<usize>,
    lines: Lines,
}

/// What is drawn of a step.
pub(crate) struct Still {
    /// Cells along x, y (and z).
    pub cells: Vec<usize>,
    pub density: Vec<f32>,
    pub body: Option<Body>,
}

/// What tells how far the flow moves smoke in a step.
struct Flow {
    places: Places,
    /// Cells a step that a velocity of 1 is.
    scale: f32,
    /// Length of a step.
    dt: f64,
}

impl Flow {
    fn plane<'a>(&'a self, densities: &'a mut Densities) -> Plane<'a> {
        Plane {
            densities,
            places: &self.places,
            scale: self.scale,
        }
    }
}

impl Reel {
    /// Opens a result folder; `None` if it is none.
    pub fn open(folder: &Path) -> Result<Option<Self>, OutputError> {
        let archive = folder.join("result.npz");
        let Some(said) = Said::of(folder).ok().filter(|_| archive.is_file()) else {
            return Ok(None);
        };
        let axes = said.cells.len();
        let (Some(steps), Some(known), true) = (said.steps, &said.keyframes, said.boundary.len() == axes)
        else {
            return Ok(None);
        };
        let flow = Flow {
            places: Places {
                beyond: (0..axes).map(|axis| usize::from(!said.repeats(axis))).collect(),
                centred: said.centred,
            },
            scale: (said.dt / said.side()) as f32,
            dt: said.dt,
        };
        let keyframes = (0..known.len()).map(|target| Pictured {
            stay: Stay::at(0),
            step: 0,
            target,
        });
        let mut densities = Densities::open(&archive, said.cells, steps, keyframes.collect(), said.densest)?;
        let (full, body) = (densities.full()?, densities.body()?);
        Ok(Some(Self {
            densities,
            full,
            body,
            flow,
            drift: None,
            keyframes: known.clone(),
            lines: Lines::default(),
        }))
    }

    /// Cells along x, y (and z).
    pub fn cells(&self) -> &[usize] {
        &self.densities.cells
    }

    /// Length of a step.
    pub fn dt(&self) -> f64 {
        self.flow.dt
    }

    /// The last step.
    pub fn steps(&self) -> usize {
        self.densities.steps
    }

    /// The archive.
    pub fn archive(&self) -> &Path {
        self.densities.path()
    }

    /// Whether the archive has these vectors.
    pub fn has(&self, vectors: Vectors) -> bool {
        self.densities.has_vectors(vectors.name())
    }

    /// Whether any force changes the flow of a plane by more than rounding and the errors of steps do.
    pub fn is_steered(&mut self) -> Result<bool, OutputError> {
        let mut plane = self.flow.plane(&mut self.densities);
        let [force, velocity] = [
            plane.strongest(Vectors::Force, 1)?,
            plane.strongest(Vectors::Velocity, 1)?,
        ];
        Ok(f64::from(force) * self.flow.dt > UNSTEERED * f64::from(velocity))
    }

    /// Has arrows and streaklines drawn over planes.
    pub fn draw_over(&mut self, arrows: Option<Vectors>, streaklines: bool) {
        self.lines = Lines::new(arrows, streaklines);
    }

    /// The steps of the keyframes, ascending.
    pub fn keyframes(&self) -> &[usize] {
        &self.keyframes
    }

    /// The density of a step.
    pub fn density(&mut self, step: usize) -> Result<Vec<f32>, OutputError> {
        self.densities.density(step)
    }

    /// The solid cells as 1, others as 0, if there are any.
    pub fn solid(&mut self) -> Result<Option<Vec<f32>>, OutputError> {
        self.densities.solid()
    }

    /// Component `axis` of the flow from `step` to the next one, in the scene's units, on all faces, those on walls included.
    pub fn faces(&mut self, axis: usize, step: usize) -> Result<Vec<f32>, OutputError> {
        self.densities
            .vectors(Vectors::Velocity.name(), axis, step, &self.flow.places)
    }

    /// Bytes that drawing a picture takes, about, of the result's cells or of so many that are finer.
    pub fn bytes(&self, finer: Option<&[usize]>, shot: &Shot) -> usize {
        let coarse = self.densities.cells.as_slice();
        Smoke::bytes(finer.unwrap_or(coarse), coarse, self.body.is_some(), shot)
    }

    /// The step as it is.
    fn still(&mut self, step: usize) -> Result<Still, OutputError> {
        Ok(Still {
            cells: self.densities.cells.clone(),
            density: self.densities.density(step)?,
            body: self.body.clone(),
        })
    }

    /// The light of a step, of which `still` may be drawn instead of what the result has.
    pub fn expose(&mut self, step: usize, still: Option<Still>, shot: &Shot) -> Result<Film, OutputError> {
        let still = still.map_or_else(|| self.still(step), Ok)?;
        let smoke = Smoke::new(&still.cells, still.density, self.full, still.body);
        let smoke = match self.drifted(step, shot.detail)? {
            Some(drift) => smoke.with_detail(drift, shot.detail),
            None => smoke,
        };
        let mut film = smoke.expose(shot);
        if let Some(pixels) = smoke.pixels_of(self.densities.cells.first().copied().unwrap_or(1), shot) {
            let mut plane = self.flow.plane(&mut self.densities);
            let over = self.lines.at(&mut plane, step, pixels)?;
            smoke.draw_over(&mut film, shot, &over);
        }
        Ok(film)
    }

    /// Where the detail of a step came from, if there is any: the flow is followed from where that was last asked for, or from
    /// where it does not matter any more.
    fn drifted(&mut self, step: usize, amount: f32) -> Result<Option<Drift>, OutputError> {
        let &[nx, ny, nz] = self.densities.cells.as_slice() else {
            return Ok(None);
        };
        // What was photographed has no flow for detail to go with.
        if amount <= 0.0 || !self.has(Vectors::Velocity) {
            return Ok(None);
        }
        let mut drift = self.drift.take().filter(|drift| drift.step() <= step);
        let mut now = drift.take().unwrap_or_else(|| Drift::new([nx, ny, nz]));
        now.begin_at(now.step().max(Drift::begins(step)));
        while now.step() < step {
            let (name, Flow { places, scale, .. }) = (Vectors::Velocity.name(), &self.flow);
            let flow = self
                .densities
                .at_centres(name, places.carrying(now.step()), places, *scale)?;
            now.follow(&flow);
        }
        self.drift = Some(now.clone());
        Ok(Some(now))
    }
}

impl Film {
    /// The bytes of an OpenEXR file.
    pub fn to_exr(&self) -> Vec<u8> {
        exr(self)
    }
}
