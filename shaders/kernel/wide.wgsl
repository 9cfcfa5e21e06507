// Double-float numbers: hi + lo with |lo| at most half a last digit of hi, some 48 bits, in place of the CPU's f64.
//
// Knuth's and Dekker's error-free sums and products (Dekker 1971, doi:10.1007/BF01397083; Hida, Li and Bailey 2001).
// They depend on rounding, which algebra ignores, and drivers apply algebra: Mesa replaces `(a + b) - a` by b, and
// others fuse a product with the following sum at will. Operations that must be rounded as written go through `opaque`.
// So every function here is a pure function of its arguments' bits, wherever it is inlined: the walk relies on that.
#import params

struct Wide {
    hi: f32,
    lo: f32,
}

struct Wide3 {
    hi: vec3f,
    lo: vec3f,
}

// x, in a form that no compiler can simplify: `params.zero` is known at run time only.
fn opaque(x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) ^ params.zero);
}

fn opaque3(x: vec3f) -> vec3f {
    return bitcast<vec3f>(bitcast<vec3u>(x) ^ vec3u(params.zero));
}

// a + b, exactly, if |a| >= |b|.
fn quick_two_sum(a: f32, b: f32) -> Wide {
    let sum = opaque(a + b);
    return Wide(sum, b - opaque(sum - a));
}

fn quick_two_sum3(a: vec3f, b: vec3f) -> Wide3 {
    let sum = opaque3(a + b);
    return Wide3(sum, b - opaque3(sum - a));
}

// a + b, exactly.
fn two_sum(a: f32, b: f32) -> Wide {
    let sum = opaque(a + b);
    let of_b = opaque(sum - a);
    let of_a = opaque(sum - of_b);
    return Wide(sum, opaque(a - of_a) + opaque(b - of_b));
}

fn two_sum3(a: vec3f, b: vec3f) -> Wide3 {
    let sum = opaque3(a + b);
    let of_b = opaque3(sum - a);
    let of_a = opaque3(sum - of_b);
    return Wide3(sum, opaque3(a - of_a) + opaque3(b - of_b));
}

// The upper half of x's digits: the remainder has the other half.
fn upper_half(x: f32) -> f32 {
    let shifted = opaque(4097.0 * x);
    return opaque(shifted - opaque(shifted - x));
}

fn upper_half3(x: vec3f) -> vec3f {
    let shifted = opaque3(4097.0 * x);
    return opaque3(shifted - opaque3(shifted - x));
}

// a·b, exactly. Products of halves have no more digits than fit, so that fusing them changes nothing.
fn two_product(a: f32, b: f32) -> Wide {
    let product = opaque(a * b);
    let a1 = upper_half(a);
    let b1 = upper_half(b);
    let a2 = a - a1;
    let b2 = b - b1;
    return Wide(product, ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2);
}

fn two_product3(a: vec3f, b: vec3f) -> Wide3 {
    let product = opaque3(a * b);
    let a1 = upper_half3(a);
    let b1 = upper_half3(b);
    let a2 = a - a1;
    let b2 = b - b1;
    return Wide3(product, ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2);
}

fn wide(x: f32) -> Wide {
    return Wide(x, 0.0);
}

fn wide_neg(a: Wide) -> Wide {
    return Wide(-a.hi, -a.lo);
}

fn wide_add(a: Wide, b: Wide) -> Wide {
    let high = two_sum(a.hi, b.hi);
    let low = two_sum(a.lo, b.lo);
    let sum = quick_two_sum(high.hi, high.lo + low.hi);
    return quick_two_sum(sum.hi, sum.lo + low.lo);
}

fn wide_sub(a: Wide, b: Wide) -> Wide {
    return wide_add(a, wide_neg(b));
}

fn wide_mul(a: Wide, b: Wide) -> Wide {
    let product = two_product(a.hi, b.hi);
    return quick_two_sum(product.hi, product.lo + (opaque(a.hi * b.lo) + opaque(a.lo * b.hi)));
}

// a·b for a plain b.
fn wide_times(a: Wide, b: f32) -> Wide {
    let product = two_product(a.hi, b);
    return quick_two_sum(product.hi, product.lo + opaque(a.lo * b));
}

