//! The tree of a grid: a root, nodes of 32^3 and of 16^3 places, leaves of 8^3 voxels, and tiles, places that are one value all over.

use super::bytes::{Bytes, broken};
use super::codec::{Mask, Packing, values};
use super::container::Grid;
use crate::keyframes::error::Fault;
use std::collections::BTreeSet;

/// The lowest voxel of something.
pub(super) type Corner = [i64; 3];

/// What the tree is made of, in the order of the file.
pub(super) enum Part<'a> {
    /// A cube of so many voxels a side with one value, and whether it counts.
    Tile {
        at: Corner,
        side: i64,
        value: f32,
        active: bool,
    },
    /// 8^3 voxels, and which of them count.
    Leaf {
        at: Corner,
        values: Vec<f32>,
        active: Mask<'a>,
    },
}

/// Sides of what a node's place is, and of a node, in powers of two.
const MIDDLE: (u32, u32) = (3, 4);
const UPPER: (u32, u32) = (7, 5);
/// Voxels along a side of a place of the root.
const WHOLE: i64 = 4096;

/// Gives the value outside of everything, then every part to `with`.
pub(super) fn walk<'a>(
    grid: &Grid<'a>,
    mut with: impl FnMut(f32, Part<'a>) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let mut bytes = grid.topology;
    if bytes.u32()? != 1 {
        return Err(broken("it has several buffers"));
    }
    let background = bytes.f32()?;
    let packing = Packing {
        background,
        ..grid.packing
    };
    let (tiles, children) = (bytes.u32()?, bytes.u32()?);
    // No voxel is in two places: what says so again and again would fill the box again and again.
    let mut known = BTreeSet::new();
    let mut corner = |bytes: &mut Bytes<'_>| {
        let at = corner(bytes)?;
        if at.iter().any(|x| x % WHOLE != 0) || !known.insert(at) {
            return Err(broken("its parts overlap"));
        }
        Ok(at)
    };
    for _ in 0..tiles {
        let at = corner(&mut bytes)?;
        let (value, active) = (bytes.f32()?, bytes.byte()? != 0);
        with(
            background,
            Part::Tile {
                at,
                side: WHOLE,
                value,
                active,
            },
        )?;
    }
    let mut leaves = Vec::new();
    for _ in 0..children {
        let at = corner(&mut bytes)?;
        upper(&mut bytes, at, packing, &mut leaves, &mut |part| {
            with(background, part)
        })?;
    }
    let mut buffers = grid.buffers;
    for at in leaves {
        let active = Mask(buffers.take(64)?);
        let values = values(&mut buffers, 512, active, packing)?;
        with(background, Part::Leaf { at, values, active })?;
    }
    Ok(())
}

fn corner(bytes: &mut Bytes<'_>) -> Result<Corner, Fault> {
    Ok([bytes.i32()?.into(), bytes.i32()?.into(), bytes.i32()?.into()])
}

/// The corner of place `index` in a node at `at`.
fn place(at: Corner, index: usize, (side, node): (u32, u32)) -> Corner {
    let part = |shift: u32| ((index >> (shift * node)) & ((1 << node) - 1)) as i64;
    [
        at[0] + (part(2) << side),
        at[1] + (part(1) << side),
        at[2] + (part(0) << side),
    ]
}

type With<'w, 'a> = &'w mut dyn FnMut(Part<'a>) -> Result<(), Fault>;

/// Reads the masks and tiles of a node; the places that have children.
fn node<'a>(
    bytes: &mut Bytes<'a>,
    at: Corner,
    sizes: (u32, u32),
    packing: Packing,
    with: With<'_, 'a>,
) -> Result<Vec<Corner>, Fault> {
    let count = 1_usize << (3 * sizes.1);
    let children = Mask(bytes.take(count / 8)?);
    let active = Mask(bytes.take(count / 8)?);
    let values = values(bytes, count, active, packing)?;
    for (index, value) in values.into_iter().enumerate() {
        // What is inactive and as the background is nothing.
        if !children.is_on(index) && (active.is_on(index) || value != packing.background) {
            let at = place(at, index, sizes);
            with(Part::Tile {
                at,
                side: 1 << sizes.0,
                value,
                active: active.is_on(index),
            })?;
        }
    }
    Ok(children.all().map(|index| place(at, index, sizes)).collect())
}

fn upper<'a>(
    bytes: &mut Bytes<'a>,
    at: Corner,
    packing: Packing,
    leaves: &mut Vec<Corner>,
    with: With<'_, 'a>,
) -> Result<(), Fault> {
    for child in node(bytes, at, UPPER, packing, with)? {
        for leaf in node(bytes, child, MIDDLE, packing, with)? {
            bytes.take(64)?;
            leaves.push(leaf);
        }
    }
    Ok(())
}
