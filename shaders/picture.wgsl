// A picture's rays, one per invocation, in bands of pieces.
#import params
#import kernel/ray

// What a ray gives: `Traced` of icoray/src/device. `error` is MISSED or LOST where there is no light to speak of.
struct Pixel {
    red: f32,
    green: f32,
    blue: f32,
    absorbed: f32,
    error: f32,
    variance: f32,
    columns: u32,
    frusta: u32,
    void_frusta: u32,
}

const MISSED: f32 = -1.0;
const LOST: f32 = -2.0;

// What a workgroup traces: a piece of a tile, in steps of traced pixels.
struct Piece {
    left: u32,
    top: u32,
    width: u32,
    height: u32,
    // Where its first ray lies in `pixels`, and the next row's behind it.
    first: u32,
    stride: u32,
    // A triangle near those that its rays start over.
    hint: u32,
}

@group(0) @binding(12) var<storage, read> pieces: array<Piece>;
@group(0) @binding(13) var<storage, read_write> pixels: array<Pixel>;

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

// Mesa's llvmpipe ends all loops of an invocation once they have taken 65,535 turns together, and does not tell: then this
// one ends early too. Rays without light, which come near that on the largest grids only, see it in `trace` alone.
fn are_loops_whole() -> bool {
    var turns = params.zero;
    while turns < 2u {
        turns++;
    }
    return turns == 2u;
}

@compute @workgroup_size(8, 8)
fn picture(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) id: vec3u) {
    let piece = pieces[params.first_piece + group.x];
    if id.x >= piece.width || id.y >= piece.height {
        return;
    }
    let x = min((piece.left + id.x) * params.pixel_step, params.width - 1u);
    let y = min((piece.top + id.y) * params.pixel_step, params.height - 1u);
    let traced = trace(Wide3(params.eye_hi, params.eye_lo), direction(x, y), piece.hint);
    let light = traced.light;
    var error = light.error;
    if !traced.is_met {
        error = MISSED;
    }
    if is_lost || (IS_LIT && !are_loops_whole()) {
        error = LOST;
    }
    pixels[piece.first + id.y * piece.stride + id.x] = Pixel(
        light.color.x,
        light.color.y,
        light.color.z,
        light.absorbed,
        error,
        light.variance,
        traced.ray.columns,
        traced.ray.frusta,
        traced.ray.void_frusta,
    );
}
