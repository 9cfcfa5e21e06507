// Mirrors kernel/walk.rs in double-float.
//
// The sides of vertices are as certain as there, a pure function of plane and vertex; loops are bounded anyway, as a
// GPU that never ends hangs its host.
#import params
#import grid
#import kernel/plane

// Set if a walk takes more steps than possible: a broken invariant, or a driver that computes wrongly.
var<private> is_lost: bool = false;
var<private> steps_taken: u32 = 0u;

// Counts a step; returns false if there were too many.
fn may_step() -> bool {
    steps_taken++;
    is_lost = is_lost || steps_taken > params.max_steps;
    return !is_lost;
}

struct Contour {
    triangle: u32,
    cells: vec3u,
    left: PlaneVertex,
    right: PlaneVertex,
    apex: PlaneVertex,
}

struct Crossing {
    point: Point,
    w: Wide,
}

fn crossing_between(left: PlaneVertex, right: PlaneVertex) -> Crossing {
    let w = wide_div(plane_vertex_q(left), wide_sub(plane_vertex_q(left), plane_vertex_q(right)));
    return Crossing(point_lerp(plane_vertex_point(left), plane_vertex_point(right), w), w);
}

// Whether the circle passes `triangle`; if so, sets `contour`.
fn contour_inside(plane: Plane, triangle: u32, contour: ptr<function, Contour>) -> bool {
    let cells = grid_triangle(triangle);
    var seen: array<PlaneVertex, 3>;
    for (var k = 0u; k < 3u; k++) {
        seen[k] = plane_see(plane, cells[k], grid_direction(cells[k]));
    }
    for (var k = 0u; k < 3u; k++) {
        let right = (k + 1u) % 3u;
        if plane_vertex_is_left(seen[k]) && !plane_vertex_is_left(seen[right]) {
            *contour = Contour(triangle, cells, seen[k], seen[right], seen[(k + 2u) % 3u]);
            return true;
        }
    }
    return false;
}

// Number of triangles that are searched around one that rounding misses: two rings.
const AROUND: u32 = 32u;

fn contour_near(plane: Plane, triangle: u32) -> Contour {
    var contour: Contour;
    var queue: array<u32, AROUND>;
    queue[0] = triangle;
    var count = 1u;
    for (var next = 0u; next < count; next++) {
        if contour_inside(plane, queue[next], &contour) {
            return contour;
        }
        for (var k = 0u; k < 3u; k++) {
            let beyond = grid_across(queue[next], k);
            var is_new = count < AROUND;
            for (var i = 0u; i < count; i++) {
                is_new = is_new && queue[i] != beyond;
            }
            if is_new {
                queue[count] = beyond;
                count++;
            }
        }
    }
    is_lost = true;
    return contour;
}

fn contour_entry(contour: ptr<function, Contour>) -> Crossing {
    return crossing_between((*contour).left, (*contour).right);
}

fn contour_exit(contour: ptr<function, Contour>) -> Crossing {
    var left = (*contour).left;
    var right = (*contour).apex;
    if plane_vertex_is_left(right) {
        left = right;
        right = (*contour).right;
    }
    return crossing_between(left, right);
}

fn contour_column_of(cells: vec3u, cell: u32) -> u32 {
    return select(select(2u, 1u, cells.y == cell), 0u, cells.x == cell);
}

fn contour_cross(plane: Plane, contour: ptr<function, Contour>, behind: u32) -> PlaneVertex {
    let cells = (*contour).cells;
    let kept = cells.x + cells.y + cells.z - behind;
    let triangle = grid_across((*contour).triangle, contour_column_of(cells, behind));
    let beyond = grid_triangle(triangle);
    (*contour).triangle = triangle;
    (*contour).cells = beyond;
    let new_cell = beyond.x + beyond.y + beyond.z - kept;
    return plane_see(plane, new_cell, grid_direction(new_cell));
}

fn contour_forward(plane: Plane, contour: ptr<function, Contour>) {
    let apex = (*contour).apex;
    let is_left = plane_vertex_is_left(apex);
    let behind = select((*contour).right.cell, (*contour).left.cell, is_left);
    let new_apex = contour_cross(plane, contour, behind);
    if is_left {
        (*contour).left = apex;
    } else {
        (*contour).right = apex;
    }
    (*contour).apex = new_apex;
}

fn contour_backward(plane: Plane, contour: ptr<function, Contour>) {
    let new_seen = contour_cross(plane, contour, (*contour).apex.cell);
    if plane_vertex_is_left(new_seen) {
        (*contour).apex = (*contour).left;
        (*contour).left = new_seen;
    } else {
        (*contour).apex = (*contour).right;
        (*contour).right = new_seen;
    }
}

fn middle_of(triangle: u32) -> Wide3 {
    let cells = grid_triangle(triangle);
    var sum = Wide3(vec3f(0.0), vec3f(0.0));
    for (var k = 0u; k < 3u; k++) {
        sum = wide3_add(sum, grid_direction(cells[k]));
    }
    return wide3_normalize(sum);
}

