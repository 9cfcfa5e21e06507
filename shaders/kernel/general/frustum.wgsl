// Mirrors kernel/general/frustum.rs for one volume, which kernel/ray.wgsl integrates: what a ray meets beside it.
#import params
#import kernel/column
#import kernel/lit
#import kernel/ray
#import kernel/signature
#import kernel/general/clips
#import kernel/general/isosurfaces
#import kernel/general/surfaces

struct RayScene {
    // The stretch of the ray between bounds of cuts.
    stretch: Stretch,
    // Whether the ray is in what is cut away.
    is_cut: bool,
    // The surfaces that the ray has met and that are seen.
    surfaces: BoundarySignature,
    // Distances along the ray are from its point closest to the centre; this is the eye's.
    eye: Wide,
}

var<private> ray_scene: RayScene;

fn scene_begin(line: RayLine, eye: Wide3, dir: Wide3) {
    known_sides = 0u;
    ray_scene = RayScene(clips_behind(line, line.start), false, BoundarySignature(0u, 0.0), wide3_dot(eye, dir));
}

// The ray meets a boundary at `t`, behind matter that absorbs `alpha`.
fn scene_boundary(boundary: u32, alpha: f32, t: Wide) {
    if 1.0 - alpha > scenery.seen_above {
        ray_scene.surfaces = signature_push(ray_scene.surfaces, boundary, wide_apart(t, ray_scene.eye));
    }
}

// The fraction of the frustum at which the stretch ends; 1 where it goes on behind.
fn stretch_end(column: Column, way: GapWay) -> f32 {
    let rough = wide_apart(ray_scene.stretch.end, column.entry.t);
    let length = wide_apart(column.exit.t, column.entry.t);
    // More than rounding does to a fraction of the column.
    if !(rough < (way.b.u + 1e-5) * length) {
        return 1.0;
    }
    let u = wide_div(wide_sub(ray_scene.stretch.end, column.entry.t), wide_sub(column.exit.t, column.entry.t));
    return clamp(wide_apart(u, column_fraction(column, way.a)) / max(way.part, 1e-30), 0.0, 1.0);
}

// The fraction of the column at a point, to all digits.
fn column_fraction(column: Column, at: RayPoint) -> Wide {
    if at.u <= 0.0 {
        return wide(0.0);
    }
    return wide_div(wide_sub(at.rho, column.entry.rho), wide_sub(column.exit.rho, column.entry.rho));
}

// Whether the whole frustum is cut away.
fn scene_hides(line: RayLine, column: Column, way: GapWay) -> bool {
    while stretch_end(column, way) <= 0.0 && may_step() {
        ray_scene.stretch = clips_behind(line, ray_scene.stretch.end);
    }
    let is_hidden = stretch_end(column, way) >= 1.0 && !clips_show(ray_scene.stretch.inside, way.gap - 1u, way.gap);
    ray_scene.is_cut = ray_scene.is_cut || is_hidden;
    return is_hidden;
}

// Whether the volume may be seen between two layers.
fn scene_is_visible(bases: array<Base, 3>, gap: u32) -> bool {
    var low = ENDLESS;
    var high = -ENDLESS;
    for (var k = 0u; k < 3u; k++) {
        for (var i = 0u; i < 2u; i++) {
            let value = samples_get(bases[k], gap - i);
            low = min(low, value);
            high = max(high, value);
        }
    }
    if low == high {
        let span = spans[spans_search(low)];
        return span.is_clear == 0u && span_extinction(span, low) != 0.0;
    }
    for (var k = 0u; k < params.spans; k++) {
        if spans[k].is_clear == 0u && spans[k].high > low && spans[k].low < high {
            return true;
        }
    }
    return false;
}

// A shown part of a frustum, in fractions of the whole.
struct FrustumPart {
    from_: f32,
    to: f32,
    is_there: bool,
}

