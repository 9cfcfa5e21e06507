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
    // Index of its ray in `passed`, and its place among the fragments of that ray.
    ray: u32,
    number: u32,
    // Its end: NOT_PAINTED, or the number of a surface layer with lines, or PAINTED_CORE, and the triangle there.
    painted: u32,
    triangle: u32,
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
    // The surfaces that the ray met in it.
    order: u32,
    nearness: f32,
}

const NOT_PAINTED: u32 = 0xFFFFFFFFu;
const PAINTED_CORE: u32 = 0xFFFFFFFEu;

struct Found {
    // Exceeds the room if there is not enough.
    count: atomic<u32>,
    all: array<Fragment>,
}

// In storage: lavapipe fails to compile the shader of a scene if it is uniform.
#plain @group(2) @binding(1) var<storage, read> part: Part;
// A bit per triangle.
#plain @group(2) @binding(2) var<storage, read> owned: array<u32>;
#plain @group(2) @binding(3) var<storage, read_write> found: Found;
#scene @group(2) @binding(3) var<storage, read> part: Part;
#scene @group(2) @binding(4) var<storage, read> owned: array<u32>;
#scene @group(2) @binding(5) var<storage, read_write> found: Found;

fn part_has(triangle: u32) -> bool {
    return triangle < params.triangles && ((owned[triangle >> 5u] >> (triangle & 31u)) & 1u) == 1u;
}

fn part_is_near(line: RayLine) -> bool {
    let x = dot(part.middle, line.plane.x.hi) - line.b.hi;
    let q = dot(part.middle, line.plane.q.hi);
    return x * x + q * q <= part.reach;
}

// The fragment of a ray that is being traced.
struct Run {
    place: u32,
    from_: Wide,
    triangle: u32,
    // The number of fragments before.
    number: u32,
    // Whether the one before ends at lines.
    goes_on: bool,
}

var<private> run: Run;

// Adds the fragment up to `to`, which ends at `painted`.
fn run_add(to: Wide, light: Radiance, painted: u32) {
    let at = atomicAdd(&found.count, 1u);
    if at < part.max_fragments {
        found.all[at] = fragment_new(to, light, painted);
    }
    run.number++;
}

// Begins the fragment behind `light`.
fn run_restart(ray: ptr<function, Ray>, light: ptr<function, Radiance>) {
    (*ray).min_transmittance /= 1.0 - (*light).alpha;
    *light = radiance_none();
#scene     ray_scene.surfaces = BoundarySignature(0u, 0.0);
}

// Ends the fragment at lines or at the core, whose light the host adds, and begins the next one.
fn run_paint(ray: ptr<function, Ray>, light: ptr<function, Radiance>, t: Wide, painted: u32) {
    run_add(t, *light, painted);
    run_restart(ray, light);
    run.from_ = t;
    run.goes_on = true;
}

fn fragment_new(to: Wide, light: Radiance, painted: u32) -> Fragment {
    return Fragment(
        run.place,
        run.number,
        painted,
        run.triangle,
        run.from_.hi,
        run.from_.lo,
        to.hi,
        to.lo,
        light.color.x,
        light.color.y,
        light.color.z,
        light.alpha,
        light.error,
        light.variance + light.shade_variance,
#plain         0u,
#plain         0.0,
#scene         ray_scene.surfaces.order,
#scene         ray_scene.surfaces.nearness,
    );
}

fn fragment_is_clear(light: Radiance) -> bool {
#scene     if ray_scene.surfaces.order != 0u {
#scene         return false;
#scene     }
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
    run = Run(place, wide(0.0), 0u, 0u, false);
    let line = ray_line_new(eye, dir, shell_outer());
    if !line.is_there || !part_is_near(line) {
        return InPart(ray, 0u);
    }
    if IS_LIT {
        ray.shading = shading_along(lighting, dir);
    }
    ray.min_transmittance = params.min_transmittance;
#concentric     let highest = shell_inner();
#native     let highest = Wide(scenery.core_high.x, scenery.core_high.y);
    let near_core = ray_line_first_inside(line, highest, line.start, line.end);
    let behind_core =
        ray_line_first_inside(line, Wide(part.lowest_hi, part.lowest_lo), line.start, line.end);
    var light = radiance_none();
    var walk = walk_new(line, hint);
#scene     scene_begin(line, eye, dir);
    var gap = 0u;
    var run_to = wide(0.0);
    var has_run = false;
    // Behind the core, or with almost no light left.
    var is_over = false;
    loop {
        let has_column = !is_over && !walk.is_over;
        let triangle = walk.contour.triangle;
        let is_own = has_column && part_has(triangle);
        if has_run && !is_own {
            let meets_core = params.has_core != 0u && near_core.is_there && !wide_less(run_to, near_core.t);
            if is_over || meets_core || run.goes_on || !fragment_is_clear(light) {
                run_add(run_to, light, NOT_PAINTED);
            }
            run_restart(&ray, &light);
            ray.is_in_span = false;
#scene             scene_restart();
            has_run = false;
            run.goes_on = false;
        }
        if !has_column {
            break;
        }
        let column = walk_next_column(&walk, line);
        ray.columns++;
        if !is_own {
            is_over = params.has_core != 0u && behind_core.is_there && wide_less(behind_core.t, column.exit.t);
            continue;
        }
        if !has_run {
#concentric             gap = shell_gap(column.entry.rho);
#native             gap = native_gap(column);
            run.from_ = column.entry.t;
        }
        has_run = true;
        run.triangle = triangle;
        run_to = column.exit.t;
        is_over = cross(&ray, &light, line, column, &gap);
        if is_over {
            run_to = wide(ENDLESS);
        }
    }
    // Neither, or not yet passed on: the driver has ended the loop.
    is_lost = is_lost || has_run || !(is_over || walk.is_over);
    return InPart(ray, run.number);
}
