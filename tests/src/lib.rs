//! Shared by the tests: small scenes and comparisons that can fail; programs in C and Fortran.

// As icoray-capi calls it, one of whose files `layout` includes.
extern crate icoray as icoray_core;

pub mod interface;
pub mod layout;
pub mod layouts;
pub mod native;
pub mod programs;
pub mod ranks;

use icoray::{Frame, Scene};

/// Largest and root-mean-square difference over all channels of all pixels.
#[derive(Debug, Clone, Copy)]
pub struct Difference {
    /// Largest absolute difference of a channel.
    pub max: f64,
    /// Root of the mean squared difference.
    pub rmse: f64,
    /// Number of pixels of which any channel is not finite, in either picture.
    pub not_finite: usize,
}

/// Compares two lists of premultiplied pixels.
///
/// # Panics
/// When the lists differ in length or are empty: such a comparison would mean nothing.
pub fn difference(a: &[[f32; 4]], b: &[[f32; 4]]) -> Difference {
    assert!(a.len() == b.len() && !a.is_empty(), "{} pixels against {}", a.len(), b.len());
    let channels = || a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| f64::from(*x) - f64::from(*y));
    let not_finite = a.iter().zip(b).filter(|(x, y)| x.iter().chain(y.iter()).any(|c| !c.is_finite())).count();
    Difference {
        max: channels().fold(0.0, |m: f64, d| m.max(d.abs())),
        rmse: (channels().map(|d| d * d).sum::<f64>() / (4 * a.len()) as f64).sqrt(),
        not_finite,
    }
}

/// A scene from a template: `camera` and `rest` are TOML lines, one ray per pixel, tolerance 1e-7, knots rise from
/// clear to dense.
///
/// # Panics
/// When the text is no scene.
pub fn scene(size: u32, camera: &str, transfer: &str, rest: &str) -> Scene {
    let background = if rest.contains("background") { "" } else { "background = \"transparent\"\n" };
    let text = format!(
        "field = \"f\"\nantialias = false\n{background}tolerance = 1e-7\n{rest}\n[image]\nwidth = {size}\nheight = {size}\n\
         [camera]\n{camera}\n[transfer]\n{transfer}\n"
    );
    Scene::parse(&text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Fraction of pixels that show something.
pub fn covered(frame: &Frame) -> f64 {
    frame.pixels.iter().filter(|p| p[3] > 1e-3).count() as f64 / frame.pixels.len() as f64
}
