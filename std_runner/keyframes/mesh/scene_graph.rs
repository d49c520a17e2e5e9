//! The nodes of a glTF scene: each puts its mesh and its children somewhere.

use serde::Deserialize;

use super::surface::{Point, Surface};
use crate::keyframes::error::Fault;

/// Points and faces that repeated meshes may make of a file, beyond which it is refused.
const MOST_REPEATED: usize = 1 << 24;

/// A node as the file has it.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Node {
    mesh: Option<usize>,
    children: Vec<usize>,
    matrix: Option<[f64; 16]>,
    translation: Option<Point>,
    rotation: Option<[f64; 4]>,
    scale: Option<Point>,
}

/// Three columns, and where the origin goes.
#[derive(Clone, Copy)]
struct Placing([Point; 4]);

impl Placing {
    const NONE: Self = Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]);

    fn of(node: &Node) -> Self {
        if let Some(m) = node.matrix {
            return Self(core::array::from_fn(|column| {
                core::array::from_fn(|row| m[4 * column + row])
            }));
        }
        let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let scale = node.scale.unwrap_or([1.0; 3]);
        let turned: [Point; 3] = [
            [
                1.0 - 2.0 * (y * y + z * z),
                2.0 * (x * y + z * w),
                2.0 * (x * z - y * w),
            ],
            [
                2.0 * (x * y - z * w),
                1.0 - 2.0 * (x * x + z * z),
                2.0 * (y * z + x * w),
            ],
            [
                2.0 * (x * z + y * w),
                2.0 * (y * z - x * w),
                1.0 - 2.0 * (x * x + y * y),
            ],
        ];
        let [a, b, c] = core::array::from_fn(|axis| turned[axis].map(|part| part * scale[axis]));
        Self([a, b, c, node.translation.unwrap_or_default()])
    }

    fn turn(&self, point: Point) -> Point {
        core::array::from_fn(|row| (0..3).map(|column| self.0[column][row] * point[column]).sum())
    }

    fn apply(&self, point: Point) -> Point {
        let turned = self.turn(point);
        core::array::from_fn(|row| turned[row] + self.0[3][row])
    }

    /// First `inner`, then this one.
    fn after(&self, inner: &Self) -> Self {
        let [a, b, c, origin] = inner.0;
        Self([self.turn(a), self.turn(b), self.turn(c), self.apply(origin)])
    }

    /// Whether it turns bodies inside out, as a mirror does.
    fn mirrors(&self) -> bool {
        let [a, b, c, _] = self.0;
        let cross = [
            b[1] * c[2] - b[2] * c[1],
            b[2] * c[0] - b[0] * c[2],
            b[0] * c[1] - b[1] * c[0],
        ];
        a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2] < 0.0
    }
}

/// All meshes where the nodes below `roots` put them.
pub(super) fn placed(nodes: &[Node], roots: &[usize], meshes: &[Surface]) -> Result<Surface, Fault> {
    let remedy = "export it again as glTF 2.0";
    // Where all nodes are taken for roots, those that are another one's children are none.
    let mut is_child = vec![false; nodes.len()];
    for &child in nodes.iter().flat_map(|node| &node.children) {
        if let Some(slot) = is_child.get_mut(child) {
            *slot = true;
        }
    }
    let roots = roots.iter().filter(|&&root| is_child.get(root) == Some(&false));
    let mut open: Vec<(usize, Placing)> = roots.map(|&root| (root, Placing::NONE)).collect();
    let most = MOST_REPEATED.max(8 * meshes.iter().map(|mesh| mesh.triangles.len()).sum::<usize>());
    let (mut whole, mut visited) = (Surface::default(), 0);
    while let Some((number, outer)) = open.pop() {
        let Some(node) = nodes.get(number) else { continue };
        visited += 1;
        let placing = outer.after(&Placing::of(node));
        if let Some(mesh) = node.mesh.and_then(|mesh| meshes.get(mesh)) {
            add(&mut whole, mesh, &placing);
        }
        if whole.points.len() + whole.triangles.len() > most {
            return Err(Fault::content("repeats its meshes too often", "reduce it"));
        }
        let there = node.children.iter().filter(|&&child| child < nodes.len());
        open.extend(there.map(|&child| (child, placing)));
        // What is open is going to be visited: a node more than there are is one that comes again.
        if visited + open.len() > nodes.len() {
            return Err(Fault::content("has nodes that hold each other", remedy));
        }
    }
    Ok(whole)
}

fn add(whole: &mut Surface, mesh: &Surface, placing: &Placing) {
    let first = whole.points.len() as u32;
    whole
        .points
        .extend(mesh.points.iter().map(|&point| placing.apply(point)));
    let mirrored = placing.mirrors();
    whole.triangles.extend(mesh.triangles.iter().map(|&triangle| {
        let [a, b, c] = triangle.map(|corner| corner.saturating_add(first));
        if mirrored { [a, c, b] } else { [a, b, c] }
    }));
}
