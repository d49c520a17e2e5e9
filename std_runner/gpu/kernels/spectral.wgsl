// The projection and the blur: a transform along each axis, a product with the eigenvalues, and back (core/poisson, core/operators/blur.rs).

@group(0) @binding(0) var<storage, read_write> to: array<f32>;
@group(0) @binding(1) var<storage, read_write> source: array<f32>;
@group(0) @binding(2) var<storage, read_write> table: array<f32>;

// to = div source, at `count` steps.
@compute @workgroup_size(256)
fn divergence(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    let step = element / u.apart;
    let cell = element % u.apart;
    if step >= u.count || cell >= cells() {
        return;
    }
    var sum = 0.0;
    for (var axis = 0u; axis < dims(); axis++) {
        let base = (step * dims() + axis) * u.apart;
        var high = 0.0;
        if flows(cell, axis, 1) {
            high = source[base + beside(cell, axis, 1)];
        }
        sum += (high - source[base + cell]) * inverse_of(axis);
    }
    to[element] = sum;
}

// to -= grad source at the faces of `count` steps, but for those on walls.
@compute @workgroup_size(256)
fn subtract_gradient(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    let step = element / (u.apart * dims());
    let axis = (element / u.apart) % dims();
    let cell = element % u.apart;
    if step >= u.count || cell >= cells() || on_wall(cell, axis) {
        return;
    }
    let base = step * u.apart;
    to[element] = to[element] - (source[base + cell] - source[base + beside(cell, axis, -1)]) * inverse_of(axis);
}

// to = M source along `axis`, in `count` fields; flag 0: M^T source. The matrix begins at `first` of the table, by rows.
@compute @workgroup_size(256)
fn transform(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    let cell = element % u.apart;
    if element / u.apart >= u.count || cell >= cells() {
        return;
    }
    let n = along(u.axis);
    let here = at(cell, u.axis);
    let between = stride(u.axis);
    var place = element - here * between;
    let by = select(1u, n, flag(0u));
    var entry = u.first + here * select(n, 1u, flag(0u));
    var sum = 0.0;
    for (var i = 0u; i < n; i++) {
        sum += table[entry] * source[place];
        place += between;
        entry += by;
    }
    to[element] = sum;
}

// to *= -1 / (the sum of the eigenvalues), 0 for the mean, in `count` fields. The eigenvalues along x, y and z begin at `first`.
@compute @workgroup_size(256)
fn invert(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    let cell = element % u.apart;
    if element / u.apart >= u.count || cell >= cells() {
        return;
    }
    var eigenvalue = 0.0;
    var place = u.first;
    for (var axis = 0u; axis < dims(); axis++) {
        eigenvalue += table[place + at(cell, axis)];
        place += along(axis);
    }
    to[element] = select(0.0, -to[element] / eigenvalue, eigenvalue > 0.0);
}

// to *= a + the sum over `second` filters of the product of their eigenvalues, which begin at `first`: along x, y, z of each.
@compute @workgroup_size(256)
fn filter_all(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let cell = number(group, groups, local);
    if cell >= cells() {
        return;
    }
    var sum = u.a;
    var place = u.first;
    for (var j = 0u; j < u.second; j++) {
        var product = 1.0;
        for (var axis = 0u; axis < dims(); axis++) {
            product *= table[place + at(cell, axis)];
            place += along(axis);
        }
        sum += product;
    }
    to[cell] = sum * to[cell];
}
