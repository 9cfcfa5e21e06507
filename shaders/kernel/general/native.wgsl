// Mirrors kernel/packet/native.rs and kernel/packet/native_way.rs: layers at other heights over each cell.
//
// ψ = Σ α/R is linear along the ray and 1 on the facet of a layer, in double-float. The gap in which a ray leaves a column
// follows from the ψ at the exit alone, so that it crosses no layer twice.
#import params
#import scenery
#import kernel/column
#import kernel/ray
#import kernel/general/isosurfaces

// A gap's path for values: weights of the second and third vertex in N of the lower and N' of the upper layer, at the
// column's entry (x, y) and exit (z, w); at the ends of the path ψ of the upper layer, the fraction of the column, and x =
// (ψ - 1)/(ψ - ψ'), with which the value is (1 - x) N + x N'.
struct NativeWay {
    low: vec4f,
    high: vec4f,
    above: vec2f,
    u: vec2f,
    place: vec2f,
    eps: f32,
}

// A layer in a column: ψ at the entry and the exit, and the contributions of the second and third vertex to it.
struct Facet {
    entry: Wide,
    exit: Wide,
    weights: vec4f,
}

// 1 / radius of a layer over a cell.
fn native_inverse(cell: u32, layer: u32) -> Wide {
    let at = scenery.first_inverse + 2u * (cell * params.layers + layer);
    return Wide(surface_values[at], surface_values[at + 1u]);
}

// ψ at one end, and the contributions of the vertices.
struct FacetEnd {
    psi: Wide,
    weights: vec2f,
}

fn facet_end(end: ColumnEnd, a: Wide, b: Wide, c: Wide) -> FacetEnd {
    let weights = array<Wide, 2>(Wide(end.weight.x, end.weight_lo.x), Wide(end.weight.y, end.weight_lo.y));
    let rest = wide_sub(wide_sub(wide(1.0), weights[0]), weights[1]);
    let second = wide_mul(b, weights[0]);
    let third = wide_mul(c, weights[1]);
    let sum = wide_add(wide_mul(wide_max(rest, wide(0.0)), a), wide_add(second, third));
    return FacetEnd(wide_mul(end.rho, sum), end.rho.hi * vec2f(second.hi, third.hi));
}

fn facet_of(column: Column, layer: u32) -> Facet {
    let a = native_inverse(column.cells.x, layer);
    let b = native_inverse(column.cells.y, layer);
    let c = native_inverse(column.cells.z, layer);
    let entry = facet_end(column.entry, a, b, c);
    let exit = facet_end(column.exit, a, b, c);
    return Facet(entry.psi, exit.psi, vec4f(entry.weights, exit.weights));
}

fn facet_at(facet: Facet, u: Wide) -> Wide {
    return wide_add(facet.entry, wide_mul(u, wide_sub(facet.exit, facet.entry)));
}

// Whether ψ is that of a place on or above the layer.
fn is_above(psi: Wide) -> bool {
    return wide_apart(psi, wide(1.0)) >= 0.0;
}

