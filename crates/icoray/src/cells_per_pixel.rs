//! Number of cells per pixel, from the rays of some pixels.
//!
//! A pixel covers the cells on the layer that its ray meets first: the outermost one or, from within the shell, the
//! outermost or innermost one. At the distance t the pixel is a = t · sqrt(Ω) wide, where Ω is its solid angle. On the
//! layer it is as long as the arc between rays that pass the centre a / 2 nearer and farther: a / cos θ at an angle of
//! incidence θ, and finite at the limb. A cell has twice the area of the triangle of the mesh that the ray meets.

use crate::ranks::Part;
use glam::DVec3;
use icoray_grid::Grid;
use icoray_kernel::walk::locate;
use icoray_output::CellsPerPixel;
use icoray_scene::Scene;
use std::f64::consts::{PI, TAU};

/// Maximum number of sampled pixels in each direction: the walk between them costs little compared with a frame.
const NODES: u32 = 16;

/// Cells per pixel of a scene whose shell has these radii. On ranks with parts of the grid all cells count as equally
/// large.
pub(crate) fn cells_per_pixel(scene: &Scene, grid: &Grid, part: Option<&Part>, radius: [f64; 2]) -> CellsPerPixel {
    let mean_area = part.map(|part| 4.0 * PI * part.covered() / part.cells() as f64);
    let (mut max, mut sum, mut count) = (0.0f64, 0.0, 0.0);
    let mut row_hint = 0;
    for y in nodes(scene.height) {
        let mut hint = None;
        for x in nodes(scene.width) {
            let Some((direction, area)) = footprint(scene, [x, y], radius) else { continue };
            let cell = mean_area.unwrap_or_else(|| {
                let triangle = locate(grid, hint.unwrap_or(row_hint), direction);
                if hint.replace(triangle).is_none() {
                    row_hint = triangle;
                }
                if grid.is_void(triangle) {
                    return f64::INFINITY;
                }
                let [a, b, c] = grid.triangle(triangle).map(|cell| grid.direction(cell));
                (b - a).cross(c - a).length()
            });
            let cells = area / cell;
            (max, sum, count) = (max.max(cells), sum + cells, count + 1.0);
        }
    }
    CellsPerPixel { max, mean: if count > 0.0 { sum / count } else { 0.0 } }
}

/// Evenly spaced pixels of a side.
fn nodes(side: u32) -> impl Iterator<Item = u32> {
    let many = side.min(NODES);
    (0..many).map(move |node| (2 * node + 1) * side / (2 * many))
}

/// The first intersection of a pixel's ray with the shell, as a unit vector, and the solid angle that the pixel covers
/// there, seen from the centre; `None` for a ray that misses the shell.
fn footprint(scene: &Scene, [x, y]: [u32; 2], [inner, outer]: [f64; 2]) -> Option<(DVec3, f64)> {
    let camera = &scene.camera;
    let eye = DVec3::from_array(camera.eye());
    let dir = DVec3::from_array(camera.direction(x, y, scene.width, scene.height));
    let along = -eye.dot(dir);
    let passes_at = (eye + along * dir).length();
    let meets = |radius: f64| {
        let half = (radius * radius - passes_at * passes_at).max(0.0).sqrt();
        let nearest = [along - half, along + half].into_iter().find(|at| *at > 0.0)?;
        (passes_at < radius).then_some((nearest, radius))
    };
    let (distance, radius) = [inner, outer].into_iter().filter_map(meets).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let (axes, _) = camera.frame();
    // Off the middle of the picture a pixel is narrower and oblique.
    let aslant = dir.dot(DVec3::from_array(axes[0]));
    let width = distance * camera.pixel_width(scene.height) * aslant.powf(1.5) / radius;
    let passes_at = passes_at / radius;
    let arc = |at: f64| at.clamp(-1.0, 1.0).asin();
    let length = arc(passes_at + 0.5 * width) - arc(passes_at - 0.5 * width);
    Some(((eye + distance * dir) / radius, (width * length).min(TAU)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray_grid::IcosahedralMesh;

    fn of(level: u32, side: u32, camera: &str) -> CellsPerPixel {
        let mesh = IcosahedralMesh::new(level).unwrap();
        let text = format!("field = 'f'\nimage = {{ width = {side}, height = {side} }}\n[camera]\n{camera}");
        cells_per_pixel(&Scene::parse(&text).unwrap(), &Grid::new(mesh.tables()).unwrap(), None, [1.0, 1.1])
    }

    #[test]
    fn a_globe_shows_the_cells_that_face_the_camera() {
        // From far away a pixel is a column through half of the sphere: the mean over the disc is 2πR² over πR².
        let found = of(5, 256, "lon = 10\nlat = 20\ndistance = 100\nfov = 1.5");
        let width = 2.0 * 100.0 * (0.75f64).to_radians().tan() / 256.0;
        let straight = width * width / 1.21 / (4.0 * PI / 10242.0);
        assert!((found.mean / (2.0 * straight) - 1.0).abs() < 0.15, "{found:?}, {straight} in the middle");
        assert!(found.max > 3.0 * straight && found.max < 20.0 * straight, "{found:?}, {straight} in the middle");
    }

    #[test]
    fn four_times_the_cells_or_half_the_pixels_are_four_times_as_many() {
        let camera = "lon = 10\nlat = 20\ndistance = 3\nfov = 20";
        let cells = of(4, 64, camera);
        let (finer, coarser) = (of(5, 64, camera), of(4, 32, camera));
        for more in [finer, coarser] {
            assert!((more.mean / cells.mean - 4.0).abs() < 0.3, "{more:?} and {cells:?}");
        }
        // Nothing of the shell is in sight.
        let none = of(2, 16, "eye = [3, 0, 0]\ntarget = [9, 0, 0]");
        assert_eq!(none, CellsPerPixel::default());
    }

    #[test]
    fn from_within_the_shell_the_nearer_sphere_counts() {
        let below = of(4, 16, "eye = [1.05, 0, 0]\ntarget = [0, 0, 0]\nup = [0, 0, 1]\nfov = 20");
        let above = of(4, 16, "eye = [1.05, 0, 0]\ntarget = [2, 0, 0]\nup = [0, 0, 1]\nfov = 20");
        assert!(below.mean > 0.0 && (below.mean / above.mean / 1.21 - 1.0).abs() < 0.1, "{below:?} {above:?}");
    }
}