// The next shown part of a frustum behind the fraction `from_`.
fn scene_next_part(line: RayLine, column: Column, way: GapWay, from_: f32) -> FrustumPart {
    var start = from_;
    while start < 1.0 && may_step() {
        let end = max(stretch_end(column, way), start);
        let is_shown = clips_show(ray_scene.stretch.inside, way.gap - 1u, way.gap);
        if end < 1.0 {
            ray_scene.stretch = clips_behind(line, ray_scene.stretch.end);
        }
        if end > start {
            if is_shown {
                return FrustumPart(start, end, true);
            }
            ray_scene.is_cut = true;
        }
        start = end;
    }
    return FrustumPart(1.0, 1.0, false);
}

// A face of the volume where a part begins behind what is cut away.
fn scene_cut_face(column: Column, bases: array<Base, 3>, way: GapWay, from_: f32, alpha: f32) {
    if ray_scene.is_cut && scene_is_visible(bases, way.gap) {
        let length = wide_apart(column.exit.t, column.entry.t);
        let t = wide_add(column.entry.t, wide((way.a.u + from_ * way.part) * length));
        scene_boundary(BOUNDARY_CUT_FACE, alpha, t);
        ray_scene.is_cut = false;
    }
}

// The gradient along a part of a frustum.
fn frustum_interpolant_part(whole: FrustumInterpolant, from_: f32, to: f32) -> FrustumInterpolant {
    let r0 = 1.0 + whole.eps * from_;
    let r1 = 1.0 + whole.eps * to;
    let du = to - from_;
    return FrustumInterpolant(
        frustum_interpolant_gradient(whole, from_),
        frustum_interpolant_gradient(whole, to),
        whole.kappa * (du * du * (1.0 + whole.eps) / (r0 * r0 * r1)),
        whole.eps * du / r0,
    );
}

// The volume and isosurfaces in a frustum, as far as they are shown; true where the ray ends. Without values `own` is not
// there.
fn scene_frustum(
    ray: ptr<function, Ray>,
    light: ptr<function, Radiance>,
    line: RayLine,
    column: Column,
    bases: array<Base, 3>,
    way: GapWay,
    own: FieldSegment,
) -> bool {
    let frusta = (*ray).frusta + 1u;
    find_crossings(column, way, own);
    let segment = own.segment;
    var next = 0u;
    var start = 0.0;
    var shown_to = 0.0;
    var is_over = false;
    while !is_over {
        if shown_to > 0.0 && next < crossing_count && crossings[next].u <= start {
            is_over = scene_isosurface(ray, light, crossings[next], column, way, own);
            next++;
        } else if start < shown_to {
            var end = shown_to;
            if next < crossing_count {
                end = min(end, crossings[next].u);
            }
            if own.is_there {
                var shown = segment;
                var course = own.interpolant;
                if start > 0.0 || end < 1.0 {
                    shown = segment_part(segment, segment_place(segment, start), segment_place(segment, end));
                    if IS_LIT {
                        course = frustum_interpolant_part(own.interpolant, start, end);
                    }
                }
                is_over = frustum(ray, light, shown, course);
                scene_rounded_ends(light, segment.length, shown, FrustumPart(start, end, true));
            }
            start = end;
        } else {
            let part = scene_next_part(line, column, way, shown_to);
            if !part.is_there {
                break;
            }
            if own.is_there {
                scene_cut_face(column, bases, way, part.from_, (*light).alpha);
            }
            start = part.from_;
            shown_to = part.to;
            while next < crossing_count && crossings[next].u < start {
                next++;
            }
        }
    }
    (*ray).frusta = frusta;
    return is_over;
}

// The ray passes where there is no field: on which side of a surface it comes out is open.
fn scene_leave() {
    known_sides = 0u;
}

