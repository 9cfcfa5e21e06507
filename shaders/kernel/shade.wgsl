// Mirrors kernel/shade.rs.
#import kernel/piece
#import kernel/plane
#import kernel/turn

// Shading parameters of all rays (`Shading` of icoray/src/device), and the maximum number of cuts of a piece for its
// light.
struct Shading {
    light_hi: vec3f,
    ambient: f32,
    light_lo: vec3f,
    diffuse: f32,
    specular: f32,
    shininess: f32,
    sharpness: f32,
    is_headlight: u32,
    max_cuts: u32,
}

@group(2) @binding(0) var<uniform> lighting: Shading;

struct RayShading {
    ambient: f32,
    diffuse: f32,
    specular: f32,
    shininess: f32,
    light: vec3f,
    halfway: vec3f,
    sharpness: f32,
}

struct Shade {
    body: f32,
    highlight: f32,
}

struct MeanShade {
    shade: Shade,
    tilt: f32,
    off: f32,
    rounding: f32,
    deviation: f32,
}

struct ColorChange {
    brightest: f32,
    change: f32,
    bend: f32,
    eps: f32,
}

fn shading_along(s: Shading, dir: Wide3) -> RayShading {
    var light = Wide3(s.light_hi, s.light_lo);
    if s.is_headlight != 0u {
        light = wide3_neg(dir);
    }
    let between = wide3_add(light, wide3_neg(dir));
    var halfway = vec3f(0.0);
    if length(between.hi) > TINY {
        halfway = wide3_normalize(between).hi;
    }
    return RayShading(
        s.ambient, s.diffuse, s.specular, s.shininess, light.hi, halfway, s.sharpness,
    );
}

fn ray_shading_shade(s: RayShading, gradient: vec3f) -> Shade {
    let normal = direction_of(gradient);
    let body = s.ambient + s.diffuse * abs(dot(normal, s.light));
    let gleam = min(abs(dot(normal, s.halfway)), 1.0);
    return Shade(body, s.specular * power(gleam, s.shininess));
}

// `size` is the largest component of the gradients at the frustum's vertices.
fn ray_shading_mean(s: RayShading, turn: NormalTurn, color: ColorChange, size: f32) -> MeanShade {
    let body = ray_shading_mean_body(s, turn, color);
    let highlight = ray_shading_mean_highlight(s, turn);
    let most = color.brightest * s.diffuse + s.specular;
    let rounded = 4.0 * color.brightest * body.x + 3.0 * s.sharpness * highlight.x;
    let off = select(body.z + highlight.y, most, turn.is_wild);
    let deviation = ray_shading_deviation(s, size, turn.size);
    return MeanShade(Shade(body.x, highlight.x), body.y, off, ROUNDING * rounded, deviation);
}

// Factor for the colour, factor for the colour's change, and the error of both.
fn ray_shading_mean_body(s: RayShading, turn: NormalTurn, color: ColorChange) -> vec3f {
    let cosine = normal_turn_cosine(turn, s.light);
    let sign = select(1.0, -1.0, cosine.mean < 0.0);
    let level = abs(cosine.mean);
    let centre = turn.spread.centre;
    let swing = cosine_swing(cosine);
    let may_cross = 0.5 * swing + 0.02 * turn.angle2 + turn.across - level;
    let crosses = may_cross > 0.0;
    let reach = 0.5 * abs(cosine.rise);
    let beyond = max(reach - sign * cosine.even, 0.0);
    let part = beyond / (reach + reach + LEAST);
    let forward = select(centre, -centre, sign * cosine.rise < 0.0);
    let kink = beyond * part * (1.0 - forward * (6.0 - 4.0 * part));
    // Rules beyond their validity must not leave the range of what they approximate.
    let body = s.ambient + s.diffuse * clamp(level + kink, 0.0, 1.0);
    let tilt = select(sign * cosine.rise * normal_turn_variance(turn) * s.diffuse, 0.0, crosses);
    let bend = abs(cosine.bend);
    let unsure = turn.spread.error_bound;
    var at_kink = 0.25 * (bend + turn.across) + (unsure + 0.3 * centre * centre) * swing + 0.05 * turn.angle2;
    at_kink = select(0.0, min(0.5 * may_cross, at_kink), crosses);
    let apart = select(0.0, 0.1, crosses);
    let even = unsure * swing + turn.across + turn.along + at_kink;
    let skewed = color.bend * (0.015 * abs(color.eps) + 0.1 * abs(centre)) * swing;
    let change = color.change * (0.12 * bend + (unsure + apart) * swing + turn.across) + skewed;
    return vec3f(body, tilt, s.diffuse * min(color.brightest * even + change, color.brightest));
}

