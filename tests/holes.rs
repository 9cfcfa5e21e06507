//! Pictures of a real ocean without land against the oracle by brute force over all triangles. Random scenes have meshes
//! with holes of all kinds.

use glam::DVec3;
use icoray::{Field, Grid, Layers, Location, Renderer, Scene, Stretch, Traversal};
use icoray_reference::comparison::pixel_error;
use icoray_reference::job::Job;
use icoray_reference::oracle::brute_force;
use icoray_test_support::data_file;
use std::ops::ControlFlow;

const RADIUS: [f64; 5] = [1.0, 1.02, 1.05, 1.09, 1.15];

/// An analytic field: waves over the sphere whose phase turns with height.
fn values(grid: &Grid) -> Vec<f64> {
    let value = |p: DVec3, layer: usize| {
        let turn = 0.4 * layer as f64;
        (3.0 * p.x + turn).sin() * (4.0 * p.y).cos() + (2.0 * p.z - turn).sin()
    };
    let at = (0..grid.cells() as u32).map(|cell| grid.direction(cell));
    at.flat_map(|p| (0..RADIUS.len()).map(move |layer| value(p, layer))).collect()
}

fn scene(camera: &str, core: &str, precision: &str) -> Scene {
    let tolerance = if precision == "f64" { 1e-9 } else { 1e-6 };
    let scene = Scene::parse(&format!(
        "field = \"f\"\nantialias = false\nbackground = \"transparent\"\ncore = \"{core}\"\nprecision = \"{precision}\"\n\
         [image]\nwidth = 48\nheight = 36\n[camera]\n{camera}\n\
         [transfer]\nmap = \"viridis\"\nrange = [-2, 2]\nopacity = [[-2, 0.6], [0, 0.05], [0.5, 0.9], [2, 0.4]]\n"
    ));
    Scene { tolerance, ..scene.unwrap() }
}

/// Draws the grid and gives the largest error of a channel and how many pixels show something.
fn measure(renderer: &Renderer, grid: &Grid, scene: &Scene) -> (f64, usize) {
    let layers = Layers::new(RADIUS.to_vec(), 1.0).unwrap();
    let values = values(grid);
    let field = Field::level_fastest(&values, RADIUS.len(), Location::Center).unwrap();
    let job = Job { scene, grid, layers: &layers, field: &field };
    // A gap, a place that no triangle covers, data or void, would be NaN, an infinite error.
    let exact = brute_force(&job, renderer).unwrap();
    let pixels = job.render(renderer).unwrap().pixels;
    let errors = pixels.into_iter().zip(&exact).map(|(pixel, exact)| pixel_error(pixel, exact));
    (errors.fold(0.0, f64::max), exact.iter().filter(|pixel| pixel[3] > 0.0).count())
}

#[test]
fn an_ocean_without_land_is_drawn_exactly() {
    let Some(path) = data_file("spherical_grid_500km_landculled.nc") else { return };
    let file = icoray_netcdf::open(path).unwrap();
    let grid = file.mesh().grid().unwrap();
    let there = (0..grid.triangles() as u32).filter(|&t| grid.is_triangle(t)).count();
    // 933 of its corners lack a cell.
    assert_eq!((grid.cells(), grid.triangles() - there), (1735, 933));
    println!("{there} triangles, {} void ones", grid.void_triangles());
    // Straight down: whether there are data is whether there is water.
    let traversal = Traversal::new(&grid, &RADIUS).unwrap();
    let is_water = |lon: f64, lat: f64| {
        let (lon_rad, lat_rad) = (lon.to_radians(), lat.to_radians());
        let up = DVec3::new(lat_rad.cos() * lon_rad.cos(), lat_rad.cos() * lon_rad.sin(), lat_rad.sin());
        let mut frusta = 0;
        traversal.ray(up * 2.0, -up, &mut 0, |stretch| match stretch {
            Stretch::Frustum(_) => {
                frusta += 1;
                ControlFlow::Continue(())
            }
            Stretch::Core { .. } => ControlFlow::Break(()),
        });
        assert!(frusta == 0 || frusta == RADIUS.len() - 1, "{frusta} frusta at {lon}, {lat}");
        frusta > 0
    };
    let water =
        [(-150.0, 0.0), (-30.0, 0.0), (80.0, -20.0), (-140.0, 40.0), (100.0, -50.0), (170.0, -30.0), (-20.0, -40.0)];
    let land = [
        (22.0, 3.0),
        (20.0, 22.0),
        (95.0, 55.0),
        (80.0, 45.0),
        (-58.0, -10.0),
        (-100.0, 45.0),
        (134.0, -25.0),
        (60.0, -82.0),
    ];
    for (lon, lat) in water {
        assert!(is_water(lon, lat), "no water at {lon}, {lat}");
    }
    for (lon, lat) in land {
        assert!(!is_water(lon, lat), "no land at {lon}, {lat}");
    }
    let renderer = Renderer::new(0).unwrap();
    let views = [
        "lon = -20\nlat = 10\ndistance = 3.2\nfov = 40",
        "lon = 130\nlat = -20\ndistance = 3.2\nfov = 40",
        // Inside the shell, over a coast.
        "lon = -70\nlat = -30\ndistance = 1.1\nfov = 110",
    ];
    let (mut worst, mut seen) = ([0.0f64; 2], 0);
    for (i, view) in views.iter().enumerate() {
        for (j, (precision, limit)) in [("f64", 1e-9), ("f32", 1e-5)].into_iter().enumerate() {
            let core = ["transparent", "#804020"][(i + j) % 2];
            let (error, pixels) = measure(&renderer, &grid, &scene(view, core, precision));
            assert!(error <= limit, "view {i}, {precision}: {error:e}");
            worst[j] = worst[j].max(error);
            seen += pixels;
        }
    }
    println!("largest errors: f64 {:.1e}, f32 {:.1e}; {seen} pixels see something", worst[0], worst[1]);
    assert!(seen > 3000, "{seen}");
}
