// Mirrors kernel/ray.rs.
//
// Each of `piece`, `monotone` and `frustum` is called from one place only, since drivers inline every call.
#import params
#import kernel/column
#import kernel/roundoff
#import kernel/lit
#import gradients
#concentric #import kernel/ray/concentric
#native #import kernel/general/native
#scene #import kernel/general/frustum

struct Ray {
    // The span of the transfer function at the ray's position, if known.
    span: u32,
    is_in_span: bool,
    columns: u32,
    frusta: u32,
    void_frusta: u32,
    // If IN_PARTS: see `ray_min_transmittance`.
    min_transmittance: f32,
    // If the scene is lit.
    shading: RayShading,
}

// The transmittance at which the ray ends, reduced by the fragments before.
fn ray_min_transmittance(ray: ptr<function, Ray>) -> f32 {
    if IN_PARTS {
        return (*ray).min_transmittance;
    }
    return params.min_transmittance;
}

// Transmittance at which the ray has ended: that of a piece that ended early is accurate to the last digit only.
fn ray_rest(ray: ptr<function, Ray>) -> f32 {
    return ray_min_transmittance(ray) * 1.001 + 2.0 * ROUNDING;
}

// Radiance along a ray, and the surfaces that it met.
struct Traced {
    light: Radiance,
    ray: Ray,
    is_met: bool,
}

fn trace(eye: Wide3, dir: Wide3, hint: u32) -> Traced {
    var light = radiance_none();
    var ray: Ray;
    if IS_LIT {
        ray.shading = shading_along(lighting, dir);
    }
    let line = ray_line_new(eye, dir, shell_outer());
    if !line.is_there {
        return Traced(light, ray, false);
    }
    var walk = walk_new(line, hint);
#scene     scene_begin(line, eye, dir);
    var gap = 0u;
    var is_in_gap = false;
    var is_over = false;
    while !is_over && !walk.is_over {
        let is_void = grid_is_void(walk.contour.triangle);
        let column = walk_next_column(&walk, line);
        ray.columns++;
        if is_void {
            is_over = void_column(&ray, &light, line, column);
        } else {
            if !is_in_gap {
#concentric                 gap = shell_gap(column.entry.rho);
#native                 gap = native_gap(column);
            }
            is_over = cross(&ray, &light, line, column, &gap);
        }
        is_in_gap = !is_void;
    }
    // Neither: the driver has ended the loop.
    is_lost = is_lost || !(is_over || walk.is_over);
    return Traced(light, ray, true);
}

// The gradient from `a` to `b`, beside the value.
fn frustum_interpolant_over(at_a: Chord, at_b: Chord, tau_a: f32, tau_b: f32, eps: f32) -> FrustumInterpolant {
    let slope_a = at_a.exit_gradient - at_a.entry_gradient;
    let slope_b = at_b.exit_gradient - at_b.entry_gradient;
    return FrustumInterpolant(
        lerp3(at_a.entry_gradient, at_a.exit_gradient, tau_a),
        lerp3(at_b.entry_gradient, at_b.exit_gradient, tau_b),
        (tau_b - tau_a) * ((slope_a - slope_b) + eps * slope_a),
        eps,
        max(at_a.gradient_size, at_b.gradient_size),
    );
}

fn void_column(ray: ptr<function, Ray>, light: ptr<function, Radiance>, line: RayLine, column: Column) -> bool {
    (*ray).is_in_span = false;
#scene     scene_leave();
    let met = ray_line_first_inside(line, shell_inner(), column.entry.t, column.exit.t);
    return met.is_there && core(ray, light, met.t, round_body(ray, line, met.t));
}

// The factor that lighting gives to the colour of a spherical core.
fn round_body(ray: ptr<function, Ray>, line: RayLine, t: Wide) -> f32 {
    if IS_LIT {
        return ray_shading_solid((*ray).shading, normalize(ray_line_position(line, t).hi));
    }
    return 1.0;
}

// Returns true if the core ends the ray; `body` is the factor of its colour.
fn core(ray: ptr<function, Ray>, light: ptr<function, Radiance>, t: Wide, body: f32) -> bool {
    if params.has_core == 0u {
        return false;
    }
#scene     scene_boundary(BOUNDARY_CORE, (*light).alpha, t);
#painted     if params.paints_core != 0u {
#painted         run_paint(ray, light, t, PAINTED_CORE);
#painted         return true;
#painted     }
    let color = params.core * body;
    // Colour, factor and product are rounded.
    let rounded = ROUNDING * largest(color);
    radiance_over(light, Radiance(color, 1.0, 0.0, rounded * rounded, 0.0));
    return true;
}

fn frustum(ray: ptr<function, Ray>, light: ptr<function, Radiance>, segment: Segment, interpolant: FrustumInterpolant) -> bool {
    (*ray).frusta++;
    let is_constant = segment.f0 == segment.f1 && segment.kappa == 0.0;
    var k = 0u;
    if (*ray).is_in_span && !is_constant {
        k = spans_follow((*ray).span, segment.f0);
    } else {
        k = spans_find(segment.f0);
    }
    let is_whole = IS_EXACT && span_holds(spans[k], segment);
    var turn = Turn(0.0, 0.0, false);
    if !is_whole {
        turn = segment_extremum(segment);
    }
    let start = vec2f(0.0, segment.f0);
    let middle = vec2f(turn.u, turn.f);
    let end = vec2f(1.0, segment.f1);
    for (var i = 0u; i < select(1u, 2u, turn.is_there); i++) {
        var part = segment;
        var range = vec2f(0.0, 1.0);
        if turn.is_there {
            let is_behind = i == 1u;
            part = segment_part(segment, select(start, middle, is_behind), select(middle, end, is_behind));
            range = select(vec2f(0.0, turn.u), vec2f(turn.u, 1.0), is_behind);
        }
        k = monotone(ray, light, part, k, interpolant, range, is_whole);
    }
    (*ray).span = k;
    (*ray).is_in_span = true;
    if HAS_STEPS {
        near_steps(light, segment, 0u, params.steps, 0.0);
    }
    let through = 1.0 - (*light).alpha;
    if through > ray_rest(ray) {
        return false;
    }
    (*light).error += through * params.brightest;
    return true;
}

