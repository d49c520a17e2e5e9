// The projection and the blur: a transform along each axis, a product with the eigenvalues, and back (core/poisson, core/operators/blur.rs).

@group(0) @binding(0) var<storage, read_write> to: array<f32>;
@group(0) @binding(1) var<storage, read_write> source: array<f32>;
@group(0) @binding(2) var<storage, read_write> table: array<f32>;
@group(0) @binding(3) var<storage, read_write> solids: array<f32>;

// to = div source, at `count` steps; 0 outside of open sides.
@compute @workgroup_size(256)
fn divergence(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    let step = element / u.apart;
    let cell = element % u.apart;
    if step >= u.count || cell >= cells() {
        return;
    }
    let here = site(cell);
    var sum = 0.0;
    for (var axis = 0u; axis < DIMS; axis++) {
        let base = (step * DIMS + axis) * u.apart;
        var high = 0.0;
        if flows(here, axis, 1) {
            high = source[base + beside(here, axis, 1)];
        }
        sum += (high - source[base + cell]) * inverse_of(axis);
    }
    to[element] = select(sum, 0.0, (solid_bits(cell) & OUTSIDE) != 0u);
}

// to -= grad source at the faces of `count` steps, but for closed ones.
@compute @workgroup_size(256)
fn subtract_gradient(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    let step = element / (u.apart * DIMS);
    let axis = (element / u.apart) % DIMS;
    let cell = element % u.apart;
    if step >= u.count || cell >= cells() {
        return;
    }
    let here = site(cell);
    if is_closed(here, axis) {
        return;
    }
    let base = step * u.apart;
    to[element] = to[element] - (source[base + cell] - source[base + beside(here, axis, -1)]) * inverse_of(axis);
}

// Sides of the tiles of a product with a matrix: 64 x 64 numbers of the result for each group, by 16 terms at a time. Rows of a tile are a
// little longer, so that those who write a column of it write to banks of their own.
const SIDE: u32 = 64u;
const TERMS: u32 = 16u;
const LONG: u32 = 68u;

var<workgroup> of_matrix: array<f32, 1088>;
var<workgroup> of_source: array<f32, 1088>;

// to = M source along `axis`, in `count` fields; flag 0: M^T source. The matrix begins at `first` of the table, by rows. Lines of fields along
// the axis are columns: all lines of a field along x and along z, those of a plane of z along y. A group makes a tile of rows and columns,
// an invocation 4 x 4 numbers of it, 16 apart.
@compute @workgroup_size(256)
fn transform(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let n = along(u.axis);
    let is_x = u.axis == 0u;
    let columns = select(stride(u.axis), u.n.y * u.n.z, is_x);
    let planes = select(1u, u.n.z, u.axis == 1u);
    let tiles = vec2<u32>((n + SIDE - 1u) / SIDE, (columns + SIDE - 1u) / SIDE);
    let tile = group_number(group, groups);
    let plane = tile / (tiles.x * tiles.y);
    if plane >= planes * u.count {
        return;
    }
    let row = (tile % tiles.x) * SIDE;
    let column = (tile / tiles.x % tiles.y) * SIDE;
    let begin = plane / planes * u.apart + plane % planes * u.n.x * u.n.y;
    // Numbers between terms, and between columns.
    let between = select(vec2<u32>(stride(u.axis), 1u), vec2<u32>(1u, n), is_x);
    let transposed = flag(0u);
    // Those beside each other read and write what lies beside each other.
    let high = local / 16u;
    let low = local % 16u;
    let own = select(vec2<u32>(high, low), vec2<u32>(low, high), is_x);
    let far = vec2<u32>(local / SIDE, local % SIDE);
    var sums: array<vec4<f32>, 4>;
    for (var term = 0u; term < n; term += TERMS) {
        for (var j = 0u; j < 4u; j++) {
            let near = vec2<u32>(low, high + 16u * j);
            let wide = vec2<u32>(far.x + 4u * j, far.y);
            let of_m = select(near, wide, transposed);
            let m = vec2<u32>(term + of_m.x, row + of_m.y);
            var value = 0.0;
            if m.x < n && m.y < n {
                value = table[u.first + select(m.y * n + m.x, m.x * n + m.y, transposed)];
            }
            of_matrix[of_m.x * LONG + of_m.y] = value;
            let of_s = select(wide, near, is_x);
            let s = vec2<u32>(term + of_s.x, column + of_s.y);
            value = 0.0;
            if s.x < n && s.y < columns {
                value = source[begin + s.x * between.x + s.y * between.y];
            }
            of_source[of_s.x * LONG + of_s.y] = value;
        }
        workgroupBarrier();
        for (var i = 0u; i < TERMS; i++) {
            let a = i * LONG + own.x;
            let b = i * LONG + own.y;
            let rows = vec4<f32>(of_matrix[a], of_matrix[a + 16u], of_matrix[a + 32u], of_matrix[a + 48u]);
            let lines = vec4<f32>(of_source[b], of_source[b + 16u], of_source[b + 32u], of_source[b + 48u]);
            sums[0] += rows.x * lines;
            sums[1] += rows.y * lines;
            sums[2] += rows.z * lines;
            sums[3] += rows.w * lines;
        }
        workgroupBarrier();
    }
    for (var r = 0u; r < 4u; r++) {
        let k = row + own.x + 16u * r;
        for (var q = 0u; q < 4u; q++) {
            let line = column + own.y + 16u * q;
            if k < n && line < columns {
                to[begin + k * between.x + line * between.y] = sums[r][q];
            }
        }
    }
}

