// Mirrors kernel/doubt.rs.
#import kernel/transfer
#import kernel/piece

struct Medium {
    extinction: f32,
    color: vec3f,
}

fn medium_at(span: Span, f: f32) -> Medium {
    return Medium(span_extinction(span, f), span_color(span, f));
}

fn medium_paints_apart(a: Medium, b: Medium) -> f32 {
    let apart = abs(a.color - b.color);
    return min(a.extinction, b.extinction) * max(apart.x, max(apart.y, apart.z));
}

struct Cut {
    value: f32,
    length: f32,
    mean: Medium,
    change: f32,
    is_narrow: bool,
}

struct Doubt {
    length: f32,
    ends: vec2f,
    reach: f32,
    start: Medium,
    // The piece before the cut, if there is one.
    has_last: bool,
    last: Medium,
    last_length: f32,
}

fn doubt_new(segment: Segment, start: Medium) -> Doubt {
    let ends = vec2f(segment.f0, segment.f1);
    return Doubt(segment.length, ends, segment_reach(segment), start, false, start, 0.0);
}

fn doubt_rise(doubt: ptr<function, Doubt>) -> f32 {
    return abs((*doubt).ends.y - (*doubt).ends.x);
}

fn doubt_cut(doubt: ptr<function, Doubt>, light: ptr<function, Light>, absorbed: f32, piece: Cut) {
    let unit = 2.0 * ROUNDING;
    let knot = unit * (*doubt).length * abs(piece.value) / (unit + doubt_rise(doubt));
    let off = unit * piece.length + knot;
    if (*doubt).has_last {
        let nearer = unit * min((*doubt).last_length, piece.length) + knot;
        doubt_moved(light, absorbed, nearer, (*doubt).last, piece.mean);
    }
    var stretch = 0.0;
    if piece.is_narrow {
        stretch = doubt_stretch(doubt, piece.value);
    }
    // A piece without length, which f32 can have, has no colours to have elsewhere.
    let part = min(stretch + off / max(piece.length, 1e-37), 1.0);
    let colors = ((*light).absorbed - absorbed) * piece.change * part;
    let depth = min((1.0 - (*light).absorbed) * piece.mean.extinction * piece.length * stretch, 1.0);
    (*light).variance += colors * colors + depth * depth;
    (*doubt).has_last = true;
    (*doubt).last = piece.mean;
    (*doubt).last_length = piece.length;
}

fn doubt_stretch(doubt: ptr<function, Doubt>, value: f32) -> f32 {
    let near = min(abs(value - (*doubt).ends.x), abs(value - (*doubt).ends.y));
    return 2.0 * (*doubt).reach / ((*doubt).reach + near);
}

fn doubt_shift(doubt: ptr<function, Doubt>, light: ptr<function, Light>, end: Medium) {
    let shift = (*doubt).length * (*doubt).reach / ((*doubt).reach + doubt_rise(doubt));
    doubt_moved(light, (*light).absorbed, shift, (*doubt).start, end);
}

fn doubt_moved(light: ptr<function, Light>, absorbed: f32, length: f32, before: Medium, behind: Medium) {
    let rises = behind.extinction > before.extinction;
    let through = 1.0 - select(absorbed, (*light).absorbed, rises);
    let thicker = min(length * abs(behind.extinction - before.extinction), 1.0);
    let painted = min(length * medium_paints_apart(before, behind), 1.0);
    let off = through * thicker + (1.0 - absorbed) * painted;
    (*light).variance += off * off;
}