// `is_whole` segments stay in their span, and need not be monotone.
fn monotone(
    ray: ptr<function, Ray>,
    light: ptr<function, Radiance>,
    segment: Segment,
    first: u32,
    interpolant: FrustumInterpolant,
    range: vec2f,
    is_whole: bool,
) -> u32 {
    var k = first;
    let f0 = segment.f0;
    let f1 = segment.f1;
    let is_inside = is_whole || (min(f0, f1) >= spans[k].low && max(f0, f1) <= spans[k].high);
    var roundoff = roundoff_new(segment, medium_sample_at(spans[k], f0));
    let rising = f1 >= f0;
    var rest = segment;
    var from_ = range.x;
    var at = 0.0;
    loop {
        let span = spans[k];
        let knot = select(span.low, span.high, rising);
        let is_last = is_inside || select(f1 >= knot, f1 <= knot, rising);
        var end = vec2f(1.0, f1);
        if !is_last {
            end = vec2f(segment_solve(rest, knot), knot);
        }
        let to = lerp(from_, range.y, end.x);
        if end.x > 0.0 {
            let before = (*light).alpha;
            let f = vec2f(rest.f0, end.y);
            var part = rest;
            if !is_last {
                part = segment_part(rest, vec2f(0.0, f.x), end);
            }
            let is_between = rest.f0 != f0 && !is_last;
            let reach = select(segment_reach(segment), between(f), is_between);
            piece(ray, light, part, span, interpolant, vec2f(from_, to), reach);
            if !is_inside {
                let mean = medium_sample_at(span, 0.5 * (f.x + f.y));
                let change = span.steepest * abs(f.y - f.x);
                let cut = KnotCrossing(f, segment_slope(segment, at), part.length, mean, change, span_is_narrow(span));
                roundoff_cut(&roundoff, light, before, cut);
            }
        }
        if is_last {
            if !is_inside {
                roundoff_shift(&roundoff, light, medium_sample_at(span, f1));
            }
            break;
        }
        if roundoff.absorbed_before < 0.0 {
            roundoff.absorbed_before = (*light).alpha;
        }
        rest = segment_part(rest, end, vec2f(1.0, f1));
        from_ = to;
        at = lerp(at, 1.0, end.x);
        k = select(k - 1u, k + 1u, rising);
    }
    return k;
}

fn piece(
    ray: ptr<function, Ray>,
    light: ptr<function, Radiance>,
    segment: Segment,
    span: Span,
    interpolant: FrustumInterpolant,
    range: vec2f,
    reach: f32,
) {
    let through = 1.0 - (*light).alpha;
    if span_is_clear_in(span, segment) || through <= ray_rest(ray) {
        return;
    }
    let budget = ErrorBudget(params.color_tolerance, ray_min_transmittance(ray), through, reach);
    var behind: Radiance;
    if IS_LIT {
        let lit = Lit(budget, (*ray).shading, span, interpolant);
        behind = lit_light(lit, segment, range, lighting.max_cuts, *light);
    } else {
        behind = integrate(segment, span, budget);
    }
    radiance_over(light, behind);
    let off = 0.5 * ROUNDING * (*light).alpha;
    (*light).variance += off * off;
}

// Accounts for the `count` steps from `first` on, each with an extinction of at least `least`.
fn near_steps(light: ptr<function, Radiance>, segment: Segment, first: u32, count: u32, least: f32) {
    let steep = abs(segment.f1 - segment.f0) + abs(segment.kappa);
    if steep == 0.0 {
        return;
    }
    let reach = 8.0 * segment_reach(segment);
    let root = sqrt(reach / (reach + steep));
    let rise = segment.f1 - segment.f0;
    let slopes = vec2f(rise + segment.kappa, rise - segment.kappa / (1.0 + segment.eps));
    let at_ends = min(reach / (reach + abs(slopes)), vec2f(root));
    let turn = segment_extremum(segment);
    for (var i = 0u; i < select(2u, 3u, turn.is_there); i++) {
        var extreme = turn.f;
        var part = root;
        if i < 2u {
            extreme = select(segment.f0, segment.f1, i == 1u);
            part = select(at_ends.x, at_ends.y, i == 1u);
        }
        for (var j = first; j < first + count && steps[j].value <= extreme + reach; j++) {
            if steps[j].value >= extreme - reach {
                let beyond = absorbed_by(segment.length * part * max(steps[j].extinction + steps[j].slope * reach, least));
                (*light).error += (1.0 - (*light).alpha) * beyond;
            }
        }
    }
}

fn between(knots: vec2f) -> f32 {
    return 0.5 * ROUNDING * (abs(knots.x) + abs(knots.y));
}
