//! The model and the scene as files that the script reads.

use crate::results::write_file;
use icoray::{Result, Scene};
use icoray_reference::sphere::Sphere;
use std::fmt::Write as _;
use std::path::Path;

/// Writes `scene.txt`, a line of numbers behind a name; `directions.f64`, `triangles.i32` and `values.f32`,
/// little-endian.
pub(super) fn write(directory: &Path, scene: &Scene, sphere: &Sphere) -> Result<()> {
    let put = |name: &str, bytes: Vec<u8>| write_file(&directory.join(name), bytes);
    let grid = sphere.grid()?;
    let directions = (0..grid.cells() as u32).flat_map(|cell| grid.direction(cell).to_array());
    put("directions.f64", directions.flat_map(f64::to_le_bytes).collect())?;
    let triangles = sphere.mesh.corner_cell.iter().map(|cell| cell - sphere.mesh.tables().index_base);
    put("triangles.i32", triangles.flat_map(i32::to_le_bytes).collect())?;
    put("values.f32", sphere.values.iter().flat_map(|v| v.to_le_bytes()).collect())?;
    put("scene.txt", text(scene, sphere.layers.radius_m()).into_bytes())
}

fn text(scene: &Scene, radii: &[f64]) -> String {
    let mut text = String::new();
    let mut line = |name: &str, numbers: &[f64]| {
        let numbers: Vec<_> = numbers.iter().map(|n| format!("{n:e}")).collect();
        let _ = writeln!(text, "{name} {}", numbers.join(" "));
    };
    let ([forward, _, up], half_height) = scene.camera.frame();
    line("size", &[scene.width, scene.height].map(f64::from));
    line("eye", &scene.camera.eye());
    line("forward", &forward);
    line("up", &up);
    line("half_height", &[half_height]);
    line("radii", radii);
    let unit = scene.volumes[0].transfer.unit_length.unwrap_or(radii[radii.len() - 1] - radii[0]);
    for knot in &scene.volumes[0].transfer.knots {
        let [red, green, blue] = knot.color;
        line("knot", &[knot.value, red, green, blue, knot.extinction / unit]);
    }
    text
}
