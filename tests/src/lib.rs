//! Shared by the tests: small scenes and comparisons that can fail; programs in C and Fortran.

// As icoray-capi calls it, one of whose files `layout` includes.
extern crate icoray as icoray_core;

pub mod interface;
pub mod layout;
pub mod layouts;
pub mod native;
pub mod pictures;
pub mod programs;
pub mod ranks;

use icoray::{Frame, Scene};

/// A scene from a template: `camera` and `rest` are TOML lines, one ray per pixel, tolerance 1e-7, knots rise from
/// clear to dense.
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
