// Gradients at the vertices: what lit scenes read beside the field.
#import params

// x, y and z one after the other, a cell's layers side by side.
@group(1) @binding(1) var<storage, read> gradients: array<f32>;

fn gradients_get(cell: u32, layer: u32) -> vec3f {
    let at = 3u * (cell * params.layers + layer);
    return vec3f(gradients[at], gradients[at + 1u], gradients[at + 2u]);
}
