// Mirrors kernel/packet/blend.rs: several volumes on one piece of a ray. Extinctions add up, colours mix by extinction;
// Simpson's rule over the start, the middle and the end of the piece gives the mean colour of the light that is absorbed.
#import params
#import scenery
#import kernel/lit

// A volume on a piece: parts and spans of the fields of its extinction and of its colour.
struct VolumePiece {
    extinction: Segment,
    extinction_span: u32,
    color: Segment,
    color_span: u32,
}

// Extinctions at the start, in the middle and at the end of a piece, and optical depths of all and of the first half.
struct VolumeDepths {
    extinction: vec3f,
    whole: f32,
    front: f32,
}

fn volume_depths(piece: VolumePiece) -> VolumeDepths {
    let s = piece.extinction;
    let span = spans[piece.extinction_span];
    let middle = segment_value(s, 0.5);
    let at = vec3f(span_extinction(span, s.f0), span_extinction(span, middle), span_extinction(span, s.f1));
    let first = segment_part(s, vec2f(0.0, s.f0), vec2f(0.5, middle));
    return VolumeDepths(at, depth_of(s, span, at.x, at.z), depth_of(first, span, at.x, at.y));
}

// Optical depth of a part with these extinctions at its ends.
fn depth_of(part: Segment, span: Span, from_: f32, to: f32) -> f32 {
    let bend = part.kappa * bend_factor(part.eps);
    return max(part.length * (0.5 * (from_ + to) + span.extinction_slope * bend * (1.0 / 6.0)), 0.0);
}

// The colours at the three places, none below black.
fn volume_colors(piece: VolumePiece) -> mat3x3f {
    let s = piece.color;
    let span = spans[piece.color_span];
    let none = vec3f(0.0);
    return mat3x3f(
        max(span_color(span, s.f0), none),
        max(span_color(span, segment_value(s, 0.5)), none),
        max(span_color(span, s.f1), none),
    );
}

// Colours under the mean shade of their volume, the light that it absorbs, and the error of the shade.
struct ShadedColors {
    color: mat3x3f,
    absorbed: f32,
    off: f32,
}

// `through` is the transmittance in the middle and at the end; `at` are the gradients at the three places.
fn volume_shade(
    shading: RayShading,
    piece: VolumePiece,
    extinction: vec3f,
    colors: mat3x3f,
    through: vec2f,
    at: mat3x3f,
) -> ShadedColors {
    let a = extinction.x;
    let m = extinction.y * through.x;
    let b = extinction.z * through.y;
    let absorbed = (a + 4.0 * m + b) * (1.0 / 6.0);
    let mean = absorbed + LEAST;
    let bent = abs((a - m) + (b - m)) / mean;
    let spread = LightSpread((b - a) / (12.0 * mean), min(0.2 * bent, 0.5));
    let rise = colors[2] - colors[0];
    let bends = abs(colors[0] - colors[1] - colors[1] + colors[2]);
    let bend = 2.0 * max(bends.x, max(bends.y, bends.z));
    let change = max(abs(rise.x), max(abs(rise.y), abs(rise.z))) + bend;
    let eps = piece.extinction.eps;
    let turn = normal_turn_of(at[0], at[1], at[2], eps, spread);
    let shade = ray_shading_mean(shading, turn, ColorChange(spans[piece.color_span].brightest, change, bend, eps));
    let added = rise * shade.tilt + vec3f(shade.shade.highlight);
    let body = shade.shade.body;
    return ShadedColors(
        mat3x3f(colors[0] * body + added, colors[1] * body + added, colors[2] * body + added), absorbed, shade.off,
    );
}

// All volumes at the three places of a piece: extinction, and colour times extinction.
struct Mixture {
    rates: vec3f,
    colors: mat3x3f,
}

// The mean colour by Simpson's rule, how far that of the ends alone is from it, and how far colours are apart.
struct MeanColor {
    color: vec3f,
    rule: f32,
    spread: f32,
}

fn mean_color(mixture: Mixture, through: vec2f) -> MeanColor {
    let at_ends = mixture.rates.x + through.y * mixture.rates.z;
    let sum = at_ends + 4.0 * through.x * mixture.rates.y;
    let ends = mixture.colors[0] + through.y * mixture.colors[2];
    let color = (ends + 4.0 * through.x * mixture.colors[1]) / max(sum, LEAST);
    let off = abs(color - ends / max(at_ends, LEAST));
    let has = mixture.rates > vec3f(0.0);
    let inverse = 1.0 / max(mixture.rates, vec3f(LEAST));
    let a = mixture.colors[0] * inverse.x;
    let b = mixture.colors[1] * inverse.y;
    let c = mixture.colors[2] * inverse.z;
    let none = vec3f(ENDLESS);
    let low = min(select(none, a, has.x), min(select(none, b, has.y), select(none, c, has.z)));
    let high = max(select(-none, a, has.x), max(select(-none, b, has.y), select(-none, c, has.z)));
    let apart = max(high - low, vec3f(0.0));
    let spread = max(apart.x, max(apart.y, apart.z));
    let rule = select(spread, min(max(off.x, max(off.y, off.z)), spread), at_ends > 0.0);
    return MeanColor(color, rule, spread);
}

// The light of all volumes on a piece, and the error of the colour per absorbed light for which the piece is halved.
struct Blend {
    light: Radiance,
    off: f32,
}

// `rounded` is what rounding does to the colours, `thickened` to the optical depth `depth`, and `shade_off` the error of
// shades per absorbed light.
fn blend_of(mixture: Mixture, depth: f32, through: vec2f, rounded: f32, thickened: f32, shade_off: f32, sharpness: f32) -> Blend {
    let mean = mean_color(mixture, through);
    let absorbed = absorbed_by(depth);
    var off = mean.spread;
    var weight = 3.0;
    if depth <= THIN {
        off = mean.rule;
        weight = 1.0;
    }
    let told = off + weight * shade_off;
    // Coarse light is taken as it is.
    if !IS_LIT || lighting.max_cuts > 0u {
        off = told;
    }
    let off_by = min(rounded + thickened * through.y + absorbed * ROUNDING, 1.0);
    let shaded = absorbed * 0.5 * ROUNDING * sharpness;
    return Blend(Radiance(mean.color * absorbed, absorbed, absorbed * told, off_by * off_by + shaded * shaded), off);
}

// Rounding in single precision leaves no smaller differences of colours.
const LEAST_TOLERANCE: f32 = 8.0 * ROUNDING;

// Whether the ray cannot afford the error of the piece, from what pieces before have left of theirs and an advance.
fn blend_is_far(blend: Blend, light: Radiance) -> bool {
    var color_tolerance = params.color_tolerance;
    if !IS_LIT {
        // The budget of lit rays has the advance in it, and room for rounding.
        color_tolerance *= 0.95 / (1.0 + ADVANCE);
    }
    color_tolerance = max(color_tolerance, LEAST_TOLERANCE);
    let earned = max((light.alpha + ADVANCE) * color_tolerance - light.error, 0.0);
    let through = max(1.0 - light.alpha, LEAST);
    return (blend.off - color_tolerance) * blend.light.alpha * through > earned;
}