// The contour of the ray's plane at its start. The way there from the triangle `hint` follows one plane, or two, as half
// a turn leaves the direction open and takes a stop at a right angle. One loop follows all planes, since compilers put a
// function's code at each of its calls.
fn contour_at_start(line: RayLine, hint: u32) -> Contour {
    let start = wide3_normalize(ray_line_position(line, line.start));
    var triangle = grid_standing(hint);
    var contour: Contour;
    for (var leg = 0u; leg < 3u; leg++) {
        var plane = line.plane;
        var goal = ray_line_at(line, line.start);
        if leg < 2u {
            let middle = middle_of(triangle);
            var stop = start;
            if leg == 0u && wide3_dot(middle, start).hi < -0.5 {
                stop = any_orthonormal_vector(start);
                if wide3_dot(stop, middle).hi < 0.0 {
                    stop = wide3_neg(stop);
                }
            } else {
                leg = 1u;
            }
            plane = plane_through(middle, stop);
            if all(plane.q.hi == vec3f(0.0)) {
                continue;
            }
            goal = plane_point(plane, stop);
        }
        contour = contour_near(plane, triangle);
        while leg == 2u && !is_lost && point_cross(goal, contour_entry(&contour).point).hi > 0.0 && may_step() {
            contour_backward(plane, &contour);
        }
        while !is_lost && point_cross(goal, contour_exit(&contour).point).hi <= 0.0 && may_step() {
            contour_forward(plane, &contour);
        }
        triangle = contour.triangle;
    }
    return contour;
}

// One end of a ray's path through a column. Weights are those of the column's second and third vertex.
struct ColumnEnd {
    t: Wide,
    rho: Wide,
    weight: vec2f,
#native     // The lower halves of the weights.
#native     weight_lo: vec2f,
}

struct Column {
    cells: vec3u,
    entry: ColumnEnd,
    exit: ColumnEnd,
}

struct Walk {
    contour: Contour,
    from_: ContourPoint,
    last_t: Wide,
    last_rho: Wide,
    is_over: bool,
}

struct ContourPoint {
    point: Point,
    weight: vec2f,
#native     weight_lo: vec2f,
}

fn contour_point(point: Point, second: Wide, third: Wide) -> ContourPoint {
#concentric     return ContourPoint(point, vec2f(second.hi, third.hi));
#native     return ContourPoint(point, vec2f(second.hi, third.hi), vec2f(second.lo, third.lo));
}

fn column_end(t: Wide, rho: Wide, place: ContourPoint) -> ColumnEnd {
#concentric     return ColumnEnd(t, rho, place.weight);
#native     return ColumnEnd(t, rho, place.weight, place.weight_lo);
}

fn walk_new(line: RayLine, hint: u32) -> Walk {
    var contour = contour_at_start(line, hint);
    let start = ray_line_at(line, line.start);
    let entry = contour_entry(&contour);
    let place = walk_clip(
        contour_point(entry.point, entry.w, wide(0.0)),
        walk_exit_place(&contour, contour_exit(&contour)),
        start,
    );
    return Walk(contour, place, line.start, height(start, place.point), is_lost);
}

fn walk_exit_place(contour: ptr<function, Contour>, crossing: Crossing) -> ContourPoint {
    if plane_vertex_is_left((*contour).apex) {
        return contour_point(crossing.point, crossing.w, wide_sub(wide(1.0), crossing.w));
    }
    return contour_point(crossing.point, wide(0.0), crossing.w);
}

fn walk_clip(a: ContourPoint, b: ContourPoint, to: Point) -> ContourPoint {
    let before = point_cross(to, a.point);
    let whole = wide_sub(before, point_cross(to, b.point));
    var w = wide(0.0);
    if whole.hi < 0.0 {
        w = wide_min(wide_max(wide_div(before, whole), wide(0.0)), wide(1.0));
    }
    let point = point_lerp(a.point, b.point, w);
#concentric     return ContourPoint(point, a.weight + w.hi * (b.weight - a.weight));
#native     let second = wide_lerp(Wide(a.weight.x, a.weight_lo.x), Wide(b.weight.x, b.weight_lo.x), w);
#native     let third = wide_lerp(Wide(a.weight.y, a.weight_lo.y), Wide(b.weight.y, b.weight_lo.y), w);
#native     return contour_point(point, second, third);
}

// The next column; the walk is over with the ray's last one.
fn walk_next_column(walk: ptr<function, Walk>, line: RayLine) -> Column {
    var contour = (*walk).contour;
    let entry_place = (*walk).from_;
    let crossing = contour_exit(&contour);
    var exit_place = walk_exit_place(&contour, crossing);
    let end = ray_line_at(line, line.end);
    let is_last = point_cross(end, exit_place.point).hi >= 0.0;
    var t1 = line.end;
    if is_last {
        exit_place = walk_clip(entry_place, exit_place, end);
    } else {
        // Every boundary but the last lies ahead, where x is positive.
        let there = wide_div(wide_mul(line.b, exit_place.point.y), exit_place.point.x);
        t1 = wide_min(wide_max(there, (*walk).last_t), line.end);
    }
    let rho1 = height(ray_line_at(line, t1), exit_place.point);
    let column = Column(
        vec3u(contour.left.cell, contour.right.cell, contour.apex.cell),
        column_end((*walk).last_t, (*walk).last_rho, entry_place),
        column_end(t1, rho1, exit_place),
    );
    (*walk).last_t = t1;
    (*walk).last_rho = rho1;
    (*walk).is_over = is_last || !may_step();
    if !(*walk).is_over {
        contour_forward(line.plane, &contour);
        (*walk).contour = contour;
        (*walk).from_ = contour_point(crossing.point, crossing.w, wide(0.0));
    }
    return column;
}

fn height(at: Point, on: Point) -> Wide {
    return wide_div(point_dot(at, on), point_dot(on, on));
}
