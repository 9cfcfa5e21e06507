// Mirrors kernel/general/frustum.rs: the parts of a scene beside volumes that a ray meets.
#import params
#import kernel/column
#import kernel/lit
#import kernel/ray
#import kernel/signature
#import kernel/general/clips
#import kernel/general/isosurfaces
#import kernel/general/surfaces
#single #import kernel/general/single
#several #import kernel/general/several

struct RayScene {
    // The stretch of the ray between bounds of cuts.
    stretch: Stretch,
    // Whether the ray is in space that is cut away.
    is_cut: bool,
    // The visible surfaces that the ray has met.
    surfaces: BoundarySignature,
    // Distances along the ray are from its point closest to the centre; this is the eye's.
    eye: Wide,
}

var<private> ray_scene: RayScene;

fn scene_begin(line: RayLine, eye: Wide3, dir: Wide3) {
    known_sides = 0u;
    // The first frustum or layer moves on from a stretch that ends well before the ray.
    let before = Stretch(0u, wide_sub(line.start, wide(1.0)));
    ray_scene = RayScene(before, false, BoundarySignature(0u, 0.0), wide3_dot(eye, dir));
}

// Begins a new run of columns.
fn scene_restart() {
    known_sides = 0u;
    ray_scene.is_cut = false;
}

// Records a boundary at `t`, behind matter that absorbs `alpha`.
fn scene_boundary(boundary: u32, alpha: f32, t: Wide) {
    if 1.0 - alpha > scenery.seen_above {
        ray_scene.surfaces = signature_push(ray_scene.surfaces, boundary, wide_apart(t, ray_scene.eye));
    }
}

