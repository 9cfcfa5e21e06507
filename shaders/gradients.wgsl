// Gradients at the vertices: the data that lit scenes read beside the field, in pages like the field's.
#import pages

// x, y and z one after the other, at the place of the value in the field's page.
#each @group(3) @binding(PAGE) var<storage, read> gradients_PAGE: array<f32>;

fn gradients_get(base: Base, layer: u32) -> vec3f {
    let at = 3u * pages_at(base, layer);
    if PAGES == 1u {
        return vec3f(gradients_0[at], gradients_0[at + 1u], gradients_0[at + 2u]);
    }
    switch base.page {
#each         case PAGEu: { return vec3f(gradients_PAGE[at], gradients_PAGE[at + 1u], gradients_PAGE[at + 2u]); }
        default: { return vec3f(0.0); }
    }
}
