// Multiplies and adds in registers: measures a device's peak rate. Twelve chains, which fill a processor's pipes and
// fit its registers.

@group(0) @binding(0) var<storage, read_write> products: array<f32>;

// Flops of an invocation: 2 in each of 12 chains, 16 times a round.
const ROUNDS: u32 = 64u;

@compute @workgroup_size(256)
fn multiply(@builtin(global_invocation_id) id: vec3u) {
    let start = f32(id.x & 1023u);
    var x = vec4f(start, start + 1.0, start + 2.0, start + 3.0);
    var y = x + 4.0;
    var z = x + 8.0;
    let by = vec4f(0.5 + 1e-4 * start);
    let plus = vec4f(start);
    for (var round = 0u; round < ROUNDS; round++) {
        for (var i = 0u; i < 16u; i++) {
            x = fma(x, by, plus);
            y = fma(y, by, plus);
            z = fma(z, by, plus);
        }
    }
    let sum = x + y + z;
    products[id.x] = sum.x + sum.y + sum.z + sum.w;
}