// The gap that contains the entry of a column.
fn native_gap(column: Column) -> u32 {
    var low = 0u;
    var high = params.layers;
    while low < high {
        let middle = (low + high) / 2u;
        if is_above(facet_of(column, middle).entry) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

// The fraction of the column at which the ray crosses a facet, no less than `from_`.
fn facet_root(facet: Facet, rises: bool, from_: Wide) -> Wide {
    // Two columns each find the ψ of the side between them to a rounding: a ray may be beyond its layer at once.
    if is_above(facet.entry) == rises {
        return from_;
    }
    let root = wide_div(wide_sub(wide(1.0), facet.entry), wide_sub(facet.exit, facet.entry));
    return wide_min(wide_max(root, from_), wide(1.0));
}

// x at a place with these ψ of the lower layer and difference to that of the upper one.
fn native_place(psi: Wide, depth: f32) -> f32 {
    // Facets that meet have no space in between.
    return select(0.5, clamp(wide_apart(psi, wide(1.0)) / depth, 0.0, 1.0), depth > 0.0);
}

// Relative change beyond which a value is taken as linear.
const MOST_EPS: f32 = 1e9;

// The path from `u` to `v` of a column. `on` is x at a layer at which it begins or ends, else negative.
fn native_way(low: Facet, high: Facet, u: Wide, v: Wide, on: vec2f) -> NativeWay {
    let above = array<Wide, 2>(facet_at(high, u), facet_at(high, v));
    let below = array<Wide, 2>(facet_at(low, u), facet_at(low, v));
    let first = wide_sub(below[0], above[0]);
    let last = wide_sub(below[1], above[1]);
    let places = vec2f(native_place(below[0], first.hi), native_place(below[1], last.hi));
    var eps = wide_apart(last, first) / first.hi;
    if !(first.hi > 0.0 && eps <= MOST_EPS) {
        eps = 0.0;
    }
    return NativeWay(
        low.weights,
        high.weights,
        vec2f(above[0].hi, above[1].hi),
        vec2f(u.hi, v.hi),
        select(places, on, on >= vec2f(0.0)),
        max(eps, ROUNDING - 1.0),
    );
}

// A field along a path of this length, from values and gradients at the vertices below (first three) and above.
fn native_segment(way: NativeWay, v: array<vec4f, 6>, length: f32) -> FieldSegment {
    let low = way.low.x * (v[1] - v[0]) + way.low.y * (v[2] - v[0]);
    let low_exit = way.low.z * (v[1] - v[0]) + way.low.w * (v[2] - v[0]);
    let high = way.high.x * (v[4] - v[3]) + way.high.y * (v[5] - v[3]);
    let high_exit = way.high.z * (v[4] - v[3]) + way.high.w * (v[5] - v[3]);
    let below_a = low + way.u.x * (low_exit - low);
    let below_b = low + way.u.y * (low_exit - low);
    let above_a = high + way.u.x * (high_exit - high) + way.above.x * (v[3] - v[0]);
    let above_b = high + way.u.y * (high_exit - high) + way.above.y * (v[3] - v[0]);
    let rise_a = above_a - below_a;
    let rise_b = above_b - below_b;
    let from_ = v[0] + select(below_a + way.place.x * rise_a, above_a, way.place.x == 1.0);
    let to = v[0] + select(below_b + way.place.y * rise_b, above_b, way.place.y == 1.0);
    let kappa = (way.place.y - way.place.x) * (way.eps * rise_a + (rise_a - rise_b));
    let most = max(max(max(abs(v[0]), abs(v[1])), max(abs(v[2]), abs(v[3]))), max(abs(v[4]), abs(v[5])));
    let size = max(max(most.x, 2.0 * most.x - 1.0), select(1.0, 0.0, HAS_STEPS));
    // A missing value is larger than all others.
    return FieldSegment(
        Segment(from_.x, to.x, kappa.x, way.eps, length, size),
        FrustumInterpolant(from_.yzw, to.yzw, kappa.yzw, way.eps, largest(most.yzw)),
        !is_missing(most.x),
    );
}

// The volume's field at a vertex, and its gradient.
fn native_vertex(base: Base, layer: u32) -> vec4f {
    var gradient = vec3f(0.0);
    if IS_LIT {
        gradient = gradients_get(base, layer);
    }
    return vec4f(samples_get(base, layer), gradient);
}

// The volume's field at the vertices around a gap.
fn native_own(bases: array<Base, 3>, gap: u32) -> array<vec4f, 6> {
    let below = gap - 1u;
    return array<vec4f, 6>(
        native_vertex(bases[0], below),
        native_vertex(bases[1], below),
        native_vertex(bases[2], below),
        native_vertex(bases[0], gap),
        native_vertex(bases[1], gap),
        native_vertex(bases[2], gap),
    );
}

// Another field at the vertices around a gap.
fn native_field(field: SceneField, column: Column, gap: u32, has_gradients: bool) -> array<vec4f, 6> {
    let above = column.cells * params.layers + gap;
    return array<vec4f, 6>(
        native_vertex_of(field, above.x - 1u, has_gradients),
        native_vertex_of(field, above.y - 1u, has_gradients),
        native_vertex_of(field, above.z - 1u, has_gradients),
        native_vertex_of(field, above.x, has_gradients),
        native_vertex_of(field, above.y, has_gradients),
        native_vertex_of(field, above.z, has_gradients),
    );
}

fn native_vertex_of(field: SceneField, at: u32, has_gradients: bool) -> vec4f {
    var gradient = vec3f(0.0);
    if has_gradients {
        gradient = scene_gradient(field, at);
    }
    return vec4f(surface_values[field.first_value + at], gradient);
}

// The weights of the second and third vertex on a layer, at the fraction `tau` between the column's edge points.
fn native_weights(column: Column, layer: u32, tau: f32) -> vec2f {
    let weight = column.entry.weight + tau * (column.exit.weight - column.entry.weight);
    let inverse = vec3f(
        native_inverse(column.cells.x, layer).hi,
        native_inverse(column.cells.y, layer).hi,
        native_inverse(column.cells.z, layer).hi,
    );
    let on = vec3f(1.0 - weight.x - weight.y, weight) * inverse;
    return on.yz / (on.x + on.y + on.z);
}

// The normal of a layer there, from those of the cells from number `first` on.
fn native_normal(column: Column, layer: u32, tau: f32, first: u32) -> vec3f {
    let weights = native_weights(column, layer, tau);
    let a = surface_vector(first + 3u * column.cells.x);
    let b = surface_vector(first + 3u * column.cells.y);
    let c = surface_vector(first + 3u * column.cells.z);
    return normalize(a + weights.x * (b - a) + weights.y * (c - a));
}

fn native_point(column: Column, u: Wide) -> RayPoint {
    let rho = wide_add(column.entry.rho, wide_mul(u, wide_sub(column.exit.rho, column.entry.rho)));
    return RayPoint(u.hi, clamp(u.hi * column.exit.rho.hi / rho.hi, 0.0, 1.0), rho, 0.0);
}

// `cross` of kernel/ray.wgsl.
fn cross(
    ray: ptr<function, Ray>,
    light: ptr<function, Radiance>,
    line: RayLine,
    column: Column,
    gap: ptr<function, u32>,
) -> bool {
    let top = params.layers;
    let length = wide_apart(column.exit.t, column.entry.t);
    let bases = samples_bases(column.cells);
    var low = facet_of(column, max(*gap, 1u) - 1u);
    var high = facet_of(column, min(*gap, top - 1u));
    var u = wide(0.0);
    var on = -1.0;
    loop {
        let rises = *gap < top && is_above(high.exit);
        let falls = !rises && *gap > 0u && !is_above(low.exit);
        let passes = rises || falls;
        var end = wide(1.0);
        if passes {
            var next = low;
            if rises {
                next = high;
            }
            end = facet_root(next, rises, u);
        }
        let a = native_point(column, u);
        let b = native_point(column, end);
        let part = wide_apart(end, u);
        if *gap > 0u && *gap < top {
            if part > 0.0 {
                let ends = vec2f(on, select(-1.0, select(0.0, 1.0, rises), passes));
                let way = GapWay(*gap, a, b, part, u, native_way(low, high, u, end, ends));
                let own = native_segment(way.layers, native_own(bases, *gap), length * part);
                if scene_gap(ray, light, line, column, bases, way, own) {
                    return true;
                }
            }
        } else {
            if *gap == 0u {
                let t = wide_add(column.entry.t, wide(a.u * length));
                var body = 1.0;
                if IS_LIT {
                    body = ray_shading_solid((*ray).shading, native_normal(column, 0u, a.tau, scenery.core_normal));
                }
                if core(ray, light, t, body) {
                    return true;
                }
            }
            scene_leave();
        }
        if !passes {
            break;
        }
        let layer = select(*gap - 1u, *gap, rises);
        if scene_layer(ray, light, line, column, layer, b) {
            return true;
        }
        *gap = select(*gap - 1u, *gap + 1u, rises);
        u = end;
        on = select(1.0, 0.0, rises);
        if rises {
            low = high;
            high = facet_of(column, min(*gap, top - 1u));
        } else {
            high = low;
            low = facet_of(column, max(*gap, 1u) - 1u);
        }
    }
    return false;
}