// Long division, a digit of f32 at a time: a rough first digit does no harm. What is left is small, so that f32 has it.
fn wide_div(a: Wide, b: Wide) -> Wide {
    let first = opaque(a.hi / b.hi);
    let second = opaque(wide_apart(a, wide_times(b, first)) / b.hi);
    let both = quick_two_sum(first, second);
    let third = opaque(wide_apart(a, wide_mul(b, both)) / b.hi);
    return quick_two_sum(both.hi, both.lo + third);
}

// 0 below 0. There is no branch: it is inlined at many places.
fn wide_sqrt(a: Wide) -> Wide {
    let root = wide_mul(a, wide_inverse_sqrt(a));
    return Wide(select(0.0, root.hi, a.hi > 0.0), select(0.0, root.lo, a.hi > 0.0));
}

// 1 / sqrt(a) = rough (1 - off)^(-1/2) with off = 1 - a rough^2, which is a few last digits of f32: the series has all
// digits with its first two terms.
fn wide_inverse_sqrt(a: Wide) -> Wide {
    let rough = opaque(inverseSqrt(max(a.hi, 1.2e-38)));
    let off = wide_apart(wide(1.0), wide_times(wide_times(a, rough), rough));
    return quick_two_sum(rough, opaque(rough * off * (0.5 + 0.375 * off)));
}

// a - b to the digits of f32, which suffice for a small difference of two wide numbers: if the upper halves are close,
// their difference is exact.
fn wide_apart(a: Wide, b: Wide) -> f32 {
    return opaque(a.hi - b.hi) + opaque(a.lo - b.lo);
}

fn wide_less(a: Wide, b: Wide) -> bool {
    return wide_apart(a, b) < 0.0;
}

fn wide_max(a: Wide, b: Wide) -> Wide {
    if wide_less(a, b) {
        return b;
    }
    return a;
}

fn wide_min(a: Wide, b: Wide) -> Wide {
    if wide_less(b, a) {
        return b;
    }
    return a;
}

fn wide_lerp(a: Wide, b: Wide, w: Wide) -> Wide {
    return wide_add(a, wide_mul(w, wide_sub(b, a)));
}

fn wide3_neg(a: Wide3) -> Wide3 {
    return Wide3(-a.hi, -a.lo);
}

fn wide3_add(a: Wide3, b: Wide3) -> Wide3 {
    let high = two_sum3(a.hi, b.hi);
    let low = two_sum3(a.lo, b.lo);
    let sum = quick_two_sum3(high.hi, high.lo + low.hi);
    return quick_two_sum3(sum.hi, sum.lo + low.lo);
}

fn wide3_mul(a: Wide3, b: Wide3) -> Wide3 {
    let product = two_product3(a.hi, b.hi);
    return quick_two_sum3(product.hi, product.lo + (opaque3(a.hi * b.lo) + opaque3(a.lo * b.hi)));
}

fn wide3_scale(a: Wide3, s: Wide) -> Wide3 {
    return wide3_mul(a, Wide3(vec3f(s.hi), vec3f(s.lo)));
}

fn wide3_dot(a: Wide3, b: Wide3) -> Wide {
    let p = wide3_mul(a, b);
    return wide_add(wide_add(Wide(p.hi.x, p.lo.x), Wide(p.hi.y, p.lo.y)), Wide(p.hi.z, p.lo.z));
}

fn wide3_cross(a: Wide3, b: Wide3) -> Wide3 {
    let there = wide3_mul(Wide3(a.hi.yzx, a.lo.yzx), Wide3(b.hi.zxy, b.lo.zxy));
    let back = wide3_mul(Wide3(a.hi.zxy, a.lo.zxy), Wide3(b.hi.yzx, b.lo.yzx));
    return wide3_add(there, wide3_neg(back));
}

fn wide3_length(a: Wide3) -> Wide {
    return wide_sqrt(wide3_dot(a, a));
}

// The unit vector along `a`, which is no shorter than `TINY` (`plane.wgsl`).
fn wide3_normalize(a: Wide3) -> Wide3 {
    return wide3_scale(a, wide_inverse_sqrt(wide3_dot(a, a)));
}
