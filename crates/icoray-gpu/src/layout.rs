//! The structs in the shaders' buffers, with the names and members of their declarations in `shaders/`, from which the
//! build script makes them.
#![allow(missing_docs)]

use bytemuck::{Pod, Zeroable};
use icoray::device::{MAX_CLIPS, MAX_FIELDS, MAX_SURFACES, MAX_VOLUMES};

/// Name, bytes, and members with their offsets of a struct.
pub type Layout = (&'static str, usize, &'static [(&'static str, usize)]);

const MAX_MAPS: usize = 2 * MAX_VOLUMES;

include!(concat!(env!("OUT_DIR"), "/layout.rs"));

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

impl From<&icoray::device::Step> for Step {
    fn from(step: &icoray::device::Step) -> Self {
        let finite = |x: f32| x.min(1e37);
        Step { value: step.value, extinction: finite(step.extinction), slope: finite(step.slope) }
    }
}

impl Clip {
    /// The conditions in `kind`.
    pub const HAS_HALF_SPACE: u32 = 1;
    pub const HAS_SHELL: u32 = 2;
    pub const HAS_LATITUDES: u32 = 4;
    pub const HAS_LONGITUDES: u32 = 8;
    pub const IS_WIDE: u32 = 16;
}

impl SurfaceLayer {
    /// `layer` of a sphere.
    pub const AT_RADIUS: u32 = u32::MAX;
}

impl Material {
    /// The values of `kind`.
    pub const PLAIN: u32 = 0;
    pub const FIELD: u32 = 1;
    pub const CELLS: u32 = 2;
    pub const BETWEEN: u32 = 3;
}

impl Isosurface {
    /// The number of the volume's field.
    pub const OWN_FIELD: u32 = u32::MAX;
}

impl Fragment {
    /// `painted` of a fragment that does not end at a place whose light the host computes, and of one that ends at the
    /// core.
    pub const NOT_PAINTED: u32 = u32::MAX;
    pub const PAINTED_CORE: u32 = u32::MAX - 1;
}

impl Pixel {
    /// `error` of a ray that missed the shell.
    pub const MISSED: f32 = icoray::device::Traced::MISSED;
    /// `error` of a ray whose walk failed.
    pub const LOST: f32 = -2.0;
}

impl Passed {
    /// Bit of `fragments` that marks a ray whose walk failed.
    pub const LOST: u32 = 1 << 31;
}
