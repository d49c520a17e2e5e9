// What all kernels share: the numbers of a dispatch, and who is beside whom.
//
// A buffer holds fields of cells one after the other, `apart` numbers each, of which the first `cells` count, x fastest. A step of faces is
// a field for each axis. Face i of an axis is the low side of cell i; on a wall it is 0. Before this file stands `const DIMS`, the axes: a driver
// compiles loops over a constant number of them to straight code.

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
    // Bits 0, 1, 2: which axes are rings. Bit 3: whether there are solid cells or open sides. Bits 8 and on: what the kernel is to do.
    flags: u32,
    axis: u32,
    first: u32,
    second: u32,
    third: u32,
}

var<immediate> u: Numbers;

const GROUP: u32 = 256u;
// A cell is solid or outside; it is outside (core/grid/solids.rs).
const SOLID: u32 = 1u;
const OUTSIDE: u32 = 128u;

// The bits of a cell in the table of solid cells (core/grid/solids.rs); `solids` holds them as numbers, and is declared by each file.
fn solid_bits(cell: u32) -> u32 {
    if ((u.flags >> 3u) & 1u) == 0u {
        return 0u;
    }
    return u32(solids[cell]);
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

// The number of this group among all of a dispatch.
fn group_number(group: vec3<u32>, groups: vec3<u32>) -> u32 {
    return group.y * groups.x + group.x;
}

// The number of this invocation among all of a dispatch.
fn number(group: vec3<u32>, groups: vec3<u32>, local: u32) -> u32 {
    return group_number(group, groups) * GROUP + local;
}

// A cell, and where it is. Where it is, is divided out once: a card has no fast division of whole numbers.
struct Site {
    cell: u32,
    place: vec3<u32>,
}

fn site(cell: u32) -> Site {
    let row = cell / u.n.x;
    let x = cell - row * u.n.x;
    if DIMS == 2u {
        return Site(cell, vec3<u32>(x, row, 0u));
    }
    let z = row / u.n.y;
    return Site(cell, vec3<u32>(x, row - z * u.n.y, z));
}

fn at(here: Site, axis: u32) -> u32 {
    return select(select(here.place.z, here.place.y, axis == 1u), here.place.x, axis == 0u);
}

// Whether the low face of a cell along an axis is on a wall.
fn on_wall(here: Site, axis: u32) -> bool {
    return !is_ring(axis) && at(here, axis) == 0u;
}

// Whether a solid cell closes the low face of a cell along an axis, or it is on a wall: nothing flows there.
fn is_closed(here: Site, axis: u32) -> bool {
    return on_wall(here, axis) || (solid_bits(here.cell) & (2u << axis)) != 0u;
}

// Whether the low face of a cell along an axis is an exit, which leads out of an open side; which side of it is outside: 1 where it is that
// of the cell, -1 where it is the one below.
fn is_exit(cell: u32, axis: u32) -> bool {
    return (solid_bits(cell) & (256u << axis)) != 0u;
}

fn outwards(cell: u32) -> f32 {
    return select(-1.0, 1.0, (solid_bits(cell) & OUTSIDE) != 0u);
}

// Whether there is a cell above along an axis.
fn has_above(here: Site, axis: u32) -> bool {
    return is_ring(axis) || at(here, axis) + 1u < along(axis);
}

// Where an offset along an axis leads, of no more cells than there are: round a ring, and behind a wall to the last cell before it.
fn led(here: Site, axis: u32, offset: i32) -> i32 {
    let n = i32(along(axis));
    let there = i32(at(here, axis)) + offset;
    if is_ring(axis) {
        return there + select(0, n, there < 0) - select(0, n, there >= n);
    }
    return clamp(there, 0, n - 1);
}

// The cell at an offset along an axis.
fn beside(here: Site, axis: u32, offset: i32) -> u32 {
    return u32(i32(here.cell) + (led(here, axis, offset) - i32(at(here, axis))) * i32(stride(axis)));
}

// The same, with where it is.
fn moved(here: Site, axis: u32, offset: i32) -> Site {
    let there = u32(led(here, axis, offset));
    let is_axis = vec3<bool>(axis == 0u, axis == 1u, axis == 2u);
    return Site(beside(here, axis, offset), select(here.place, vec3<u32>(there), is_axis));
}

// Whether the face at an offset along an axis is neither on a wall nor behind it.
fn flows(here: Site, axis: u32, offset: i32) -> bool {
    let there = i32(at(here, axis)) + offset;
    return is_ring(axis) || (there > 0 && there < i32(along(axis)));
}

var<workgroup> of_group: array<f32, 256>;

// The largest of what the invocations of a group have. All of them ask.
fn largest_in_group(own: f32, local: u32) -> f32 {
    of_group[local] = own;
    workgroupBarrier();
    for (var half = GROUP / 2u; half > 0u; half /= 2u) {
        if local < half {
            of_group[local] = max(of_group[local], of_group[local + half]);
        }
        workgroupBarrier();
    }
    return of_group[0];
}

// Their sum, in a fixed order.
fn sum_in_group(own: f32, local: u32) -> f32 {
    of_group[local] = own;
    workgroupBarrier();
    for (var half = GROUP / 2u; half > 0u; half /= 2u) {
        if local < half {
            of_group[local] = of_group[local] + of_group[local + half];
        }
        workgroupBarrier();
    }
    return of_group[0];
}

// A size that is compared with others: 1e30 where it is none.
fn sized(size: f32) -> f32 {
    return select(1e30, size, size < 1e30);
}
