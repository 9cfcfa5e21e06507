// Mirrors grid/mod.rs: the model's tables unchanged, counted from `params.index_base`.
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

// A triangle without data: its cells, and the triangles beyond the sides opposite them.
struct Void {
    cells: array<u32, 3>,
    beyond: array<u32, 3>,
}

// A side of the rim, sorted by triangle and vertex.
struct RimSide {
    triangle: u32,
    opposite: u32,
    void_triangle: u32,
}

@group(0) @binding(1) var<storage, read> directions: array<Direction>;
@group(0) @binding(2) var<storage, read> corner_cell: array<i32>;
@group(0) @binding(3) var<storage, read> corner_edge: array<i32>;
@group(0) @binding(4) var<storage, read> edge_corner: array<i32>;
// Four of `TriangleOrientation` in a word, the first one lowest.
@group(0) @binding(5) var<storage, read> orientations: array<u32>;
@group(0) @binding(6) var<storage, read> voids: array<Void>;
@group(0) @binding(7) var<storage, read> rim: array<RimSide>;

const ORIENTATION_CLOCKWISE: u32 = 64u;
const ORIENTATION_ABSENT: u32 = 128u;
const ORIENTATION_RIM: u32 = 3u;

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
    if grid_is_void(triangle) {
        let cells = voids[triangle - params.triangles].cells;
        return vec3u(cells[0], cells[1], cells[2]);
    }
    let row = 3u * triangle;
    return vec3u(vec3i(corner_cell[row], corner_cell[row + 1u], corner_cell[row + 2u]) - params.index_base);
}

fn grid_across(triangle: u32, k: u32) -> u32 {
    if grid_is_void(triangle) {
        return voids[triangle - params.triangles].beyond[k];
    }
    let column = (grid_orientation(triangle) >> (2u * k)) & 3u;
    if HAS_VOID && column == ORIENTATION_RIM {
        return grid_over_the_rim(triangle, k);
    }
    let edge = u32(corner_edge[3u * triangle + column] - params.index_base);
    let a = u32(edge_corner[2u * edge] - params.index_base);
    let b = u32(edge_corner[2u * edge + 1u] - params.index_base);
    return a ^ b ^ triangle;
}

fn grid_over_the_rim(triangle: u32, k: u32) -> u32 {
    var low = 0u;
    var high = params.rim_sides;
    while low < high {
        let middle = (low + high) / 2u;
        let side = rim[middle];
        if side.triangle < triangle || (side.triangle == triangle && side.opposite < k) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return rim[low].void_triangle;
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
