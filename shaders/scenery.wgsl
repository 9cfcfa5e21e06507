// What is shown beside the volume. Mirrored by icoray-gpu/src/layout.rs; lengths and directions are in double-float,
// upper half first.

// A cut: where all of its conditions hold.
struct Clip {
    // The direction in which a half-space lies, and how far out.
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

const MAX_CLIPS: u32 = 8u;

struct Scenery {
    clips: array<Clip, MAX_CLIPS>,
    clip_count: u32,
    // A surface is seen where more than this part of its light comes through.
    seen_above: f32,
}

@group(2) @binding(1) var<uniform> scenery: Scenery;
