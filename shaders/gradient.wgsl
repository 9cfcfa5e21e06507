// Mirrors gradient.rs, from the field on the device: one vertex per invocation. The mean over all frusta is the same
// sum as that over those that miss no value, so only the latter is implemented.
//
// If a field is almost flat in one direction, f32 has no digits left for the slope there: so values have more.
#import kernel/column

// One page: the number of its first column, its number of columns, and the places for triangles around each cell.
struct Around {
    first: u32,
    columns: u32,
    row: u32,
}

// Marks that there is no triangle behind a cell's last one.
const NONE: u32 = 0xffffffffu;

@group(2) @binding(0) var<uniform> around: Around;
// The triangles with data around each cell.
@group(2) @binding(1) var<storage, read> corners: array<u32>;
// The cells of columns, if these are not all cells.
@group(2) @binding(2) var<storage, read> cells_of_columns: array<u32>;
// In the format of gradients.wgsl.
@group(2) @binding(3) var<storage, read_write> gradients_out: array<f32>;
// Remainders of the values beyond f32, in 16 bits each, two in a word: a value's last digits, in pages like the
// field's.
#each @group(3) @binding(PAGE) var<storage, read> rests_PAGE: array<u32>;

const LARGEST: f32 = 1e15;

fn rests_get(base: Base, layer: u32) -> f32 {
    let at = pages_at(base, layer);
    var word = rests_0[at >> 1u];
    if PAGES > 1u {
        switch base.page {
#each             case PAGEu: { word = rests_PAGE[at >> 1u]; }
            default: { word = 0u; }
        }
    }
    let pair = unpack2x16snorm(word);
    return select(pair.x, pair.y, (at & 1u) == 1u);
}

// A value of the field with all its digits. Equal values must have equal remainders, so that their difference, which
// gives the normal its direction, is 0: a driver must not fuse this product with a difference.
fn value_get(base: Base, layer: u32) -> Wide {
    let value = samples_get(base, layer);
    return Wide(value, opaque(rests_get(base, layer) * abs(value) * ROUNDING));
}

// The value next to that at a vertex: one layer further.
struct Next {
    layer: u32,
    slope: f32,
    size: f32,
    is_known: bool,
}

// From `layer` to the one above it, seen from the vertex with value `own` at either of them.
fn next_above(base: Base, layer: u32, is_above: bool, own: Wide) -> Next {
    if layer >= params.layers - 1u {
        return Next(layer, 0.0, 0.0, false);
    }
    let there = layer + u32(is_above);
    let value = value_get(base, there);
    let rise = wide_apart(value, own) * select(-1.0, 1.0, is_above);
    return Next(there, rise * shell[layer].inverse, abs(value.hi), !is_missing(value.hi));
}

// b - a, to the digits of f32.
fn apart3(b: Wide3, a: Wide3) -> vec3f {
    return opaque3(b.hi - a.hi) + opaque3(b.lo - a.lo);
}

// The mean over those frusta at a vertex that miss no value.
fn known(cell: u32, layer: u32) -> vec3f {
    let base = samples_base(cell);
    let own = value_get(base, layer);
    if is_missing(own.hi) {
        return vec3f(0.0);
    }
    var next = array<Next, 2>(
        // There is no layer below the innermost: its number exceeds all.
        next_above(base, layer - 1u, false, own),
        next_above(base, layer, true, own),
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
        let bases = array<Base, 2>(samples_base(others.x), samples_base(others.y));
        let values = array<Wide, 2>(value_get(bases[0], layer), value_get(bases[1], layer));
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
                && !is_missing(samples_get(bases[0], beyond.layer))
                && !is_missing(samples_get(bases[1], beyond.layer)) {
                sum += (flat_ * shell[layer].curvature + beyond.slope * radial) / volume;
                count += 1.0;
                size = max(max(size, beyond.size), max(abs(values[0].hi), abs(values[1].hi)));
            }
        }
    }
    return narrowed(sum / max(count, 1.0), size);
}

// Values at the limit of f32 kernels, of size `size`, represent all values beyond: gradients there have the largest
// length.
fn narrowed(mean: vec3f, size: f32) -> vec3f {
    let largest = max(abs(mean.x), max(abs(mean.y), abs(mean.z)));
    return mean * select(1.0, 1e30 / max(largest, 1.0), size >= LARGEST);
}

@compute @workgroup_size(64)
fn gradient(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let layers = params.last_layer + 1u - params.first_layer;
    let at = id.y * (64u * groups.x) + id.x;
    let column = at / layers;
    if column >= around.columns {
        return;
    }
    var cell = around.first + column;
    if HAS_PLACES {
        cell = cells_of_columns[cell];
    }
    let row = at % layers;
    let mean = known(cell, params.first_layer + row);
    let there = 3u * (column * params.column_stride + row * params.layer_stride);
    gradients_out[there] = mean.x;
    gradients_out[there + 1u] = mean.y;
    gradients_out[there + 2u] = mean.z;
}
