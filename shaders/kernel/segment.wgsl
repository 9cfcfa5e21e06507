// Mirrors kernel/segment.rs.
#import kernel/real

struct Segment {
    f0: f32,
    f1: f32,
    kappa: f32,
    eps: f32,
    length: f32,
    // The largest magnitude of the values at the frustum's vertices; at least 1 if the transfer function has no steps.
    size: f32,
}

// A place on a segment, and the value there.
struct Turn {
    u: f32,
    f: f32,
    is_there: bool,
}

fn segment_value(s: Segment, u: f32) -> f32 {
    return s.f0 + (s.f1 - s.f0) * u + s.kappa * u * (1.0 - u) / (1.0 + s.eps * u);
}

fn segment_slope(s: Segment, u: f32) -> f32 {
    let r = 1.0 + s.eps * u;
    return s.f1 - s.f0 + s.kappa * (1.0 - u - u * r) / (r * r);
}

// Slopes at the start and the end.
fn segment_end_slopes(s: Segment) -> vec2f {
    let rise = s.f1 - s.f0;
    return vec2f(rise + s.kappa, rise - s.kappa / (1.0 + s.eps));
}

fn segment_reach(s: Segment) -> f32 {
    return ROUNDING * (s.size + abs(s.f0) + abs(s.f1));
}

fn segment_extremum(s: Segment) -> Turn {
    let d = s.f1 - s.f0;
    let rise_in = d + s.kappa;
    let rise_out = (1.0 + s.eps) * d - s.kappa;
    if rise_in * rise_out >= 0.0 {
        return Turn(0.0, 0.0, false);
    }
    let m = s.kappa - d * s.eps;
    let root = sqrt(max(s.kappa * (1.0 + s.eps) / m, 0.0));
    let u = clamp(rise_in / m / (1.0 + root), 0.0, 1.0);
    let bend = s.kappa * u * (1.0 - u) / (1.0 + s.eps * u);
    return Turn(u, s.f0 + d * u + bend, true);
}

fn segment_solve(s: Segment, v: f32) -> f32 {
    let below = s.f0 - v;
    let above = s.f1 - v;
    let c0 = below;
    let c2 = (1.0 + s.eps) * above;
    if c0 == 0.0 {
        return 0.0;
    }
    if c2 == 0.0 {
        return 1.0;
    }
    let c1 = 0.5 * (s.kappa + above + (1.0 + s.eps) * below);
    let root = sqrt(max(c1 * c1 - c0 * c2, 0.0));
    let q = select(-(c1 + root), root - c1, c1 < 0.0);
    let u = select(q / (q + c2), c0 / (c0 + q), (c0 < 0.0) == (q < 0.0));
    return clamp(u, 0.0, 1.0);
}

// The part from `from` to `to`: u and value at both.
fn segment_part(s: Segment, from_: vec2f, to: vec2f) -> Segment {
    let r0 = 1.0 + s.eps * from_.x;
    let r1 = 1.0 + s.eps * to.x;
    let du = to.x - from_.x;
    return Segment(
        from_.y,
        to.y,
        s.kappa * du * du * (1.0 + s.eps) / (r0 * r0 * r1),
        s.eps * du / r0,
        s.length * du,
        s.size,
    );
}
