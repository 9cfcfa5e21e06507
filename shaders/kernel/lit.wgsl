// Mirrors kernel/lit.rs; instead of its recursion, which cuts a piece in two, a loop visits the parts in order.
#import kernel/shade

// The gradient along a whole frustum; the value beside it is the frustum's segment.
struct FrustumInterpolant {
    from_: vec3f,
    to: vec3f,
    kappa: vec3f,
    eps: f32,
    // The largest component of the gradients at the frustum's vertices.
    size: f32,
}

fn frustum_interpolant_gradient(interpolant: FrustumInterpolant, u: f32) -> vec3f {
    let bent = u * (1.0 - u) / (1.0 + interpolant.eps * u);
    return interpolant.from_ + u * (interpolant.to - interpolant.from_) + bent * interpolant.kappa;
}

fn light_spread_of(piece: Segment, span: Span) -> LightSpread {
    let from_ = span_extinction(span, piece.f0);
    let to = span_extinction(span, piece.f1);
    let sum = from_ + to + LEAST;
    let all = 0.5 * piece.length * sum;
    // Depths beyond 1e3 have the largest spread already; the limit keeps their squares finite.
    let depth = min(all, 1e3);
    let rise = (to - from_) / sum;
    let forward = min(depth, 3.0) * (5.0 / 60.0 - (1.0 / 60.0) * rise * rise);
    let bent = min(abs(span.extinction_slope * piece.kappa) / sum, 1e3);
    let error_bound = min(0.02 * depth * depth + 0.2 * bent, 0.5);
    return LightSpread((1.0 / 6.0) * rise - forward, 1.0 / 12.0, error_bound, 1.0 / max(all, 1.0));
}

fn color_change_of(piece: Segment, span: Span) -> ColorChange {
    let bend = span.steepest * abs(piece.kappa);
    return ColorChange(span.brightest, span.steepest * abs(piece.f1 - piece.f0) + bend, bend, piece.eps);
}

fn mean_shade(
    shading: RayShading,
    piece: Segment,
    span: Span,
    at_a: vec3f,
    at_m: vec3f,
    at_b: vec3f,
    size: f32,
) -> MeanShade {
    let turn = normal_turn_of(at_a, at_m, at_b, piece.eps, light_spread_of(piece, span));
    return ray_shading_mean(shading, turn, color_change_of(piece, span), size);
}

fn shaded(shading: RayShading, piece: Segment, span: Span, mean: MeanShade, light: Radiance) -> Radiance {
    return ray_shading_apply(shading, light, mean, span.color_slope * (piece.f1 - piece.f0));
}

// `off` are the errors of the piece per absorbed light that add up along a ray, and those that are independent.
fn is_affordable(before: Radiance, absorbed: f32, off: vec2f, color_tolerance: f32) -> bool {
    let share = absorbed * (1.0 - before.alpha);
    let allowed = color_tolerance * (before.alpha + share + ADVANCE) - before.error - share * off.x;
    let own = off.y * LIT_DEVIATIONS * INDEPENDENT;
    let own_share = share * own;
    let spread = LIT_DEVIATIONS * LIT_DEVIATIONS * before.shade_variance + own_share * own_share;
    return off.x + own <= color_tolerance || (allowed >= 0.0 && spread <= allowed * allowed);
}

const ADVANCE: f32 = 0.1;

struct Lit {
    budget: ErrorBudget,
    shading: RayShading,
    span: Span,
    interpolant: FrustumInterpolant,
}

// Maximum number of halvings of a piece at its start, and of further ones by its end.
const HALVINGS_AT_START: f32 = 500.0;
const HALVINGS_ALONG: f32 = 1500.0;

// Whether a part that ends at `done` of its piece, or of its frustum, may be halved after this number of halvings.
fn may_halve(halvings: u32, done: f32) -> bool {
    return f32(halvings) < HALVINGS_AT_START + HALVINGS_ALONG * done;
}

// Maximum of `lighting.most_cuts`.
const MAX_CUTS: u32 = 20u;

// The light of the last front half of each level. Outside of the function, which would zero it for each piece.
var<private> fronts: array<Radiance, MAX_CUTS + 1u>;

// The piece or, if its error cannot be afforded, its halves one after the other: number `index` of 2^level. Their light
// is summed in pairs, as there: a sum of thousands one by one would lose light below the last digit.
fn lit_light(lit: Lit, piece: Segment, range: vec2f, cuts: u32, ray_light: Radiance) -> Radiance {
    var light: Radiance;
    var level = 0u;
    var index = 0u;
    var from_ = vec2f(0.0, piece.f0);
    var before = ray_light;
    var halvings = 0u;
    loop {
        var part = piece;
        var to = vec2f(1.0, piece.f1);
        if level > 0u {
            let u = f32(index + 1u) / f32(1u << level);
            if u < 1.0 {
                to = vec2f(u, segment_value(piece, u));
            }
            part = segment_part(piece, from_, to);
        }
        let ends = vec2f(f32(index), f32(index + 1u)) / f32(1u << level);
        let at = vec2f(lerp(range.x, range.y, ends.x), lerp(range.x, range.y, ends.y));
        let outcome = lit_part(lit, part, at, level, level == cuts || !may_halve(halvings, ends.y), before);
        if !outcome.is_done {
            halvings++;
            level++;
            index *= 2u;
            continue;
        }
        light = outcome.light;
        radiance_over(&before, light);
        // A back half completes its parent, and so does a front half behind which nothing is visible.
        while level > 0u {
            if (index & 1u) == 1u {
                var whole = fronts[level];
                radiance_over(&whole, light);
                light = whole;
            } else if (1.0 - light.alpha) * lit.budget.transmittance > lit.budget.min_transmittance {
                break;
            }
            level--;
            index /= 2u;
        }
        if level == 0u {
            break;
        }
        fronts[level] = light;
        index++;
        from_ = to;
    }
    return light;
}

// The light of a part of this level, if it is not cut.
fn lit_part(lit: Lit, part: Segment, range: vec2f, level: u32, is_last: bool, before: Radiance) -> Outcome {
    var mean = mean_shade(
        lit.shading, part, lit.span, frustum_interpolant_gradient(lit.interpolant, range.x),
        frustum_interpolant_gradient(lit.interpolant, 0.5 * (range.x + range.y)),
        frustum_interpolant_gradient(lit.interpolant, range.y), lit.interpolant.size,
    );
    let depth = part.length * max(span_extinction(lit.span, part.f0), span_extinction(lit.span, part.f1));
    let off = vec2f(mean.rounding, mean.off);
    if !(is_last || is_affordable(before, min(depth, 1.0), off, lit.budget.color_tolerance)) {
        return Outcome(radiance_none(), false);
    }
    let light = integrate(part, lit.span, lit.budget);
    // All parts of a piece, dense ones by their light, share the rounding of the gradients at the vertices.
    mean.deviation /= sqrt(max(exp2(-f32(level)), 0.5 * light.alpha));
    return Outcome(shaded(lit.shading, part, lit.span, mean, light), true);
}
