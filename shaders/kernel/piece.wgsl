// Mirrors kernel/piece.rs; instead of its recursion, which halves a piece, a loop visits the halves in order.
#import params
#import kernel/transfer

struct Radiance {
    color: vec3f,
    alpha: f32,
    error: f32,
    variance: f32,
    shade_variance: f32,
}

// Number of standard deviations in the error of a lit pixel.
const LIT_DEVIATIONS: f32 = 4.0;
// Standard deviation of an independent error, as a fraction of its estimate.
const INDEPENDENT: f32 = 0.31;
// The part of the estimate of an unlit mean colour that is added as an independent one: with the five deviations of an
// unlit pixel, the error of a piece alone is the whole estimate.
const COLOR_PART: f32 = 1.0 / (5.0 * INDEPENDENT);

fn radiance_none() -> Radiance {
    return Radiance(vec3f(0.0), 0.0, 0.0, 0.0, 0.0);
}

fn radiance_plain(color: vec3f, alpha: f32) -> Radiance {
    return Radiance(color * alpha, alpha, 0.0, 0.0, 0.0);
}

fn radiance_over(light: ptr<function, Radiance>, behind: Radiance) {
    let through = 1.0 - (*light).alpha;
    (*light).color += through * behind.color;
    (*light).alpha += through * behind.alpha;
    (*light).error += through * behind.error;
    (*light).variance += through * through * behind.variance;
    (*light).shade_variance += through * through * behind.shade_variance;
}

struct ErrorBudget {
    color_tolerance: f32,
    min_transmittance: f32,
    transmittance: f32,
    reach: f32,
}

fn integrate(piece: Segment, span: Span, budget: ErrorBudget) -> Radiance {
    let terms = terms_new(piece, span);
    var light: Radiance;
    if IS_EXACT {
        light = exact(terms, budget);
    } else {
        light = linear(terms);
    }
    light.variance += terms_variance(terms, light.alpha, budget.reach);
    return light;
}

struct Terms {
    piece: Segment,
    span: Span,
    ends: vec2f,
    slope: f32,
    rise: f32,
    bend: f32,
    steep: f32,
    depth: f32,
}

fn terms_new(piece: Segment, span: Span) -> Terms {
    let ends = vec2f(span_extinction(span, piece.f0), span_extinction(span, piece.f1));
    let slope = span.extinction_slope;
    let rise = piece.f1 - piece.f0;
    let bend = piece.kappa * bend_factor(piece.eps);
    let depth = max(piece.length * (0.5 * (ends.x + ends.y) + slope * bend * (1.0 / 6.0)), 0.0);
    return Terms(piece, span, ends, slope, rise, bend, abs(rise) + abs(bend), depth);
}

fn terms_bend_of_depth(terms: Terms) -> f32 {
    return terms.piece.length * abs(terms.slope) * terms.steep;
}

fn terms_light(terms: Terms, alpha: f32, weight: f32, error: f32) -> Radiance {
    let color = span_color(terms.span, terms.piece.f1) * alpha - terms.span.color_slope * weight;
    return Radiance(color, alpha, error, 0.0, 0.0);
}

fn terms_skew(terms: Terms, alpha: f32) -> f32 {
    let eps = terms.piece.eps;
    var far = 1.0;
    if eps < -0.04 {
        far = 1.0 / (1.0 + eps);
    }
    let bent = far * abs(terms.bend) * abs(eps);
    return bent * (0.05 * alpha + (1.0 / 60.0) * terms_bend_of_depth(terms));
}

fn terms_variance(terms: Terms, alpha: f32, reach: f32) -> f32 {
    let thicker = terms.piece.length * abs(terms.slope) * (1.0 - alpha);
    let change = thicker + terms.span.steepest * alpha;
    let off = min(reach * change + ROUNDING * alpha, 1.0);
    return off * off;
}

fn linear(terms: Terms) -> Radiance {
    let depth = terms.piece.length * 0.5 * (terms.ends.x + terms.ends.y);
    let alpha = absorbed_by(depth);
    let left_out = terms.piece.length * abs(terms.slope * terms.bend) * (1.0 / 6.0);
    let skew = abs(terms.rise) * (terms_bend_of_depth(terms) + depth * alpha) * (1.0 / 12.0);
    let painted = skew + abs(terms.bend) * alpha * (1.0 / 6.0);
    let error = left_out + terms.span.steepest * painted;
    return terms_light(terms, alpha, 0.5 * terms.rise * alpha, min(error, 1.0));
}

