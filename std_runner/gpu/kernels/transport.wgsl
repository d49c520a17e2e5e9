// Limited transport (core/transport/limited): the stages of a sub-step, forward and back, and the Courant number of a step.

@group(0) @binding(0) var<storage, read_write> to: array<f32>;
@group(0) @binding(1) var<storage, read_write> mu: array<f32>;
@group(0) @binding(2) var<storage, read_write> gradient: array<f32>;
@group(0) @binding(3) var<storage, read_write> z: array<f32>;
@group(0) @binding(4) var<storage, read_write> y: array<f32>;
@group(0) @binding(5) var<storage, read_write> v: array<f32>;
@group(0) @binding(6) var<storage, read_write> solids: array<f32>;

fn limited(c: f32, d: f32) -> f32 {
    let at_c = c + c;
    let mean = (c + d + d) * (1.0 / 3.0);
    let at_d = d + d;
    let rising = max(min(min(at_c, mean), at_d), 0.0);
    let falling = min(max(max(at_c, mean), at_d), 0.0);
    return rising + falling;
}

// The derivatives of lim(c, d) by c and by d.
fn slopes(c0: f32, d0: f32) -> vec2<f32> {
    let sign = select(-1.0, 1.0, d0 > 0.0);
    let c = c0 * sign;
    let d = d0 * sign;
    let first = d * 0.4 - c > 0.0;
    let second = d * 4.0 - c > 0.0;
    let by_c = select(select(0.0, 1.0 / 3.0, second), 2.0, first);
    let by_d = select(select(2.0, 2.0 / 3.0, second), 0.0, first);
    return select(vec2<f32>(0.0, 0.0), vec2<f32>(by_c, by_d), c > 0.0);
}

// rho_f at a face between b and c, from the differences across the face before, itself and the face after.
fn at_face(b: f32, c: f32, across: vec3<f32>, upward: bool) -> f32 {
    let half = 0.5 * limited(select(across.z, across.x, upward), across.y);
    return select(c - half, b + half, upward);
}

fn by_velocity(b: f32, c: f32, across: vec3<f32>, through: f32) -> f32 {
    let upward = at_face(b, c, across, true);
    let downward = at_face(b, c, across, false);
    return select(select(0.5 * (upward + downward), downward, through < 0.0), upward, through > 0.0);
}

fn face(here: Site, axis: u32, offset: i32) -> f32 {
    if !flows(here, axis, offset) {
        return 0.0;
    }
    return v[axis * u.apart + beside(here, axis, offset)];
}

// y at the cells at -2, -1, 1 and 2.
fn around_y(here: Site, axis: u32) -> vec4<f32> {
    return vec4<f32>(y[beside(here, axis, -2)], y[beside(here, axis, -1)], y[beside(here, axis, 1)], y[beside(here, axis, 2)]);
}

// 1 at the faces at -1, 0, 1 and 2 that are open: across those that solid cells close, and across exits, nothing differs. Walls are mirrors
// already.
fn open_around(here: Site, axis: u32) -> vec4<f32> {
    if ((u.flags >> 3u) & 1u) == 0u {
        return vec4<f32>(1.0);
    }
    var open = vec4<f32>(0.0);
    for (var face = 0; face < 4; face++) {
        let closes = (solid_bits(beside(here, axis, face - 1)) & (258u << axis)) != 0u;
        open[face] = select(1.0, 0.0, closes);
    }
    return open;
}

// to = p rho + (1 - p) (y + tau L y), p being `b`; rho is `z`, which is not read where p is 0. What is below `c` is 0. `a` is tau.
@compute @workgroup_size(256)
fn carry(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let cell = number(group, groups, local);
    if cell >= cells() {
        return;
    }
    let here = site(cell);
    let own = y[cell];
    var sum = 0.0;
    for (var axis = 0u; axis < DIMS; axis++) {
        let o = around_y(here, axis);
        let across = vec4<f32>(o.y - o.x, own - o.y, o.z - own, o.w - o.z) * open_around(here, axis);
        let low = face(here, axis, 0);
        let high = face(here, axis, 1);
        let inflow = low * at_face(o.y, own, across.xyz, low > 0.0) - high * at_face(own, o.z, across.yzw, high > 0.0);
        sum += u.a * inverse_of(axis) * inflow;
    }
    let carried = own + sum;
    var value = carried;
    if u.b != 0.0 {
        value = carried + u.b * (z[cell] - carried);
    }
    to[cell] = select(value, 0.0, abs(value) < u.c);
}

