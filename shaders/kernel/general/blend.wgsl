// Mirrors kernel/packet/blend.rs: several volumes on one piece of a ray. Extinctions add up, colours mix by extinction;
// the start, the middle and the end of the piece give the mean colour of the absorbed light, by the rule of
// kernel/general/mean_color.rs.
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

// Extinctions at the start, in the middle and at the end of a piece, their slopes at the start and the end, and optical
// depths of all and of the first half.
struct VolumeDepths {
    extinction: vec3f,
    thickening: vec2f,
    whole: f32,
    front: f32,
}

fn volume_depths(piece: VolumePiece) -> VolumeDepths {
    let s = piece.extinction;
    let span = spans[piece.extinction_span];
    let middle = segment_value(s, 0.5);
    let at = vec3f(span_extinction(span, s.f0), span_extinction(span, middle), span_extinction(span, s.f1));
    let first = segment_part(s, vec2f(0.0, s.f0), vec2f(0.5, middle));
    let thickening = span.extinction_slope * segment_end_slopes(s);
    return VolumeDepths(at, thickening, depth_of(s, span, at.x, at.z), depth_of(first, span, at.x, at.y));
}

// Optical depth of a part with these extinctions at its ends.
fn depth_of(part: Segment, span: Span, from_: f32, to: f32) -> f32 {
    let bend = part.kappa * bend_factor(part.eps);
    return max(part.length * (0.5 * (from_ + to) + span.extinction_slope * bend * (1.0 / 6.0)), 0.0);
}

// Colours at the three places, and their slopes at the start and the end.
struct VolumeColors {
    at: mat3x3f,
    tints: mat2x3f,
}

// The colours of a volume, none below black.
fn volume_colors(piece: VolumePiece) -> VolumeColors {
    let s = piece.color;
    let span = spans[piece.color_span];
    let none = vec3f(0.0);
    let at = mat3x3f(
        max(span_color(span, s.f0), none),
        max(span_color(span, segment_value(s, 0.5)), none),
        max(span_color(span, s.f1), none),
    );
    let slopes = segment_end_slopes(s);
    return VolumeColors(at, mat2x3f(span.color_slope * slopes.x, span.color_slope * slopes.y));
}

// Colours with the mean shade of their volume, the light that it absorbs, and the shade's error, that by
// rounding, and its standard deviation.
struct ShadedColors {
    color: VolumeColors,
    absorbed: f32,
    off: vec3f,
}

// `at` are the gradients at the three places, mixed from gradients of `size`.
fn volume_shade(
    shading: RayShading,
    piece: VolumePiece,
    depths: VolumeDepths,
    own: VolumeColors,
    fading: Fading,
    at: mat3x3f,
    size: f32,
) -> ShadedColors {
    let colors = own.at;
    let absorbs = faded(depths.extinction, depths.thickening, fading);
    // The three places may miss dense media entirely.
    let share = (absorbs.values.x + 4.0 * absorbs.values.y + absorbs.values.z) * (1.0 / 6.0) + LEAST;
    let spread = nodes_spread(absorbs, fading);
    let rise = colors[2] - colors[0];
    let bends = abs(colors[0] - colors[1] - colors[1] + colors[2]);
    let bend = 2.0 * max(bends.x, max(bends.y, bends.z));
    let change = max(abs(rise.x), max(abs(rise.y), abs(rise.z))) + bend;
    let eps = piece.extinction.eps;
    let turn = normal_turn_of(at[0], at[1], at[2], eps, spread);
    let shade = ray_shading_mean(shading, turn, ColorChange(spans[piece.color_span].brightest, change, bend, eps), size);
    let added = rise * shade.tilt + vec3f(shade.shade.highlight);
    let body = shade.shade.body;
    let lit = mat3x3f(colors[0] * body + added, colors[1] * body + added, colors[2] * body + added);
    return ShadedColors(VolumeColors(lit, own.tints * body), share, vec3f(shade.off, shade.rounding, shade.deviation));
}

