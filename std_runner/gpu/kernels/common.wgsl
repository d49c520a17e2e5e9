// What all kernels share: the numbers of a dispatch, and who is beside whom.
//
// A buffer holds fields of cells one after the other, `apart` numbers each, of which the first `cells` count, x fastest. A step of faces is
// a field for each axis. Face i of an axis is the low side of cell i; on a wall it is 0.

struct Numbers {
    // Cells along x, y, z; numbers between fields.
    n: vec3<u32>,
    apart: u32,
    // 1 / h along each axis, and a factor.
    inverse: vec3<f32>,
    a: f32,
    b: f32,
    c: f32,
    // Numbers in all, or fields where a kernel says so.
    count: u32,
    // Bits 0, 1, 2: which axes are rings. Bits 4, 5: the axes. Bits 8 and on: what the kernel is to do.
    flags: u32,
    axis: u32,
    first: u32,
    second: u32,
    third: u32,
}

var<immediate> u: Numbers;

const GROUP: u32 = 256u;

fn dims() -> u32 {
    return (u.flags >> 4u) & 3u;
}

fn flag(bit: u32) -> bool {
    return ((u.flags >> (8u + bit)) & 1u) != 0u;
}

fn is_ring(axis: u32) -> bool {
    return ((u.flags >> axis) & 1u) != 0u;
}

fn along(axis: u32) -> u32 {
    return select(select(u.n.z, u.n.y, axis == 1u), u.n.x, axis == 0u);
}

fn inverse_of(axis: u32) -> f32 {
    return select(select(u.inverse.z, u.inverse.y, axis == 1u), u.inverse.x, axis == 0u);
}

// Numbers between cells that are neighbours along an axis.
fn stride(axis: u32) -> u32 {
    return select(select(u.n.x * u.n.y, u.n.x, axis == 1u), 1u, axis == 0u);
}

fn cells() -> u32 {
    return u.n.x * u.n.y * u.n.z;
}

fn at(cell: u32, axis: u32) -> u32 {
    return (cell / stride(axis)) % along(axis);
}

// The number of this invocation among all of a dispatch.
fn number(group: vec3<u32>, groups: vec3<u32>, local: u32) -> u32 {
    return (group.y * groups.x + group.x) * GROUP + local;
}

// Whether the low face of a cell along an axis is on a wall.
fn on_wall(cell: u32, axis: u32) -> bool {
    return !is_ring(axis) && at(cell, axis) == 0u;
}

// Whether there is a cell above along an axis.
fn has_above(cell: u32, axis: u32) -> bool {
    return is_ring(axis) || at(cell, axis) + 1u < along(axis);
}

// The cell at an offset along an axis; behind a wall the last one before it.
fn beside(cell: u32, axis: u32, offset: i32) -> u32 {
    let n = i32(along(axis));
    let here = i32(at(cell, axis));
    var there = here + offset;
    if is_ring(axis) {
        there = ((there % n) + n) % n;
    } else {
        there = clamp(there, 0, n - 1);
    }
    return u32(i32(cell) + (there - here) * i32(stride(axis)));
}

// Whether the face at an offset along an axis is neither on a wall nor behind it.
fn flows(cell: u32, axis: u32, offset: i32) -> bool {
    let there = i32(at(cell, axis)) + offset;
    return is_ring(axis) || (there > 0 && there < i32(along(axis)));
}