const MAX_PANELS: f32 = 32.0;
const THIN: f32 = 0.5;
// Maximum depth of halvings. The rest is about 1e-8 of the piece, whose colours are those of its start.
const MAX_HALVINGS: u32 = 24u;

// `whole` of the piece or, if that requests it, of its halves one after the other: number `index` of 2^level.
fn exact(terms: Terms, budget: ErrorBudget) -> Radiance {
    var light = radiance_none();
    var level = 0u;
    var index = 0u;
    var from_ = vec2f(0.0, terms.piece.f0);
    var behind = budget;
    loop {
        var part = terms;
        var to = vec2f(1.0, terms.piece.f1);
        if level > 0u {
            let u = f32(index + 1u) / f32(1u << level);
            if u < 1.0 {
                to = vec2f(u, segment_value(terms.piece, u));
            }
            part = terms_new(segment_part(terms.piece, from_, to), terms.span);
        }
        let outcome = whole(part, behind, level == MAX_HALVINGS);
        if !outcome.is_done {
            level++;
            index *= 2u;
            continue;
        }
        radiance_over(&light, outcome.light);
        behind.transmittance = (1.0 - light.alpha) * budget.transmittance;
        // After a back half its parent is done too.
        while level > 0u && (index & 1u) == 1u {
            level--;
            index /= 2u;
        }
        if level == 0u || behind.transmittance <= budget.min_transmittance {
            break;
        }
        index++;
        from_ = to;
    }
    return light;
}

// A piece's light, unless it must be halved.
struct Outcome {
    light: Radiance,
    is_done: bool,
}

fn whole(terms: Terms, budget: ErrorBudget, is_last: bool) -> Outcome {
    let alpha = absorbed_by(terms.depth);
    let steepest = terms.span.steepest;
    if steepest * terms.steep == 0.0 {
        return Outcome(radiance_plain(span_color(terms.span, terms.piece.f0), alpha), true);
    }
    if terms.depth < THIN {
        let error = steepest * (thin_error(terms) + terms_skew(terms, alpha));
        if error <= budget.color_tolerance * alpha {
            return Outcome(terms_light(terms, alpha, thin(terms), error), true);
        }
    }
    return dense(terms, alpha, budget, is_last);
}

fn dense(terms: Terms, alpha: f32, budget: ErrorBudget, is_last: bool) -> Outcome {
    let steepest = terms.span.steepest;
    if !(terms.depth <= SURFACE) {
        var light = radiance_plain(span_color(terms.span, terms.piece.f0), 1.0);
        light.error = 4e-5 * steepest * terms.steep;
        return Outcome(light, true);
    }
    let color_tolerance = budget.color_tolerance * alpha;
    let bound = steepest * gauss_error(terms);
    let skew = steepest * terms_skew(terms, alpha);
    let is_near = bound + skew <= color_tolerance;
    let change = steepest * terms.steep;
    if !is_near && (0.5 * change <= budget.color_tolerance || is_last) {
        let error = 0.5 * change * alpha;
        return Outcome(terms_light(terms, alpha, 0.5 * terms.rise * alpha, error), true);
    }
    var wanted = 1.0;
    if !is_near {
        wanted = max(ceil(max(sqrt(sqrt(2.0 * bound / color_tolerance)), sqrt(2.0 * skew / color_tolerance))), 2.0);
    }
    if wanted <= MAX_PANELS {
        return Outcome(panels(terms, u32(wanted), budget), true);
    }
    return Outcome(radiance_none(), false);
}