// All volumes at the three places of a piece: extinction, and colour times extinction; their slopes at its start and end;
// its length, and relative change of height along it.
struct Mixture {
    rates: vec3f,
    thickening: vec2f,
    colors: mat3x3f,
    tints: mat2x3f,
    length: f32,
    eps: f32,
}

fn mixture_none() -> Mixture {
    return Mixture(vec3f(0.0), vec2f(0.0), mat3x3f(), mat2x3f(), 0.0, 0.0);
}

// Adds a volume to the mixture.
fn mixture_and(mixture: Mixture, depths: VolumeDepths, color: VolumeColors, piece: Segment) -> Mixture {
    let rates = depths.extinction;
    let thickening = depths.thickening;
    let colors = mat3x3f(color.at[0] * rates.x, color.at[1] * rates.y, color.at[2] * rates.z);
    let tints = mat2x3f(
        color.at[0] * thickening.x + color.tints[0] * rates.x,
        color.at[2] * thickening.y + color.tints[1] * rates.z,
    );
    return Mixture(
        mixture.rates + rates,
        mixture.thickening + thickening,
        mixture.colors + colors,
        mixture.tints + tints,
        piece.length,
        abs(piece.eps),
    );
}

// The light that passes all volumes of a piece.
struct Fading {
    // Transmittance to the middle and to the end.
    through: vec2f,
    // Extinction at the start and the end, times the length of the piece.
    rates: vec2f,
    // Factors by which coefficients two to four degrees higher come.
    growth: vec3f,
    // Relative error of the absorption as it follows from the three places.
    unseen: f32,
}

fn growth_of(rates: vec3f, length: f32, depth: f32, eps: f32) -> vec3f {
    let tilt = 0.25 * length * max(abs(rates.y - rates.x), abs(rates.z - rates.y));
    let uneven = eps / (1.0 - 0.5 * eps);
    let bent = length * abs(rates.x - rates.y - rates.y + rates.z) * (1.0 / 12.0);
    let e2 = 0.05 * depth * depth + tilt + 0.75 * uneven * uneven;
    return vec3f(e2, bent + e2 * sqrt(e2), bent * (0.25 * depth + uneven) + e2 * e2);
}

// A function at the three places, and its slopes at the start and the end.
struct Nodes {
    values: vec3f,
    slopes: vec2f,
}

// The function with these values and slopes, weighted by the transmittance.
fn faded(values: vec3f, slopes: vec2f, fading: Fading) -> Nodes {
    let faded_slopes = slopes - fading.rates * values.xz;
    return Nodes(values * vec3f(1.0, fading.through), faded_slopes * vec2f(1.0, fading.through.y));
}

// Its mean, exact to the fifth degree.
fn nodes_mean(n: Nodes) -> f32 {
    return (7.0 * (n.values.x + n.values.z) + 16.0 * n.values.y) / 30.0 + (n.slopes.x - n.slopes.y) / 60.0;
}

// The distribution of light that is absorbed like this.
fn nodes_spread(n: Nodes, fading: Fading) -> LightSpread {
    let ends = n.values.x + n.values.z;
    let rise = n.values.z - n.values.x;
    let bend = ends - 2.0 * n.values.y;
    let slopes = n.slopes.x + n.slopes.y;
    let inverse = 1.0 / max(nodes_mean(n), LEAST);
    let first = 0.1 * rise - slopes * (1.0 / 120.0);
    let second = n.values.y * (2.0 / 105.0) + ends * (9.0 / 280.0) + (n.slopes.x - n.slopes.y) * (1.0 / 560.0);
    let a3 = abs(0.25 * (rise - 0.5 * slopes));
    let a4 = abs(0.5 * (bend - 0.25 * (n.slopes.y - n.slopes.x)));
    let e = fading.growth;
    let missed = e.x * (a4 + a3 + n.values.y * e.y) + abs(0.5 * bend) * e.y + abs(0.5 * rise) * e.z;
    let error_bound = ((12.0 / 105.0) * missed + 0.02 * abs(bend)) * inverse + 0.5 * fading.unseen;
    return LightSpread(
        clamp(first * inverse, -0.5, 0.5), clamp(second * inverse, 0.0, 0.25), min(error_bound, 0.5), 1.0,
    );
}

