// Mirrors kernel/turn.rs.
#import kernel/real

struct LightSpread {
    centre: f32,
    // Mean square of the distance from the middle.
    second: f32,
    error_bound: f32,
    // Fraction of the piece, from its start, in which most of the light is.
    extent: f32,
}

struct NormalTurn {
    mean: vec3f,
    rise: vec3f,
    bend: vec3f,
    // The largest component of the gradients where most of the light is.
    size: f32,
    angle: f32,
    angle2: f32,
    bend_length: f32,
    across: f32,
    along: f32,
    spread: LightSpread,
    is_wild: bool,
}

struct Cosine {
    even: f32,
    mean: f32,
    rise: f32,
    bend: f32,
}

const LEAST: f32 = 1.1754944e-38;

// The turn from the start over the middle to the end of a piece.
fn normal_turn_of(at_a: vec3f, at_m: vec3f, at_b: vec3f, eps: f32, spread: LightSpread) -> NormalTurn {
    let size = largest(max(max(abs(at_a), abs(at_m)), max(abs(at_b), vec3f(LEAST))));
    let a = scaled(at_a, size);
    let m = scaled(at_m, size);
    let b = scaled(at_b, size);
    let size_a = dot(a, a);
    let size_m = dot(m, m);
    let size_b = dot(b, b);
    let has_a = size_a > NO_SIZE;
    let has_m = size_m > NO_SIZE;
    let has_b = size_b > NO_SIZE;
    let is_at_start = !has_a && has_m && has_b;
    let is_at_end = has_a && has_m && !has_b;
    let n_m = unit(m, size_m);
    var n_a = unit(a, size_a);
    var n_b = unit(b, size_b);
    if is_at_start {
        n_a = n_m + n_m - n_b;
    }
    if is_at_end {
        n_b = n_m + n_m - n_a;
    }
    let rise = n_b - n_a;
    let bend = (n_a - n_m) + (n_b - n_m);
    let mean = n_m + bend * (2.0 * spread.second);
    let rise2 = dot(rise, rise);
    let bend2 = dot(bend, bend);
    let angle2 = rise2 + bend2 + 2.0 * abs(dot(rise, bend));
    let angle = sqrt(angle2);
    let bend_length = sqrt(bend2);
    let least = min(min(select(ENDLESS, size_a, has_a), select(ENDLESS, size_m, has_m)),
        select(ENDLESS, size_b, has_b));
    let bulged = (a - m) + (b - m);
    let bulge = min(sqrt(dot(bulged, bulged) / least), 4.0);
    let part = bend2 / (rise2 + bend2 + LEAST);
    let uneven = min((0.5 + 4.0 * part) * part, 0.6) + 0.03 * eps * eps;
    let lost = select(0.0, 0.2 * angle, is_at_start || is_at_end);
    let centre = abs(spread.centre);
    let bulging = 0.2 * angle * (centre + bulge) + 0.6 * bulge * bulge;
    let along = (1.0 / 400.0) * angle2 + (1.0 / 30.0) * centre * angle + 0.03 * bulge;
    let has_gap = (has_a || has_m || has_b) && !(has_a && has_m && has_b);
    return NormalTurn(
        mean, rise, bend, max(largest(abs(at_a)), spread.extent * size), angle, angle2, bend_length,
        uneven * bend_length + bulge * bulging + lost, angle2 * along, spread,
        angle2 > 4.0 || (has_gap && !(is_at_start || is_at_end)),
    );
}

fn normal_turn_cosine(turn: NormalTurn, direction: vec3f) -> Cosine {
    let even = dot(turn.mean, direction);
    let rise = dot(turn.rise, direction);
    return Cosine(even, even + turn.spread.centre * rise, rise, dot(turn.bend, direction));
}

fn normal_turn_variance(turn: NormalTurn) -> f32 {
    return max(turn.spread.second - turn.spread.centre * turn.spread.centre, 0.0);
}

fn cosine_largest(c: Cosine) -> f32 {
    let middle = c.even - (1.0 / 6.0) * c.bend;
    let end = abs(c.even + (1.0 / 3.0) * c.bend) + 0.5 * abs(c.rise);
    return max(end, abs(middle));
}

fn cosine_reach(c: Cosine) -> f32 {
    return 0.5 * cosine_swing(c);
}

fn cosine_swing(c: Cosine) -> f32 {
    return abs(c.rise) + abs(c.bend);
}

// Unit vector of a gradient of any size; zero if it vanishes.
fn direction_of(gradient: vec3f) -> vec3f {
    let x = scaled(gradient, largest(max(abs(gradient), vec3f(LEAST))));
    return unit(x, dot(x, x));
}

fn scaled(gradient: vec3f, largest: f32) -> vec3f {
    if !(largest <= ENDLESS) {
        return vec3f(0.0);
    }
    return gradient * (1.0 / largest);
}

// The squared length of a scaled gradient without a direction.
const NO_SIZE: f32 = 1e-30;

fn unit(gradient: vec3f, length2: f32) -> vec3f {
    if !(length2 > NO_SIZE) {
        return vec3f(0.0);
    }
    return gradient * (1.0 / sqrt(length2));
}