// to *= -1 / (the sum of the eigenvalues), 0 for the mean, in `count` fields. The eigenvalues along x, y and z begin at `first`.
@compute @workgroup_size(256)
fn invert(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    let cell = element % u.apart;
    if element / u.apart >= u.count || cell >= cells() {
        return;
    }
    let here = site(cell);
    var eigenvalue = 0.0;
    var place = u.first;
    for (var axis = 0u; axis < DIMS; axis++) {
        eigenvalue += table[place + at(here, axis)];
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
    let here = site(cell);
    var sum = u.a;
    var place = u.first;
    for (var j = 0u; j < u.second; j++) {
        var product = 1.0;
        for (var axis = 0u; axis < DIMS; axis++) {
            product *= table[place + at(here, axis)];
            place += along(axis);
        }
        sum += product;
    }
    to[cell] = sum * to[cell];
}

// to = A source in `count` fields, A = -div grad through open faces.
@compute @workgroup_size(256)
fn through_open(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    let cell = element % u.apart;
    if element / u.apart >= u.count || cell >= cells() {
        return;
    }
    let here = site(cell);
    let begin = element - cell;
    let own = source[element];
    var sum = 0.0;
    for (var axis = 0u; axis < DIMS; axis++) {
        let weight = inverse_of(axis) * inverse_of(axis);
        if !is_closed(here, axis) {
            sum += weight * (own - source[begin + beside(here, axis, -1)]);
        }
        if has_above(here, axis) {
            let above = moved(here, axis, 1);
            if !is_closed(above, axis) {
                sum += weight * (own - source[begin + above.cell]);
            }
        }
    }
    to[element] = sum;
}

// to *= a in `count` fields, and is 0 in cells that have any of the bits `second`.
@compute @workgroup_size(256)
fn leave_out(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    let cell = element % u.apart;
    if element / u.apart < u.count && cell < cells() {
        to[element] = select(u.a * to[element], 0.0, (solid_bits(cell) & u.second) != 0u);
    }
}

// Where a cell at any distance behind the ends of an axis is found: round a ring, mirrored at walls and open sides. The first of `count` cells
// inside is `third`.
fn mirrored(at: i32, axis: u32) -> i32 {
    let begin = i32(u.third);
    let n = i32(u.count);
    let period = select(2 * n, n, is_ring(axis));
    let place = (((at - begin) % period) + period) % period;
    return begin + select(place, 2 * n - 1 - place, place >= n);
}

// to = a Gaussian of `second` taps on either side along `axis` of source, a field of cells. Its taps begin at `first` of the table.
@compute @workgroup_size(256)
fn gaussian(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let cell = number(group, groups, local);
    if cell >= cells() {
        return;
    }
    let here = i32(at(site(cell), u.axis));
    let radius = i32(u.second);
    var sum = 0.0;
    for (var offset = -radius; offset <= radius; offset++) {
        let there = mirrored(here + offset, u.axis);
        let tap = table[u.first + u32(abs(offset))];
        sum += tap * source[u32(i32(cell) + (there - here) * i32(stride(u.axis)))];
    }
    to[cell] = sum;
}
