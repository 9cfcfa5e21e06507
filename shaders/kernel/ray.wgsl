// Mirrors kernel/ray.rs.
//
// `cross` of kernel/column.rs is here, with its visitor: WGSL cannot pass functions. Each of `piece`, `monotone` and
// `frustum` is called from one place only, since drivers inline every call.
#import params
#import kernel/column
#import kernel/roundoff
#import kernel/lit
#import gradients
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
                gap = shell_gap(column.entry.rho);
            }
            is_over = cross(&ray, &light, line, column, &gap);
        }
        is_in_gap = !is_void;
    }
    // Neither: the driver has ended the loop.
    is_lost = is_lost || !(is_over || walk.is_over);
    return Traced(light, ray, true);
}

// Visits the gaps that the ray passes in `column`; returns true if the ray ends.
fn cross(
    ray: ptr<function, Ray>,
    light: ptr<function, Radiance>,
    line: RayLine,
    column: Column,
    gap: ptr<function, u32>,
) -> bool {
    let top = params.layers;
    let entry = column.entry.rho;
    let exit = column.exit.rho;
    let rise = wide_apart(exit, entry);
    let rising = rise >= 0.0;
    let scale = select(0.0, 1.0 / rise, rise != 0.0);
    let length = wide_apart(column.exit.t, column.entry.t);
    let bases = samples_bases(column.cells);
    var a = RayPoint(0.0, 0.0, entry, 1.0 / entry.hi);
    var near: Chord;
    var has_near = false;
    var is_first = true;
    loop {
        let behind = select(*gap, *gap - 1u, rising);
        let ahead = select(*gap - 1u, *gap, rising);
        var b = RayPoint(1.0, 1.0, exit, 0.0);
        var passes = false;
        if ahead < top {
            let radius = shell_radius(ahead);
            let above = wide_apart(radius, exit);
            passes = select(above > 0.0, above <= 0.0, rising);
            if passes {
                let u = clamp(wide_apart(radius, entry) * scale, 0.0, 1.0);
                let curvature = shell[ahead].curvature;
                b = RayPoint(u, clamp(u * exit.hi * curvature, 0.0, 1.0), radius, curvature);
            }
        }
        if *gap > 0u && *gap < top {
            if !has_near {
                near = chord(column, bases, behind);
            }
            let far = chord(column, bases, ahead);
            var at_a = near;
            if !has_near {
                let w = shell_fraction(*gap, a.rho);
                at_a = chord_mix(near, far, select(1.0 - w, w, rising));
            }
            var at_b = far;
            if !passes {
                let w = shell_fraction(*gap, b.rho);
                at_b = chord_mix(near, far, select(1.0 - w, w, rising));
            }
            // The whole column if no layer is passed. Else a separate fraction, not the difference of two.
            let climb = wide_apart(b.rho, a.rho);
            let part = select(clamp(climb * scale, 0.0, 1.0), 1.0, is_first && !passes);
#scene             let way = GapWay(*gap, a, b, part);
#scene             let is_hidden = scene_hides(line, column, way);
#scene             let is_void = at_a.is_void || at_b.is_void;
#plain             if at_a.is_void || at_b.is_void {
#scene             if volumes_skip(is_void) {
                (*ray).frusta++;
#plain                 (*ray).void_frusta++;
#scene                 (*ray).void_frusta += select(1u, 0u, is_hidden);
                (*ray).is_in_span = false;
            } else {
                let eps = max(climb * a.curvature, ROUNDING - 1.0);
                let slope_a = at_a.exit - at_a.entry;
                let slope_b = at_b.exit - at_b.entry;
                let kappa = (b.tau - a.tau) * ((slope_a - slope_b) + eps * slope_a);
                let size = max(near.size, far.size);
                let segment =
                    Segment(chord_at(at_a, a.tau), chord_at(at_b, b.tau), kappa, eps, length * part, size);
                var interpolant: FrustumInterpolant;
                if IS_LIT {
                    interpolant = frustum_interpolant_over(at_a, at_b, a.tau, b.tau, eps);
                }
#plain                 if frustum(ray, light, segment, interpolant) {
#scene                 let own = FieldSegment(segment, interpolant, !is_void);
#scene                 if !is_hidden && volumes_enter(column, way, own) {
#scene                     (*ray).void_frusta++;
#scene                 }
#scene                 if scene_frustum(ray, light, line, column, bases, way, own) {
                    return true;
                }
            }
            near = far;
            has_near = true;
        } else {
            if *gap == 0u && core(ray, light, line, wide_add(column.entry.t, wide(a.u * length))) {
                return true;
            }
            has_near = false;
#scene             scene_leave();
        }
        if !passes {
            break;
        }
#scene         if scene_layer(ray, light, line, column, ahead, b) {
#scene             return true;
#scene         }
        *gap = select(*gap - 1u, *gap + 1u, rising);
        a = b;
        is_first = false;
    }
    return false;
}

fn chord(column: Column, bases: array<Base, 3>, layer: u32) -> Chord {
    let values = vec3f(
        samples_get(bases[0], layer),
        samples_get(bases[1], layer),
        samples_get(bases[2], layer),
    );
    var chord = chord_over(values, column.entry.weight, column.exit.weight);
    if IS_LIT {
        chord_over_gradients(
            &chord,
            gradients_get(bases[0], layer),
            gradients_get(bases[1], layer),
            gradients_get(bases[2], layer),
            column.entry.weight,
            column.exit.weight,
        );
    }
    return chord;
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
    return met.is_there && core(ray, light, line, met.t);
}

// Returns true if the core ends the ray.
fn core(ray: ptr<function, Ray>, light: ptr<function, Radiance>, line: RayLine, t: Wide) -> bool {
    if HAS_CORE {
        var body = 1.0;
        if IS_LIT {
            body = ray_shading_solid((*ray).shading, normalize(ray_line_position(line, t).hi));
        }
#scene         scene_boundary(BOUNDARY_CORE, (*light).alpha, t);
        radiance_over(light, radiance_plain(params.core * body, 1.0));
    }
    return HAS_CORE;
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
        behind = lit_light(lit, segment, range, lighting.max_cuts, spare_of(*light, params.color_tolerance));
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
