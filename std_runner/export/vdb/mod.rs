//! OpenVDB files, written by ourselves: version 224 of the format, which OpenVDB 6 and later read.
//!
//! Values are packed a leaf at a time, so that a grid takes the memory of its leaves' masks, an eighth of a bit for each bit of a value.

mod codec;
mod tree;

pub use codec::Codec;
pub(super) use tree::Component;

use std::io::{self, Seek, SeekFrom, Write};
use tree::{Values, write_mask};

/// The first bytes of a file, the version of the format, and that of the library which has it.
const MAGIC: i64 = 0x5644_4220;
const FORMAT: u32 = 224;
const LIBRARY: [u32; 2] = [10, 0];
/// Files are told apart by their content: equal input gives equal bytes.
const UUID: &[u8; 36] = b"00000000-0000-0000-0000-000000000000";

/// An entry of metadata.
pub(super) enum Meta<'a> {
    Text(&'a str),
    Float(f32),
    Whole(i64),
    Flag(bool),
    Place([i32; 3]),
}

impl Meta<'_> {
    /// Its type's name and its bytes.
    fn parts(&self) -> (&'static str, Vec<u8>) {
        match self {
            Self::Text(text) => ("string", text.as_bytes().to_vec()),
            Self::Float(number) => ("float", number.to_le_bytes().to_vec()),
            Self::Whole(number) => ("int64", number.to_le_bytes().to_vec()),
            Self::Flag(flag) => ("bool", vec![u8::from(*flag)]),
            Self::Place(place) => ("vec3i", place.iter().flat_map(|x| x.to_le_bytes()).collect()),
        }
    }
}

/// Entries of metadata by their names.
pub(super) type Metadata<'a> = Vec<(&'a str, Meta<'a>)>;

/// A grid of numbers, or of vectors.
pub(super) struct Grid<'a> {
    pub name: &'a str,
    /// "fog volume", "staggered", or "unknown", as OpenVDB says for others.
    pub class: &'a str,
    /// One component, or three.
    pub components: Vec<Component<'a>>,
    /// Entries of its metadata beside those that say how it is written.
    pub metadata: Metadata<'a>,
}

/// How grids are written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Manner {
    pub half: bool,
    pub codec: Codec,
    /// The side of a cell, and the low corner of the box.
    pub side: f64,
    pub corner: [f64; 3],
}

/// Writes a file of `grids`.
pub(super) fn write(
    sink: &mut (impl Write + Seek),
    metadata: &Metadata<'_>,
    grids: &[Grid<'_>],
    manner: Manner,
) -> io::Result<()> {
    sink.write_all(&MAGIC.to_le_bytes())?;
    for word in [FORMAT].iter().chain(&LIBRARY) {
        sink.write_all(&word.to_le_bytes())?;
    }
    // There are offsets of grids.
    sink.write_all(&[1])?;
    sink.write_all(UUID)?;
    put_metadata(sink, metadata)?;
    sink.write_all(&(grids.len() as u32).to_le_bytes())?;
    grids.iter().try_for_each(|grid| put_grid(sink, grid, manner))
}

fn put_grid(sink: &mut (impl Write + Seek), grid: &Grid<'_>, manner: Manner) -> io::Result<()> {
    let values = Values {
        components: &grid.components,
        half: manner.half,
    };
    let tree = values.tree();
    put_text(sink, grid.name.as_bytes())?;
    let kind = if grid.components.len() == 1 {
        "float"
    } else {
        "vec3s"
    };
    let half = if manner.half { "_HalfFloat" } else { "" };
    put_text(sink, format!("Tree_{kind}_5_4_3{half}").as_bytes())?;
    put_text(sink, b"")?;
    let places = sink.stream_position()?;
    sink.write_all(&[0; 24])?;
    let begin = sink.stream_position()?;
    sink.write_all(&manner.codec.word().to_le_bytes())?;
    let [low, high] = tree.bounds.unwrap_or([[i32::MAX; 3], [i32::MIN; 3]]);
    let mut all: Metadata<'_> = vec![
        ("class", Meta::Text(grid.class)),
        ("file_bbox_max", Meta::Place(high)),
        ("file_bbox_min", Meta::Place(low)),
        ("file_compression", Meta::Text(manner.codec.name())),
        ("file_voxel_count", Meta::Whole(tree.active as i64)),
        ("is_saved_as_half_float", Meta::Flag(manner.half)),
        ("name", Meta::Text(grid.name)),
    ];
    if kind == "vec3s" {
        all.push(("vector_type", Meta::Text("contravariant relative")));
    }
    put_metadata_of(sink, all.iter().chain(&grid.metadata))?;
    put_transform(sink, manner)?;
    let mut nothing = Vec::new();
    manner
        .codec
        .write(&mut nothing, &[], values.bytes(), manner.half)?;
    tree.write(sink, grid.components.len(), &nothing)?;
    let blocks = sink.stream_position()?;
    values.leaves(&tree, |mask, bytes| {
        write_mask(sink, mask)?;
        sink.write_all(&[0])?;
        manner.codec.write(sink, bytes, values.bytes(), manner.half)
    })?;
    let end = sink.stream_position()?;
    sink.seek(SeekFrom::Start(places))?;
    for place in [begin, blocks, end] {
        sink.write_all(&place.to_le_bytes())?;
    }
    sink.seek(SeekFrom::Start(end)).map(drop)
}

/// From places to lengths: values stand in the middle of cells.
fn put_transform(sink: &mut impl Write, manner: Manner) -> io::Result<()> {
    put_text(sink, b"UniformScaleTranslateMap")?;
    let side = manner.side;
    let middle = manner.corner.map(|corner| corner + 0.5 * side);
    let alike = [side, side, 1.0 / side, 1.0 / (side * side), 0.5 / side].map(|number| [number; 3]);
    for number in middle.iter().chain(alike.as_flattened()) {
        sink.write_all(&number.to_le_bytes())?;
    }
    Ok(())
}

fn put_metadata(sink: &mut impl Write, metadata: &Metadata<'_>) -> io::Result<()> {
    put_metadata_of(sink, metadata.iter())
}

fn put_metadata_of<'a>(
    sink: &mut impl Write,
    metadata: impl Iterator<Item = &'a (&'a str, Meta<'a>)> + Clone,
) -> io::Result<()> {
    sink.write_all(&(metadata.clone().count() as u32).to_le_bytes())?;
    for (name, meta) in metadata {
        let (kind, bytes) = meta.parts();
        put_text(sink, name.as_bytes())?;
        put_text(sink, kind.as_bytes())?;
        put_text(sink, &bytes)?;
    }
    Ok(())
}

/// Writes bytes after their number.
fn put_text(sink: &mut impl Write, text: &[u8]) -> io::Result<()> {
    sink.write_all(&(text.len() as u32).to_le_bytes())?;
    sink.write_all(text)
}
