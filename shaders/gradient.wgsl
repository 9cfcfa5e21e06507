// Mirrors gradient.rs, from the field on the device: one vertex per invocation. The mean over all frusta is the same sum as
// that over those that miss no value, so there is the latter only.
//
// Where a field is all but flat in one direction, f32 has no digits left for the slope there: so values have more.
#import kernel/column

// How many cells there are, and places for triangles around each.
struct Around {
    cells: u32,
    row: u32,
}

// In place of a triangle behind a cell's last one.
const NONE: u32 = 0xffffffffu;

@group(1) @binding(0) var<uniform> around: Around;
// The triangles with data around each cell.
@group(1) @binding(1) var<storage, read> corners: array<u32>;
// As gradients.wgsl reads them.
@group(1) @binding(2) var<storage, read_write> gradients_out: array<f32>;
// What f32 leaves of values, in 16 bits each, two in a word: a value's last digits, in order of the field.
@group(1) @binding(3) var<storage, read> rests: array<u32>;

const LARGEST: f32 = 1e15;

// A value of the field with all its digits.
fn value_get(cell: u32, layer: u32) -> Wide {
    let value = samples_get(cell, layer);
    let at = cell * params.column_stride + layer * params.layer_stride;
    let rest = unpack2x16snorm(rests[at >> 1u]);
    return Wide(value, select(rest.x, rest.y, (at & 1u) == 1u) * abs(value) * ROUNDING);
}

// A value beside that at a vertex: one layer further.
struct Next {
    layer: u32,
    slope: f32,
    size: f32,
    is_known: bool,
}

// From `layer` to the one above it, seen from the vertex with value `own` at either of them.
fn next_above(cell: u32, layer: u32, is_above: bool, own: Wide) -> Next {
    if layer >= params.layers - 1u {
        return Next(layer, 0.0, 0.0, false);
    }
    let there = layer + u32(is_above);
    let value = value_get(cell, there);
    let rise = wide_apart(value, own) * select(-1.0, 1.0, is_above);
    return Next(there, rise * shell[layer].inverse, abs(value.hi), !is_missing(value.hi));
}

// b - a, to the digits of f32.
fn apart3(b: Wide3, a: Wide3) -> vec3f {
    return opaque3(b.hi - a.hi) + opaque3(b.lo - a.lo);
}

// The mean over those frusta at a vertex that miss no value.
fn known(cell: u32, layer: u32) -> vec3f {
    let own = value_get(cell, layer);
    if is_missing(own.hi) {
        return vec3f(0.0);
    }
    var next = array<Next, 2>(
        // There is no layer below the innermost: its number is beyond all.
        next_above(cell, layer - 1u, false, own),
        next_above(cell, layer, true, own),
    );
    let a = grid_direction(cell);
    var sum = vec3f(0.0);
    var count = 0.0;
    var size = abs(own.hi);
    for (var i = 0u; i < around.row; i++) {
        let triangle = corners[cell * around.row + i];
        if triangle == NONE {
            break;
        }
        let cells = grid_triangle(triangle);
        let k = contour_column_of(cells, cell);
        let others = vec2u(cells[(k + 1u) % 3u], cells[(k + 2u) % 3u]);
        let values = array<Wide, 2>(value_get(others.x, layer), value_get(others.y, layer));
        if is_missing(values[0].hi) || is_missing(values[1].hi) {
            continue;
        }
        let b = apart3(grid_direction(others.x), a);
        let c = apart3(grid_direction(others.y), a);
        let radial = cross(b, c);
        let volume = dot(a.hi, radial);
        let flat_ = wide_apart(values[0], own) * cross(c, a.hi) + wide_apart(values[1], own) * cross(a.hi, b);
        for (var j = 0u; j < 2u; j++) {
            let beyond = next[j];
            if beyond.is_known
                && !is_missing(samples_get(others.x, beyond.layer))
                && !is_missing(samples_get(others.y, beyond.layer)) {
                sum += (flat_ * shell[layer].curvature + beyond.slope * radial) / volume;
                count += 1.0;
                size = max(max(size, beyond.size), max(abs(values[0].hi), abs(values[1].hi)));
            }
        }
    }
    return narrowed(sum / max(count, 1.0), size);
}

// Values at the end of what f32 kernels are given, of size `size`, stand for whatever lies beyond: there gradients are as long
// as any may be.
fn narrowed(mean: vec3f, size: f32) -> vec3f {
    let largest = max(abs(mean.x), max(abs(mean.y), abs(mean.z)));
    return mean * select(1.0, 1e30 / max(largest, 1.0), size >= LARGEST);
}

@compute @workgroup_size(64)
fn gradient(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = id.y * (64u * groups.x) + id.x;
    let cell = at / params.layers;
    if cell >= around.cells {
        return;
    }
    let mean = known(cell, at % params.layers);
    gradients_out[3u * at] = mean.x;
    gradients_out[3u * at + 1u] = mean.y;
    gradients_out[3u * at + 2u] = mean.z;
}
