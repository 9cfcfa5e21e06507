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
    let rest = wide_sub(wide_sub(wide(1.0), wide(end.weight.x)), wide(end.weight.y));
    let second = wide_times(b, end.weight.x);
    let third = wide_times(c, end.weight.y);
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

// A value and its gradient at the ends of a path, and their bend.
struct Course {
    from_: vec4f,
    to: vec4f,
    kappa: vec4f,
}

// The course of values at the vertices below (first three) and above.
fn native_course(way: NativeWay, v: array<vec4f, 6>) -> Course {
    let ab = v[1] - v[0];
    let ac = v[2] - v[0];
    let ad = v[3] - v[0];
    let de = v[4] - v[3];
    let df = v[5] - v[3];
    let low = way.low.x * ab + way.low.y * ac;
    let low_rise = way.low.z * ab + way.low.w * ac - low;
    let high = way.high.x * de + way.high.y * df;
    let high_rise = way.high.z * de + way.high.w * df - high;
    let below = array<vec4f, 2>(low + way.u.x * low_rise, low + way.u.y * low_rise);
    let above = array<vec4f, 2>(
        high + way.u.x * high_rise + way.above.x * ad,
        high + way.u.y * high_rise + way.above.y * ad,
    );
    let rise = array<vec4f, 2>(above[0] - below[0], above[1] - below[1]);
    let start = select(below[0] + way.place.x * rise[0], above[0], way.place.x == 1.0);
    let end = select(below[1] + way.place.y * rise[1], above[1], way.place.y == 1.0);
    let kappa = (way.place.y - way.place.x) * (way.eps * rise[0] + (rise[0] - rise[1]));
    return Course(v[0] + start, v[0] + end, kappa);
}

// A field along a path of this length, from values and gradients at the vertices.
fn native_segment(way: NativeWay, v: array<vec4f, 6>, length: f32) -> FieldSegment {
    let course = native_course(way, v);
    var most = vec4f(0.0);
    var is_known = true;
    for (var k = 0u; k < 6u; k++) {
        most = max(most, abs(v[k]));
        is_known = is_known && !is_missing(v[k].x);
    }
    let size = max(max(most.x, 2.0 * most.x - 1.0), select(1.0, 0.0, HAS_STEPS));
    let kappa = course.kappa;
    return FieldSegment(
        Segment(course.from_.x, course.to.x, kappa.x, way.eps, length, size),
        FrustumInterpolant(course.from_.yzw, course.to.yzw, kappa.yzw, way.eps, largest(most.yzw)),
        is_known,
    );
}

// The field of the volume at the vertices around a gap.
fn native_own(bases: array<Base, 3>, gap: u32) -> array<vec4f, 6> {
    var v: array<vec4f, 6>;
    for (var k = 0u; k < 6u; k++) {
        let base = bases[k % 3u];
        let layer = gap - 1u + k / 3u;
        v[k].x = samples_get(base, layer);
        if IS_LIT {
            v[k] = vec4f(v[k].x, gradients_get(base, layer));
        }
    }
    return v;
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
    var normals: array<vec3f, 3>;
    for (var k = 0u; k < 3u; k++) {
        let at = first + 3u * column.cells[k];
        normals[k] = vec3f(surface_values[at], surface_values[at + 1u], surface_values[at + 2u]);
    }
    return normalize(normals[0] + weights.x * (normals[1] - normals[0]) + weights.y * (normals[2] - normals[0]));
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
                let is_hidden = scene_hides(line, column, way);
                let own = native_segment(way.layers, native_own(bases, *gap), length * part);
                if volumes_skip(!own.is_there) {
                    (*ray).frusta++;
                    (*ray).void_frusta += select(1u, 0u, is_hidden);
                    (*ray).is_in_span = false;
                } else {
                    if !is_hidden && volumes_enter(column, way, own) {
                        (*ray).void_frusta++;
                    }
                    if scene_frustum(ray, light, line, column, bases, way, own) {
                        return true;
                    }
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
