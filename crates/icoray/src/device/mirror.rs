//! Functions of the kernel in `f32`, with which a device's tests compare its own, one by one.
//!
//! A segment is `[f0, f1, kappa, eps, length]`; see `kernel/segment.rs`.

pub mod light;

use super::Span;
use icoray_grid::real::Real;
use icoray_kernel::lit::{HALVINGS_ALONG, HALVINGS_AT_START, Lit};
use icoray_kernel::piece::{self, ErrorBudget, Radiance};
use icoray_kernel::segment::Segment;
use icoray_scene::Method;

fn segment([f0, f1, kappa, eps, length]: [f32; 5]) -> Segment<f32> {
    Segment { f0, f1, kappa, eps, length }
}

/// Optical depth beyond which a piece is a surface.
pub const SURFACE: f32 = <f32 as Real>::SURFACE as f32;
/// Maximum optical depth of pieces that the rule for thin ones integrates.
pub const THIN: f32 = piece::THIN as f32;
/// Maximum number of panels of equal length in which a piece is integrated.
pub const MAX_PANELS: usize = piece::MAX_PANELS;
/// Number of halvings of a piece at its start, and of further ones by its end.
pub const HALVINGS: [f64; 2] = [HALVINGS_AT_START, HALVINGS_ALONG];
/// Maximum depth of nested halves of a lit piece.
pub const MAX_CUTS: u32 = Lit::<f32, 4>::MAX_CUTS;

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

/// `Segment::reach`, of values of up to `size` at vertices.
pub fn segment_reach(s: [f32; 5], size: f32) -> f32 {
    segment(s).reach(size)
}

/// `bend_factor`.
pub fn bend_factor(eps: f32) -> f32 {
    piece::bend_factor(eps)
}

/// `Real::absorbed_by`.
pub fn absorbed_by(x: f32) -> f32 {
    x.absorbed_by()
}

/// `integrate` with an allowance of share, rest, transmittance before and reach: red, green, blue, absorbed, error,
/// variance.
pub fn integrate(method: Method, piece: [f32; 5], span: &Span, [share, rest, through, reach]: [f32; 4]) -> [f32; 6] {
    let allowance = ErrorBudget { color_tolerance: share, min_transmittance: rest, transmittance: through, reach };
    let Radiance { color: [r, g, b], alpha: absorbed, error, variance } =
        piece::integrate(method, &segment(piece), span, &allowance);
    [r, g, b, absorbed, error, variance]
}