// The sum over the faces around a cell of v_f times the derivative of rho_f by the cell times the change of z across the face. Where a face is
// not `open` nothing differs across it, whatever the cells are: an exit has a flow all the same.
fn outflow(across: vec4<f32>, zs: array<f32, 5>, faces: vec4<f32>, open: vec4<f32>) -> f32 {
    let low = faces.y;
    let high = faces.z;
    let left = slopes(select(across.z, across.x, low > 0.0), across.y);
    let by_left = left.y * open.y;
    let as_right = select(1.0 + 0.5 * (left.x - by_left), 0.5 * by_left, low > 0.0);
    let right = slopes(select(across.w, across.y, high > 0.0), across.z);
    let by_right = right.y * open.z;
    let as_left = select(0.5 * by_right, 1.0 + 0.5 * (right.x - by_right), high > 0.0);
    let far_left = slopes(across.z, across.w).x;
    let far_right = slopes(across.y, across.x).x;
    let near = low * as_right * (zs[2] - zs[1]) + high * as_left * (zs[3] - zs[2]);
    let beyond = max(faces.w, 0.0) * far_left * (zs[4] - zs[3]) + min(faces.x, 0.0) * far_right * (zs[1] - zs[0]);
    return near - 0.5 * beyond;
}

// A stage back: sum = z + tau L'(y)^T z. Flag 0: to = share sum. Flag 1: mu = b mu + c times sum, or times z where there is a next z.
// Flag 2: the gradient begins here. `a` is tau; the share is in the bits of `third`.
@compute @workgroup_size(256)
fn carry_back(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let cell = number(group, groups, local);
    if cell >= cells() {
        return;
    }
    let here = site(cell);
    let share = bitcast<f32>(u.third);
    let here_z = z[cell];
    let here_y = y[cell];
    var sum = here_z;
    for (var axis = 0u; axis < DIMS; axis++) {
        let o = around_y(here, axis);
        let open = open_around(here, axis);
        let across = vec4<f32>(o.y - o.x, here_y - o.y, o.z - here_y, o.w - o.z) * open;
        let zs = array<f32, 5>(z[beside(here, axis, -2)], z[beside(here, axis, -1)], here_z, z[beside(here, axis, 1)], z[beside(here, axis, 2)]);
        let faces = vec4<f32>(face(here, axis, -1), face(here, axis, 0), face(here, axis, 1), face(here, axis, 2));
        let scale = u.a * inverse_of(axis);
        let rho_f = by_velocity(o.y, here_y, across.xyz, faces.y);
        let place = axis * u.apart + cell;
        let part = share * scale * rho_f * (here_z - zs[1]);
        if flag(2u) {
            gradient[place] = part;
        } else {
            gradient[place] = gradient[place] + part;
        }
        sum += scale * outflow(across, zs, faces, open);
    }
    let taken = select(sum, here_z, flag(0u));
    if flag(0u) {
        to[cell] = share * sum;
    }
    if flag(1u) {
        mu[cell] = u.b * mu[cell] + u.c * taken;
    }
}

// The largest sum over a cell's faces of |v_f| / (2 h), of each group of cells: group.x of a step, which is group.y. What is not finite
// counts as 1e30.
@compute @workgroup_size(256)
fn courant(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let step = group.y * DIMS * u.apart;
    var largest = 0.0;
    for (var cell = group.x * GROUP + local; cell < cells(); cell += groups.x * GROUP) {
        let here = site(cell);
        var sum = 0.0;
        for (var axis = 0u; axis < DIMS; axis++) {
            let low = v[step + axis * u.apart + cell];
            var high = 0.0;
            if flows(here, axis, 1) {
                high = v[step + axis * u.apart + beside(here, axis, 1)];
            }
            sum += 0.5 * inverse_of(axis) * (abs(low) + abs(high));
        }
        largest = max(largest, sized(sum));
    }
    let largest_of_all = largest_in_group(largest, local);
    if local == 0u {
        to[u.first + group.y * groups.x + group.x] = largest_of_all;
    }
}