// The closed form loses too many digits in f32 if ε is neither near 0 nor large; there 8-point Gauss, whose nodes are
// summed in pairs x and 1 - x, has an error of less than 1e-7.
fn bend_factor(eps: f32) -> f32 {
    if abs(eps) < 0.02 {
        let e2 = eps * eps;
        let low = 1.0 - eps * (1.0 / 2.0);
        let middle = 3.0 / 10.0 - eps * (1.0 / 5.0);
        let high = 1.0 / 7.0 - eps * (3.0 / 28.0);
        return low + e2 * (middle + e2 * high);
    }
    if eps < -0.75 || eps > 3.0 {
        // Reversed, the piece has the ε below.
        let e = select(eps, -eps / (1.0 + eps), eps < 0.0);
        let turned = 6.0 * (e + 0.5 * e * e - (1.0 + e) * log(1.0 + e)) / (e * e * e);
        return select(turned, turned / (1.0 + eps), eps < 0.0);
    }
    let ends = 1.0 + eps;
    let e2 = eps * eps;
    let sum = 0.005909979436670754 / (ends + e2 * 0.019460847876985345)
        + 0.06093060055804422 / (ends + e2 * 0.09133063094134085)
        + 0.1702993433466529 / (ends + e2 * 0.1809539215318839)
        + 0.2628600766586317 / (ends + e2 * 0.24158793298312325);
    return (2.0 + eps) * sum;
}

fn thin(terms: Terms) -> f32 {
    let third = 1.0 / 3.0;
    let bend = terms.bend;
    let p = terms.rise + bend;
    let level = terms.ends.x * (0.5 * p - (2.0 / 3.0) * bend);
    let ramp = terms.slope * (p * ((1.0 / 6.0) * p - third * bend) + (2.0 / 15.0) * bend * bend);
    return terms.piece.length * (level + ramp) * (1.0 - third * terms.depth)
        + bend * terms.depth * terms.depth * (1.0 / 36.0);
}

fn thin_error(terms: Terms) -> f32 {
    let x = terms.depth;
    let b = terms_bend_of_depth(terms);
    let y = x + 0.5 * b;
    return terms.steep * (b * (0.02 * x + (1.0 / 240.0) * b) + y * y * y * (1.0 / 24.0));
}

fn gauss(terms: Terms) -> f32 {
    let offset = 0.28867513459481287;
    let quartic = terms.piece.length * terms.slope * terms.bend * terms.bend * (1.0 / 270.0);
    return 0.5 * (gauss_weighted(terms, 0.5 - offset) + gauss_weighted(terms, 0.5 + offset)) + quartic;
}

fn gauss_weighted(terms: Terms, u: f32) -> f32 {
    let risen = u * u * (0.5 * terms.rise + terms.bend * (0.5 - u * (1.0 / 3.0)));
    let depth = terms.piece.length * (terms.ends.x * u + terms.slope * risen);
    return (terms.rise + terms.bend * (1.0 - u - u)) * absorbed_by(max(depth, 0.0));
}

fn gauss_error(terms: Terms) -> f32 {
    let bend = abs(terms.bend);
    let length = terms.piece.length;
    let swing = abs(terms.slope) * bend;
    let a = length * (max(terms.ends.x, terms.ends.y) + 0.25 * swing);
    let b = terms_bend_of_depth(terms);
    let j = 2.0 * length * swing;
    let a2 = a * a;
    let even = a2 * (a2 + 6.0 * b) + 3.0 * b * b + 4.0 * a * j;
    let odd = 8.0 * bend * (a * (a2 + 3.0 * b) + j * min(a, 1.0));
    return (terms.steep * even + odd) * (1.0 / 4320.0);
}

// Here a single panel is computed in the same way, so that a shader contains the rule once.
fn panels(terms: Terms, count: u32, budget: ErrorBudget) -> Radiance {
    let piece = terms.piece;
    let steepest = terms.span.steepest;
    var light = radiance_none();
    var from_ = vec2f(0.0, piece.f0);
    for (var i = 1u; i <= count; i++) {
        let u = f32(i) / f32(count);
        var to = vec2f(1.0, piece.f1);
        if i < count {
            to = vec2f(u, segment_value(piece, u));
        }
        var panel = terms;
        if count > 1u {
            panel = terms_new(segment_part(piece, from_, to), terms.span);
        }
        let alpha = absorbed_by(panel.depth);
        let error = steepest * (gauss_error(panel) + terms_skew(panel, alpha));
        radiance_over(&light, terms_light(panel, alpha, gauss(panel), error));
        if (1.0 - light.alpha) * budget.transmittance <= budget.min_transmittance {
            break;
        }
        from_ = to;
    }
    return light;
}
