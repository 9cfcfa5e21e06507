// The parts of a scene beside the volume. Mirrored by icoray-gpu/src/layout.rs; lengths and directions are in
// double-float, upper half first.

// A cut: the region where all of its conditions hold.
struct Clip {
    // Unit normal of a half-space's plane, and its distance from the centre.
    towards_hi: vec3f,
    distance_hi: f32,
    towards_lo: vec3f,
    distance_lo: f32,
    // Normals of the meridians at the western and at the eastern end: x and y, upper halves first.
    west: vec4f,
    east: vec4f,
    // Radii of a shell.
    inner: vec2f,
    outer: vec2f,
    // Sines of latitudes.
    south: vec2f,
    north: vec2f,
    first_layer: u32,
    last_layer: u32,
    // The conditions: HAS_HALF_SPACE and those behind it.
    kind: u32,
    // Whether the inside is cut away.
    cuts_inside: u32,
}

const HAS_HALF_SPACE: u32 = 1u;
const HAS_SHELL: u32 = 2u;
const HAS_LATITUDES: u32 = 4u;
const HAS_LONGITUDES: u32 = 8u;
// The box is wider than half a turn.
const IS_WIDE: u32 = 16u;

// A layer with surfaces on it, or a sphere: the first in front.
struct SurfaceLayer {
    // AT_RADIUS for a sphere.
    layer: u32,
    first_material: u32,
    material_count: u32,
    // Whether the host adds lines in front.
    is_painted: u32,
    radius: vec2f,
    // For native heights: index in `surface_values` of the normals of the layer at the cells.
    first_normal: u32,
    padding: u32,
}

const AT_RADIUS: u32 = 0xFFFFFFFFu;

// Colours of a surface.
struct Material {
    // The colour, if it is uniform.
    color: vec3f,
    opacity: f32,
    // One of MATERIAL_PLAIN and those behind it.
    kind: u32,
    // Index in `surface_values` of the value over the first cell.
    first_value: u32,
    // The spans of its transfer function in `spans`.
    first_span: u32,
    span_count: u32,
    // For MATERIAL_BETWEEN: the field, OWN_FIELD or its number in `fields`, and the conversion from its normalised
    // value to that of the spans.
    field: u32,
    scale: f32,
    shift: f32,
    padding: u32,
}

const MATERIAL_PLAIN: u32 = 0u;
// Colours of interpolated values.
const MATERIAL_FIELD: u32 = 1u;
// Each cell has one colour.
const MATERIAL_CELLS: u32 = 2u;
// Colours of values that are interpolated between layers.
const MATERIAL_BETWEEN: u32 = 3u;

// A field beside the volume's.
struct SceneField {
    // Index of its values in `surface_values`, level-fastest, normalised to its range.
    first_value: u32,
    // Index of its gradients there, x, y and z one after the other, if the scene is lit.
    first_gradient: u32,
    padding: vec2u,
}

// A surface on which a field has one value.
struct Isosurface {
    // The colour, if it is uniform.
    color: vec3f,
    opacity: f32,
    // The value, normalised as the field.
    value: f32,
    // The field: OWN_FIELD, or else its number in `fields`.
    field: u32,
    // Colours: MATERIAL_PLAIN or MATERIAL_FIELD.
    kind: u32,
    // For the colouring field: its number, the spans of its transfer function in `spans`, and the conversion from the
    // field's normalised value to that of the spans.
    color_field: u32,
    first_span: u32,
    span_count: u32,
    scale: f32,
    shift: f32,
}

const OWN_FIELD: u32 = 0xFFFFFFFFu;

// A transfer function with its field.
struct VolumeMap {
    // OWN_FIELD, or else its number in `fields`.
    field: u32,
    // In `spans`. Empty for a colour equal to that of the volume's extinction.
    first_span: u32,
    span_count: u32,
    // In `steps`.
    first_step: u32,
    @size(16) step_count: u32,
}

const MAX_CLIPS: u32 = 8u;
const MAX_SURFACES: u32 = 8u;
const MAX_FIELDS: u32 = 8u;
const MAX_VOLUMES: u32 = 4u;
const MAX_MAPS: u32 = 2u * MAX_VOLUMES;

struct Scenery {
    clips: array<Clip, MAX_CLIPS>,
    surface_layers: array<SurfaceLayer, MAX_SURFACES>,
    materials: array<Material, MAX_SURFACES>,
    isosurfaces: array<Isosurface, MAX_SURFACES>,
    fields: array<SceneField, MAX_FIELDS>,
    // For several volumes: the maps of the extinction and of the colour of the first one, and so on.
    maps: array<VolumeMap, MAX_MAPS>,
    clip_count: u32,
    surface_layer_count: u32,
    isosurface_count: u32,
    // A surface is visible if more than this fraction of its light passes.
    seen_above: f32,
    // 0 if the scene has only the volume of the field.
    volume_count: u32,
    // The number of spheres among `surface_layers`.
    sphere_count: u32,
    // For native heights: indices in `surface_values` of 1 / radius of all layers over all cells, in double-float and
    // level-fastest, and of the normals of the core.
    first_inverse: u32,
    core_normal: u32,
    // Radius of the visible space, and least and greatest radius of the core.
    outer: vec2f,
    core_low: vec2f,
    core_high: vec2f,
}

@group(2) @binding(1) var<uniform> scenery: Scenery;
// Values of fields on the layers that they colour, cell by cell, normalised to their transfer functions; then whole
// fields, and heights.
@group(2) @binding(2) var<storage, read> surface_values: array<f32>;
