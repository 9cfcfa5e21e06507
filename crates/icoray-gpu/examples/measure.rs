//! Seconds of a frame on a GPU and on the CPU, one after the other, and how far the pictures are apart.
//!
//! `cargo run --release -p icoray-gpu --example measure -- [LEVEL [LAYERS [SIDE [GPU.png]]]]`: a sphere of LEVEL bisections,
//! 6 unless told, with LAYERS layers (20), in a picture of SIDE² pixels (512).

use icoray::device::Device;
use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene, Shape};
use icoray_gpu::{Choice, Gpu};
use std::error::Error;
use std::sync::Arc;
use std::time::Instant;

const TRANSFERS: [(&str, &str); 3] = [
    ("dense", "[[-1, 0.3], [1, 0.9]]"),
    ("lobes", "[[-1, 0], [-0.5, 0.9], [-0.2, 0], [0.2, 0], [0.5, 0.9], [1, 0]]"),
    ("thin", "[[-1, 0], [0.58, 0], [0.6, 0.95], [0.62, 0], [1, 0]]"),
];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: usize| arguments.get(i).map_or(Ok(default), |text| text.parse());
    let (level, count, side) = (number(0, 6)?, number(1, 20)?, number(2, 512)?);
    let tables = IcosahedralMesh::new(level as u32)?;
    let grid = Grid::new(tables.tables())?;
    let layers = Layers::new((0..count).map(|l| 1.0 + 0.15 * l as f64 / (count - 1) as f64).collect(), 1.0)?;
    let wave = |cell: u32, layer: usize| {
        let (p, phase) = (grid.direction(cell), 3.0 * layer as f64 / count as f64);
        let fine = (17.0 * p.x + phase).sin() * (15.0 * p.y - phase).cos();
        (0.6 * (3.0 * p.x + phase).sin() * (4.0 * p.y).cos() + 0.4 * fine) as f32
    };
    let values: Vec<f32> =
        (0..grid.cells() as u32).flat_map(|cell| (0..count).map(move |layer| wave(cell, layer))).collect();
    let shape = Shape::level_fastest(grid.cells(), count);
    let field = Field::new(values.as_slice().into(), shape, Location::Center, None)?;
    let renderer = Renderer::new(0)?;
    let gpu: Arc<dyn Device> = Arc::new(Gpu::new(&Choice::Any)?);
    let with_gpu = Renderer::new(0)?.with_device(Arc::clone(&gpu));
    println!("{}", gpu.name());
    println!("{} cells x {count} layers, {side} x {side}; seconds", grid.cells());
    println!(
        "| scene | frusta | GPU first | GPU upload | MB | GPU render | CPU render, {} threads | RMSE | max |",
        renderer.threads()
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for (name, opacity) in TRANSFERS {
        let scene = Scene::parse(&format!(
            "field = \"f\"\n[image]\nwidth = {side}\nheight = {side}\n[camera]\nlon = 30\nlat = 25\ndistance = 3.2\nfov = 45\n\
             [transfer]\nmap = \"viridis\"\nrange = [-1, 1]\nopacity = {opacity}\n"
        ))?;
        // Of a field that the model may have written anew.
        let draw = || {
            let field = Field::new(values.as_slice().into(), shape, Location::Center, None)?;
            let frame = with_gpu.render(&scene, &grid, &layers, &field)?;
            match frame.report.left_to_cpu.clone() {
                None => Ok::<_, Box<dyn Error>>(frame),
                Some(reason) => Err(reason.into()),
            }
        };
        // The first frame uploads the grid and compiles the shader.
        let start = Instant::now();
        draw()?;
        let first_s = start.elapsed().as_secs_f64();
        let ours = draw()?;
        let theirs = renderer.render(&scene, &grid, &layers, &field)?;
        let off: Vec<f64> = (ours.pixels.iter().flatten().zip(theirs.pixels.iter().flatten()))
            .map(|(a, b)| f64::from((a - b).abs()))
            .collect();
        let rmse = (off.iter().map(|d| d * d).sum::<f64>() / off.len() as f64).sqrt();
        println!(
            "| {name} | {} | {first_s:.3} | {:.3} | {:.1} | {:.3} | {:.3} | {rmse:.1e} | {:.1e} |",
            ours.report.counts.frusta,
            ours.report.upload_s,
            ours.report.bytes_uploaded as f64 / 1e6,
            ours.report.render_s,
            theirs.report.render_s,
            off.iter().copied().fold(0.0, f64::max),
        );
        if let Some(path) = arguments.get(3) {
            icoray::output::write_picture(path.as_ref(), &ours)?;
        }
    }
    Ok(())
}
