// Mirrors kernel/lit.rs; where recursion cuts a piece in two there, a loop goes through the parts in their order.
#import kernel/shade

// The gradient along a whole frustum; the value beside it is the frustum's segment.
struct Course {
    from_: vec3f,
    to: vec3f,
    kappa: vec3f,
    eps: f32,
}

fn course_gradient(course: Course, u: f32) -> vec3f {
    let bent = u * (1.0 - u) / (1.0 + course.eps * u);
    return course.from_ + u * (course.to - course.from_) + bent * course.kappa;
}

struct Spread {
    centre: f32,
    doubt: f32,
}

const LEAST: f32 = 1.1754944e-38;

fn spread_of(piece: Segment, span: Span) -> Spread {
    let from_ = span_extinction(span, piece.f0);
    let to = span_extinction(span, piece.f1);
    let sum = from_ + to + LEAST;
    // All that is dense is as doubtful as can be, which spares the square of what is denser still.
    let depth = min(piece.length * max(from_, to), 1e3);
    let centre = (1.0 / 6.0) * ((to - from_) / sum - 0.5 * min(depth, 1.0));
    let bent = min(abs(span.extinction_slope * piece.kappa) / sum, 1e3);
    let plain = span.steepest * abs(piece.f1 - piece.f0) / (span.brightest + LEAST);
    return Spread(centre, min(0.2 * (depth * depth + bent + 0.5 * min(plain, 1e3)), 0.5));
}

struct Lit {
    allowance: Allowance,
    shading: RayShading,
    span: Span,
    course: Course,
}

// Most of `lighting.most_cuts`.
const MOST_CUTS: u32 = 20u;

// Of each level, the light of the last front half. Not in the function, where it would be zeroed for each piece.
var<private> fronts: array<Light, MOST_CUTS + 1u>;

// `part` of the piece or, where that asks for it, of its halves one after the other: number `index` of 2^level. Their light
// is added up in pairs, as there: a sum of thousands one by one would lose what is less than a last digit.
fn lit_light(lit: Lit, piece: Segment, range: vec2f, cuts: u32) -> Light {
    var light: Light;
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
                enough = 0.03 * lit.allowance.share * absorbed_by(0.5 * lit_depth(lit, piece));
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
                light_over(&whole, light);
                light = whole;
            } else if (1.0 - light.absorbed) * lit.allowance.through > lit.allowance.rest {
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
    return ray_shading_shade(lit.shading, course_gradient(lit.course, u));
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
    let spread = spread_of(part, lit.span);
    let doubt = ray_shading_doubt(lit.shading, front, middle, back, spread.doubt);
    let apart = select(vec2f(lit.shading.diffuse, lit.shading.specular), doubt.off, doubt.is_there);
    let off = lit.span.brightest * apart.x + apart.y;
    let is_near = off <= lit.allowance.share || off * lit_depth(lit, part) <= enough;
    if !(is_near || is_last) {
        return Outcome(light_none(), false);
    }
    let light = integrate(part, lit.span, lit.allowance);
    let mean = ray_shading_mean(front, middle, back, spread.centre);
    return Outcome(ray_shading_apply(lit.shading, light, mean, off), true);
}

// No less than the optical depth.
fn lit_depth(lit: Lit, part: Segment) -> f32 {
    return part.length * max(span_extinction(lit.span, part.f0), span_extinction(lit.span, part.f1));
}
