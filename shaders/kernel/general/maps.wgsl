// A transfer function with its field along the current frustum. Mirrors kernel/packet/cut.rs.
#import params
#import scenery
#import kernel/column
#import kernel/ray
#import kernel/general/isosurfaces

// State of a transfer function's field along the current frustum.
struct MapState {
    whole: Segment,
    // The rest of the part that is integrated, and whether the value is monotone there, or behind `end`.
    rest: Segment,
    is_monotone: bool,
    is_monotone_behind: bool,
    // The piece, its span, and its end in `rest`: fraction and value.
    piece: Segment,
    span: u32,
    end: vec2f,
}

// Two of each volume, as in `scenery.maps`.
var<private> map_states: array<MapState, MAX_MAPS>;

// The number of the map of a volume's colour.
fn color_map_of(volume: u32) -> u32 {
    return 2u * volume + select(0u, 1u, scenery.maps[2u * volume + 1u].span_count > 0u);
}

// Reads a map's field along the frustum; false if a value is missing.
fn map_enter(k: u32, column: Column, way: GapWay, own: FieldSegment) -> bool {
    let map = scenery.maps[k];
    var found = own;
    if map.field != OWN_FIELD {
        found = scene_field_segment(map.field, column, way, own.segment.eps, own.segment.length, false);
    }
    map_states[k].whole = found.segment;
    map_states[k].span = map.first_span;
    return found.is_there;
}

// The span of values behind `f`, searched from span `near`.
fn map_follow(map: VolumeMap, near: u32, f: f32, is_falling: bool) -> u32 {
    var k = near;
    let last = map.first_span + map.span_count - 1u;
    loop {
        let high = spans[k].high;
        if k >= last || !select(f > high, f >= high, !is_falling) {
            break;
        }
        k++;
    }
    loop {
        let low = spans[k].low;
        if k <= map.first_span || !select(f < low, f <= low, is_falling) {
            break;
        }
        k--;
    }
    return k;
}

// Extinction of a map at a value.
fn map_extinction(k: u32, f: f32) -> f32 {
    let map = scenery.maps[k];
    return span_extinction(spans[map_follow(map, map.first_span, f, false)], f);
}

// Begins a part of the frustum.
fn map_begin(k: u32, part: FrustumPart) {
    let whole = map_states[k].whole;
    map_states[k].rest = whole;
    if part.from_ > 0.0 || part.to < 1.0 {
        map_states[k].rest = segment_part(whole, segment_place(whole, part.from_), segment_place(whole, part.to));
    }
    map_states[k].is_monotone = false;
}

// Finds the piece of the rest of a map's part: all of it if its values stay in one span, else up to the extremum or the
// next knot. Returns the fraction at which it ends.
fn map_cut(k: u32) -> f32 {
    let rest = map_states[k].rest;
    let map = scenery.maps[k];
    let is_monotone = map_states[k].is_monotone;
    map_states[k].end = vec2f(1.0, rest.f1);
    map_states[k].is_monotone_behind = is_monotone;
    var end = vec2f(1.0, rest.f1);
    var front = rest;
    var turns = false;
    if !is_monotone {
        let turn = segment_extremum(rest);
        if turn.is_there {
            end = vec2f(turn.u, turn.f);
            front = segment_part(rest, vec2f(0.0, rest.f0), end);
            turns = true;
        }
    }
    let is_falling = end.y < rest.f0;
    let found = map_follow(map, map_states[k].span, rest.f0, is_falling);
    map_states[k].span = found;
    let span = spans[found];
    if span_holds(span, rest) {
        return 1.0;
    }
    let knot = select(span.high, span.low, is_falling);
    let crosses = select(knot < end.y, end.y < knot, is_falling);
    if crosses {
        end = vec2f(end.x * segment_solve(front, knot), knot);
    }
    map_states[k].end = end;
    map_states[k].is_monotone_behind = is_monotone || !turns || !crosses;
    return end.x;
}

// Ends the piece of a map at the fraction `upto` of the rest.
fn map_end_at(k: u32, upto: f32) {
    let rest = map_states[k].rest;
    if map_states[k].end.x != upto {
        map_states[k].end = segment_place(rest, upto);
        map_states[k].is_monotone_behind = map_states[k].is_monotone;
    }
    map_states[k].piece = rest;
    if upto < 1.0 {
        map_states[k].piece = segment_part(rest, vec2f(0.0, rest.f0), map_states[k].end);
    }
}

// Continues behind the piece of a map.
fn map_go_on(k: u32) {
    let rest = map_states[k].rest;
    map_states[k].rest = segment_part(rest, map_states[k].end, vec2f(1.0, rest.f1));
    map_states[k].is_monotone = map_states[k].is_monotone_behind;
}

// Variance of the light from rounding of a knot of a map with steps, at which the piece ends, behind `through`.
fn map_step_variance(k: u32, place: f32, through: f32) -> f32 {
    let map = scenery.maps[k];
    if map.step_count == 0u || map_states[k].end.x >= 1.0 {
        return 0.0;
    }
    let f = map_states[k].end.y;
    let a = spans[map_states[k].span];
    let b = spans[map_follow(map, map_states[k].span, f, map_states[k].piece.f1 < map_states[k].piece.f0)];
    let is_color = (k & 1u) == 1u;
    // A spike rises and falls within the reach of rounding.
    var jump = abs(span_extinction(a, f) - span_extinction(b, f));
    let apart = abs(span_color(a, f) - span_color(b, f));
    var painted = max(apart.x, max(apart.y, apart.z));
    if span_is_narrow(a) {
        jump += abs(a.extinction_slope) * (a.high - a.low);
        painted += a.steepest * (a.high - a.low);
    }
    if span_is_narrow(b) {
        jump += abs(b.extinction_slope) * (b.high - b.low);
        painted += b.steepest * (b.high - b.low);
    }
    if is_color {
        jump = 0.0;
    } else if color_map_of(k >> 1u) != k {
        painted = 0.0;
    }
    let shift = crossing_off(map_states[k].whole, place) * map_states[k].whole.length;
    let own = map_states[k & ~1u];
    let span = spans[own.span];
    let extinction = max(span_extinction(span, own.piece.f0), span_extinction(span, own.piece.f1));
    let off = through * (min(shift * jump, 1.0) + min(shift * extinction * painted, 1.0));
    return off * off;
}

// Adds the error of steps that are near a map's values at their extremum or their ends.
fn map_near_steps(k: u32, light: ptr<function, Radiance>) {
    let map = scenery.maps[k];
    if map.step_count == 0u {
        return;
    }
    var least = 0.0;
    if (k & 1u) == 1u {
        let own = map_states[k - 1u].whole;
        least = max(map_extinction(k - 1u, own.f0), map_extinction(k - 1u, own.f1));
    }
    near_steps(light, map_states[k].whole, map.first_step, map.step_count, least);
}