// The mean colour of the absorbed light, its error, and the difference of the colours.
struct MeanColor {
    color: vec3f,
    off: f32,
    spread: f32,
}

// The mean of functions of these values at three places and these slopes at the first and the last, exact to the fifth
// degree.
fn fifth_degree(values: mat3x4f, slopes: mat2x4f) -> vec4f {
    return (7.0 * (values[0] + values[2]) + 16.0 * values[1]) / 30.0 + (slopes[0] - slopes[1]) / 60.0;
}

fn mixture_mean(mixture: Mixture, through: vec2f, depth: f32, absorbed: f32) -> MeanColor {
    let rates = mixture.rates;
    // Colours times extinction, and extinction, weighted by the transmittance to the place.
    let entry = vec4f(mixture.colors[0], rates.x);
    let middle = vec4f(mixture.colors[1], rates.y) * through.x;
    let exit = vec4f(mixture.colors[2], rates.z);
    let rise_in = vec4f(mixture.tints[0], mixture.thickening.x) - mixture.length * rates.x * entry;
    let rise_out = (vec4f(mixture.tints[1], mixture.thickening.y) - mixture.length * rates.z * exit) * through.y;
    let values = mat3x4f(entry, middle, exit * through.y);
    let whole = fifth_degree(values, mat2x4f(rise_in, rise_out));
    let color = whole.xyz / whole.w;
    let a = values[0].xyz - color * values[0].w;
    let m = values[1].xyz - color * values[1].w;
    let b = values[2].xyz - color * values[2].w;
    let from_ = rise_in.xyz - color * rise_in.w;
    let to = rise_out.xyz - color * rise_out.w;
    let rise = b - a;
    let bend = a - m - m + b;
    let a1 = largest(abs(0.5 * rise));
    let a2 = largest(abs(0.5 * bend));
    let a3 = largest(abs(0.25 * (rise - 0.5 * (from_ + to))));
    let a4 = largest(abs(0.5 * (bend - 0.25 * (to - from_))));
    let e = growth_of(rates, mixture.length, depth, mixture.eps);
    let missed = e.x * (a4 + a1 * e.y) + a3 * e.y + a2 * e.z;
    let spread = mixture_spread(mixture);
    let longer = mixture.length / max(absorbed, LEAST);
    let off = missed * longer * (24.0 / 105.0) + spread * abs(longer * whole.w - 1.0);
    if whole.w > 0.0 && off <= spread {
        return MeanColor(color, off, spread);
    }
    // Simpson's rule: a mean of the colours at the places. The light absorbed at the start may leave none in the middle
    // and at the end.
    let simpson = values[0] + 4.0 * values[1] + values[2];
    if simpson.w > LEAST {
        return MeanColor(simpson.xyz / simpson.w, spread, spread);
    }
    return MeanColor(mixture_first(mixture), spread, spread);
}

// The first colour of a piece.
fn mixture_first(mixture: Mixture) -> vec3f {
    if mixture.rates.x > 0.0 {
        return mixture.colors[0] / mixture.rates.x;
    }
    if mixture.thickening.x != 0.0 {
        return mixture.tints[0] / mixture.thickening.x;
    }
    if mixture.rates.y > 0.0 {
        return mixture.colors[1] / mixture.rates.y;
    }
    return mixture.colors[2] / max(mixture.rates.z, LEAST);
}

