//! The structs in the shaders' buffers. Each has the name, members and offsets of its twin in `shaders/`; a test
//! compares them.
#![allow(missing_docs)]

use bytemuck::{Pod, Zeroable};
use icoray::device::{MAX_CLIPS, MAX_FIELDS, MAX_SURFACES, MAX_VOLUMES};

/// Splits a double into the high and the low half of the shaders' `Wide`.
pub fn halves(x: f64) -> [f32; 2] {
    let hi = x as f32;
    [hi, (x - f64::from(hi)) as f32]
}

/// [`halves`] of a vector.
pub fn halves3(v: [f64; 3]) -> [[f32; 3]; 2] {
    let pairs = v.map(halves);
    [pairs.map(|p| p[0]), pairs.map(|p| p[1])]
}

/// See `shaders/params.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Params {
    pub eye_hi: [f32; 3],
    pub width: u32,
    pub eye_lo: [f32; 3],
    pub height: u32,
    pub forward_hi: [f32; 3],
    pub first_piece: u32,
    pub forward_lo: [f32; 3],
    pub pixel_step: u32,
    pub right_hi: [f32; 3],
    pub half_pixel_hi: f32,
    pub right_lo: [f32; 3],
    pub half_pixel_lo: f32,
    pub up_hi: [f32; 3],
    pub zero: u32,
    pub up_lo: [f32; 3],
    pub max_steps: u32,
    pub knots: [f32; 4],
    pub core: [f32; 3],
    pub layers: u32,
    pub index_base: i32,
    pub triangles: u32,
    pub rim_sides: u32,
    pub spans: u32,
    pub steps: u32,
    pub column_stride: u32,
    pub layer_stride: u32,
    pub color_tolerance: f32,
    pub min_transmittance: f32,
    pub brightest: f32,
    pub start: u32,
    pub page_columns: u32,
    pub first_layer: u32,
    pub last_layer: u32,
    pub padding: [u32; 2],
}

/// See `shaders/kernel/transfer.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Span {
    pub low: f32,
    pub high: f32,
    pub anchor: f32,
    pub extinction: f32,
    pub color: [f32; 3],
    pub extinction_slope: f32,
    pub color_slope: [f32; 3],
    pub steepest: f32,
    pub is_clear: u32,
    pub brightest: f32,
    pub padding: [u32; 2],
}

impl From<&icoray::device::Span> for Span {
    fn from(span: &icoray::device::Span) -> Self {
        // Shaders need finite numbers. Larger ones would have the same effect.
        let finite = |x: f32| x.clamp(-1e37, 1e37);
        Span {
            low: span.low.max(-icoray::device::ENDLESS),
            high: span.high.min(icoray::device::ENDLESS),
            anchor: span.anchor,
            extinction: finite(span.extinction),
            color: span.color,
            extinction_slope: finite(span.extinction_slope),
            color_slope: span.color_slope.map(finite),
            steepest: finite(span.steepest),
            is_clear: u32::from(span.is_clear),
            brightest: span.brightest,
            padding: [0; 2],
        }
    }
}

/// See `shaders/kernel/transfer.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Step {
    pub value: f32,
    pub extinction: f32,
    pub slope: f32,
}

impl From<&icoray::device::Step> for Step {
    fn from(step: &icoray::device::Step) -> Self {
        let finite = |x: f32| x.min(1e37);
        Step { value: step.value, extinction: finite(step.extinction), slope: finite(step.slope) }
    }
}

/// See `shaders/kernel/column.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct ShellLayer {
    pub radius_hi: f32,
    pub radius_lo: f32,
    pub curvature: f32,
    pub inverse: f32,
}

/// See `shaders/kernel/shade.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Shading {
    pub light_hi: [f32; 3],
    pub ambient: f32,
    pub light_lo: [f32; 3],
    pub diffuse: f32,
    pub specular: f32,
    pub shininess: f32,
    pub sharpness: f32,
    pub is_headlight: u32,
    pub max_cuts: u32,
    pub padding: [u32; 3],
}

/// See `shaders/scenery.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Clip {
    pub towards_hi: [f32; 3],
    pub distance_hi: f32,
    pub towards_lo: [f32; 3],
    pub distance_lo: f32,
    pub west: [f32; 4],
    pub east: [f32; 4],
    pub inner: [f32; 2],
    pub outer: [f32; 2],
    pub south: [f32; 2],
    pub north: [f32; 2],
    pub first_layer: u32,
    pub last_layer: u32,
    pub kind: u32,
    pub cuts_inside: u32,
}

