//! Colours of which no two vertices that are joined have the same.

use super::ordering::{Marks, Neighbours};

/// No number, and no colour.
const NONE: u32 = u32::MAX;

/// Gives each free vertex the parity of its place on a regular mesh, on others the first colour, in the order of the vertices, that no
/// neighbour has; how many there are.
pub fn colours(neighbours: &Neighbours<'_>, place: &[u32], colour: &mut [u32], marks: &mut [u32]) -> usize {
    let mesh = &neighbours.mesh;
    let mut most = 0;
    colour.fill(NONE);
    let mut marks = Marks::new(marks);
    for vertex in (0..mesh.vertices()).filter(|&vertex| !mesh.held.get(vertex).copied().unwrap_or(true)) {
        let own = if mesh.regular[0] > 0 {
            parity(mesh.regular, vertex, mesh.dims)
        } else {
            greedy(neighbours, place, colour, &mut marks, vertex)
        };
        let number = place.get(vertex).copied().unwrap_or(NONE);
        if let Some(to) = colour.get_mut(number as usize) {
            *to = own;
        }
        most = most.max(own as usize + 1);
    }
    most
}

fn greedy(
    neighbours: &Neighbours<'_>,
    place: &[u32],
    colour: &[u32],
    marks: &mut Marks<'_>,
    vertex: usize,
) -> u32 {
    let mut own = 0;
    loop {
        let mut taken = false;
        marks.renew();
        neighbours.visit(vertex, marks, |other| {
            let number = place.get(other).copied().unwrap_or(NONE);
            taken |= colour.get(number as usize) == Some(&own);
        });
        if !taken {
            return own;
        }
        own += 1;
    }
}

/// The parity of the place along each axis as a digit; on a rod odd ones come first, since the first of all is held.
fn parity(sides: [usize; 3], vertex: usize, dims: usize) -> u32 {
    let (mut rest, mut parity) = (vertex, 0);
    for (axis, side) in sides.into_iter().enumerate().take(dims) {
        parity |= ((rest % side.max(1)) % 2) << axis;
        rest /= side.max(1);
    }
    if dims == 1 {
        1 - parity as u32
    } else {
        parity as u32
    }
}
