// Traces a picture's rays through a rank's part of the cells: fragments of each, in bands of pieces.
#import params
#import pieces
#import kernel/ray/fragment

// The boundaries that a ray met, and its number of fragments; LOST if the walk failed.
struct Passed {
    columns: u32,
    frusta: u32,
    void_frusta: u32,
    fragments: u32,
}

const LOST: u32 = 0x80000000u;

@group(0) @binding(9) var<storage, read_write> passed: array<Passed>;

@compute @workgroup_size(8, 8)
fn parts(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) id: vec3u) {
    let piece = pieces[params.first_piece + group.x];
    if id.x >= piece.width || id.y >= piece.height {
        return;
    }
    let x = min((piece.left + id.x) * params.pixel_step, params.width - 1u);
    let y = min((piece.top + id.y) * params.pixel_step, params.height - 1u);
    let place = piece.first + id.y * piece.stride + id.x;
    let met = fragments(Wide3(params.eye_hi, params.eye_lo), direction(x, y), piece.hint, place);
    var count = met.count;
#single     if is_lost || (IS_LIT && !are_loops_whole()) {
#several     if is_lost || !are_loops_whole() {
        count |= LOST;
    }
    passed[place] = Passed(met.ray.columns, met.ray.frusta, met.ray.void_frusta, count);
}
