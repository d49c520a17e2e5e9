//! The tree of a grid: leaves of 8 cubed values, in nodes of 16 cubed leaves, in nodes of 32 cubed of those.

use super::super::orient::Lattice;
use half::f16;
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Cells along a side of a leaf, and of the nodes above.
const LEAF: usize = 8;
const INNER: usize = 128;
const OUTER: usize = 4096;

/// One component of a grid's values.
pub(in super::super) struct Component<'a> {
    pub values: &'a [f64],
    pub lattice: Lattice,
    pub factor: f64,
}

impl Component<'_> {
    /// The value at a place; beyond the field there is nothing.
    pub fn at(&self, at: [usize; 3]) -> f32 {
        let value = self.lattice.place(at).and_then(|place| self.values.get(place));
        value.map_or(0.0, |value| (value * self.factor) as f32)
    }
}

/// The bits of the active values of a leaf.
type Mask = [u64; 8];

/// Leaves or nodes by their low corners, in the order in which they are written.
type ByCorner<T> = BTreeMap<[usize; 3], T>;

/// The active values of a leaf: which, and their bytes.
struct Leaf {
    mask: Mask,
    bytes: Vec<u8>,
}

/// The leaves with anything in them, by the corners of the nodes that hold them.
#[derive(Default)]
pub(super) struct Tree {
    nodes: ByCorner<ByCorner<ByCorner<Mask>>>,
    /// Active values.
    pub active: u64,
    /// The first and the last place with one.
    pub bounds: Option<[[i32; 3]; 2]>,
}

/// The values of a grid, one component or three.
pub(super) struct Values<'a> {
    pub components: &'a [Component<'a>],
    pub half: bool,
}

impl Values<'_> {
    /// Places along each axis.
    fn size(&self) -> [usize; 3] {
        let most = |axis: usize| self.components.iter().map(|one| one.lattice.size[axis]).max();
        core::array::from_fn(|axis| most(axis).unwrap_or(0))
    }

    /// Bytes of one value.
    pub fn bytes(&self) -> usize {
        self.components.len() * if self.half { 2 } else { 4 }
    }

    /// Whether a value is written as 0, and so is not active.
    fn is_nothing(&self, value: f32) -> bool {
        if self.half {
            f16::from_f32(value) == f16::ZERO
        } else {
            value == 0.0
        }
    }

    /// The leaf at `corner`.
    fn leaf(&self, corner: [usize; 3]) -> Leaf {
        let mut leaf = Leaf {
            mask: [0; 8],
            bytes: Vec::new(),
        };
        for offset in 0..LEAF * LEAF * LEAF {
            let at = [
                corner[0] + offset / (LEAF * LEAF),
                corner[1] + offset / LEAF % LEAF,
                corner[2] + offset % LEAF,
            ];
            let mut value = [0.0; 3];
            for (value, component) in value.iter_mut().zip(self.components) {
                *value = component.at(at);
            }
            let value = value.get(..self.components.len()).unwrap_or(&[]);
            if value.iter().all(|&value| self.is_nothing(value)) {
                continue;
            }
            leaf.mask[offset / 64] |= 1 << (offset % 64);
            for &number in value {
                if self.half {
                    leaf.bytes.extend(f16::from_f32(number).to_le_bytes());
                } else {
                    leaf.bytes.extend(number.to_le_bytes());
                }
            }
        }
        leaf
    }

    /// Finds the leaves that are not empty.
    pub fn tree(&self) -> Tree {
        let mut tree = Tree::default();
        let size = self.size();
        let along = |axis: usize| (0..size[axis]).step_by(LEAF);
        for x in along(0) {
            for y in along(1) {
                for z in along(2) {
                    let corner = [x, y, z];
                    let mask = self.leaf(corner).mask;
                    if mask != [0; 8] {
                        tree.add(corner, mask);
                    }
                }
            }
        }
        tree
    }

    /// Hands every leaf's mask and values to `write`, in the tree's order.
    pub fn leaves(
        &self,
        tree: &Tree,
        mut write: impl FnMut(&Mask, &[u8]) -> io::Result<()>,
    ) -> io::Result<()> {
        let inner = tree.nodes.values().flat_map(BTreeMap::values);
        for (&corner, mask) in inner.flatten() {
            write(mask, &self.leaf(corner).bytes)?;
        }
        Ok(())
    }
}

impl Tree {
    fn add(&mut self, corner: [usize; 3], mask: Mask) {
        let node = |side: usize| corner.map(|place| place / side * side);
        let outer = self.nodes.entry(node(OUTER)).or_default();
        outer.entry(node(INNER)).or_default().insert(corner, mask);
        for offset in (0..LEAF * LEAF * LEAF).filter(|offset| (mask[offset / 64] >> (offset % 64)) & 1 == 1) {
            self.active += 1;
            let within = [offset / (LEAF * LEAF), offset / LEAF % LEAF, offset % LEAF];
            let at: [i32; 3] = core::array::from_fn(|axis| (corner[axis] + within[axis]) as i32);
            let [low, high] = self.bounds.get_or_insert([at, at]);
            for axis in 0..3 {
                low[axis] = low[axis].min(at[axis]);
                high[axis] = high[axis].max(at[axis]);
            }
        }
    }

    /// Writes what OpenVDB calls the topology. `nothing` is a block without values, as the inner nodes have it: where no inner value is
    /// active all that follows the masks is that.
    pub fn write(&self, sink: &mut impl Write, components: usize, nothing: &[u8]) -> io::Result<()> {
        sink.write_all(&1_u32.to_le_bytes())?;
        sink.write_all(&[0; 12][..4 * components])?;
        sink.write_all(&0_u32.to_le_bytes())?;
        sink.write_all(&(self.nodes.len() as u32).to_le_bytes())?;
        for (origin, outer) in &self.nodes {
            for &place in origin {
                sink.write_all(&(place as i32).to_le_bytes())?;
            }
            masks(sink, outer.keys(), INNER, OUTER)?;
            sink.write_all(&[0])?;
            sink.write_all(nothing)?;
            for inner in outer.values() {
                masks(sink, inner.keys(), LEAF, INNER)?;
                sink.write_all(&[0])?;
                sink.write_all(nothing)?;
                for mask in inner.values() {
                    write_mask(sink, mask)?;
                }
            }
        }
        Ok(())
    }
}

/// Writes which children a node of side `side` has, whose own sides are `child`, and that it has no active values.
fn masks<'a>(
    sink: &mut impl Write,
    children: impl Iterator<Item = &'a [usize; 3]>,
    child: usize,
    side: usize,
) -> io::Result<()> {
    let along = side / child;
    let mut mask = vec![0_u8; along * along * along / 8];
    for corner in children {
        let [x, y, z] = corner.map(|place| place % side / child);
        let bit = (x * along + y) * along + z;
        if let Some(byte) = mask.get_mut(bit / 8) {
            *byte |= 1 << (bit % 8);
        }
    }
    sink.write_all(&mask)?;
    mask.fill(0);
    sink.write_all(&mask)
}

/// Writes the mask of a leaf.
pub(super) fn write_mask(sink: &mut impl Write, mask: &Mask) -> io::Result<()> {
    mask.iter()
        .try_for_each(|word| sink.write_all(&word.to_le_bytes()))
}
