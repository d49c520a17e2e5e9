//! Vector fields for game engines: a text file of sizes, bounds and vectors.

use super::sink::{Manner, Sink};
use super::source::{Frame, Source};
use crate::output::{OutputError, create_folder, write_whole};
use core::ops::RangeInclusive;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The folder of the files.
const FOLDER: &str = "fga";

/// A file for each step.
pub(super) struct Fields<'a>(pub &'a Manner);

impl Sink for Fields<'_> {
    fn parts(&self) -> Vec<PathBuf> {
        vec![FOLDER.into()]
    }

    fn step(&mut self, folder: &Path, source: &mut Source, frame: &Frame) -> Result<(), OutputError> {
        create_folder(&folder.join(FOLDER))?;
        let path = folder.join(format!("{FOLDER}/{}", self.0.numbered(frame.step, "fga")));
        write_whole(&path, |file| {
            self.write(file, source, frame).map_err(OutputError::of(&path))
        })
    }

    fn finish(&mut self, _: &Path, _: &mut Source, _: RangeInclusive<usize>) -> Result<(), OutputError> {
        Ok(())
    }
}

impl Fields<'_> {
    /// Sizes, the low and the high corner, and a vector a line, x fastest.
    fn write(&self, sink: &mut impl Write, source: &Source, frame: &Frame) -> io::Result<()> {
        let orientation = &self.0.orientation;
        let lattice = orientation.lattice(source.cells());
        let [nx, ny, nz] = lattice.size;
        let low = orientation.corner(source.sides());
        let high: [f64; 3] = core::array::from_fn(|axis| low[axis] + source.sides()[orientation.from[axis]]);
        writeln!(sink, "{nx},{ny},{nz},")?;
        for [x, y, z] in [low, high] {
            writeln!(sink, "{x},{y},{z},")?;
        }
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let place = lattice.place([x, y, z]).unwrap_or(0);
                    for axis in 0..3 {
                        let values = frame.velocity.get(orientation.from[axis]);
                        let value = values.and_then(|values| values.get(place)).copied();
                        let factor = self.0.time.factor * if orientation.turned[axis] { -1.0 } else { 1.0 };
                        write!(sink, "{},", (value.unwrap_or(0.0) * factor) as f32)?;
                    }
                    writeln!(sink)?;
                }
            }
        }
        Ok(())
    }
}
