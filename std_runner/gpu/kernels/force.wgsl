// The force of a flow, its adjoint (core/force), and the price of curls (core/force/price), gathered at each face from its plaquettes;
// buoyancy (core/force/lift.rs), masks (core/force/mask.rs) and the push of emitters (core/objective/script/jets.rs).
//
// For a face along axis a and each other axis b there are two plaquettes: that of the face's own cell, whose A+ the face is, and the next one
// along b, whose A- it is (core/operators/plaquette.rs).

@group(0) @binding(0) var<storage, read_write> to: array<f32>;
@group(0) @binding(1) var<storage, read_write> v: array<f32>;
@group(0) @binding(2) var<storage, read_write> w: array<f32>;
@group(0) @binding(3) var<storage, read_write> other: array<f32>;
@group(0) @binding(4) var<storage, read_write> solids: array<f32>;

// The faces A-, A+, B-, B+ of the plaquette of a cell.
fn corners(a: u32, b: u32, here: Site) -> vec4<u32> {
    return vec4<u32>(a * u.apart + beside(here, b, -1), a * u.apart + here.cell, b * u.apart + beside(here, a, -1), b * u.apart + here.cell);
}

// Whether the plaquette of a cell does nothing: on a wall, or where a solid cell closes one of its faces. Pairs are xy, yz and zx.
fn is_dead(a: u32, b: u32, here: Site) -> bool {
    let pair = select(select(0u, 2u, a + b == 2u), 1u, a + b == 3u);
    return on_wall(here, a) || on_wall(here, b) || (solid_bits(here.cell) & (16u << pair)) != 0u;
}

fn omega(q: vec4<f32>, a: u32, b: u32) -> f32 {
    return (q.w - q.z) * inverse_of(a) - (q.y - q.x) * inverse_of(b);
}

fn of_v(at: vec4<u32>, begin: u32) -> vec4<f32> {
    return vec4<f32>(v[begin + at.x], v[begin + at.y], v[begin + at.z], v[begin + at.w]);
}

fn of_w(at: vec4<u32>) -> vec4<f32> {
    return vec4<f32>(w[at.x], w[at.y], w[at.z], w[at.w]);
}

// What the plaquette of a cell does to its face A+ (sign -1) or A- (sign 1): Adv(v) + nu C^T C v. `a` is nu.
fn advection(a: u32, b: u32, here: Site, sign: f32) -> f32 {
    if is_dead(a, b, here) {
        return 0.0;
    }
    let q = of_v(corners(a, b, here), 0u);
    let curl = omega(q, a, b);
    return -(curl * 0.5 * (q.z + q.w) * 0.5) + sign * u.a * curl * inverse_of(b);
}

// What an exit gets: with the outward speed o it is max(o, 0) times this second field, which is v / 2 for the force and w for its adjoint
// (core/operators/exits.rs).
fn leaving(axis: u32, cell: u32, second: f32) -> f32 {
    if !is_exit(cell, axis) {
        return 0.0;
    }
    let out = outwards(cell) * v[axis * u.apart + cell];
    return inverse_of(axis) * max(out, 0.0) * second;
}

// to = v - w + Adv(v) + nu C^T C v at a step, w being the flow before.
@compute @workgroup_size(256)
fn force(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    let a = element / u.apart;
    let cell = element % u.apart;
    if a >= DIMS || cell >= cells() {
        return;
    }
    let here = site(cell);
    var sum = v[element] - w[element];
    for (var b = 0u; b < DIMS; b++) {
        if b == a {
            continue;
        }
        sum += advection(a, b, here, -1.0);
        if has_above(here, b) {
            sum += advection(a, b, moved(here, b, 1), 1.0);
        }
    }
    sum += leaving(a, cell, 0.5 * v[element]);
    to[element] = sum;
}

fn transposed(a: u32, b: u32, here: Site, sign: f32) -> f32 {
    if is_dead(a, b, here) {
        return 0.0;
    }
    let at = corners(a, b, here);
    let q = of_v(at, 0u);
    let m = of_w(at);
    let curl = omega(q, a, b);
    let ma = -0.5 * (m.x + m.y);
    let mb = 0.5 * (m.z + m.w);
    let g = ma * 0.5 * (q.z + q.w) + mb * 0.5 * (q.x + q.y) + u.a * omega(m, a, b);
    return mb * curl * 0.5 + sign * g * inverse_of(b);
}

