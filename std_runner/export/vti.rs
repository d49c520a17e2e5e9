//! Files of VTK's image data, which ParaView opens, and the list of them by time.

use super::sink::{Manner, SMOKE, Sink};
use super::source::{Frame, Source};
use crate::output::{OutputError, create_folder, write_bytes, write_whole};
use core::ops::RangeInclusive;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The folder of the files.
const FOLDER: &str = "vti";

/// A file for each step.
pub(super) struct Images<'a>(pub &'a Manner);

impl Sink for Images<'_> {
    fn parts(&self) -> Vec<PathBuf> {
        vec![FOLDER.into(), format!("{SMOKE}.pvd").into()]
    }

    fn step(&mut self, folder: &Path, source: &mut Source, frame: &Frame) -> Result<(), OutputError> {
        create_folder(&folder.join(FOLDER))?;
        let path = folder.join(self.file(frame.step));
        write_whole(&path, |file| {
            write(file, source, frame).map_err(OutputError::of(&path))
        })
    }

    fn finish(
        &mut self,
        folder: &Path,
        source: &mut Source,
        steps: RangeInclusive<usize>,
    ) -> Result<(), OutputError> {
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n  <Collection>\n",
        );
        for step in steps {
            let time = step as f64 * source.said.dt;
            text += &format!(
                "    <DataSet timestep=\"{time}\" group=\"\" part=\"0\" file=\"{}\"/>\n",
                self.file(step)
            );
        }
        text += "  </Collection>\n</VTKFile>\n";
        write_bytes(&folder.join(format!("{SMOKE}.pvd")), text.as_bytes())
    }
}

impl Images<'_> {
    fn file(&self, step: usize) -> String {
        format!("{FOLDER}/{}", self.0.numbered(step, "vti"))
    }
}

/// Writes one file: its head names where each array begins in what follows, as it is in memory.
fn write(sink: &mut impl Write, source: &Source, frame: &Frame) -> io::Result<()> {
    let double = source.said.double;
    let (kind, size) = if double { ("Float64", 8) } else { ("Float32", 4) };
    let [nx, ny, nz] = source.cells();
    let deep = if source.said.cells.len() == 3 { nz } else { 0 };
    let extent = format!("0 {nx} 0 {ny} 0 {deep}");
    let side = source.said.side();
    let cells = (nx * ny * nz) as u64;
    // Before each array stands its number of bytes.
    let density = 8 + 8;
    let velocity = density + 8 + cells * size;
    let mut arrays = format!(
        "        <DataArray type=\"{kind}\" Name=\"density\" format=\"appended\" offset=\"{density}\"/>\n"
    );
    let mut active = String::from("Scalars=\"density\"");
    if source.has_flow() {
        active += " Vectors=\"velocity\"";
        arrays += &format!(
            "        <DataArray type=\"{kind}\" Name=\"velocity\" NumberOfComponents=\"3\" format=\"appended\" offset=\"{velocity}\"/>\n"
        );
    }
    write!(
        sink,
        "<?xml version=\"1.0\"?>
<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">
  <ImageData WholeExtent=\"{extent}\" Origin=\"0 0 0\" Spacing=\"{side} {side} {side}\">
    <FieldData>
      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"appended\" offset=\"0\"/>
    </FieldData>
    <Piece Extent=\"{extent}\">
      <CellData {active}>
{arrays}      </CellData>
    </Piece>
  </ImageData>
  <AppendedData encoding=\"raw\">
   _"
    )?;
    sink.write_all(&8_u64.to_le_bytes())?;
    sink.write_all(&(frame.step as f64 * source.said.dt).to_le_bytes())?;
    let put = |sink: &mut dyn Write, value: f64| {
        if double {
            sink.write_all(&value.to_le_bytes())
        } else {
            sink.write_all(&(value as f32).to_le_bytes())
        }
    };
    sink.write_all(&(cells * size).to_le_bytes())?;
    frame.density.iter().try_for_each(|&value| put(sink, value))?;
    if source.has_flow() {
        sink.write_all(&(3 * cells * size).to_le_bytes())?;
        for cell in 0..frame.density.len() {
            for axis in 0..3 {
                let value = frame.velocity.get(axis).and_then(|values| values.get(cell));
                put(sink, value.copied().unwrap_or(0.0))?;
            }
        }
    }
    sink.write_all(b"\n  </AppendedData>\n</VTKFile>\n")
}
