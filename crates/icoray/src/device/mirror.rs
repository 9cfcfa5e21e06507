//! Functions of the kernel in `f32`, for a device's tests to compare its own with, one by one.
//!
//! A segment is `[f0, f1, kappa, eps, length]`; see `kernel/segment.rs`.

pub mod light;

use super::Span;
use crate::kernel::Real;
use crate::kernel::piece::{self, Allowance, Light, Method};
use crate::kernel::segment::Segment;
use crate::kernel::transfer;

fn segment([f0, f1, kappa, eps, length]: [f32; 5]) -> Segment<f32> {
    Segment { f0, f1, kappa, eps, length }
}

/// `Segment::value`.
pub fn segment_value(s: [f32; 5], u: f32) -> f32 {
    segment(s).value(u)
}

/// `Segment::extremum`.
pub fn segment_extremum(s: [f32; 5]) -> Option<(f32, f32)> {
    segment(s).extremum()
}

/// `Segment::solve`.
pub fn segment_solve(s: [f32; 5], v: f32) -> f32 {
    segment(s).solve(v)
}

/// `Segment::part`.
pub fn segment_part(s: [f32; 5], from: (f32, f32), to: (f32, f32)) -> [f32; 5] {
    let Segment { f0, f1, kappa, eps, length } = segment(s).part(from, to);
    [f0, f1, kappa, eps, length]
}

/// `bend_factor`.
pub fn bend_factor(eps: f32) -> f32 {
    piece::bend_factor(eps)
}

/// `Real::absorbed_by`.
pub fn absorbed_by(x: f32) -> f32 {
    x.absorbed_by()
}

/// `integrate` with an allowance of share, rest, transmittance before and reach: red, green, blue, absorbed, error, variance.
pub fn integrate(
    method: Method,
    piece: [f32; 5],
    span: &Span,
    [share, rest, through, reach]: [f32; 4],
) -> [f32; 6] {
    let allowance = Allowance { share, rest, through, reach };
    let Light { color: [r, g, b], absorbed, error, variance } =
        piece::integrate(method, &segment(piece), &span.kernel(), &allowance);
    [r, g, b, absorbed, error, variance]
}

impl Span {
    pub(crate) fn of(span: &transfer::Span<f32>) -> Self {
        let transfer::Span {
            low,
            high,
            anchor,
            extinction,
            extinction_slope,
            color,
            color_slope,
            steepest,
            brightest,
            is_clear,
        } = *span;
        Span {
            low,
            high,
            anchor,
            extinction,
            extinction_slope,
            color,
            color_slope,
            steepest,
            brightest,
            is_clear,
        }
    }

    pub(super) fn kernel(&self) -> transfer::Span<f32> {
        let Span {
            low,
            high,
            anchor,
            extinction,
            extinction_slope,
            color,
            color_slope,
            steepest,
            brightest,
            is_clear,
        } = *self;
        transfer::Span {
            low,
            high,
            anchor,
            extinction,
            extinction_slope,
            color,
            color_slope,
            steepest,
            brightest,
            is_clear,
        }
    }
}
