// Kernels that read nothing beside an element, and sums over all elements.

@group(0) @binding(0) var<storage, read_write> to: array<f32>;
@group(0) @binding(1) var<storage, read_write> x: array<f32>;
@group(0) @binding(2) var<storage, read_write> y: array<f32>;
@group(0) @binding(3) var<storage, read_write> solids: array<f32>;

// to = a to + b x; where a is 0 `to` is not read, where b is 0 x is not.
@compute @workgroup_size(256)
fn add(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    if element >= u.count {
        return;
    }
    var sum = 0.0;
    if u.a != 0.0 {
        sum = u.a * to[element];
    }
    if u.b != 0.0 {
        sum += u.b * x[element];
    }
    to[element] = sum;
}

// to = a to + b y x in field after field, `apart` elements each, y having a number for each.
@compute @workgroup_size(256)
fn add_each(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    if element < u.count {
        to[element] = u.a * to[element] + u.b * y[element / u.apart] * x[element];
    }
}

// to *= x.
@compute @workgroup_size(256)
fn multiply(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    if element >= u.count {
        return;
    }
    to[element] = to[element] * x[element];
}

// to = max(to, a x) where x is positive: what an emitter fills up.
@compute @workgroup_size(256)
fn fill(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    if element < u.count && x[element] > 0.0 {
        to[element] = max(to[element], u.a * x[element]);
    }
}

// to = 0 where x is positive and y is a x: what an emitter filled up depends on nothing before.
@compute @workgroup_size(256)
fn forget(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let element = number(group, groups, local);
    if element < u.count && x[element] > 0.0 && y[element] <= u.a * x[element] {
        to[element] = 0.0;
    }
}

// The sum of x y over `count` elements, or of x x (flag 0), a number for each group at `first` of `to`; in row after row of so many elements,
// which are those of group.y.
@compute @workgroup_size(256)
fn dot_all(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    // Pieces of 64 are added up first, so that rounding grows with their number and not with that of all elements.
    var all_of_them = 0.0;
    var sum = 0.0;
    var terms = 0u;
    let begin = group.y * u.count;
    for (var element = group.x * GROUP + local; element < u.count; element += groups.x * GROUP) {
        var factor = x[begin + element];
        if !flag(0u) {
            factor = y[begin + element];
        }
        sum += x[begin + element] * factor;
        terms++;
        if terms == 64u {
            all_of_them += sum;
            sum = 0.0;
            terms = 0u;
        }
    }
    let total = sum_in_group(all_of_them + sum, local);
    if local == 0u {
        to[u.first + group_number(group, groups)] = total;
    }
}

// The largest |x| of `count` elements, a number for each group at `first` of `to`; 1e30 where x is not finite; row after row as above.
@compute @workgroup_size(256)
fn largest(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    var most = 0.0;
    let begin = group.y * u.count;
    for (var element = group.x * GROUP + local; element < u.count; element += groups.x * GROUP) {
        most = max(most, sized(abs(x[begin + element])));
    }
    let largest_of_all = largest_in_group(most, local);
    if local == 0u {
        to[u.first + group_number(group, groups)] = largest_of_all;
    }
}
