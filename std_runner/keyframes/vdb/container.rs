//! The file around the trees: which grids there are, how they are kept and where they lie in the world.

use super::bytes::{Bytes, broken, short};
use super::codec::Packing;
use crate::keyframes::error::Fault;

/// The grid that is smoke where nothing is said.
const DENSITY: &str = "density";
/// Types of trees that are read.
const TREE: &str = "Tree_float_5_4_3";

/// A grid of floats, before its tree is read.
pub(super) struct Grid<'a> {
    pub name: String,
    pub packing: Packing,
    /// Whether its values are distances to a surface, negative inside.
    pub level_set: bool,
    /// Side of a voxel along each axis, and where the middle of voxel 0 is.
    pub scale: [f64; 3],
    pub origin: [f64; 3],
    /// What follows the transform, and the values of the leaves.
    pub topology: Bytes<'a>,
    pub buffers: Bytes<'a>,
}

struct Entry {
    name: String,
    kind: String,
    parent: String,
    grid: usize,
    buffers: usize,
}

/// Finds the grid `name` in a file, or its density, or the only grid of floats.
pub(super) fn grid<'a>(file: &'a [u8], name: Option<&str>) -> Result<Grid<'a>, Fault> {
    let entries = entries(file)?;
    let floats: Vec<&Entry> = entries
        .iter()
        .filter(|entry| entry.kind.starts_with(TREE))
        .collect();
    let found = match name {
        Some(name) => entries.iter().find(|entry| entry.name == name),
        None => match (
            floats.iter().find(|entry| entry.name == DENSITY),
            floats.as_slice(),
        ) {
            (Some(density), _) => Some(*density),
            (None, [one]) => Some(*one),
            _ => None,
        },
    };
    let names: Vec<&str> = floats.iter().map(|entry| entry.name.as_str()).collect();
    let Some(entry) = found else {
        let found = name.map_or_else(
            || "holds no single grid of density".to_owned(),
            |name| format!("has no grid `{name}`"),
        );
        let remedy = if names.is_empty() {
            "save a grid of floats".to_owned()
        } else {
            format!("say which by `name`; grids of floats are: {}", names.join(", "))
        };
        return Err(Fault::content(found, remedy));
    };
    if !entry.kind.starts_with(TREE) || !entry.parent.is_empty() {
        let found = format!("holds `{}` as {}", entry.name, entry.kind);
        return Err(Fault::content(
            found,
            "save it as a grid of floats, full or half, of its own",
        ));
    }
    opened(file, entry)
}

/// What stands before the grids.
fn entries(file: &[u8]) -> Result<Vec<Entry>, Fault> {
    let mut bytes = Bytes(file);
    let no_vdb = |_| Fault::content("is no OpenVDB file", "save it as .vdb");
    if bytes.i64().map_err(no_vdb)? != 0x5644_4220 {
        return Err(Fault::content("is no OpenVDB file", "save it as .vdb"));
    }
    let version = bytes.u32()?;
    if !(222..=224).contains(&version) {
        let found = format!("has version {version} of OpenVDB's format");
        return Err(Fault::content(
            found,
            "versions 222 to 224 are read: save it again by a newer program",
        ));
    }
    bytes.take(8)?;
    if bytes.byte()? == 0 {
        return Err(Fault::content(
            "is a stream without places of its grids",
            "save it as a file",
        ));
    }
    bytes.take(36)?;
    metadata(&mut bytes, |_, _| {})?;
    let count = bytes.u32()?;
    let mut entries = Vec::new();
    for _ in 0..count {
        // Each entry says where the next one begins: behind it, or there would be no end of them.
        let (name, kind, parent) = (bytes.text()?, bytes.text()?, bytes.text()?);
        let mut place = || {
            bytes
                .i64()
                .and_then(|place| usize::try_from(place).map_err(|_| short()))
        };
        let (grid, buffers, end) = (place()?, place()?, place()?);
        // Grids of one name are told apart by what follows this character.
        let name = name.split('\u{1e}').next().unwrap_or_default().to_owned();
        entries.push(Entry {
            name,
            kind,
            parent,
            grid,
            buffers,
        });
        let here = file.len() - bytes.0.len();
        if end < here {
            return Err(broken("a grid ends before it begins"));
        }
        bytes = Bytes(file.get(end..).ok_or_else(short)?);
    }
    Ok(entries)
}

/// Reads pairs of name and value.
fn metadata(bytes: &mut Bytes<'_>, mut with: impl FnMut(&str, &[u8])) -> Result<(), Fault> {
    for _ in 0..bytes.u32()? {
        let (name, _) = (bytes.text()?, bytes.text()?);
        let size = bytes.u32()? as usize;
        with(&name, bytes.take(size)?);
    }
    Ok(())
}

fn opened<'a>(file: &'a [u8], entry: &Entry) -> Result<Grid<'a>, Fault> {
    let mut bytes = Bytes(file.get(entry.grid..).ok_or_else(short)?);
    let compression = bytes.u32()?;
    let (mut half, mut level_set) = (entry.kind.ends_with("_HalfFloat"), false);
    metadata(&mut bytes, |name, value| match name {
        "is_saved_as_half_float" => half = value.first().is_some_and(|&byte| byte != 0),
        "class" => level_set = value == b"level set",
        _ => {}
    })?;
    let (scale, origin) = transform(&mut bytes)?;
    if !scale
        .iter()
        .chain(&origin)
        .all(|x| x.is_finite() && x.abs() < 1e12)
        || !scale.iter().all(|&x| x > 1e-12)
    {
        return Err(broken("its voxels have no size"));
    }
    Ok(Grid {
        name: entry.name.clone(),
        packing: Packing {
            compression,
            half,
            background: 0.0,
        },
        level_set,
        scale,
        origin,
        topology: bytes,
        buffers: Bytes(file.get(entry.buffers..).ok_or_else(short)?),
    })
}

/// Side of a voxel along each axis, and the middle of voxel 0.
fn transform(bytes: &mut Bytes<'_>) -> Result<([f64; 3], [f64; 3]), Fault> {
    let kind = bytes.text()?;
    let mut vector = || -> Result<[f64; 3], Fault> { Ok([bytes.f64()?, bytes.f64()?, bytes.f64()?]) };
    match kind.as_str() {
        "UniformScaleMap" | "ScaleMap" => {
            let scale = vector()?;
            (0..4).try_for_each(|_| vector().map(drop))?;
            Ok((scale, [0.0; 3]))
        }
        "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
            let (origin, scale) = (vector()?, vector()?);
            (0..4).try_for_each(|_| vector().map(drop))?;
            Ok((scale, origin))
        }
        "TranslationMap" => Ok(([1.0; 3], vector()?)),
        "AffineMap" | "UnitaryMap" => {
            let mut all = [0.0; 16];
            for number in &mut all {
                *number = bytes.f64()?;
            }
            let [x, a, b, _, c, y, d, _, e, f, z, _, p, q, r, _] = all;
            if [a, b, c, d, e, f].iter().any(|part| part.abs() > 1e-9 * x.abs()) {
                return Err(Fault::content(
                    "is turned or sheared in space",
                    "resample it to straight voxels before saving",
                ));
            }
            Ok(([x, y, z], [p, q, r]))
        }
        other => Err(Fault::content(
            format!("has voxels of a {other}"),
            "resample it to straight voxels before saving",
        )),
    }
}
