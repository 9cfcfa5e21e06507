//! A minimal program that draws a field on a geodesic grid: a wave of the jet stream around the northern hemisphere.
//!
//! `cargo run --release --package first-picture` writes `first_picture.png`; an argument gives another name.

use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene, Shape, output};
use std::path::PathBuf;

const LAYERS: usize = 16;

/// Content and camera of the picture. Lengths are in planet radii, angles in degrees.
const SCENE: &str = r##"
field = "wave"
exaggeration = 40
background = "#0b0f16"
core = "#36424e"
image = { width = 720, height = 540 }
camera = { lon = 10, lat = 38, distance = 3.1, fov = 45 }
light = { kind = "sun", lon = -35, lat = 45, ambient = 0.35, diffuse = 0.65, specular = 0.2 }
lines = [
    { pattern = "coast", color = "#aebccb", opacity = 0.8 },
    { pattern = "graticule", spacing = 30, color = "#8fa3b8", opacity = 0.3 },
]

[transfer]
map = "vik"
range = [-1, 1]
opacity = [[-1, 0.95], [-0.35, 0.6], [-0.2, 0], [0.2, 0], [0.35, 0.6], [1, 0.95]]
unit_length = 0.05

[labels]
title = "A wave of the jet stream"
"##;

/// The model's field: six lows and six highs, which lean to the west with height. `height` is 0 to 1.
fn wave(lon: f64, lat: f64, height: f64) -> f64 {
    let jet = ((lat - 0.8 - 0.1 * (3.0 * lon).sin()) / 0.25).powi(2);
    let depth = ((height - 0.5) / 0.35).powi(2);
    (6.0 * lon + 1.5 * height).cos() * (-jet - depth).exp()
}

fn main() -> Result<(), icoray::Error> {
    // The grid: a model's own tables are borrowed in the same way, by `GridTables`.
    let mesh = IcosahedralMesh::new(6)?;
    let grid = Grid::new(mesh.tables())?;

    // Layers 1 km apart, and a value per cell and layer, those of a cell one after the other.
    let heights: Vec<f64> = (0..LAYERS).map(|k| 1000.0 * k as f64).collect();
    let layers = Layers::from_heights(&heights, 6.371e6)?;
    let cells = mesh.lon_center_rad.iter().zip(&mesh.lat_center_rad);
    let column = |(lon, lat): (&f64, &f64)| {
        let (lon, lat) = (*lon, *lat);
        (0..LAYERS).map(move |k| wave(lon, lat, k as f64 / (LAYERS - 1) as f64))
    };
    let values: Vec<f64> = cells.flat_map(column).collect();
    let shape = Shape::level_fastest(grid.cells(), LAYERS);
    let field = Field::new(values.as_slice().into(), shape, Location::Center, None)?;

    // The picture, on all processors.
    let scene = Scene::parse(SCENE)?;
    let frame = Renderer::new(0)?.render(&scene, &grid, &layers, &field)?;
    let path = std::env::args_os().nth(1).map_or("first_picture.png".into(), PathBuf::from);
    output::write_picture(&path, &frame)
}
