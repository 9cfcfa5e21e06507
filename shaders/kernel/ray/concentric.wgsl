// The columns of concentric layers: `cross` of kernel/column.rs with its visitor, as WGSL cannot pass functions.
#import kernel/ray

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
#scene             {
#plain             if at_a.is_void || at_b.is_void {
#plain                 (*ray).frusta++;
#plain                 (*ray).void_frusta++;
#plain                 (*ray).is_in_span = false;
#plain             } else {
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
#scene                 let own = FieldSegment(segment, interpolant, !(at_a.is_void || at_b.is_void));
#scene                 if scene_gap(ray, light, line, column, bases, GapWay(*gap, a, b, part), own) {
                    return true;
                }
            }
            near = far;
            has_near = true;
        } else {
            let t = wide_add(column.entry.t, wide(a.u * length));
            if *gap == 0u && core(ray, light, t, round_body(ray, line, t)) {
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
