// Mirrors kernel/ray/fragment.rs. Fragments of all rays are appended to `found` in no order: the host sorts them.
#import kernel/ray

// Parameters of a rank's part that all rays share.
struct Part {
    // A ball around own columns, and the square of its radius.
    middle: vec3f,
    reach: f32,
    // Radius of the lowest place of any rank's facets of the innermost layer.
    lowest_hi: f32,
    lowest_lo: f32,
    // Room in `found`.
    max_fragments: u32,
}

struct Fragment {
    // Index of its ray in `passed`.
    ray: u32,
    entry_hi: f32,
    entry_lo: f32,
    // ENDLESS if the ray ended in it.
    exit_hi: f32,
    exit_lo: f32,
    red: f32,
    green: f32,
    blue: f32,
    alpha: f32,
    error: f32,
    variance: f32,
}

struct Found {
    // Exceeds the room if there is not enough.
    count: atomic<u32>,
    all: array<Fragment>,
}

@group(2) @binding(1) var<uniform> part: Part;
// A bit per triangle.
@group(2) @binding(2) var<storage, read> owned: array<u32>;
@group(2) @binding(3) var<storage, read_write> found: Found;

fn part_has(triangle: u32) -> bool {
    return triangle < params.triangles && ((owned[triangle >> 5u] >> (triangle & 31u)) & 1u) == 1u;
}

fn part_is_near(line: RayLine) -> bool {
    let x = dot(part.middle, line.plane.x.hi) - line.b.hi;
    let q = dot(part.middle, line.plane.q.hi);
    return x * x + q * q <= part.reach;
}

fn fragment_new(place: u32, from_: Wide, to: Wide, light: Radiance) -> Fragment {
    return Fragment(
        place,
        from_.hi,
        from_.lo,
        to.hi,
        to.lo,
        light.color.x,
        light.color.y,
        light.color.z,
        light.alpha,
        light.error,
        light.variance,
    );
}

fn fragment_is_clear(light: Radiance) -> bool {
    return light.alpha == 0.0 && light.error == 0.0 && light.variance == 0.0 && all(light.color == vec3f(0.0));
}

// The boundaries that the ray met, and its number of fragments.
struct InPart {
    ray: Ray,
    count: u32,
}

// Adds the fragments of the ray at `place` to `found`.
fn fragments(eye: Wide3, dir: Wide3, hint: u32, place: u32) -> InPart {
    var ray: Ray;
    var count = 0u;
    let line = ray_line_new(eye, dir, shell_outer());
    if !line.is_there || !part_is_near(line) {
        return InPart(ray, count);
    }
    if IS_LIT {
        ray.shading = shading_along(lighting, dir);
    }
    ray.min_transmittance = params.min_transmittance;
    let near_core = ray_line_first_inside(line, shell_inner(), line.start, line.end);
    let behind_core =
        ray_line_first_inside(line, Wide(part.lowest_hi, part.lowest_lo), line.start, line.end);
    var light = radiance_none();
    var walk = walk_new(line, hint);
    var gap = 0u;
    var run_from = wide(0.0);
    var run_to = wide(0.0);
    var has_run = false;
    // Behind the core, or with almost no light left.
    var is_over = false;
    loop {
        let has_column = !is_over && !walk.is_over;
        let is_own = has_column && part_has(walk.contour.triangle);
        if has_run && !is_own {
            let meets_core = HAS_CORE && near_core.is_there && !wide_less(run_to, near_core.t);
            if is_over || meets_core || !fragment_is_clear(light) {
                let at = atomicAdd(&found.count, 1u);
                if at < part.max_fragments {
                    found.all[at] = fragment_new(place, run_from, run_to, light);
                }
                count++;
            }
            ray.min_transmittance /= 1.0 - light.alpha;
            light = radiance_none();
            ray.is_in_span = false;
            has_run = false;
        }
        if !has_column {
            break;
        }
        let column = walk_next_column(&walk, line);
        ray.columns++;
        if !is_own {
            is_over = HAS_CORE && behind_core.is_there && wide_less(behind_core.t, column.exit.t);
            continue;
        }
        if !has_run {
            gap = shell_gap(column.entry.rho);
            run_from = column.entry.t;
        }
        has_run = true;
        run_to = column.exit.t;
        is_over = cross(&ray, &light, line, column, &gap);
        if is_over {
            run_to = wide(ENDLESS);
        }
    }
    // Neither, or not yet passed on: the driver has ended the loop.
    is_lost = is_lost || has_run || !(is_over || walk.is_over);
    return InPart(ray, count);
}
