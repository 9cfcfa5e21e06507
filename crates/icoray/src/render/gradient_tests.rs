//! Gradients that a renderer computes for a picture and keeps for the next one.

use super::Renderer;
use super::frame_cache::GradientKey;
use icoray_grid::gradient::PartialGradients;
use icoray_grid::{Field, Grid, IcosahedralMesh, Layers, Location};
use icoray_scene::Scene;

fn scene(camera: &str) -> Scene {
    Scene::parse(&format!(
        "field = \"f\"\n[image]\nwidth = 24\nheight = 24\n[camera]\n{camera}\n[light]\nkind = \"headlight\"\n\
         [transfer]\nmap = \"viridis\"\nrange = [0, 1]\nopacity = [[0, 0.5], [1, 0.5]]\n"
    ))
    .unwrap()
}

/// A close-up computes a few cells' gradients; the next view adds those that it needs besides, and the same view none.
#[test]
fn each_view_adds_the_gradients_that_it_needs() {
    let mesh = IcosahedralMesh::new(5).unwrap();
    let grid = Grid::new(mesh.tables()).unwrap();
    let layers = Layers::from_heights(&[0.0, 100e3, 200e3], 6.371e6).unwrap();
    let values: Vec<f32> = (0..mesh.cells() * 3).map(|i| (i as f32 * 0.37).sin().abs()).collect();
    let field = Field::level_fastest(&values, 3, Location::Center).unwrap();
    let renderer = Renderer::new(1).unwrap();
    let mut computed = Vec::new();
    let views = ["lon = 10\nlat = 20", "lon = 10\nlat = 20", "lon = 200\nlat = -30"];
    for view in views.map(|place| format!("{place}\ndistance = 1.5\nfov = 20")) {
        renderer.render(&scene(&view), &grid, &layers, &field).unwrap();
        let known = renderer
            .frame_cache
            .gradients
            .newest(|_: &GradientKey, gradients: &PartialGradients| gradients.computed_cells(grid.cells()));
        computed.push(known.expect("the gradients of the last picture"));
    }
    let [first, again, both] = computed[..] else { unreachable!("three pictures") };
    assert!(first > 50 && first < grid.cells() / 10, "{first} of {}", grid.cells());
    assert_eq!(first, again);
    assert!(both > first + 50 && both < grid.cells() / 5, "{both} of {}", grid.cells());
}