// The highlight and its error.
fn ray_shading_mean_highlight(s: RayShading, turn: NormalTurn) -> vec2f {
    let sharp = s.shininess;
    let cosine = normal_turn_cosine(turn, s.halfway);
    let level = min(abs(cosine.mean), 1.0);
    let reach = cosine_reach(cosine);
    let variance = cosine.rise * cosine.rise * normal_turn_variance(turn) + cosine.bend * cosine.bend * (1.0 / 45.0);
    let inverse = 1.0 / max(max(level * level, reach * reach), LEAST);
    let bent = 1.0 + 0.5 * sharp * (sharp - 1.0) * variance * inverse;
    let powered = power(level, sharp);
    let highlight = clamp(powered * bent, 0.0, 1.0);
    let x2 = sharp * turn.angle2;
    let root = sqrt(sharp);
    let x = root * turn.angle;
    let nearest = max(1.0 - cosine_largest(cosine), 0.0);
    let y = max(0.85 * max(sharp - 2.0, 0.0) * nearest - 0.1 * x2, 0.0);
    let near = clamp(1.3 - (1.0 / 12.0) * y, 0.0, 1.0);
    let near2 = near * near;
    let centre = 0.03 * abs(turn.spread.centre) * x + 0.008 * root * turn.bend_length;
    let turned = x2 * ((1.0 / 700.0) * x2 + centre) + sharp * turn.along;
    let bound = turn.spread.error_bound;
    let local = sharp * powered / max(level, LEAST) * cosine_swing(cosine) + 0.5 * bound * x2;
    let slope = bound * min(local, 0.61 * x) + 0.61 * root * turn.across;
    let unsure = 0.25 * bound * x2;
    let across = max(reach + 0.02 * turn.angle2 + turn.across - level, 0.0);
    let beside = 0.01 * reach * reach * reach * inverse;
    var blunt = select(across * reach, 0.5 * across + beside, sharp < 2.0);
    blunt = select(0.0, blunt, sharp < 6.0);
    let off = min(near2 * near2 * (turned + slope + unsure) + blunt, 1.0);
    return vec2f(s.specular * highlight, s.specular * off);
}

// Standard deviation of the shade across a gradient of this size, mixed from gradients of size `mixed_of`. The
// gradients of devices are not packed.
fn ray_shading_deviation(s: RayShading, mixed_of: f32, size: f32) -> f32 {
    let highlight = 0.61 * sqrt(s.shininess) * s.specular;
    // Gradients are rounded when they are stored and when they are mixed.
    let turned = sqrt(0.25 + 1.0) * ROUNDING * sqrt(s.diffuse * s.diffuse + highlight * highlight);
    let rounded = 0.5 * ROUNDING * s.sharpness;
    return min(rounded + turned * max(mixed_of / max(size, LEAST), 1.0), s.diffuse + s.specular);
}

fn ray_shading_apply(s: RayShading, light: Radiance, mean: MeanShade, change: vec3f) -> Radiance {
    let deviation = light.alpha * mean.deviation;
    let off = light.alpha * mean.off * INDEPENDENT;
    let body = mean.shade.body;
    let scale = max(body, 1.0);
    return Radiance(
        light.color * body + light.alpha * (mean.shade.highlight + mean.tilt * change),
        light.alpha,
        light.error * body + light.alpha * mean.rounding,
        light.variance * scale * scale + deviation * deviation,
        light.shade_variance + off * off,
    );
}

fn ray_shading_solid(s: RayShading, normal: vec3f) -> f32 {
    return s.ambient + s.diffuse * max(dot(normal, s.light), 0.0);
}
