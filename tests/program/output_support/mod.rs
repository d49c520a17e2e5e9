//! A made-up run: smoke that turns from a ball into a letter, and what a solve would have recorded of it.

use core::marker::PhantomData;

use thurible::keyframes::{Canvas, ShapeSpec};
use thurible::output::{Frames, Precision, Sample, Samples};
use thurible::report::{
    AdvectionRecord, Facts, IterationRecord, KeyframeRecord, LedgerLine, MemoryRecord, ObjectiveRecord,
    RunRecord, SecondsRecord,
};
use thurible::stay::Stay;
use thurible_core::output::{DENSITY, FORCE, VELOCITY};
use thurible_core::{Boundary, Fact, Kind, Method, Output, Place, Status, Unit};

/// A trajectory without a solver; values tell which field, step and place they come from.
#[derive(Clone)]
pub struct MadeUp<T> {
    cells: Vec<usize>,
    periodic: Vec<bool>,
    steps: usize,
    keyframes: Vec<usize>,
    source: Vec<f64>,
    target: Vec<f64>,
    number: PhantomData<T>,
}

impl<T: Number> MadeUp<T> {
    pub fn new(cells: &[usize], periodic: &[bool], steps: usize, keyframes: &[usize]) -> Self {
        let canvas = Canvas {
            cells: cells.to_vec(),
            periodic: periodic.to_vec(),
            length: 1.0,
        };
        let draw = |shape: &str| {
            toml::from_str::<ShapeSpec>(shape)
                .unwrap()
                .rasterise(&canvas, "".as_ref())
                .unwrap()
        };
        let middle: Vec<String> = canvas.middle()[..cells.len()]
            .iter()
            .map(f64::to_string)
            .collect();
        let source = draw(&format!(
            "circle = {{ center = [{}], radius = 0.2 }}",
            middle.join(", ")
        ));
        let target = draw("text = \"F\"");
        Self {
            cells: cells.to_vec(),
            periodic: periodic.to_vec(),
            steps,
            keyframes: keyframes.to_vec(),
            source,
            target,
            number: PhantomData,
        }
    }

    fn fill(&self, out: &mut Samples, values: impl Iterator<Item = f64>) {
        let list = T::list(out);
        list.clear();
        list.extend(values.map(T::from));
    }

    fn faces(&self, axis: usize) -> usize {
        let count =
            |(other, cells): (usize, &usize)| cells + usize::from(other == axis && !self.periodic[other]);
        self.cells.iter().enumerate().map(count).product()
    }

    fn density(&self, step: usize) -> impl Iterator<Item = f64> {
        let part = step as f64 / self.steps as f64;
        let amount = 2.0 * part * (1.0 - part) + 0.1 * part;
        (0..self.source.len()).map(move |index| {
            let from = self.swirl(index, amount);
            (1.0 - part).powf(1.5) * self.source[from] + part.powf(1.5) * self.target[from] + 1e-3 * part
        })
    }

    /// A wavy place to look at, so that the smoke swirls on its way.
    fn swirl(&self, index: usize, amount: f64) -> usize {
        let (nx, ny) = (self.cells[0], self.cells[1]);
        let nz = self.cells.get(2).copied().unwrap_or(1);
        let (x, y, z) = (index % nx, index / nx % ny, index / nx / ny);
        let (up, ups) = if nz > 1 { (z, nz) } else { (y, ny) };
        let wave = |place: usize, count: usize, phase: f64| {
            (place as f64 / count as f64 * 11.0 + phase).sin() * amount * count as f64 * 0.06
        };
        let moved = |place: usize, count: usize, by: f64| {
            ((place as f64 + by).round().clamp(0.0, count as f64 - 1.0)) as usize
        };
        let new_x = moved(x, nx, wave(up, ups, 1.0) + 0.5 * wave(3 * up, ups, 0.3));
        let new_up = moved(up, ups, wave(x, nx, 2.0));
        if nz > 1 {
            (new_up * ny + y) * nx + new_x
        } else {
            new_up * nx + new_x
        }
    }
}

/// A precision of `Sample` that values of f64 round to.
pub trait Number: Sample {
    fn from(value: f64) -> Self;
}

impl Number for f32 {
    fn from(value: f64) -> Self {
        value as f32
    }
}

impl Number for f64 {
    fn from(value: f64) -> Self {
        value
    }
}

impl<T: Number> Frames for MadeUp<T> {
    fn cells(&self) -> &[usize] {
        &self.cells
    }

    fn periodic(&self) -> &[bool] {
        &self.periodic
    }

    fn steps(&self) -> usize {
        self.steps
    }

    fn precision(&self) -> Precision {
        T::PRECISION
    }

    fn keyframe_steps(&self) -> &[usize] {
        &self.keyframes
    }

    fn keyframe(&self, index: usize, out: &mut Samples) {
        let part = self.keyframes[index] as f64 / self.steps as f64;
        self.fill(
            out,
            self.source
                .iter()
                .zip(&self.target)
                .map(|(from, to)| from + part * (to - from)),
        );
    }

    fn outputs(&self) -> &[Output] {
        &OUTPUTS
    }

    fn read(&self, output: &Output, step: usize, axis: usize, out: &mut Samples) {
        let place = 100.0 * axis as f64;
        let faces = (0..self.faces(axis)).map(|face| 0.1 + step as f64 + place + face as f64 / 8192.0);
        match (output.place, output.unit) {
            (Place::Cells, _) => self.fill(out, self.density(step)),
            (Place::Faces, Unit::Velocity) => self.fill(out, faces),
            (Place::Faces, _) => self.fill(out, faces.map(|value| -value)),
        }
    }
}

