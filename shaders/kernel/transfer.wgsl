// Mirrors kernel/transfer.rs.
#import params
#import kernel/segment

struct Span {
    low: f32,
    high: f32,
    anchor: f32,
    extinction: f32,
    color: vec3f,
    extinction_slope: f32,
    color_slope: vec3f,
    steepest: f32,
    is_clear: u32,
    brightest: f32,
}

// A value at which the transfer function jumps, the larger extinction of its two sides, and its slope beside narrow spans.
struct Step {
    value: f32,
    extinction: f32,
    slope: f32,
}

@group(0) @binding(4) var<storage, read> spans: array<Span>;
@group(0) @binding(5) var<storage, read> steps: array<Step>;

fn span_holds(span: Span, segment: Segment) -> bool {
    let swing = 0.5 * abs(segment.kappa);
    let low = min(segment.f0, segment.f1);
    let high = max(segment.f0, segment.f1);
    return low - swing >= span.low && high + swing <= span.high && segment.eps > -0.75;
}

fn span_is_clear_in(span: Span, segment: Segment) -> bool {
    let is_constant = segment.f0 == segment.f1 && segment.kappa == 0.0;
    return span.is_clear != 0u || (is_constant && span_extinction(span, segment.f0) == 0.0);
}

fn span_extinction(span: Span, f: f32) -> f32 {
    return max(span.extinction + span.extinction_slope * (f - span.anchor), 0.0);
}

fn span_is_narrow(span: Span) -> bool {
    return span.high - span.low < 1e-3;
}

fn span_color(span: Span, f: f32) -> vec3f {
    return span.color + span.color_slope * (f - span.anchor);
}

fn spans_follow(from_: u32, f: f32) -> u32 {
    if FEW_KNOTS {
        return clamp(from_, knots_below(params.knots < vec4f(f)), knots_below(params.knots <= vec4f(f)));
    }
    return spans_walk(from_, f);
}

fn spans_find(f: f32) -> u32 {
    if FEW_KNOTS {
        return knots_below(params.knots <= vec4f(f));
    }
    return spans_search(f);
}

// The number of flags that are set: knots are in order.
fn knots_below(is_below: vec4<bool>) -> u32 {
    let counted = select(vec4u(0u), vec4u(1u), is_below);
    return counted.x + counted.y + counted.z + counted.w;
}

fn spans_walk(from_: u32, f: f32) -> u32 {
    var k = from_;
    while k + 1u < params.spans && f > spans[k].high {
        k++;
    }
    while k > 0u && f < spans[k].low {
        k--;
    }
    return k;
}

fn spans_search(f: f32) -> u32 {
    var low = 0u;
    var high = params.spans;
    while low < high {
        let middle = (low + high) / 2u;
        if spans[middle].low <= f {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return max(low, 1u) - 1u;
}
