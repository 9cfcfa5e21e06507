// Mirrors the treatment of isosurfaces in kernel/general/frustum.rs. In f32 two columns each find the value on the side
// between them to some roundings: the side of a surface that contains the ray is carried from frustum to frustum, so
// that none is met twice or missed.
#import params
#import scenery
#import kernel/ray
#import kernel/general/surfaces

// A frustum's path through a gap: from `a` to `b`, the fraction `part` of the column.
struct GapWay {
    gap: u32,
    a: RayPoint,
    b: RayPoint,
    part: f32,
#native     // The fraction of the column at `a`.
#native     start: Wide,
#native     layers: NativeWay,
}

// A place at which a frustum meets an isosurface or a sphere.
struct IsosurfaceCrossing {
    u: f32,
    // The number of the isosurface, or MAX_SURFACES and that of the surface layer.
    surface: u32,
    // Rounding error of `u`.
    off: f32,
}

// The crossings of a frustum, in order.
var<private> crossings: array<IsosurfaceCrossing, 3u * MAX_SURFACES>;
var<private> crossing_count: u32;

// Bits of the isosurfaces: the side on which the ray is, and whether it is known.
var<private> sides: u32;
var<private> known_sides: u32;

// Values of a field along a frustum, if none is missing.
struct FieldSegment {
    segment: Segment,
    interpolant: FrustumInterpolant,
    is_there: bool,
}

fn scene_field_chord(field: SceneField, column: Column, layer: u32, has_gradients: bool) -> Chord {
    let at = column.cells * params.layers + layer;
    let first = field.first_value;
    let values = vec3f(surface_values[first + at.x], surface_values[first + at.y], surface_values[first + at.z]);
    var chord = chord_over(values, column.entry.weight, column.exit.weight);
    if has_gradients {
        let a = scene_gradient(field, at.x);
        let b = scene_gradient(field, at.y);
        let c = scene_gradient(field, at.z);
        chord_over_gradients(&chord, a, b, c, column.entry.weight, column.exit.weight);
    }
    return chord;
}

// Least and greatest of a field's values around a gap.
fn scene_field_range(field: SceneField, column: Column, gap: u32) -> vec2f {
    var range = vec2f(ENDLESS, -ENDLESS);
    for (var k = 0u; k < 3u; k++) {
        let at = field.first_value + column.cells[k] * params.layers + gap;
        range.x = min(range.x, min(surface_values[at - 1u], surface_values[at]));
        range.y = max(range.y, max(surface_values[at - 1u], surface_values[at]));
    }
    return range;
}

fn scene_gradient(field: SceneField, at: u32) -> vec3f {
    return surface_vector(field.first_gradient + 3u * at);
}

fn surface_vector(at: u32) -> vec3f {
    return vec3f(surface_values[at], surface_values[at + 1u], surface_values[at + 2u]);
}

// A field beside the volume's along a frustum.
fn scene_field_segment(number: u32, column: Column, way: GapWay, eps: f32, length: f32, has_gradients: bool) -> FieldSegment {
    let field = scenery.fields[number];
#native     return native_segment(way.layers, native_field(field, column, way.gap, has_gradients), length);
#concentric     let below = scene_field_chord(field, column, way.gap - 1u, has_gradients);
#concentric     let above = scene_field_chord(field, column, way.gap, has_gradients);
#concentric     let at_a = chord_mix(below, above, shell_fraction(way.gap, way.a.rho));
#concentric     let at_b = chord_mix(below, above, shell_fraction(way.gap, way.b.rho));
#concentric     let slope_a = at_a.exit - at_a.entry;
#concentric     let slope_b = at_b.exit - at_b.entry;
#concentric     let kappa = (way.b.tau - way.a.tau) * ((slope_a - slope_b) + eps * slope_a);
#concentric     let size = max(below.size, above.size);
#concentric     let segment = Segment(chord_at(at_a, way.a.tau), chord_at(at_b, way.b.tau), kappa, eps, length, size);
#concentric     var found = FieldSegment(segment, FrustumInterpolant(vec3f(0.0), vec3f(0.0), vec3f(0.0), 0.0, 0.0), true);
#concentric     found.is_there = !(below.is_void || above.is_void);
#concentric     if has_gradients {
#concentric         found.interpolant = frustum_interpolant_over(at_a, at_b, way.a.tau, way.b.tau, eps);
#concentric     }
#concentric     return found;
}

