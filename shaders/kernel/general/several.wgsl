// Mirrors kernel/packet/several.rs: the frusta of a scene of several volumes, or of one whose opacity is that of
// another field. A piece of each volume extends to the next knot of any of the transfer functions. Steps of these, for
// which the CPU uses double precision, are crossed here too; the error includes the effect of rounding on them.
#import params
#import scenery
#import kernel/column
#import kernel/lit
#import kernel/ray
#import kernel/general/blend
#import kernel/general/isosurfaces
#import kernel/general/maps

// The gradients along the frustum.
var<private> volume_interpolants: array<FrustumInterpolant, MAX_VOLUMES>;
// Bits of the volumes: whether all of their values exist, and whether they may be visible in the frustum.
var<private> known_volumes: u32;
var<private> seen_volumes: u32;

fn is_seen(volume: u32) -> bool {
    return (seen_volumes & (1u << volume)) != 0u;
}

fn volumes_skip(is_void: bool) -> bool {
    return false;
}

// Enters a frustum that is not cut away as a whole; returns true if each volume misses a value.
fn volumes_enter(column: Column, way: GapWay, own: FieldSegment) -> bool {
    known_volumes = 0u;
    seen_volumes = 0u;
#volume     volume_enter(VOLUMEu, column, way, own);
    return known_volumes == 0u;
}

fn volume_enter(volume: u32, column: Column, way: GapWay, own: FieldSegment) {
    let k = 2u * volume;
    if !map_enter(k, column, way, own) {
        return;
    }
    if color_map_of(volume) != k && !map_enter(k + 1u, column, way, own) {
        return;
    }
    known_volumes |= 1u << volume;
    let whole = map_states[k].whole;
    let span = spans[map_follow(scenery.maps[k], scenery.maps[k].first_span, whole.f0, whole.f1 < whole.f0)];
    if span.is_clear != 0u && span_holds(span, whole) {
        return;
    }
    seen_volumes |= 1u << volume;
    if IS_LIT {
        volume_interpolants[volume] = own.interpolant;
        let field = scenery.maps[k].field;
        if field != OWN_FIELD {
            let lit = scene_field_segment(field, column, way, own.segment.eps, own.segment.length, true);
            volume_interpolants[volume] = lit.interpolant;
        }
    }
}

// Whether any volume may be visible between two layers.
fn volumes_are_visible(column: Column, bases: array<Base, 3>, gap: u32, own: FieldSegment) -> bool {
    for (var v = 0u; v < scenery.volume_count; v++) {
        if (known_volumes & (1u << v)) != 0u && volume_is_visible(v, column, bases, gap) {
            return true;
        }
    }
    return false;
}

fn volume_is_visible(volume: u32, column: Column, bases: array<Base, 3>, gap: u32) -> bool {
    let map = scenery.maps[2u * volume];
    var range = vec2f(0.0);
    if map.field == OWN_FIELD {
        range = samples_range(bases, gap);
    } else {
        range = scene_field_range(scenery.fields[map.field], column, gap);
    }
    if range.x == range.y {
        let span = spans[map_follow(map, map.first_span, range.x, false)];
        return span.is_clear == 0u && span_extinction(span, range.x) != 0.0;
    }
    for (var k = map.first_span; k < map.first_span + map.span_count; k++) {
        if spans[k].is_clear == 0u && spans[k].high > range.x && spans[k].low < range.y {
            return true;
        }
    }
    return false;
}

// Extinction of all volumes at a place of the frustum.
fn volumes_extinction(own: FieldSegment, u: f32) -> f32 {
    var sum = 0.0;
    for (var v = 0u; v < scenery.volume_count; v++) {
        if is_seen(v) {
            sum += map_extinction(2u * v, segment_place(map_states[2u * v].whole, u).y);
        }
    }
    return sum;
}

fn is_dark(volume: u32) -> bool {
    return spans[map_states[2u * volume].span].is_clear != 0u;
}

fn volume_piece(volume: u32) -> VolumePiece {
    let k = 2u * volume;
    let c = color_map_of(volume);
    return VolumePiece(map_states[k].piece, map_states[k].span, map_states[c].piece, map_states[c].span);
}

// Sums over the volumes on their pieces.
struct VolumeSums {
    mixture: Mixture,
    // Optical depths of the pieces and of their first halves.
    depth: f32,
    front: f32,
    // Extinctions at the three places, and their slopes at the ends.
    rates: vec3f,
    thickening: vec2f,
    // Length of the pieces, and relative change of height along them.
    length: f32,
    eps: f32,
    // Rounding errors of colours and of the optical depth.
    rounds: vec2f,
    // Absorbed light, and the errors of shades (as in ShadedColors) times that.
    absorbed: f32,
    shade_off: vec3f,
}

// The light of all volumes on their pieces, which are `range` of the frustum.
fn volumes_blend(shading: RayShading, range: vec2f) -> Blend {
    var sums = VolumeSums(
        mixture_none(), 0.0, 0.0, vec3f(0.0), vec2f(0.0), 0.0, 0.0, vec2f(0.0), 0.0, vec3f(0.0),
    );
#volume     volume_add(VOLUMEu, &sums);
    let through = 1.0 - vec2f(absorbed_by(sums.front), absorbed_by(sums.depth));
    if IS_LIT {
        let growth = growth_of(sums.rates, sums.length, sums.depth, sums.eps);
        var fading = Fading(through, sums.rates.xz * sums.length, growth, 0.0);
        let seen = sums.length * nodes_mean(faded(sums.rates, sums.thickening, fading));
        fading.unseen = abs(seen / max(absorbed_by(sums.depth), LEAST) - 1.0);
#volume         volume_add_lit(VOLUMEu, &sums, shading, fading, range);
    }
    var shade = sums.shade_off / max(sums.absorbed, LEAST);
    // All parts of a frustum share the rounding of the gradients at its vertices.
    shade.z /= sqrt(max(range.y - range.x, LEAST_PART));
    return blend_of(sums.mixture, sums.depth, through, sums.rounds, shade);
}

