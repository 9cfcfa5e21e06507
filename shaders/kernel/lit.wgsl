// Mirrors kernel/lit.rs; where recursion cuts a piece in two there, a loop goes through the parts in their order.
#import kernel/shade

// The gradient along a whole frustum; the value beside it is the frustum's segment.
struct FrustumInterpolant {
    from_: vec3f,
    to: vec3f,
    kappa: vec3f,
    eps: f32,
}

fn frustum_interpolant_gradient(interpolant: FrustumInterpolant, u: f32) -> vec3f {
    let bent = u * (1.0 - u) / (1.0 + interpolant.eps * u);
    return interpolant.from_ + u * (interpolant.to - interpolant.from_) + bent * interpolant.kappa;
}

struct LightSpread {
    centre: f32,
    error_bound: f32,
}

const LEAST: f32 = 1.1754944e-38;

fn light_spread_of(piece: Segment, span: Span) -> LightSpread {
    let from_ = span_extinction(span, piece.f0);
    let to = span_extinction(span, piece.f1);
    let sum = from_ + to + LEAST;
    // Depths beyond 1e3 have the largest spread already; the limit keeps their squares finite.
    let depth = min(piece.length * max(from_, to), 1e3);
    let centre = (1.0 / 6.0) * ((to - from_) / sum - 0.5 * min(depth, 1.0));
    let bent = min(abs(span.extinction_slope * piece.kappa) / sum, 1e3);
    let plain = span.steepest * abs(piece.f1 - piece.f0) / (span.brightest + LEAST);
    return LightSpread(centre, min(0.2 * (depth * depth + bent + 0.5 * min(plain, 1e3)), 0.5));
}

struct Lit {
    budget: ErrorBudget,
    shading: RayShading,
    span: Span,
    interpolant: FrustumInterpolant,
}

// Most of `lighting.most_cuts`.
const MAX_CUTS: u32 = 20u;

// The light of the last front half of each level. Outside the function, which would zero it for each piece.
var<private> fronts: array<Radiance, MAX_CUTS + 1u>;

// `part` of the piece or, where that asks for it, of its halves one after the other: number `index` of 2^level. Their
// light is added up in pairs, as there: a sum of thousands one by one would lose what is less than a last digit.
fn lit_light(lit: Lit, piece: Segment, range: vec2f, cuts: u32) -> Radiance {
    var light: Radiance;
    var level = 0u;
    var index = 0u;
    var from_ = vec2f(0.0, piece.f0);
    var front = lit_shade(lit, range.x);
    var back = lit_shade(lit, range.y);
    var enough = -1.0;
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
        let middle = lit_shade(lit, lerp(range.x, range.y, (f32(index) + 0.5) / f32(1u << level)));
        let outcome = lit_part(lit, part, front, middle, back, level == cuts, enough);
        if !outcome.is_done {
            if level == 0u {
                enough = 0.03 * lit.budget.color_tolerance * absorbed_by(0.5 * lit_depth(lit, piece));
            }
            level++;
            index *= 2u;
            back = middle;
            continue;
        }
        light = outcome.light;
        // A back half makes its parent whole, and so does a front half behind which nothing is seen.
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
        front = back;
        back = lit_shade(lit, lerp(range.x, range.y, f32(index + 1u) / f32(1u << level)));
    }
    return light;
}

fn lit_shade(lit: Lit, u: f32) -> Shade {
    return ray_shading_shade(lit.shading, frustum_interpolant_gradient(lit.interpolant, u));
}

// A part's light, if it needs not be cut. `enough` is below 0 for a whole piece.
fn lit_part(
    lit: Lit,
    part: Segment,
    front: Shade,
    middle: Shade,
    back: Shade,
    is_last: bool,
    enough: f32,
) -> Outcome {
    let spread = light_spread_of(part, lit.span);
    let error_bound = ray_shading_error_bound(lit.shading, front, middle, back, spread.error_bound);
    let apart = select(vec2f(lit.shading.diffuse, lit.shading.specular), error_bound.off, error_bound.is_there);
    let off = lit.span.brightest * apart.x + apart.y;
    let is_near = off <= lit.budget.color_tolerance || off * lit_depth(lit, part) <= enough;
    if !(is_near || is_last) {
        return Outcome(radiance_none(), false);
    }
    let light = integrate(part, lit.span, lit.budget);
    let mean = ray_shading_mean(front, middle, back, spread.centre);
    return Outcome(ray_shading_apply(lit.shading, light, mean, off), true);
}

// No less than the optical depth.
fn lit_depth(lit: Lit, part: Segment) -> f32 {
    return part.length * max(span_extinction(lit.span, part.f0), span_extinction(lit.span, part.f1));
}
