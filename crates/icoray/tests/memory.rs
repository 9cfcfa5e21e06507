//! The second and later frames of a grid allocate nothing that grows with the grid.

use icoray::{Field, Fields, Grid, Heights, IcosahedralMesh, Layers, Location, Renderer, Scene, Volume};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

const LAYERS: usize = 12;

fn scene(rest: &str) -> Scene {
    let text = format!(
        "field = \"f\"\nexaggeration = 60\ncore = \"#303030\"\n[image]\nwidth = 48\nheight = 40\n\
         [camera]\nlon = 20\nlat = 40\ndistance = 4\n[transfer]\nmap = \"viridis\"\nrange = [-1, 1]\n\
         opacity = [[-1, 0.2], [0, 0], [0.5, 0], [1, 0.8]]\n{rest}\n"
    );
    Scene::parse(&text).unwrap_or_else(|e| panic!("{e}"))
}

/// Cells and layers of a sphere of `level` bisections, and the bytes that the third frame allocates. The field f lies
/// on the layers; with `others` beside it, midway between them: g and h at centres and at corners in their own
/// precision each, and heights.
fn bytes_of_a_later_frame(level: u32, scene: &Scene, location: Location, others: bool) -> (usize, usize) {
    let mesh = IcosahedralMesh::new(level).unwrap();
    let grid = Grid::new(mesh.tables()).unwrap();
    let heights: Vec<f64> = (0..LAYERS + usize::from(others)).map(|k| 1000.0 * k as f64).collect();
    let layers = Layers::from_heights(&heights, 6_371_000.0).unwrap();
    let wave = |count: usize| (0..count).map(|i| (i as f64 * 1e-3).sin());
    let (cells, corners) = (grid.cells(), grid.triangles());
    let columns = if location == Location::Center { cells } else { corners };
    let f: Vec<f32> = wave(columns * LAYERS).map(|value| value as f32).collect();
    let g: Vec<f64> = wave(cells * (LAYERS + 1)).collect();
    let h: Vec<f32> = wave(corners * (LAYERS + 1)).map(|value| value as f32).collect();
    let lifted: Vec<f64> = (0..cells).flat_map(|_| heights.clone()).collect();
    let renderer = Renderer::new(1).unwrap();
    // Fields of their own each, as a model that computes on has.
    let draw = || {
        let mut fields = Fields::new([("f", Field::level_fastest(&f, LAYERS, location).unwrap())]);
        if others {
            let g = Field::level_fastest(&g, LAYERS + 1, Location::Center).unwrap();
            let h = Field::level_fastest(&h, LAYERS + 1, Location::Corner).unwrap();
            let lifted = Field::level_fastest(&lifted, LAYERS + 1, Location::Center).unwrap();
            fields = fields.with(Fields::new([("g", g), ("h", h)])).with_heights(lifted);
        }
        renderer.render(scene, &grid, &layers, fields).unwrap();
    };
    draw();
    draw();
    let region = Region::new(ALLOCATOR);
    draw();
    (cells * LAYERS, region.change().bytes_allocated)
}

/// One test alone in its process, as the allocator counts for all threads.
#[test]
fn later_frames_allocate_nothing_that_grows_with_the_grid() {
    general_frames_make_no_array_anew();
    let lit = "[light]\nkind = \"headlight\"";
    for (name, rest, location) in [
        ("unlit", "", Location::Center),
        ("lit", lit, Location::Center),
        ("corners", "", Location::Corner),
        ("corners, lit", lit, Location::Corner),
    ] {
        let [(_, small), (_, large)] = [3, 6].map(|level| bytes_of_a_later_frame(level, &scene(rest), location, false));
        println!("{name}: {small} bytes with 642 cells, {large} with 40,962");
        // Of 40,320 cells more, not a byte each.
        assert!(large < small + 20_000, "{name}: {small} and {large} bytes");
    }
}

/// Single rays allocate some memory in each frustum. Of those through a few pixels it is less than a
/// byte for each value of the grid, of which the smallest array has four.
fn general_frames_make_no_array_anew() {
    let more = "[[isosurfaces]]\nfield = \"h\"\nvalue = 0.3\ncolor = \"red\"\n[light]\nkind = \"headlight\"";
    for heights in ["mean", "native"] {
        let mut scene = scene(more);
        (scene.width, scene.height) = (2, 2);
        let (field, transfer) = ("g".into(), scene.volumes[0].transfer.clone());
        scene.volumes.extend([Volume { field, transfer, coloring: None, opacity: None }]);
        scene.scenery.heights = if heights == "mean" { Heights::Mean } else { Heights::Native };
        let (values, bytes) = bytes_of_a_later_frame(6, &scene, Location::Corner, true);
        println!("several fields, {heights} heights: {bytes} bytes of {values} values each");
        assert!(bytes < values, "{heights} heights: {bytes} bytes of {values} values each");
    }
}
