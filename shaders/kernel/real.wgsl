// Mirrors kernel/real.rs for f32.

const ROUNDING: f32 = 5.9604644775390625e-8;
const SURFACE: f32 = 1e12;
// Replaces the CPU's infinities and NaN, which shaders need not support: larger than all normalised values, which are
// clamped to 1e15.
const ENDLESS: f32 = 3e38;

// A missing sample is stored as ENDLESS.
fn is_missing(x: f32) -> bool {
    return x > 1e38;
}

fn absorbed_by(x: f32) -> f32 {
    if x > 0.5 {
        return 1.0 - exp(-x);
    }
    let x2 = x * x;
    let x4 = x2 * x2;
    let low = (1.0 - x * (1.0 / 2.0)) + x2 * (1.0 / 6.0 - x * (1.0 / 24.0));
    let high = (1.0 / 120.0 - x * (1.0 / 720.0)) + x2 * (1.0 / 5040.0 - x * (1.0 / 40320.0));
    return x * (low + x4 * high);
}

// x to the power of y for x up to 1: WGSL's own is as exact as its logarithm, which may be inexact near 1.
fn power(x: f32, y: f32) -> f32 {
    var ln = log(x);
    if x > 0.7 {
        let z = (x - 1.0) / (x + 1.0);
        let z2 = z * z;
        ln = 2.0 * z * (1.0 + z2 * (1.0 / 3.0 + z2 * (1.0 / 5.0 + z2 * (1.0 / 7.0 + z2 * (1.0 / 9.0)))));
    }
    return exp(y * ln);
}

fn lerp(a: f32, b: f32, w: f32) -> f32 {
    return a + w * (b - a);
}

fn lerp3(a: vec3f, b: vec3f, w: f32) -> vec3f {
    return a + w * (b - a);
}

fn largest(v: vec3f) -> f32 {
    return max(v.x, max(v.y, v.z));
}