// The fraction of the frustum at which the stretch ends; 1 if it continues behind.
fn stretch_end(column: Column, way: GapWay) -> f32 {
    let rough = wide_apart(ray_scene.stretch.end, column.entry.t);
    let length = wide_apart(column.exit.t, column.entry.t);
    // More than the rounding of a fraction of the column.
    if !(rough < (way.b.u + 1e-5) * length) {
        return 1.0;
    }
    let u = wide_div(wide_sub(ray_scene.stretch.end, column.entry.t), wide_sub(column.exit.t, column.entry.t));
#concentric     let start = column_fraction(column, way.a);
#native     let start = way.start;
    return clamp(wide_apart(u, start) / max(way.part, 1e-30), 0.0, 1.0);
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

// Passes a gap with the volume's field `own` in it; returns true if the ray ends.
fn scene_gap(
    ray: ptr<function, Ray>,
    light: ptr<function, Radiance>,
    line: RayLine,
    column: Column,
    bases: array<Base, 3>,
    way: GapWay,
    own: FieldSegment,
) -> bool {
    let is_hidden = scene_hides(line, column, way);
    if volumes_skip(!own.is_there) {
        (*ray).frusta++;
        (*ray).void_frusta += select(1u, 0u, is_hidden);
        (*ray).is_in_span = false;
        return false;
    }
    if !is_hidden && volumes_enter(column, way, own) {
        (*ray).void_frusta++;
    }
    return scene_frustum(ray, light, line, column, bases, way, own);
}

// Least and greatest of the volume's values around a gap.
fn samples_range(bases: array<Base, 3>, gap: u32) -> vec2f {
    var range = vec2f(ENDLESS, -ENDLESS);
    for (var k = 0u; k < 3u; k++) {
        for (var i = 0u; i < 2u; i++) {
            let value = samples_get(bases[k], gap - i);
            range = vec2f(min(range.x, value), max(range.y, value));
        }
    }
    return range;
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

// Adds a face of a volume if a part begins behind a cut.
fn scene_cut_face(column: Column, bases: array<Base, 3>, way: GapWay, own: FieldSegment, from_: f32, alpha: f32) {
    if !ray_scene.is_cut {
        return;
    }
    let is_face = volumes_are_visible(column, bases, way.gap, own);
    if is_face {
        let length = wide_apart(column.exit.t, column.entry.t);
        let t = wide_add(column.entry.t, wide((way.a.u + from_ * way.part) * length));
        scene_boundary(BOUNDARY_CUT_FACE, alpha, t);
    }
    ray_scene.is_cut = !is_face && crossing_count + scenery.sphere_count == 0u;
}

// Adds volumes and isosurfaces in a frustum, as far as they are shown; returns true if the ray ends. Without values
// `own` is undefined.
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
    var next = 0u;
    var start = 0.0;
    var shown_to = 0.0;
    var is_over = false;
    while !is_over {
        if shown_to > 0.0 && next < crossing_count && crossings[next].u <= start {
            let crossing = crossings[next];
            // Optical depth of matter before the surface that may be behind it.
            let depth = crossing.off * own.segment.length * volumes_extinction(own, crossing.u);
            if crossing.surface < MAX_SURFACES {
                is_over = scene_isosurface(ray, light, crossing, column, way, own, depth);
            } else {
                is_over = scene_sphere(ray, light, line, crossing, column, way, own, depth);
            }
            next++;
        } else if start < shown_to {
            var end = shown_to;
            if next < crossing_count {
                end = min(end, crossings[next].u);
            }
            let part = FrustumPart(start, end, true);
            is_over = volumes_light(ray, light, own, part);
            scene_rounded_ends(light, own, part);
            start = end;
        } else {
            let part = scene_next_part(line, column, way, shown_to);
            if !part.is_there {
                break;
            }
            scene_cut_face(column, bases, way, own, part.from_, (*light).alpha);
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

// The ray passes space without a field: the side of a surface on which it leaves that is unknown.
fn scene_leave() {
    known_sides = 0u;
}

// Adds an isosurface that the ray meets; returns true if the ray ends.
fn scene_isosurface(
    ray: ptr<function, Ray>,
    light: ptr<function, Radiance>,
    crossing: IsosurfaceCrossing,
    column: Column,
    way: GapWay,
    own: FieldSegment,
    depth: f32,
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
    let shifted = opacity * absorbed_by(depth);
    here.variance += shifted * shifted;
    radiance_over(light, here);
    return scene_ends(ray, light);
}

// Adds a sphere between layers that the ray meets; returns true if the ray ends.
fn scene_sphere(
    ray: ptr<function, Ray>,
    light: ptr<function, Radiance>,
    line: RayLine,
    crossing: IsosurfaceCrossing,
    column: Column,
    way: GapWay,
    own: FieldSegment,
    depth: f32,
) -> bool {
    let length = wide_apart(column.exit.t, column.entry.t);
    let t = wide_add(column.entry.t, wide((way.a.u + crossing.u * way.part) * length));
    var body = 1.0;
    if IS_LIT {
        body = surface_body((*ray).shading, normalize(ray_line_position(line, t).hi));
    }
    let number = crossing.surface - MAX_SURFACES;
    let surface = scenery.surface_layers[number];
#painted     if surface.is_painted != 0u {
#painted         run_paint(ray, light, t, number);
#painted     }
    var here = radiance_none();
    var painted = 0u;
    for (var m = 0u; m < surface.material_count; m++) {
        let material = scenery.materials[surface.first_material + m];
        var color = SurfaceColor(material.color, 0.0, true);
        if material.kind == MATERIAL_BETWEEN {
            let map = vec2u(material.first_span, material.span_count);
            let to_spans = vec2f(material.scale, material.shift);
            color = frustum_color(material.field, map, to_spans, crossing.u, column, way, own);
        }
        if color.is_there {
            painted |= 1u << m;
            scene_coat(&here, material, color, body);
        }
    }
    if painted != 0u {
        let shifted = here.alpha * absorbed_by(depth);
        here.variance += shifted * shifted;
        scene_boundary(boundary_surface_layer(number, painted), (*light).alpha, t);
        radiance_over(light, here);
    }
    return scene_ends(ray, light);
}

// Adds a surface of this colour, lit by `body`, behind those in `here`.
fn scene_coat(here: ptr<function, Radiance>, material: Material, color: SurfaceColor, body: f32) {
    var coat = radiance_plain(color.color * body, material.opacity);
    let off = material.opacity * (body * color.off + 4.0 * ROUNDING);
    coat.variance = off * off;
    radiance_over(here, coat);
}

// A fraction of a segment, and the value there.
fn segment_place(segment: Segment, u: f32) -> vec2f {
    if u >= 1.0 {
        return vec2f(1.0, segment.f1);
    }
    return vec2f(u, select(segment_value(segment, u), segment.f0, u <= 0.0));
}

// The effect on the light of rounding of the ends of a part of a frustum.
fn scene_rounded_ends(light: ptr<function, Radiance>, own: FieldSegment, part: FrustumPart) {
    for (var i = 0u; i < 2u; i++) {
        let is_end = i == 1u;
        if select(part.from_ > 0.0, part.to < 1.0, is_end) {
            let shift = 2.0 * ROUNDING * own.segment.length;
            let thicker = absorbed_by(shift * volumes_extinction(own, select(part.from_, part.to, is_end)));
            let off = (1.0 - (*light).alpha) * thicker;
            (*light).variance += off * off;
        }
    }
}

// Adds the surfaces on a layer that the ray crosses; returns true if the ray ends.
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
#concentric         let normal = normalize(ray_line_position(line, t).hi);
#native         let normal = native_normal(column, layer, at.tau, scenery.surface_layers[first].first_normal);
        body = surface_body((*ray).shading, normal);
    }
    for (var k = first; k < scenery.surface_layer_count; k++) {
        let surface = scenery.surface_layers[k];
        if surface.layer != layer {
            continue;
        }
#painted         if surface.is_painted != 0u {
#painted             run_paint(ray, light, t, k);
#painted         }
        var here = radiance_none();
        var painted = 0u;
        for (var m = 0u; m < surface.material_count; m++) {
            let material = scenery.materials[surface.first_material + m];
            let color = material_on_layer(material, column, layer, at.tau);
            if color.is_there {
                painted |= 1u << m;
                scene_coat(&here, material, color, body);
            }
        }
        if painted != 0u {
            scene_boundary(boundary_surface_layer(k, painted), (*light).alpha, t);
            radiance_over(light, here);
        }
    }
    return scene_ends(ray, light);
}

// The first of the surfaces on a layer; their number if there is none.
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
    if through > ray_rest(ray) {
        return false;
    }
    (*light).error += through * params.brightest;
    return true;
}