/// What a solver gives, and a field of cells beside it.
pub const OUTPUTS: [Output; 4] = [
    DENSITY,
    VELOCITY,
    FORCE,
    Output {
        name: "smoke_age",
        words: "how long the smoke has been there",
        fewer: 1,
        ..DENSITY
    },
];

/// A plausible ledger.
fn memory() -> MemoryRecord {
    let line = |name: &str, bytes: usize, depth: usize| LedgerLine {
        name: name.into(),
        bytes,
        depth,
    };
    MemoryRecord {
        planned_bytes: 41_234_432,
        used_bytes: 41_234_432,
        paper_bound_bytes: 41_943_040,
        ledger: vec![
            line("whole block", 41_234_432, 0),
            line("source and keyframes", 131_072, 1),
            line("method", 41_103_360, 1),
            line("velocity v", 5_284_864, 2),
            line("pressure p", 2_621_440, 2),
            line("force w, or candidate v*", 5_284_864, 2),
            line("multiplier", 5_284_864, 2),
            line("density", 2_686_976, 2),
            line("coarse levels", 19_940_352, 2),
        ],
    }
}

/// A plausible record of `iterations` iterations.
pub fn record(frames: &dyn Frames, iterations: usize) -> RunRecord {
    let history = (1..=iterations).map(entry).collect::<Vec<_>>();
    let objective = history.last().map_or(
        ObjectiveRecord {
            data: 0.0,
            force: f64::NAN,
            plain: f64::NAN,
            initial: None,
        },
        |entry| entry.objective,
    );
    let facts = |&step: &usize| KeyframeRecord {
        step,
        relative_l2: 0.0832,
        relative_l2_before: 0.913,
        mass_factor: 1.0532,
        mass_ratio: None,
        stay: Stay::at(step),
    };
    RunRecord {
        buoyancy: 0.0,
        gravity_axis: Some(1),
        acceleration: vec![0.0; 2],
        release: None,
        windows: Vec::new(),
        solid: false,
        outflow: None,
        emission: false,
        format: 1,
        cells: frames.cells().to_vec(),
        boundary: frames
            .periodic()
            .iter()
            .map(|&periodic| {
                if periodic {
                    Boundary::Periodic
                } else {
                    Boundary::Wall
                }
            })
            .collect(),
        length: 1.0,
        dt: 1.0,
        steps: frames.steps(),
        simulated_steps: None,
        viscosity: 0.0,
        slip: true,
        force_weight: 1e3,
        force_smoothness: 0.0,
        filters: 5,
        advection: AdvectionRecord {
            scheme: "quick".into(),
            tolerance: 1e-5,
        },
        method: Method::Admm.into(),
        precision: if frames.precision() == Precision::F64 {
            "f64"
        } else {
            "f32"
        }
        .into(),
        status: Status::Converged,
        objective,
        density_min: 0.0,
        density_max: 1.0,
        history,
        memory: memory(),
        seconds: SecondsRecord {
            total: 143.2,
            setup: 0.031,
            nested: 4.2,
            ao: 38.4,
            nso: 101.7,
            other: 1.2,
            finish: 1.9,
            ao_average: 1.05,
            nso_average: 2.75,
        },
        threads: 2,
        version: "0.1.0".into(),
        scene: "[grid]\ncells = [128, 128]   # <not> a \"tag\"\n\n[time]\nsteps = 40\n".into(),
        scene_file: "letter_f.toml".into(),
        overrides: Vec::new(),
        command: "thurible solve examples/letter_f.toml -o out".into(),
        keyframes: frames.keyframe_steps().iter().map(facts).collect(),
        templates: Vec::new(),
        frames: Vec::new(),
        remarks: Vec::new(),
        fluids: None,
    }
}

const AO_STEP: Fact = Fact::new("ao_step", Kind::Number, "step");
const DENSITY_CHANGE: Fact = Fact::new("density_change", Kind::Number, "change").in_chart("Change");
const NSO_RESIDUALS: Fact = Fact::new("nso_residuals", Kind::Series, "residuals").in_chart("Residuals");
const KKT: Fact = Fact::new("kkt", Kind::Number, "violation").in_chart("Optimality");
const HELD: Fact = Fact::new("held", Kind::Flag, "held");

fn entry(iteration: usize) -> IterationRecord {
    let late = iteration as f64;
    let wobble = 1.0 + 0.15 * (2.3 * late).sin();
    let cycles = (0..5).map(|cycle| 0.02 * (-0.1 * late).exp() * 0.17_f64.powi(cycle));
    IterationRecord {
        window: None,
        iteration,
        seconds: 3.9 * late,
        seconds_left: Some(3.9 * (40.0 - late)),
        objective: ObjectiveRecord {
            data: 2400.0 * (-0.25 * late).exp() + 38.0,
            force: 19.0 * (1.0 - (-0.2 * late).exp()) * wobble,
            plain: 19.0 * (1.0 - (-0.2 * late).exp()) * wobble,
            initial: None,
        },
        level: None,
        facts: Facts(vec![
            (AO_STEP, vec![1.0]),
            (DENSITY_CHANGE, vec![0.9 * (-0.13 * late).exp() * wobble]),
            (NSO_RESIDUALS, cycles.collect()),
            (KKT, vec![0.6 * (-0.11 * late).exp() * wobble]),
            (HELD, vec![if iteration % 3 == 1 { 1.0 } else { 0.0 }]),
        ]),
    }
}