impl Clip {
    /// The conditions in `kind`.
    pub const HAS_HALF_SPACE: u32 = 1;
    pub const HAS_SHELL: u32 = 2;
    pub const HAS_LATITUDES: u32 = 4;
    pub const HAS_LONGITUDES: u32 = 8;
    pub const IS_WIDE: u32 = 16;
}

/// See `shaders/scenery.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct SurfaceLayer {
    pub layer: u32,
    pub first_material: u32,
    pub material_count: u32,
    pub padding: u32,
    pub radius: [f32; 2],
    pub padding_b: [u32; 2],
}

impl SurfaceLayer {
    /// `layer` of a sphere.
    pub const AT_RADIUS: u32 = u32::MAX;
}

/// See `shaders/scenery.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Material {
    pub color: [f32; 3],
    pub opacity: f32,
    pub kind: u32,
    pub first_value: u32,
    pub first_span: u32,
    pub span_count: u32,
    pub field: u32,
    pub scale: f32,
    pub shift: f32,
    pub padding: u32,
}

impl Material {
    /// The values of `kind`.
    pub const PLAIN: u32 = 0;
    pub const FIELD: u32 = 1;
    pub const CELLS: u32 = 2;
    pub const BETWEEN: u32 = 3;
}

/// See `shaders/scenery.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct SceneField {
    pub first_value: u32,
    pub first_gradient: u32,
    pub padding: [u32; 2],
}

/// See `shaders/scenery.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Isosurface {
    pub color: [f32; 3],
    pub opacity: f32,
    pub value: f32,
    pub field: u32,
    pub kind: u32,
    pub color_field: u32,
    pub first_span: u32,
    pub span_count: u32,
    pub scale: f32,
    pub shift: f32,
}

impl Isosurface {
    /// The number of the volume's field.
    pub const OWN_FIELD: u32 = u32::MAX;
}

/// See `shaders/scenery.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct VolumeMap {
    pub field: u32,
    pub first_span: u32,
    pub span_count: u32,
    pub first_step: u32,
    pub step_count: u32,
    pub padding: [u32; 3],
}

/// See `shaders/scenery.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Scenery {
    pub clips: [Clip; MAX_CLIPS],
    pub surface_layers: [SurfaceLayer; MAX_SURFACES],
    pub materials: [Material; MAX_SURFACES],
    pub isosurfaces: [Isosurface; MAX_SURFACES],
    pub fields: [SceneField; MAX_FIELDS],
    pub maps: [VolumeMap; 2 * MAX_VOLUMES],
    pub clip_count: u32,
    pub surface_layer_count: u32,
    pub isosurface_count: u32,
    pub seen_above: f32,
    pub volume_count: u32,
    pub sphere_count: u32,
    pub padding: [u32; 2],
}

/// See `shaders/gradient.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Around {
    pub first: u32,
    pub columns: u32,
    pub row: u32,
}

/// See `shaders/pieces.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Piece {
    pub left: u32,
    pub top: u32,
    pub width: u32,
    pub height: u32,
    pub first: u32,
    pub stride: u32,
    pub hint: u32,
}

/// See `shaders/picture.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Pixel {
    pub red: f32,
    pub green: f32,
    pub blue: f32,
    pub alpha: f32,
    pub error: f32,
    pub variance: f32,
    pub columns: u32,
    pub frusta: u32,
    pub void_frusta: u32,
    pub order: u32,
    pub nearness: f32,
}

impl Pixel {
    /// `error` of a ray that missed the shell.
    pub const MISSED: f32 = icoray::device::Traced::MISSED;
    /// `error` of a ray whose walk failed.
    pub const LOST: f32 = -2.0;
}

/// See `shaders/kernel/ray/fragment.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Part {
    pub middle: [f32; 3],
    pub reach: f32,
    pub lowest_hi: f32,
    pub lowest_lo: f32,
    pub max_fragments: u32,
    pub padding: u32,
}

/// See `shaders/kernel/ray/fragment.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Fragment {
    pub ray: u32,
    pub entry_hi: f32,
    pub entry_lo: f32,
    pub exit_hi: f32,
    pub exit_lo: f32,
    pub red: f32,
    pub green: f32,
    pub blue: f32,
    pub alpha: f32,
    pub error: f32,
    pub variance: f32,
}

/// See `shaders/parts.wgsl`.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Passed {
    pub columns: u32,
    pub frusta: u32,
    pub void_frusta: u32,
    pub fragments: u32,
}

impl Passed {
    /// Bit of `fragments` that marks a ray whose walk failed.
    pub const LOST: u32 = 1 << 31;
}