// to = w - other + (J(v)^T + nu C^T C) w at a step, other being w of the step after; flag 0: there is none.
@compute @workgroup_size(256)
fn force_back(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    let a = element / u.apart;
    let cell = element % u.apart;
    if a >= DIMS || cell >= cells() {
        return;
    }
    let here = site(cell);
    var sum = w[element];
    if !flag(0u) {
        sum -= other[element];
    }
    for (var b = 0u; b < DIMS; b++) {
        if b == a {
            continue;
        }
        sum += transposed(a, b, here, -1.0);
        if has_above(here, b) {
            sum += transposed(a, b, moved(here, b, 1), 1.0);
        }
    }
    sum += leaving(a, cell, w[element]);
    to[element] = sum;
}

fn drag(a: u32, b: u32, here: Site, sign: f32, begin: u32) -> f32 {
    if is_dead(a, b, here) {
        return 0.0;
    }
    return sign * u.b * omega(of_v(corners(a, b, here), begin), a, b) * inverse_of(b);
}

// to = a v + b C^T C v + c w, at `count` steps.
@compute @workgroup_size(256)
fn price(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    let step = element / (u.apart * DIMS);
    let begin = step * u.apart * DIMS;
    let a = (element - begin) / u.apart;
    let cell = element % u.apart;
    if step >= u.count || cell >= cells() {
        return;
    }
    let here = site(cell);
    var sum = u.a * v[element];
    for (var b = 0u; b < DIMS; b++) {
        if b == a {
            continue;
        }
        sum += drag(a, b, here, -1.0, begin);
        if has_above(here, b) {
            sum += drag(a, b, moved(here, b, 1), 1.0, begin);
        }
    }
    if u.c != 0.0 {
        sum += u.c * w[element];
    }
    to[element] = sum;
}

// The sum of v, cells, at both sides of a face.
fn both_sides(here: Site, axis: u32) -> f32 {
    return v[here.cell] + v[beside(here, axis, -1)];
}

fn of_axis(axis: u32) -> f32 {
    return select(select(u.c, u.b, axis == 1u), u.a, axis == 0u);
}

// to, faces, += (a, b, c) times the sum of the cells v at both sides, but for closed faces and exits.
@compute @workgroup_size(256)
fn lift(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    let axis = element / u.apart;
    let cell = element % u.apart;
    if axis >= DIMS || cell >= cells() {
        return;
    }
    let here = site(cell);
    if !is_closed(here, axis) && !is_exit(cell, axis) {
        to[element] = to[element] + of_axis(axis) * both_sides(here, axis);
    }
}

// to, cells, += (a, b, c) times the sum of the faces v around it but for exits; they are 0 where they are closed.
@compute @workgroup_size(256)
fn lift_back(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let cell = number(group, groups, local);
    if cell >= cells() {
        return;
    }
    let here = site(cell);
    var sum = 0.0;
    for (var axis = 0u; axis < DIMS; axis++) {
        var both = 0.0;
        if !is_exit(cell, axis) {
            both = v[axis * u.apart + cell];
        }
        if has_above(here, axis) {
            let above = beside(here, axis, 1);
            if !is_exit(above, axis) {
                both += v[axis * u.apart + above];
            }
        }
        sum += of_axis(axis) * both;
    }
    to[cell] = to[cell] + sum;
}

// to, faces, = (1 - e) to + e (V - v) with V = (a, b, c) and e the least of 1 and the cells w at both sides; flag 0: to begins here, as 0.
// At closed faces e is 0.
@compute @workgroup_size(256)
fn push(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    let axis = element / u.apart;
    let cell = element % u.apart;
    if axis >= DIMS || cell >= cells() {
        return;
    }
    let here = site(cell);
    var e = 0.0;
    if !is_closed(here, axis) {
        e = min(1.0, min(w[cell], w[beside(here, axis, -1)]));
    }
    var before = 0.0;
    if !flag(0u) {
        before = to[element];
    }
    to[element] = (1.0 - e) * before + e * (of_axis(axis) - v[element]);
}

// to, faces at `count` steps, times the mask of the face, or divided by it (flag 0): the mean of the cells v at both sides, and at least a.
@compute @workgroup_size(256)
fn weigh(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    let step = element / (u.apart * DIMS);
    let axis = (element / u.apart) % DIMS;
    let cell = element % u.apart;
    if step >= u.count || cell >= cells() {
        return;
    }
    let mask = max(0.5 * both_sides(site(cell), axis), u.a);
    to[element] = select(to[element] * mask, to[element] / mask, flag(0u));
}

// to, faces at `count` steps, is 0 at closed faces.
@compute @workgroup_size(256)
fn close(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    let step = element / (u.apart * DIMS);
    let axis = (element / u.apart) % DIMS;
    let cell = element % u.apart;
    if step < u.count && cell < cells() && is_closed(site(cell), axis) {
        to[element] = 0.0;
    }
}
