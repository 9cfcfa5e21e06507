//! Pictures against those of the CPU.

use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene, Shape};
use icoray_gpu::{Choice, Gpu, Outcome};
use std::time::Instant;

#[test]
fn first() {
    let gpu = match Gpu::new(&Choice::Any) {
        Ok(gpu) => gpu,
        Err(reason) => return eprintln!("skipped: {reason}"),
    };
    eprintln!("{}", gpu.name());
    let mesh = IcosahedralMesh::new(4).unwrap();
    let grid = Grid::new(mesh.tables()).unwrap();
    let layers = Layers::from_heights(&[0.0, 5e3, 12e3, 20e3], 6.371e6).unwrap();
    let values: Vec<f32> = (0..grid.cells() * 4)
        .map(|i| {
            let d = grid.direction((i / 4) as u32);
            ((3.0 * d.x).sin() * (4.0 * d.y).cos() + d.z + 0.3 * (i % 4) as f64) as f32
        })
        .collect();
    let field =
        Field::new(values.as_slice().into(), Shape::level_fastest(grid.cells(), 4), Location::Center, None)
            .unwrap();
    let scene = Scene::parse("field=\"f\"\nexaggeration=60\ncore=\"black\"\n[image]\nwidth=256\nheight=256\n[camera]\nlon=20\nlat=35\ndistance=3.2\nfov=45\n[transfer]\nmap=\"viridis\"\nrange=[-1.5,2.5]\nopacity=[[-1.5,0.5],[0,0.05],[0.4,0.8],[2.5,0.3]]\n").unwrap();
    let renderer = Renderer::new(0).unwrap();
    let on = gpu.mesh(&grid).unwrap();
    let cpu = renderer.render(&scene, &grid, &layers, &field).unwrap();
    for _ in 0..2 {
        let start = Instant::now();
        let frame = match gpu.render(&renderer, &scene, &on, &layers, &field).unwrap() {
            Outcome::Drawn(f) => f,
            Outcome::Left(r) => panic!("{r}"),
        };
        eprintln!(
            "gpu {:?} {:?} {} {:?}",
            start.elapsed(),
            frame.report.counts,
            frame.report.error,
            frame.report.render_s
        );
        eprintln!("cpu {:?} {}", cpu.report.counts, cpu.report.error);
        eprintln!("{} s", cpu.report.render_s);
        let d: Vec<f64> = frame
            .pixels
            .iter()
            .flatten()
            .zip(cpu.pixels.iter().flatten())
            .map(|(a, b)| f64::from((a - b).abs()))
            .collect();
        eprintln!(
            "max {:e} rmse {:e}",
            d.iter().cloned().fold(0.0, f64::max),
            (d.iter().map(|x| x * x).sum::<f64>() / d.len() as f64).sqrt()
        );
    }
}
