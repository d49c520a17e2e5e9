//! What a scene says, section by section.

use super::document::Document;
use crate::keyframes::{Canvas, ShapeSpec};
use crate::stay::Stay;
use crate::windows::Windows;
use std::path::PathBuf;
use thurible_core::{Advection, Boundary, Emitter, FluidsParams, Params, Supply, Template};

/// Everything a scene file says, with its defaults filled in and every value checked.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The text it came from, for errors found later and for the report.
    pub document: Document,
    /// Size of the box and how its axes end.
    pub grid: Grid,
    /// Steps and their length.
    pub time: Time,
    /// The shape of rho_0; where there is none, emitters make the smoke.
    pub source: Option<ShapeSpec>,
    /// Smoke that is made on the way.
    pub emitters: Vec<Emission>,
    /// The targets, by ascending step; no two at the same.
    pub keyframes: Vec<Keyframe>,
    /// Where nothing flows, each with its key in the file.
    pub obstacles: Vec<(String, ShapeSpec)>,
    /// Step from which no force acts.
    pub release: Option<usize>,
    /// Simple fields of which the force is made, where it is.
    pub templates: Vec<Template>,
    /// What the fluid does by itself.
    pub flow: Flow,
    /// What is minimised.
    pub control: Control,
    /// How density is carried.
    pub advection: Advection,
    /// How it is solved.
    pub method: MethodSection,
    /// What is written, and where.
    pub output: Output,
}

/// `[grid]`
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Cells per axis, two or three.
    pub cells: Vec<usize>,
    /// One word per axis.
    pub boundary: Vec<Boundary>,
    /// The longest side of the box.
    pub length: f64,
}

/// `[time]`
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Time {
    /// N; densities are numbered 0 to N.
    pub steps: usize,
    /// Length of a step.
    pub dt: f64,
}

/// One `[[keyframe]]`.
#[derive(Clone, Debug)]
pub struct Keyframe {
    /// The step it stands at.
    pub step: usize,
    /// How many steps more it stands at.
    pub hold: usize,
    /// What the density should look like there.
    pub shape: ShapeSpec,
    /// What its data term is multiplied by.
    pub weight: f64,
    /// Where it matters; `None` is everywhere.
    pub region: Option<ShapeSpec>,
    /// Its key in the file, `keyframe[i]`, for errors found later.
    pub key: String,
}

impl Keyframe {
    /// All steps that it stands at.
    pub fn stay(&self) -> Stay {
        Stay {
            first: self.step,
            last: self.step + self.hold,
        }
    }
}

/// One `[[emitter]]`.
#[derive(Clone, Debug)]
pub struct Emission {
    /// When it makes how much.
    pub emits: Emitter,
    /// Where.
    pub shape: ShapeSpec,
    /// Its key in the file, `emitter[i]`, for errors found later.
    pub key: String,
}

/// `[flow]`
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// nu, in the scene's units.
    pub viscosity: f64,
    /// Whether it slips along walls and obstacles.
    pub slip: bool,
    /// Acceleration where the density is 1, in the scene's units.
    pub buoyancy: [f64; 3],
}

/// `[control]`
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// r, the weight of the force.
    pub force_weight: f64,
    /// Smoothness of the force in cells; `None` is the default.
    pub smoothness: Option<f64>,
    /// What the price of force is multiplied by at some steps.
    pub schedule: Vec<(usize, f64)>,
    /// Where force may act; `None` is everywhere.
    pub mask: Option<ShapeSpec>,
    /// m, the number of Gaussian filters; `None` is `"auto"`.
    pub filters: Option<usize>,
    /// Whether keyframes are scaled to the mass of the source.
    pub match_mass: bool,
    /// The file of v_0; `None` is `"rest"`.
    pub initial_velocity: Option<PathBuf>,
}

/// `[method]` and `[simulation]`
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MethodSection {
    /// The method, its iterations and the choices of every method; threads and ceiling are no business of a scene.
    pub params: Params,
    /// `window` and `stride`, where the scene is solved window by window.
    pub windows: Option<Windows>,
    /// `[method.projection] tolerance`
    pub projection_tolerance: f64,
    /// `[method.stable_fluids]`, and whether the scene is solved by that.
    pub fluids: FluidsSection,
}

/// `[method.stable_fluids]`
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FluidsSection {
    /// Whether the method is this one.
    pub chosen: bool,
    /// The choices.
    pub params: FluidsParams,
    /// States that are kept, 0 for all that the adjoint reads; `None` is `"auto"`.
    pub slots: Option<usize>,
}

/// `[output]`
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// The result folder, relative paths already taken from the scene file.
    pub folder: PathBuf,
    /// Whether images are written.
    pub frames: bool,
}

impl Scene {
    /// Whether keyframes take the mass of a free flow: where emitters fill up to a target, or smoke leaves by open sides, it is not known
    /// before.
    pub fn asks_a_free_flow(&self) -> bool {
        let fills = |emitter: &Emission| matches!(emitter.emits.supply, Supply::Target(_));
        let opens = self.grid.boundary.iter().any(|end| end.is_open());
        let unknown = opens || self.emitters.iter().any(fills);
        self.control.match_mass && !self.keyframes.is_empty() && unknown
    }

    /// The grid as the shapes see it.
    pub fn canvas(&self) -> Canvas {
        Canvas {
            cells: self.grid.cells.clone(),
            periodic: self
                .grid
                .boundary
                .iter()
                .map(|&boundary| boundary == Boundary::Periodic)
                .collect(),
            length: self.grid.length,
        }
    }
}
