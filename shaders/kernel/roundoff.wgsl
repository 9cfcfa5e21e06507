// Mirrors kernel/roundoff.rs.
#import kernel/transfer
#import kernel/piece

struct MediumSample {
    extinction: f32,
    color: vec3f,
}

fn medium_sample_at(span: Span, f: f32) -> MediumSample {
    return MediumSample(span_extinction(span, f), span_color(span, f));
}

fn medium_sample_color_difference(a: MediumSample, b: MediumSample) -> f32 {
    let apart = abs(a.color - b.color);
    return min(a.extinction, b.extinction) * max(apart.x, max(apart.y, apart.z));
}

struct KnotCrossing {
    values: vec2f,
    // Slope of the segment at the cut.
    slope: f32,
    length: f32,
    mean: MediumSample,
    change: f32,
    is_narrow: bool,
}

struct Roundoff {
    length: f32,
    ends: vec2f,
    reach: f32,
    // Maximum of the slope, and the least at a cut.
    steepest: f32,
    flattest: f32,
    start: MediumSample,
    // What the ray has absorbed before the first cut; -1 if there is none.
    absorbed_before: f32,
    // The piece before the cut, if there is one.
    has_last: bool,
    last: MediumSample,
    last_length: f32,
}

fn roundoff_new(segment: Segment, start: MediumSample) -> Roundoff {
    let ends = vec2f(segment.f0, segment.f1);
    let flattest = abs(ends.y - ends.x);
    let steepest = flattest + abs(segment.kappa);
    return Roundoff(segment.length, ends, segment_reach(segment), steepest, flattest, start, -1.0, false, start, 0.0);
}

fn roundoff_rise(roundoff: ptr<function, Roundoff>) -> f32 {
    return abs((*roundoff).ends.y - (*roundoff).ends.x);
}

fn roundoff_cut(roundoff: ptr<function, Roundoff>, light: ptr<function, Radiance>, alpha: f32, piece: KnotCrossing) {
    let unit = 2.0 * ROUNDING;
    let last_digit = unit * abs(piece.values.x);
    let knot = (*roundoff).length * last_digit / max(last_digit + roundoff_rise(roundoff), 1e-37);
    let off = unit * piece.length + knot;
    if (*roundoff).has_last {
        (*roundoff).flattest = min((*roundoff).flattest, abs(piece.slope));
        let nearer = unit * min((*roundoff).last_length, piece.length) + knot;
        roundoff_moved(light, alpha, nearer, (*roundoff).last, piece.mean);
    }
    var stretch = 0.0;
    if piece.is_narrow {
        stretch = roundoff_stretch(roundoff, piece.values);
    }
    // A piece without length, which is possible in f32, cannot have its colours elsewhere.
    let part = min(stretch + off / max(piece.length, 1e-37), 1.0);
    let colors = ((*light).alpha - alpha) * piece.change * part;
    let depth = min((1.0 - (*light).alpha) * piece.mean.extinction * piece.length * stretch, 1.0);
    (*light).variance += colors * colors + depth * depth;
    (*roundoff).has_last = true;
    (*roundoff).last = piece.mean;
    (*roundoff).last_length = piece.length;
}

fn roundoff_stretch(roundoff: ptr<function, Roundoff>, values: vec2f) -> f32 {
    let ends = (*roundoff).ends;
    let a = roundoff_apart(values.x, ends);
    let b = roundoff_apart(values.y, ends);
    return 2.0 * (*roundoff).reach / ((*roundoff).reach + min(a, b));
}

// Distance of a knot from the ends of its segment; the ends themselves are no knots.
fn roundoff_apart(value: f32, ends: vec2f) -> f32 {
    return select(min(abs(value - ends.x), abs(value - ends.y)), ENDLESS, any(vec2f(value) == ends));
}

fn roundoff_shift(roundoff: ptr<function, Roundoff>, light: ptr<function, Radiance>, end: MediumSample) {
    // At an extremum the place of a cut is the root of the reach of rounding.
    let reach = (*roundoff).reach;
    let shift = min(sqrt(reach / (reach + (*roundoff).steepest)), reach / (reach + (*roundoff).flattest));
    let before = (*roundoff).absorbed_before;
    let absorbed = select(before, (*light).alpha, before < 0.0);
    roundoff_moved(light, absorbed, (*roundoff).length * shift, (*roundoff).start, end);
}

fn roundoff_moved(light: ptr<function, Radiance>, alpha: f32, length: f32, before: MediumSample, behind: MediumSample) {
    let rises = behind.extinction > before.extinction;
    let through = 1.0 - select(alpha, (*light).alpha, rises);
    let thicker = min(length * abs(behind.extinction - before.extinction), 1.0);
    let painted = min(length * medium_sample_color_difference(before, behind), 1.0);
    let off = through * thicker + (1.0 - alpha) * painted;
    (*light).variance += off * off;
}
