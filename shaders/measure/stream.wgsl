// Reads a buffer from end to end, neighbours side by side: measures a device's peak memory rate.

@group(0) @binding(0) var<storage, read> streamed: array<vec4u>;
@group(0) @binding(1) var<storage, read_write> sums: array<u32>;

@compute @workgroup_size(256)
fn stream(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    var sum = vec4u(0u);
    for (var i = id.x; i < arrayLength(&streamed); i += 256u * groups.x) {
        sum += streamed[i];
    }
    sums[id.x] = sum.x + sum.y + sum.z + sum.w;
}
