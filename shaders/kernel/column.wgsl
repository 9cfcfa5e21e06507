// Mirrors kernel/column.rs. Heights are in double-float; fractions and lengths are f32, computed from differences of
// heights that are accurate to the digits of f32 (`wide_apart`): layers of 100 m on an Earth keep their digits.
#import params
#import kernel/walk
#import kernel/sample
#native #import scenery

struct ShellLayer {
    radius_hi: f32,
    radius_lo: f32,
    curvature: f32,
    // 1 / thickness of the gap above.
    inverse: f32,
}

@group(0) @binding(7) var<storage, read> shell: array<ShellLayer>;

fn shell_radius(layer: u32) -> Wide {
    return Wide(shell[layer].radius_hi, shell[layer].radius_lo);
}

fn shell_outer() -> Wide {
#native     return Wide(scenery.outer.x, scenery.outer.y);
#concentric     return shell_radius(params.layers - 1u);
}

fn shell_inner() -> Wide {
#native     return Wide(scenery.core_low.x, scenery.core_low.y);
#concentric     return shell_radius(0u);
}

fn shell_gap(rho: Wide) -> u32 {
    var low = 0u;
    var high = params.layers;
    while low < high {
        let middle = (low + high) / 2u;
        if wide_apart(shell_radius(middle), rho) <= 0.0 {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

fn shell_fraction(gap: u32, rho: Wide) -> f32 {
    let above = wide_apart(rho, shell_radius(gap - 1u));
    return clamp(above * shell[gap - 1u].inverse, 0.0, 1.0);
}

struct Chord {
    entry: f32,
    exit: f32,
    // Whether a value at a vertex is missing.
    is_void: bool,
    // As in a segment.
    size: f32,
    // Gradients, if the scene is lit.
    entry_gradient: vec3f,
    exit_gradient: vec3f,
    // The largest component of the gradients at the vertices.
    gradient_size: f32,
}

fn chord_over(values: vec3f, entry: vec2f, exit: vec2f) -> Chord {
    let a = values.x;
    let ab = values.y - a;
    let ac = values.z - a;
    let is_void = is_missing(values.x) || is_missing(values.y) || is_missing(values.z);
    let sizes = abs(values);
    let most = max(sizes.x, max(sizes.y, sizes.z));
    // Far beyond the transfer function's range, the roundings that matter are those of a column's weights, which all of
    // its frusta share.
    let size = max(max(most, 2.0 * most - 1.0), select(1.0, 0.0, HAS_STEPS));
    let none = vec3f(0.0);
    return Chord(a + (entry.x * ab + entry.y * ac), a + (exit.x * ab + exit.y * ac), is_void, size, none, none, 0.0);
}

// A chord's gradients, from those at the three vertices.
fn chord_over_gradients(chord: ptr<function, Chord>, a: vec3f, b: vec3f, c: vec3f, entry: vec2f, exit: vec2f) {
    let ab = b - a;
    let ac = c - a;
    (*chord).entry_gradient = a + (entry.x * ab + entry.y * ac);
    (*chord).exit_gradient = a + (exit.x * ab + exit.y * ac);
    (*chord).gradient_size = largest(max(abs(a), max(abs(b), abs(c))));
}

fn chord_mix(a: Chord, b: Chord, w: f32) -> Chord {
    return Chord(
        lerp(a.entry, b.entry, w),
        lerp(a.exit, b.exit, w),
        a.is_void || b.is_void,
        max(a.size, b.size),
        lerp3(a.entry_gradient, b.entry_gradient, w),
        lerp3(a.exit_gradient, b.exit_gradient, w),
        max(a.gradient_size, b.gradient_size),
    );
}

fn chord_at(chord: Chord, tau: f32) -> f32 {
    return lerp(chord.entry, chord.exit, tau);
}

struct RayPoint {
    u: f32,
    tau: f32,
    rho: Wide,
    curvature: f32,
}
