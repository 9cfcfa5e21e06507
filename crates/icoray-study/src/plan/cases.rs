//! Scenes of all kinds: dense, clear, lit, separate clouds, opaque.

use crate::scenes::multi_scale::{self, HEADLIGHT, TRANSFERS};
use glam::DVec3;
use icoray::{Result, Scene};
use icoray_reference::sphere;

/// A field and its scene.
#[derive(Debug)]
pub(super) struct Case {
    pub name: &'static str,
    pub field: fn(DVec3) -> f64,
    pub scene: fn(u32) -> Result<Scene>,
}

/// All cases.
pub(super) const CASES: [Case; 9] = [
    case("dense", sphere::multi_scale, |size| of_speed(size, 0, "")),
    case("lobes", sphere::multi_scale, |size| of_speed(size, 1, "")),
    case("thin", sphere::multi_scale, |size| of_speed(size, 2, "")),
    case("opaque", sphere::multi_scale, |size| of_speed(size, 3, "")),
    case("dense, lit", sphere::multi_scale, |size| of_speed(size, 0, HEADLIGHT)),
    case("lobes, lit", sphere::multi_scale, |size| of_speed(size, 1, HEADLIGHT)),
    case("cloud", cloud, |size| of_cloud(size, "")),
    case("cloud, lit", cloud, |size| of_cloud(size, HEADLIGHT)),
    case("low cloud", low_cloud, |size| of_cloud(size, "")),
];

const fn case(name: &'static str, field: fn(DVec3) -> f64, scene: fn(u32) -> Result<Scene>) -> Case {
    Case { name, field, scene }
}

/// One of the scenes of `icoray-study speed`.
fn of_speed(size: u32, number: usize, light: &str) -> Result<Scene> {
    multi_scale::scene(size, TRANSFERS[number].1, "", light)
}

/// Cloud water: zero between clouds.
fn cloud(p: DVec3) -> f64 {
    (2.0 * sphere::multi_scale(p) - 1.0).max(0.0)
}

/// Clouds in the lowest third of the shell.
fn low_cloud(p: DVec3) -> f64 {
    if p.length() < 1.05 { cloud(p) } else { 0.0 }
}

fn of_cloud(size: u32, light: &str) -> Result<Scene> {
    let knots = "{ value = 0, color = \"white\", extinction = 0 }, { value = 1, color = \"white\", extinction = 200 }";
    multi_scale::globe("cloud water", size, "", &format!("knots = [ {knots} ]\n{light}"))
}
