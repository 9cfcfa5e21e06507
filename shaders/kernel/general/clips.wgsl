// Mirrors kernel/general/clips.rs in double-float. No list of bounds is stored: the next one behind a distance is the
// nearest of all of them, each computed anew.
#import params
#import scenery
#import kernel/plane
#import kernel/real

// The part of a ray behind a distance up to the next bound of any cut, and the bits of the cuts that contain it,
// regardless of layers.
struct Stretch {
    inside: u32,
    end: Wide,
}

fn clips_behind(line: RayLine, t: Wide) -> Stretch {
    if !wide_less(t, line.end) {
        return Stretch(0u, wide(ENDLESS));
    }
    var end = line.end;
    for (var k = 0u; k < scenery.clip_count; k++) {
        clip_bounds(scenery.clips[k], line, t, &end);
    }
    let middle = ray_line_position(line, wide_times(wide_add(t, end), 0.5));
    var inside = 0u;
    for (var k = 0u; k < scenery.clip_count; k++) {
        inside |= select(0u, 1u << k, clip_holds(scenery.clips[k], middle));
    }
    return Stretch(inside, end);
}

// Whether the space between or on these layers in a stretch is shown.
fn clips_show(inside: u32, lowest: u32, highest: u32) -> bool {
    for (var k = 0u; k < scenery.clip_count; k++) {
        let has_layers = lowest >= scenery.clips[k].first_layer && highest <= scenery.clips[k].last_layer;
        let is_inside = has_layers && (inside & (1u << k)) != 0u;
        if is_inside == (scenery.clips[k].cuts_inside != 0u) {
            return false;
        }
    }
    return true;
}

// Moves `nearest` to the place at which `above` / `below` is met, if that lies between `behind` and it.
fn clip_bound(above: Wide, below: Wide, behind: Wide, nearest: ptr<function, Wide>) {
    // Beyond are places that no ray reaches, or a ray in the bound.
    if abs(below.hi) > 1e-15 {
        clip_bound_at(wide_div(above, below), behind, nearest);
    }
}

fn clip_bound_at(t: Wide, behind: Wide, nearest: ptr<function, Wide>) {
    if wide_less(behind, t) && wide_less(t, *nearest) {
        *nearest = t;
    }
}

// Visits all places at which the ray may pass a bound.
fn clip_bounds(clip: Clip, line: RayLine, behind: Wide, nearest: ptr<function, Wide>) {
    let x = wide3_scale(line.plane.x, line.b);
    let y = line.plane.y;
    if (clip.kind & HAS_HALF_SPACE) != 0u {
        let towards = Wide3(clip.towards_hi, clip.towards_lo);
        let above = wide_sub(Wide(clip.distance_hi, clip.distance_lo), wide3_dot(towards, x));
        clip_bound(above, wide3_dot(towards, y), behind, nearest);
    }
    if (clip.kind & HAS_SHELL) != 0u {
        for (var i = 0u; i < 2u; i++) {
            let radius = select(clip.inner, clip.outer, i == 1u);
            let half = half_chord_squared(Wide(radius.x, radius.y), line.b);
            if half.hi > 0.0 {
                let root = wide_sqrt(half);
                clip_bound_at(wide_neg(root), behind, nearest);
                clip_bound_at(root, behind, nearest);
            }
        }
    }
    if (clip.kind & HAS_LONGITUDES) != 0u {
        for (var i = 0u; i < 2u; i++) {
            let normal = select(clip.west, clip.east, i == 1u);
            clip_bound(wide_neg(clip_along(normal, x)), clip_along(normal, y), behind, nearest);
        }
    }
    if (clip.kind & HAS_LATITUDES) != 0u {
        let xz = Wide(x.hi.z, x.lo.z);
        let yz = Wide(y.hi.z, y.lo.z);
        let half_b = wide_mul(xz, yz);
        for (var i = 0u; i < 2u; i++) {
            let sine = select(clip.south, clip.north, i == 1u);
            // Beyond a pole.
            if abs(sine.x) > 1.0 {
                continue;
            }
            let s2 = wide_mul(Wide(sine.x, sine.y), Wide(sine.x, sine.y));
            let a = wide_sub(wide_mul(yz, yz), s2);
            let c = wide_sub(wide_mul(xz, xz), wide_mul(s2, wide_mul(line.b, line.b)));
            let root = wide_sqrt(wide_max(wide_sub(wide_mul(half_b, half_b), wide_mul(a, c)), wide(0.0)));
            var q = wide_neg(wide_add(half_b, root));
            if half_b.hi < 0.0 {
                q = wide_sub(root, half_b);
            }
            clip_bound(q, a, behind, nearest);
            clip_bound(c, q, behind, nearest);
        }
    }
}

// The component of a vector along a meridian's normal.
fn clip_along(normal: vec4f, v: Wide3) -> Wide {
    let x = wide_mul(Wide(normal.x, normal.z), Wide(v.hi.x, v.lo.x));
    return wide_add(x, wide_mul(Wide(normal.y, normal.w), Wide(v.hi.y, v.lo.y)));
}

// Whether a place lies inside, regardless of layers.
fn clip_holds(clip: Clip, at: Wide3) -> bool {
    if (clip.kind & HAS_HALF_SPACE) != 0u {
        let along = wide3_dot(Wide3(clip.towards_hi, clip.towards_lo), at);
        if !wide_less(Wide(clip.distance_hi, clip.distance_lo), along) {
            return false;
        }
    }
    let r = wide3_length(at);
    if (clip.kind & HAS_SHELL) != 0u {
        if wide_less(r, Wide(clip.inner.x, clip.inner.y)) || wide_less(Wide(clip.outer.x, clip.outer.y), r) {
            return false;
        }
    }
    if (clip.kind & HAS_LATITUDES) != 0u {
        let z = Wide(at.hi.z, at.lo.z);
        let south = wide_mul(r, Wide(clip.south.x, clip.south.y));
        let north = wide_mul(r, Wide(clip.north.x, clip.north.y));
        if wide_less(z, south) || wide_less(north, z) {
            return false;
        }
    }
    if (clip.kind & HAS_LONGITUDES) != 0u {
        let is_east = clip_along(clip.west, at).hi >= 0.0;
        let is_west = clip_along(clip.east, at).hi <= 0.0;
        return select(is_east && is_west, is_east || is_west, (clip.kind & IS_WIDE) != 0u);
    }
    return true;
}
