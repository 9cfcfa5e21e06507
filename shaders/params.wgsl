// Parameters of all rays of a picture. Mirrored by icoray-gpu/src/layout.rs; directions and lengths are in
// double-float.

struct Params {
    eye_hi: vec3f,
    width: u32,
    eye_lo: vec3f,
    height: u32,
    forward_hi: vec3f,
    // The first piece of this dispatch.
    first_piece: u32,
    forward_lo: vec3f,
    // Distance between traced pixels.
    pixel_step: u32,
    right_hi: vec3f,
    // Half of a pixel's side at distance 1.
    half_pixel_hi: f32,
    right_lo: vec3f,
    half_pixel_lo: f32,
    up_hi: vec3f,
    // Always 0, which compilers must not know.
    zero: u32,
    up_lo: vec3f,
    // A ray that takes more steps from triangle to triangle has failed.
    max_steps: u32,
    // With FEW_KNOTS the starts of the spans behind the first, and ENDLESS behind the last.
    knots: vec4f,
    // Linear RGB of the core.
    core: vec3f,
    layers: u32,
    triangles: u32,
    spans: u32,
    steps: u32,
    // Elements from column to column and from layer to layer, in a page.
    column_stride: u32,
    layer_stride: u32,
    // The divided tolerance: `Budget` of kernel/ray.rs.
    color_tolerance: f32,
    min_transmittance: f32,
    brightest: f32,
    // A row that is a triangle.
    start: u32,
    // Columns of a page.
    page_columns: u32,
    // Layers that the device has.
    first_layer: u32,
    last_layer: u32,
    // Whether rays end at the core, and whether the host computes its light.
    has_core: u32,
    paints_core: u32,
}

@group(0) @binding(0) var<uniform> params: Params;

// Code that a scene does not need is omitted from its shader.
override IS_EXACT: bool = true;
override HAS_VOID: bool = true;
override HAS_STEPS: bool = true;
// With at most five spans, the span is found by comparing with `params.knots`.
override FEW_KNOTS: bool = false;
override IS_LIT: bool = true;
// Whether rays are traced through a part of the cells.
override IN_PARTS: bool = false;