// The difference of the colours on a piece, from those at the places and from their slopes.
fn mixture_spread(mixture: Mixture) -> f32 {
    let has = mixture.rates > vec3f(0.0);
    let inverse = 1.0 / max(mixture.rates, vec3f(LEAST));
    var a = mixture.colors[0] * inverse.x;
    let b = mixture.colors[1] * inverse.y;
    var c = mixture.colors[2] * inverse.z;
    let slope_in = abs(mixture.tints[0] - a * mixture.thickening.x) * inverse.x;
    let slope_out = abs(mixture.tints[1] - c * mixture.thickening.y) * inverse.z;
    let steepest = max(select(vec3f(0.0), slope_in, has.x), select(vec3f(0.0), slope_out, has.z));
    // Without absorption, the colour is that of the volume that begins to absorb there.
    let begins = mixture.thickening != vec2f(0.0);
    if !has.x && begins.x {
        a = mixture.tints[0] / mixture.thickening.x;
    }
    if !has.z && begins.y {
        c = mixture.tints[1] / mixture.thickening.y;
    }
    let none = vec3f(ENDLESS);
    let has_a = has.x || begins.x;
    let has_c = has.z || begins.y;
    let low = min(select(none, a, has_a), min(select(none, b, has.y), select(none, c, has_c)));
    let high = max(select(-none, a, has_a), max(select(-none, b, has.y), select(-none, c, has_c)));
    return largest(max(high - low, vec3f(0.0))) + 0.25 * largest(steepest);
}

// The light of all volumes on a piece, and the errors of the colour per absorbed light for which the piece is halved:
// that which adds up along a ray, and that which is independent.
struct Blend {
    light: Radiance,
    off: vec2f,
    // Whether these are no more than its rounding error.
    is_rounding: bool,
}

// `rounds` is the rounding error of the colours and of the optical depth `depth`, `shade` the error of shades
// per absorbed light, that by rounding, and their standard deviation.
fn blend_of(mixture: Mixture, depth: f32, through: vec2f, rounds: vec2f, shade: vec3f) -> Blend {
    let absorbed = absorbed_by(depth);
    let mean = mixture_mean(mixture, through, depth, absorbed);
    // Errors of extinctions change the mixture of colours.
    let rounded = rounds.x + mean.spread * min(rounds.y / max(depth, LEAST), 1.0);
    // In dense pieces the centre of the light is less certain.
    let shade_off = select(3.0, 1.0, depth <= THIN) * shade.x;
    // Estimates of different pieces are added as independent ones.
    let of_color = select(COLOR_PART, 0.5, IS_LIT) * mean.off;
    let off = vec2f(shade.y, sqrt(shade_off * shade_off + of_color * of_color));
    let off_by = min(rounds.y * through.y + absorbed * (rounded + ROUNDING), 1.0);
    let turned = absorbed * shade.z;
    let deviation = absorbed * off.y * INDEPENDENT;
    let variance = off_by * off_by + turned * turned;
    let light = Radiance(mean.color * absorbed, absorbed, absorbed * off.x, variance, deviation * deviation);
    var cut_for = off;
    // Coarse light is not halved for the error of its shades.
    if IS_LIT && lighting.max_cuts == 0u {
        cut_for.y = of_color;
    }
    return Blend(light, cut_for, cut_for.x + cut_for.y <= rounded);
}

// The smallest difference of colours that rounding in single precision leaves.
const LEAST_TOLERANCE: f32 = 8.0 * ROUNDING;

// Whether a piece is to be halved: the ray cannot afford the error of a lit one, or an unlit one exceeds the tolerance
// itself, since a halving divides its error by about 64.
fn blend_is_far(blend: Blend, light: Radiance) -> bool {
    let color_tolerance = max(params.color_tolerance, LEAST_TOLERANCE);
    let is_near = select(
        blend.off.y <= COLOR_PART * color_tolerance,
        is_affordable(light, blend.light.alpha, blend.off, color_tolerance),
        IS_LIT,
    );
    return !(blend.is_rounding || is_near);
}