// Finds the crossings of a frustum; `own` is the volume's field there.
fn find_crossings(column: Column, way: GapWay, own: FieldSegment) {
    crossing_count = 0u;
    for (var k = 0u; k < scenery.isosurface_count; k++) {
        let field = scenery.isosurfaces[k].field;
        var found = own;
        if field != OWN_FIELD {
            found = scene_field_segment(field, column, way, own.segment.eps, own.segment.length, false);
        }
        let bit = 1u << k;
        if found.is_there {
            find_crossings_of(k, scenery.isosurfaces[k].value, found.segment);
            known_sides |= bit;
        } else {
            known_sides &= ~bit;
        }
    }
    for (var k = 0u; k < select(0u, scenery.surface_layer_count, scenery.sphere_count > 0u); k++) {
        let surface = scenery.surface_layers[k];
        let radius = Wide(surface.radius.x, surface.radius.y);
        let is_sphere = surface.layer == AT_RADIUS;
        if is_sphere && wide_less(way.a.rho, radius) != wide_less(way.b.rho, radius) {
            let u = wide_apart(radius, way.a.rho) / wide_apart(way.b.rho, way.a.rho);
            crossing_insert(IsosurfaceCrossing(clamp(u, 0.0, 1.0), MAX_SURFACES + k, 4.0 * ROUNDING));
        }
    }
}

fn find_crossings_of(k: u32, value: f32, segment: Segment) {
    let bit = 1u << k;
    let least = value - 4.0 * ROUNDING * (1.0 + abs(value));
    var is_above = segment.f0 >= least;
    if (known_sides & bit) != 0u {
        is_above = (sides & bit) != 0u;
    }
    let turn = segment_extremum(segment);
    var start = vec2f(0.0, segment.f0);
    for (var i = 0u; i < select(1u, 2u, turn.is_there); i++) {
        var end = vec2f(1.0, segment.f1);
        if turn.is_there && i == 0u {
            end = vec2f(turn.u, turn.f);
        }
        if (end.y >= least) != is_above {
            is_above = !is_above;
            // If rounding of the start has put it on this side before, the surface lies at the start.
            var u = start.x;
            if (start.y >= least) != is_above {
                let part = segment_part(segment, start, end);
                let within = clamp(value, min(part.f0, part.f1), max(part.f0, part.f1));
                u = lerp(start.x, end.x, segment_solve(part, within));
            }
            crossing_insert(IsosurfaceCrossing(u, k, crossing_off(segment, u)));
        }
        start = end;
    }
    sides = select(sides & ~bit, sides | bit, is_above);
}

// The effect of rounding of values on the place of a crossing: largest if the ray grazes the surface.
fn crossing_off(segment: Segment, u: f32) -> f32 {
    let reach = 4.0 * segment_reach(segment);
    let slope = abs(segment.f1 - segment.f0 + segment.kappa * (1.0 - 2.0 * u));
    return min(reach / (slope + sqrt(reach * (abs(segment.kappa) + reach))), 1.0);
}

fn crossing_insert(crossing: IsosurfaceCrossing) {
    var at = crossing_count;
    while at > 0u && crossings[at - 1u].u > crossing.u {
        crossings[at] = crossings[at - 1u];
        at--;
    }
    crossings[at] = crossing;
    crossing_count++;
}

// The colour of a field's value at a place of a frustum: `map` are the index of the first span and the number of spans.
fn frustum_color(
    field: u32,
    map: vec2u,
    to_spans: vec2f,
    u: f32,
    column: Column,
    way: GapWay,
    own: FieldSegment,
) -> SurfaceColor {
    var colors = own;
    if field != OWN_FIELD {
        colors = scene_field_segment(field, column, way, own.segment.eps, own.segment.length, false);
    }
    if !colors.is_there {
        return SurfaceColor(vec3f(0.0), 0.0, false);
    }
    let value = segment_value(colors.segment, u);
    let size = abs(colors.segment.f0) + abs(colors.segment.f1) + abs(value);
    let reach = 4.0 * ROUNDING * (size * abs(to_spans.x) + abs(to_spans.y));
    return spans_color(map.x, map.y, to_spans.x * value + to_spans.y, reach);
}

// A colour of an isosurface, with the light that it reflects; undefined if the value that colours it is missing.
fn isosurface_color(
    shading: RayShading,
    crossing: IsosurfaceCrossing,
    column: Column,
    way: GapWay,
    own: FieldSegment,
) -> SurfaceColor {
    let surface = scenery.isosurfaces[crossing.surface];
    var found = SurfaceColor(surface.color, 0.0, true);
    if surface.kind == MATERIAL_FIELD {
        let map = vec2u(surface.first_span, surface.span_count);
        let to_spans = vec2f(surface.scale, surface.shift);
        found = frustum_color(surface.color_field, map, to_spans, crossing.u, column, way, own);
        if !found.is_there {
            return found;
        }
    }
    if IS_LIT {
        var course = own.interpolant;
        if surface.field != OWN_FIELD {
            let lit = scene_field_segment(surface.field, column, way, own.segment.eps, own.segment.length, true);
            course = lit.interpolant;
        }
        let gradient = frustum_interpolant_gradient(course, crossing.u);
        let shade = ray_shading_shade(shading, gradient);
        found.color = found.color * shade.body + vec3f(shade.highlight);
        // Normals are rounded to f32.
        let turned = ray_shading_deviation(shading, course.size, largest(abs(gradient)));
        let rounded = ROUNDING * (1.0 + shading.sharpness);
        found.off = found.off * shade.body + 4.0 * sqrt(rounded * rounded + turned * turned);
    }
    return found;
}
