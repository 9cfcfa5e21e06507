// Pieces of tiles and their rays.
#import params
#import kernel/wide

// The work of one workgroup: a piece of a tile, in steps of traced pixels.
struct Piece {
    left: u32,
    top: u32,
    width: u32,
    height: u32,
    // Index of its first ray in `pixels`, and the distance to the next row's.
    first: u32,
    stride: u32,
    // A triangle near those at which its rays start.
    hint: u32,
}

@group(0) @binding(8) var<storage, read> pieces: array<Piece>;
// The unit vector through the middle of a pixel: `Camera::direction`.
fn direction(x: u32, y: u32) -> Wide3 {
    let half_pixel = Wide(params.half_pixel_hi, params.half_pixel_lo);
    // Whole numbers of half pixels, from the picture's middle.
    let right = wide_times(half_pixel, f32(2 * i32(x) + 1 - i32(params.width)));
    let up = wide_times(half_pixel, f32(i32(params.height) - 2 * i32(y) - 1));
    let across = wide3_scale(Wide3(params.right_hi, params.right_lo), right);
    let upwards = wide3_scale(Wide3(params.up_hi, params.up_lo), up);
    return wide3_normalize(
        wide3_add(Wide3(params.forward_hi, params.forward_lo), wide3_add(across, upwards)),
    );
}

// Mesa's llvmpipe ends all loops of an invocation after 65,535 turns in total, without an error: then this one ends
// early too. Rays without light, which approach that on the largest grids only, check it in `trace` only.
fn are_loops_whole() -> bool {
    var turns = params.zero;
    while turns < 2u {
        turns++;
    }
    return turns == 2u;
}
