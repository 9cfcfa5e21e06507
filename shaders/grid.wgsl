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
// The cells of each triangle, counter-clockwise, and the triangles beyond the sides opposite them. Triangles without data follow those of
// the table.
@group(0) @binding(2) var<storage, read> triangle_cells: array<u32>;
@group(0) @binding(3) var<storage, read> beyond: array<u32>;

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

fn grid_standing(hint: u32) -> u32 {
    if grid_is_void(hint) {
        return hint;
    }
    // A row that is no triangle has one cell three times.
    if hint < params.triangles && triangle_cells[3u * hint] != triangle_cells[3u * hint + 1u] {
        return hint;
    }
    return params.start;
}