fn volume_add(volume: u32, sums: ptr<function, VolumeSums>) {
    if !is_seen(volume) || is_dark(volume) {
        return;
    }
    let piece = volume_piece(volume);
    let depths = volume_depths(piece);
    (*sums).depth += depths.whole;
    (*sums).front += depths.front;
    (*sums).rates += depths.extinction;
    (*sums).thickening += depths.thickening;
    (*sums).length = piece.extinction.length;
    (*sums).eps = abs(piece.extinction.eps);
    let slope = abs(spans[piece.extinction_span].extinction_slope);
    (*sums).rounds.y += piece.extinction.length * slope * segment_reach(piece.extinction);
    (*sums).rounds.x = max((*sums).rounds.x, spans[piece.color_span].steepest * segment_reach(piece.color));
    if !IS_LIT {
        (*sums).mixture = mixture_and((*sums).mixture, depths, volume_colors(piece), piece.extinction);
    }
}

fn volume_add_lit(
    volume: u32,
    sums: ptr<function, VolumeSums>,
    shading: RayShading,
    fading: Fading,
    range: vec2f,
) {
    if !is_seen(volume) || is_dark(volume) {
        return;
    }
    let piece = volume_piece(volume);
    let depths = volume_depths(piece);
    let course = volume_interpolants[volume];
    let at = mat3x3f(
        frustum_interpolant_gradient(course, range.x),
        frustum_interpolant_gradient(course, 0.5 * (range.x + range.y)),
        frustum_interpolant_gradient(course, range.y),
    );
    let lit = volume_shade(shading, piece, depths, volume_colors(piece), fading, at, course.size);
    (*sums).shade_off += lit.absorbed * lit.off;
    (*sums).absorbed += lit.absorbed;
    (*sums).mixture = mixture_and((*sums).mixture, depths, lit.color, piece.extinction);
}

// A piece that is no longer than this fraction of the rest, or of its frustum, is taken as it is.
const LEAST_FRACTION: f32 = 1e-4;
const LEAST_PART: f32 = 1e-5;

// Integrates the volumes over a part of the frustum; returns true if the ray ends.
fn volumes_light(ray: ptr<function, Ray>, light: ptr<function, Radiance>, own: FieldSegment, part: FrustumPart) -> bool {
    if seen_volumes == 0u {
        return false;
    }
#volume     map_begin(2u * VOLUMEu, part);
#volume     map_begin(2u * VOLUMEu + 1u, part);
    var cut = -1.0;
    var fraction = 1.0;
    var from_ = part.from_;
    var is_over = false;
    var is_whole = false;
    var halvings = 0u;
    while !is_over && !is_whole && !is_lost {
        if cut < 0.0 {
            cut = 1.0;
#volume             cut = min(cut, volume_cut(VOLUMEu));
        }
        let upto = cut * fraction;
#volume         volume_end_at(VOLUMEu, upto);
        let to = from_ + upto * (part.to - from_);
        let blend = volumes_blend((*ray).shading, vec2f(from_, to));
        if blend_is_far(blend, *light) && fraction > LEAST_FRACTION && to - from_ > LEAST_PART && may_halve(halvings, to) {
            halvings++;
            fraction *= 0.5;
            continue;
        }
        is_whole = upto >= 1.0;
        let through = 1.0 - (*light).alpha;
        if blend.light.alpha > 0.0 {
            radiance_over(light, blend.light);
            let off = 0.5 * ROUNDING * (*light).alpha;
            (*light).variance += off * off;
            is_over = scene_ends(ray, light);
        }
        if HAS_STEPS && fraction == 1.0 {
            for (var k = 0u; k < 2u * scenery.volume_count; k++) {
                if is_seen(k >> 1u) {
                    (*light).variance += map_step_variance(k, to, through);
                }
            }
        }
#volume         volume_go_on(VOLUMEu);
        fraction = min(2.0 * fraction, 1.0);
        cut = -1.0;
        from_ = to;
    }
    if HAS_STEPS {
        for (var k = 0u; k < 2u * scenery.volume_count; k++) {
            if is_seen(k >> 1u) {
                map_near_steps(k, light);
            }
        }
    }
    return is_over;
}

fn volume_cut(volume: u32) -> f32 {
    if !is_seen(volume) {
        return 1.0;
    }
    let k = 2u * volume;
    var upto = map_cut(k);
    if color_map_of(volume) != k {
        map_states[k + 1u].end.x = 2.0;
        if !is_dark(volume) {
            upto = min(upto, map_cut(k + 1u));
        }
    }
    return upto;
}

fn volume_end_at(volume: u32, upto: f32) {
    if is_seen(volume) {
        map_end_at(2u * volume, upto);
        if color_map_of(volume) != 2u * volume {
            map_end_at(2u * volume + 1u, upto);
        }
    }
}

fn volume_go_on(volume: u32) {
    if is_seen(volume) {
        map_go_on(2u * volume);
        if color_map_of(volume) != 2u * volume {
            map_go_on(2u * volume + 1u);
        }
    }
}