// An isosurface that the ray meets; true where it ends.
fn scene_isosurface(
    ray: ptr<function, Ray>,
    light: ptr<function, Radiance>,
    crossing: IsosurfaceCrossing,
    column: Column,
    way: GapWay,
    own: FieldSegment,
) -> bool {
    let found = isosurface_color((*ray).shading, crossing, column, way, own);
    if !found.is_there {
        return false;
    }
    let length = wide_apart(column.exit.t, column.entry.t);
    let t = wide_add(column.entry.t, wide((way.a.u + crossing.u * way.part) * length));
    scene_boundary((crossing.surface << 2u) | 3u, (*light).alpha, t);
    let opacity = scenery.isosurfaces[crossing.surface].opacity;
    var here = radiance_plain(found.color, opacity);
    let off = opacity * (found.off + 4.0 * ROUNDING);
    here.variance = off * off;
    if own.is_there {
        // Matter that is before the surface where it may be behind.
        let f = segment_value(own.segment, crossing.u);
        let depth = crossing.off * own.segment.length * span_extinction(spans[spans_search(f)], f);
        let shifted = opacity * absorbed_by(depth);
        here.variance += shifted * shifted;
    }
    radiance_over(light, here);
    return scene_ends(ray, light);
}

// A fraction of a segment, and the value there.
fn segment_place(segment: Segment, u: f32) -> vec2f {
    if u >= 1.0 {
        return vec2f(1.0, segment.f1);
    }
    return vec2f(u, select(segment_value(segment, u), segment.f0, u <= 0.0));
}

// What rounding of the ends of a part does to the light, behind it: a frustum has `length`.
fn scene_rounded_ends(light: ptr<function, Radiance>, length: f32, segment: Segment, part: FrustumPart) {
    for (var i = 0u; i < 2u; i++) {
        let is_end = i == 1u;
        if select(part.from_ > 0.0, part.to < 1.0, is_end) {
            let f = select(segment.f0, segment.f1, is_end);
            let shift = 2.0 * ROUNDING * length;
            let off = (1.0 - (*light).alpha) * absorbed_by(shift * span_extinction(spans[spans_search(f)], f));
            (*light).variance += off * off;
        }
    }
}

// The surfaces on a layer that the ray crosses; true where it ends.
fn scene_layer(
    ray: ptr<function, Ray>,
    light: ptr<function, Radiance>,
    line: RayLine,
    column: Column,
    layer: u32,
    at: RayPoint,
) -> bool {
    let first = scene_first_surface(layer);
    if first == scenery.surface_layer_count {
        return false;
    }
    let t = wide_add(column.entry.t, wide(at.u * wide_apart(column.exit.t, column.entry.t)));
    while wide_less(ray_scene.stretch.end, t) && may_step() {
        ray_scene.stretch = clips_behind(line, ray_scene.stretch.end);
    }
    if !clips_show(ray_scene.stretch.inside, layer, layer) {
        return false;
    }
    var body = 1.0;
    if IS_LIT {
        body = surface_body((*ray).shading, normalize(ray_line_position(line, t).hi));
    }
    for (var k = first; k < scenery.surface_layer_count; k++) {
        let surface = scenery.surface_layers[k];
        if surface.layer != layer {
            continue;
        }
        var here = radiance_none();
        var painted = 0u;
        for (var m = 0u; m < surface.material_count; m++) {
            let material = scenery.materials[surface.first_material + m];
            let color = material_on_layer(material, column, at.tau);
            if color.is_there {
                painted |= 1u << m;
                var coat = radiance_plain(color.color * body, material.opacity);
                let off = material.opacity * (body * color.off + 4.0 * ROUNDING);
                coat.variance = off * off;
                radiance_over(&here, coat);
            }
        }
        if painted != 0u {
            scene_boundary(boundary_surface_layer(k, painted), (*light).alpha, t);
            radiance_over(light, here);
        }
    }
    return scene_ends(ray, light);
}

// The first of the surfaces on a layer; their number where there is none.
fn scene_first_surface(layer: u32) -> u32 {
    for (var k = 0u; k < scenery.surface_layer_count; k++) {
        if scenery.surface_layers[k].layer == layer {
            return k;
        }
    }
    return scenery.surface_layer_count;
}

// Whether the ray ends behind a surface.
fn scene_ends(ray: ptr<function, Ray>, light: ptr<function, Radiance>) -> bool {
    let through = 1.0 - (*light).alpha;
    if through > ray_min_transmittance(ray) * 1.001 + 2.0 * ROUNDING {
        return false;
    }
    (*light).error += through * params.brightest;
    return true;
}
