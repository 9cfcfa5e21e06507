//! The hook that reports finished tiles.

use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene};
use std::sync::{Arc, Mutex};

#[test]
fn each_tile_is_reported_once_and_the_picture_is_the_same() {
    let mesh = IcosahedralMesh::new(2).unwrap();
    let grid = Grid::new(mesh.tables()).unwrap();
    let layers = Layers::from_heights(&[0.0, 1e5, 2e5], 6.371e6).unwrap();
    let values: Vec<f32> = (0..grid.cells() * 3).map(|i| (i % 7) as f32).collect();
    let field = Field::level_fastest(&values, 3, Location::Center).unwrap();
    let text = "field = \"q\"\n[image]\nwidth = 97\nheight = 61\n[camera]\nlon = 0\nlat = 20\ndistance = 3\n\
                [transfer]\nmap = \"viridis\"\nrange = [0, 6]\nopacity = [[0, 0.1], [6, 0.8]]\n";
    let scene = Scene::parse(text).unwrap();
    let reports = Arc::new(Mutex::new(Vec::new()));
    let hook = Arc::clone(&reports);
    let renderer = Renderer::new(2)
        .unwrap()
        .with_progress(Arc::new(move |finished, total| hook.lock().unwrap().push((finished, total))));
    let frame = renderer.render(&scene, &grid, &layers, &field).unwrap();
    let mut reports = std::mem::take(&mut *reports.lock().unwrap());
    reports.sort_unstable();
    let total = frame.report.ranks.tiles;
    assert!(total > 4);
    assert_eq!(reports, (1..=total).map(|finished| (finished, total)).collect::<Vec<_>>());
    let silent = Renderer::new(1).unwrap().render(&scene, &grid, &layers, &field).unwrap();
    assert!(frame.pixels == silent.pixels, "the hook changes nothing");
}
