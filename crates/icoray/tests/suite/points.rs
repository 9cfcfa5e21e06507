//! Meshes of points alone: pictures against maps of the nearest point, which use no triangles.

use crate::common::{at_centers, rays};
use glam::DVec3;
use icoray::{Grid, Layers, LonLat, OwnedTables, Renderer, Scene};
use icoray_test_support::Random;
use std::f64::consts::{PI, TAU};

const RADIUS_M: f64 = 6e6;

/// Whether a longitude and latitude lie between points.
type IsCovered = fn(f64, f64) -> bool;

/// The part of pixels that show the value of the nearest point, or one between those no farther than `spacing` behind it;
/// nothing where the points do not reach. Values change over the sphere, one way.
fn share_of_right_pixels(
    points: &[[f64; 2]],
    spacing: f64,
    [lon, lat, distance]: [f64; 3],
    is_covered: IsCovered,
) -> f64 {
    let [lon_rad, lat_rad] = [0, 1].map(|k| points.iter().map(|point| point[k]).collect::<Vec<f64>>());
    let center = LonLat { lon_rad: lon_rad.as_slice().into(), lat_rad: lat_rad.as_slice().into() };
    let tables = OwnedTables::of_points(center).unwrap();
    let grid = Grid::new(tables.tables()).unwrap();
    let layers = Layers::new(vec![RADIUS_M, 1.001 * RADIUS_M], RADIUS_M).unwrap();
    let value = |cell: usize| 0.5 + 0.5 * grid.direction(cell as u32).dot(DVec3::new(0.48, 0.6, 0.64));
    let values: Vec<f64> = (0..points.len()).flat_map(|cell| [value(cell); 2]).collect();
    let scene = format!(
        "field = 'f'\ncore = 'transparent'\nbackground = 'transparent'\nimage = {{ width = 80, height = 80 }}\n\
         camera = {{ lon = {lon}, lat = {lat}, distance = {distance}, fov = 40 }}\n\
         [[surfaces]]\nlayer = 'bottom'\nfield = 'f'\nshading = 'cells'\n\
         transfer = {{ knots = [ {{ value = 0, color = 'black' }}, {{ value = 1, color = 'white' }} ] }}"
    );
    let mut scene = Scene::parse(&scene).unwrap();
    scene.volumes[0].transfer.knots.iter_mut().for_each(|knot| knot.extinction = 0.0);
    let frame = Renderer::new(1).unwrap().render(&scene, &grid, &layers, &at_centers(&values, 2)).unwrap();
    let (mut right, mut all) = (0, 0);
    for ((eye, dir), pixel) in rays(&scene).zip(&frame.pixels) {
        let (b, c) = (eye.dot(dir), eye.length_squared() - 1.0);
        // Beside the limb, where facets end before the sphere does.
        if b * b - c < 0.1 {
            continue;
        }
        let at = (eye + (-b - (b * b - c).sqrt()) * dir).normalize();
        let apart = |cell: usize| at.distance(grid.direction(cell as u32));
        let nearest = (0..points.len()).map(apart).fold(f64::INFINITY, f64::min);
        let near = (0..points.len()).filter(|cell| apart(*cell) <= nearest + spacing).map(value);
        let [least, most] = near.fold([1.0, 0.0], |[least, most], value| [value.min(least), value.max(most)]);
        // Colours of rims are multiplied by how much of the pixel is covered.
        let (shown, is_shown) = (f64::from(pixel[0] / pixel[3].max(0.5)), pixel[3] > 0.5);
        let is_right = !is_shown || (least - 1e-6..most + 1e-6).contains(&shown);
        right += usize::from(is_right && is_shown == is_covered(at.y.atan2(at.x), at.z.asin()));
        all += 1;
    }
    assert!(all > 500, "{all}");
    right as f64 / all as f64
}

#[test]
fn pictures_show_the_nearest_points() {
    let step = PI / 36.0;
    let row = |i: usize| -PI / 2.0 + step * (i / 73) as f64;
    let lat_lon: Vec<[f64; 2]> = (0..73 * 37).map(|i| [step * (i % 73) as f64, row(i)]).collect();
    let mut random = Random::new(11);
    let scattered: Vec<[f64; 2]> =
        (0..2500).map(|_| [TAU * random.unit() - PI, (2.0 * random.unit() - 1.0).asin()]).collect();
    let region = |i: usize| [0.4 + 0.01 * (i % 40) as f64, 0.6 + 0.01 * (i / 40) as f64];
    let region: Vec<[f64; 2]> = (0..40 * 30).map(region).collect();
    let everywhere: IsCovered = |_, _| true;
    let in_region: IsCovered = |lon, lat| (0.4..0.79).contains(&lon) && (0.6..0.89).contains(&lat);
    for (name, points, spacing, camera, is_covered) in [
        ("both poles", &lat_lon, step, [20.0, 70.0, 3.5], everywhere),
        ("a repeated meridian", &lat_lon, step, [0.0, 5.0, 3.5], everywhere),
        ("scattered", &scattered, 0.08, [-170.0, -30.0, 3.5], everywhere),
        ("a region", &region, 0.01, [33.0, 42.0, 1.9], in_region),
    ] {
        let share = share_of_right_pixels(points, spacing, camera, is_covered);
        assert!(share >= 0.99, "{name}: {share}");
    }
}
