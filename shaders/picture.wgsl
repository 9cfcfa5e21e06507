// Traces a picture's rays, one per invocation, in bands of pieces.
#import params
#import pieces
#import kernel/ray

// Result of a ray: `Traced` of icoray/src/device. `error` is MISSED or LOST if the ray has no light.
struct Pixel {
    red: f32,
    green: f32,
    blue: f32,
    alpha: f32,
    error: f32,
    variance: f32,
    columns: u32,
    frusta: u32,
    void_frusta: u32,
    // The surfaces that it met: `BoundarySignature`, empty if there is only a volume.
    order: u32,
    nearness: f32,
}

const MISSED: f32 = -1.0;
const LOST: f32 = -2.0;

@group(0) @binding(9) var<storage, read_write> pixels: array<Pixel>;

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
#single     if is_lost || (IS_LIT && !are_loops_whole()) {
#several     if is_lost || !are_loops_whole() {
        error = LOST;
    }
    pixels[piece.first + id.y * piece.stride + id.x] = Pixel(
        light.color.x,
        light.color.y,
        light.color.z,
        light.alpha,
        error,
        light.variance + light.shade_variance,
        traced.ray.columns,
        traced.ray.frusta,
        traced.ray.void_frusta,
#plain         0u,
#plain         0.0,
#scene         ray_scene.surfaces.order,
#scene         ray_scene.surfaces.nearness,
    );
}
