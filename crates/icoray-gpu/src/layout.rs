//! The structs in the shaders' buffers and constants of shaders, with the names of their declarations in `shaders/`,
//! from which the build script makes them.
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
