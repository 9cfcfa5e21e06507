// Mirrors grid/mod.rs.
#import params
#import kernel/wide

// Upper and lower halves of each cell's direction.
struct Direction {
    hi_x: f32,
    hi_y: f32,
    hi_z: f32,
    lo_x: f32,
    lo_y: f32,
    lo_z: f32,
}

@group(0) @binding(1) var<storage, read> directions: array<Direction>;
// The cells of each triangle, and the triangles beyond the sides opposite them. Triangles without data follow those of
// the table.
@group(0) @binding(2) var<storage, read> triangle_cells: array<u32>;
@group(0) @binding(3) var<storage, read> beyond: array<u32>;
// Four of `TriangleOrientation` in a word, the first one lowest.
@group(0) @binding(4) var<storage, read> orientations: array<u32>;

const ORIENTATION_CLOCKWISE: u32 = 64u;
const ORIENTATION_ABSENT: u32 = 128u;

fn grid_orientation(triangle: u32) -> u32 {
    return (orientations[triangle >> 2u] >> (8u * (triangle & 3u))) & 255u;
}

fn grid_is_void(triangle: u32) -> bool {
    return HAS_VOID && triangle >= params.triangles;
}

fn grid_direction(cell: u32) -> Wide3 {
    let d = directions[cell];
    return Wide3(vec3f(d.hi_x, d.hi_y, d.hi_z), vec3f(d.lo_x, d.lo_y, d.lo_z));
}

fn grid_triangle(triangle: u32) -> vec3u {
    let row = 3u * triangle;
    return vec3u(triangle_cells[row], triangle_cells[row + 1u], triangle_cells[row + 2u]);
}

fn grid_across(triangle: u32, k: u32) -> u32 {
    return beyond[3u * triangle + k];
}

fn grid_is_clockwise(triangle: u32) -> bool {
    return !grid_is_void(triangle) && (grid_orientation(triangle) & ORIENTATION_CLOCKWISE) != 0u;
}

fn grid_standing(hint: u32) -> u32 {
    if grid_is_void(hint) {
        return hint;
    }
    if hint < params.triangles && (grid_orientation(hint) & ORIENTATION_ABSENT) == 0u {
        return hint;
    }
    return params.start;
}
