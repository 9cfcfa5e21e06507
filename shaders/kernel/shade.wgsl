// Mirrors kernel/shade.rs.
#import kernel/piece
#import kernel/plane

// Shading parameters of all rays (`Shading` of icoray/src/device), and how often a piece may be cut for its light.
struct Shading {
    light_hi: vec3f,
    ambient: f32,
    light_lo: vec3f,
    diffuse: f32,
    specular: f32,
    shininess: f32,
    sharpness: f32,
    blind: f32,
    dull: f32,
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
    blind: f32,
    dull: f32,
}

struct Shade {
    body: f32,
    highlight: f32,
    normal: vec3f,
}

fn shading_along(s: Shading, dir: Wide3) -> RayShading {
    var light = Wide3(s.light_hi, s.light_lo);
    if s.is_headlight != 0u {
        light = wide3_neg(dir);
    }
    let between = wide3_add(light, wide3_neg(dir));
    let long = wide3_length(between);
    var halfway = vec3f(0.0);
    if long.hi > TINY {
        halfway = wide3_scale(between, wide_div(wide(1.0), long)).hi;
    }
    return RayShading(
        s.ambient, s.diffuse, s.specular, s.shininess, light.hi, halfway, s.sharpness, s.blind, s.dull,
    );
}

fn ray_shading_shade(s: RayShading, gradient: vec3f) -> Shade {
    let size = abs(gradient);
    let largest = max(size.x, max(size.y, size.z));
    if !(largest > 0.0 && largest <= ENDLESS) {
        return Shade(s.ambient, 0.0, vec3f(0.0));
    }
    let n = gradient / largest;
    let normal = n / sqrt(dot(n, n));
    let body = s.ambient + s.diffuse * abs(dot(normal, s.light));
    let gleam = abs(dot(normal, s.halfway));
    var highlight = 0.0;
    if gleam >= s.dull {
        highlight = s.specular * power(gleam, s.shininess);
    }
    return Shade(body, highlight, normal);
}

// Errors of body and highlight, as `error_bound` and `apply` use them.
fn ray_shading_mean(a: Shade, m: Shade, b: Shade, centre: f32) -> vec2f {
    let at_a = vec2f(a.body, a.highlight);
    let at_b = vec2f(b.body, b.highlight);
    return (at_a + 4.0 * vec2f(m.body, m.highlight) + at_b) * (1.0 / 6.0) + centre * (at_b - at_a);
}

// Error of a mean shade, where the three shades allow an estimate.
struct ShadeErrorBound {
    off: vec2f,
    is_there: bool,
}

fn ray_shading_error_bound(s: RayShading, a: Shade, m: Shade, b: Shade, skew: f32) -> ShadeErrorBound {
    let at_a = vec2f(a.body, a.highlight);
    let at_m = vec2f(m.body, m.highlight);
    let at_b = vec2f(b.body, b.highlight);
    let bend = abs(at_a - at_m - at_m + at_b);
    let off = skew * (abs(at_b - at_a) + bend) + 0.2 * bend;
    let turned = ray_shading_turned(s, a, m, b);
    return ShadeErrorBound(off + turned.off + vec2f(0.0, s.blind), turned.is_there);
}

fn ray_shading_turned(s: RayShading, a: Shade, m: Shade, b: Shade) -> ShadeErrorBound {
    let turn = max(max(turn2(a.normal, m.normal), turn2(m.normal, b.normal)), 0.0);
    let bend = (4.0 / 81.0) * turn;
    let highest = max(max(a.highlight, m.highlight), b.highlight) + 0.05 * s.specular;
    let body = s.diffuse * (bend + kink(m.normal, s.light, turn));
    let blunt = select(0.0, s.specular * kink(m.normal, s.halfway, turn), s.shininess < 2.0);
    return ShadeErrorBound(vec2f(body, bend * s.sharpness * highest + blunt), turn * s.sharpness <= 0.5);
}

// Error from the kink of |n·d| where the normal turns by the root of `turn`.
fn kink(normal: vec3f, direction: vec3f, turn: f32) -> f32 {
    let across = dot(normal, direction);
    return select(0.0, (1.0 / 6.0) * sqrt(turn), across * across < turn);
}

fn ray_shading_apply(s: RayShading, light: Radiance, mean: vec2f, off: f32) -> Radiance {
    let rounded = 0.5 * ROUNDING * s.sharpness * light.alpha;
    let scale = max(mean.x, 1.0);
    return Radiance(
        light.color * mean.x + light.alpha * mean.y,
        light.alpha,
        light.error * mean.x + light.alpha * off,
        light.variance * scale * scale + rounded * rounded,
    );
}

fn ray_shading_solid(s: RayShading, normal: vec3f) -> f32 {
    return s.ambient + s.diffuse * max(dot(normal, s.light), 0.0);
}

fn turn2(a: vec3f, b: vec3f) -> f32 {
    if dot(a, a) + dot(b, b) == 0.0 {
        return 0.0;
    }
    return 2.0 * (1.0 - dot(a, b));
}
