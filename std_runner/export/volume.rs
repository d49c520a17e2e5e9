//! OpenVDB files of the steps, and the stage that says how they play.

use super::sink::{Manner, SMOKE, Sink, TimeScale};
use super::source::{Frame, Source};
use super::usd;
use super::vdb::{self, Component, Grid, Meta};
use crate::exit::Failure;
use crate::output::{OutputError, create_folder, write_bytes, write_whole};
use core::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// The folder of the files.
const FOLDER: &str = "vdb";
/// The largest number that has 16 bits.
const LARGEST_HALF: f64 = 65504.0;

/// A file for each step.
pub(super) struct Volumes<'a> {
    pub manner: &'a Manner,
    /// Whether there is a stage too.
    pub stage: bool,
}

impl Sink for Volumes<'_> {
    fn parts(&self) -> Vec<PathBuf> {
        // A stage of an earlier export plays the files that these replace, so it goes with them even where no new one comes.
        vec![FOLDER.into(), stage()]
    }

    fn step(&mut self, folder: &Path, source: &mut Source, frame: &Frame) -> Result<(), OutputError> {
        create_folder(&folder.join(FOLDER))?;
        self.check(source, frame).map_err(OutputError::Source)?;
        let path = folder.join(self.file(frame.step));
        let time = frame.step as f64 * source.said.dt;
        let metadata = vec![
            (
                "creator",
                Meta::Text(concat!("thurible ", env!("CARGO_PKG_VERSION"))),
            ),
            ("fps", Meta::Float(self.manner.time.fps as f32)),
            ("step", Meta::Whole(frame.step as i64)),
            ("time", Meta::Float(time as f32)),
            ("up", Meta::Text(self.manner.up_word())),
        ];
        let written = vdb::Manner {
            half: self.manner.half,
            codec: self.manner.codec,
            side: source.said.side(),
            corner: self.manner.orientation.corner(source.sides()),
        };
        let grids = self.grids(source, frame);
        write_whole(&path, |file| {
            vdb::write(file, &metadata, &grids, written).map_err(OutputError::of(&path))
        })
    }

    fn finish(
        &mut self,
        folder: &Path,
        source: &mut Source,
        steps: RangeInclusive<usize>,
    ) -> Result<(), OutputError> {
        if !self.stage {
            return Ok(());
        }
        let mut fields = vec!["density"];
        if source.has_flow() {
            fields.push("velocity");
        }
        let files = steps.map(|step| (self.manner.frame(step), self.file(step)));
        let text = usd::stage(files.collect(), &fields, self.manner);
        write_bytes(&folder.join(stage()), text.as_bytes())
    }
}

impl Volumes<'_> {
    fn file(&self, step: usize) -> String {
        format!("{FOLDER}/{}", self.manner.numbered(step, "vdb"))
    }

    /// The grids of a step.
    fn grids<'f>(&self, source: &Source, frame: &'f Frame) -> Vec<Grid<'f>> {
        let (orientation, TimeScale { factor, fps }) = (&self.manner.orientation, self.manner.time);
        let cells = orientation.lattice(source.cells());
        let density = Component {
            values: &frame.density,
            lattice: cells,
            factor: 1.0,
        };
        let rate = || ("fps", Meta::Float(fps as f32));
        let mut grids = vec![Grid {
            name: "density",
            class: "fog volume",
            components: vec![density],
            metadata: vec![rate()],
        }];
        let sign = |axis: usize| if orientation.turned[axis] { -factor } else { factor };
        let unit = || {
            vec![
                rate(),
                ("unit", Meta::Text("length a second")),
                ("times_velocity_of_result", Meta::Float(factor as f32)),
            ]
        };
        if source.has_flow() {
            let component = |axis: usize| Component {
                values: frame
                    .velocity
                    .get(orientation.from[axis])
                    .map_or(&[], Vec::as_slice),
                lattice: cells,
                factor: sign(axis),
            };
            grids.push(Grid {
                name: "velocity",
                class: "unknown",
                components: (0..3).map(component).collect(),
                metadata: unit(),
            });
        }
        if !frame.faces.is_empty() {
            let component = |axis: usize| {
                let faces = frame.faces.get(orientation.from[axis]);
                Component {
                    values: faces.map_or(&[], |faces| faces.values.as_slice()),
                    lattice: faces.map_or(cells, |faces| faces.lattice(orientation)),
                    factor: sign(axis),
                }
            };
            grids.push(Grid {
                name: "velocity_faces",
                class: "staggered",
                components: (0..3).map(component).collect(),
                metadata: unit(),
            });
        }
        grids
    }

    /// Refuses what has no place in 16 bits.
    fn check(&self, source: &Source, frame: &Frame) -> Result<(), Failure> {
        if !self.manner.half {
            return Ok(());
        }
        let factor = self.manner.time.factor;
        let fields = frame
            .velocity
            .iter()
            .chain(frame.faces.iter().map(|faces| &faces.values));
        let fields = fields.map(|values| ("velocity", values, factor));
        for (name, values, factor) in [("density", &frame.density, 1.0)].into_iter().chain(fields) {
            let beyond = values.iter().find(|value| (*value * factor).abs() > LARGEST_HALF);
            if let Some(value) = beyond {
                return Err(source.refuse(&format!(
                    "has a {name} of {:.3e} in step {}, and half precision ends at {LARGEST_HALF}; write --precision float",
                    value * factor,
                    frame.step
                )));
            }
        }
        Ok(())
    }
}

/// The file of the stage.
fn stage() -> PathBuf {
    format!("{SMOKE}.usda").into()
}
