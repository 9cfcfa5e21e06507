// Mirrors kernel/plane.rs in double-float.
#import kernel/wide

struct Plane {
    x: Wide3,
    y: Wide3,
    q: Wide3,
}

// A vertex of the mesh in a plane: its x, y and q.
struct PlaneVertex {
    cell: u32,
    at: Wide3,
}

struct Point {
    x: Wide,
    y: Wide,
}

fn point_cross(a: Point, b: Point) -> Wide {
    return wide_sub(wide_mul(a.x, b.y), wide_mul(a.y, b.x));
}

fn point_dot(a: Point, b: Point) -> Wide {
    return wide_add(wide_mul(a.x, b.x), wide_mul(a.y, b.y));
}

fn point_lerp(a: Point, b: Point, w: Wide) -> Point {
    return Point(wide_lerp(a.x, b.x, w), wide_lerp(a.y, b.y, w));
}

fn plane_vertex_is_left(seen: PlaneVertex) -> bool {
    return seen.at.hi.z >= 0.0;
}

fn plane_vertex_point(seen: PlaneVertex) -> Point {
    return Point(Wide(seen.at.hi.x, seen.at.lo.x), Wide(seen.at.hi.y, seen.at.lo.y));
}

fn plane_vertex_q(seen: PlaneVertex) -> Wide {
    return Wide(seen.at.hi.z, seen.at.lo.z);
}

// A length that is negligible on any planet and whose square does not underflow.
const TINY: f32 = 1e-15;

// The least distance from the centre of a line that passes it, as in `plane.rs`, but more than the rounding here.
const LEAST_B: f32 = 1e-12;

// The plane of the great circle from `from_` towards `to`; if these are equal or opposite, q is 0.
fn plane_through(from_: Wide3, to: Wide3) -> Plane {
    let upwards = wide3_cross(from_, to);
    if length(upwards.hi) < TINY {
        let none = Wide3(vec3f(0.0), vec3f(0.0));
        return Plane(from_, none, none);
    }
    let q = wide3_normalize(upwards);
    return Plane(from_, wide3_normalize(wide3_cross(q, from_)), q);
}

fn plane_see(plane: Plane, cell: u32, direction: Wide3) -> PlaneVertex {
    // The three dot products side by side.
    let x = wide3_mul(
        Wide3(vec3f(direction.hi.x), vec3f(direction.lo.x)),
        Wide3(
            vec3f(plane.x.hi.x, plane.y.hi.x, plane.q.hi.x),
            vec3f(plane.x.lo.x, plane.y.lo.x, plane.q.lo.x),
        ),
    );
    let y = wide3_mul(
        Wide3(vec3f(direction.hi.y), vec3f(direction.lo.y)),
        Wide3(
            vec3f(plane.x.hi.y, plane.y.hi.y, plane.q.hi.y),
            vec3f(plane.x.lo.y, plane.y.lo.y, plane.q.lo.y),
        ),
    );
    let z = wide3_mul(
        Wide3(vec3f(direction.hi.z), vec3f(direction.lo.z)),
        Wide3(
            vec3f(plane.x.hi.z, plane.y.hi.z, plane.q.hi.z),
            vec3f(plane.x.lo.z, plane.y.lo.z, plane.q.lo.z),
        ),
    );
    return PlaneVertex(cell, wide3_add(wide3_add(x, y), z));
}

fn plane_point(plane: Plane, direction: Wide3) -> Point {
    return Point(wide3_dot(direction, plane.x), wide3_dot(direction, plane.y));
}

struct RayLine {
    plane: Plane,
    b: Wide,
    start: Wide,
    end: Wide,
    // Whether any part is inside the sphere.
    is_there: bool,
}

// (r - b)(r + b): the square of half the chord that a line at distance b has in a sphere of radius r.
fn half_chord_squared(r: Wide, b: Wide) -> Wide {
    return wide_mul(wide_sub(r, b), wide_add(r, b));
}

fn any_orthonormal_vector(v: Wide3) -> Wide3 {
    let size = abs(v.hi);
    var axis = vec3f(0.0, 0.0, 1.0);
    if size.x <= size.y && size.x <= size.z {
        axis = vec3f(1.0, 0.0, 0.0);
    } else if size.y <= size.z {
        axis = vec3f(0.0, 1.0, 0.0);
    }
    return wide3_normalize(wide3_cross(v, Wide3(axis, vec3f(0.0))));
}

// The component of `x` perpendicular to the unit vector `dir`.
fn upright(x: Wide3, dir: Wide3) -> Wide3 {
    return wide3_add(x, wide3_neg(wide3_scale(dir, wide3_dot(x, dir))));
}

fn ray_line_new(eye: Wide3, dir: Wide3, outer: Wide) -> RayLine {
    let closest = upright(eye, dir);
    var line: RayLine;
    line.b = wide3_length(closest);
    line.is_there = false;
    let half = half_chord_squared(outer, line.b);
    if half.hi <= 0.0 {
        return line;
    }
    line.end = wide_sqrt(half);
    line.start = wide_max(wide3_dot(eye, dir), wide_neg(line.end));
    if max(line.b.hi, abs(line.start.hi)) < TINY {
        line.start = wide(TINY);
    }
    line.is_there = wide_less(line.start, line.end);
    var x = any_orthonormal_vector(dir);
    if line.b.hi > TINY {
        let straight = upright(wide3_normalize(closest), dir);
        if length(straight.hi) > TINY {
            x = wide3_normalize(upright(wide3_normalize(straight), dir));
        }
    }
    line.plane = Plane(x, dir, wide3_cross(x, dir));
    if line.start.hi < 0.0 {
        line.b = wide_max(line.b, wide(LEAST_B));
    }
    return line;
}

fn ray_line_at(line: RayLine, t: Wide) -> Point {
    return Point(line.b, t);
}

// A place on a line, if there is one.
struct Inside {
    t: Wide,
    is_there: bool,
}

fn ray_line_first_inside(line: RayLine, radius: Wide, from_: Wide, to: Wide) -> Inside {
    let half = half_chord_squared(radius, line.b);
    if half.hi <= 0.0 {
        return Inside(from_, false);
    }
    let root = wide_sqrt(half);
    let first = wide_max(from_, wide_neg(root));
    return Inside(first, wide_less(first, wide_min(to, root)));
}

fn ray_line_position(line: RayLine, t: Wide) -> Wide3 {
    return wide3_add(wide3_scale(line.plane.x, line.b), wide3_scale(line.plane.y, t));
}
