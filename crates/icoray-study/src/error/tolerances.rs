//! Cost and errors of each tolerance: seconds, frusta, true and reported errors by kind of scene.

use crate::results::{replace_section, say, timed};
use glam::DVec3;
use icoray::{Field, Fields, Layers, Location, Precision, Renderer, Result, Scene, Shape};
use icoray_reference::comparison::{BoundCheck, Comparison};
use icoray_reference::oracle::{Data, NamedField, Oracle, PANEL};
use icoray_reference::ray::Ray;
use icoray_reference::sphere::{Sphere, multi_scale};
use rayon::prelude::*;
use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;

const LAYERS: usize = 16;
const SHELL: [f64; 2] = [1.0, 1.15];

/// Mesh level and pictures of the table.
const LEVEL: u32 = 4;
const SIZE: [u32; 2] = [120, 90];

/// Times that each picture is drawn; the shortest counts.
const FRAMES: usize = 5;

const VOLUME: &str = "[[volumes]]\nfield = \"f\"\ntransfer = { map = \"vik\", range = [-1, 1], \
    opacity = [[-0.8, 0.9], [-0.1, 0], [0.2, 0], [0.8, 0.9]] }\n";
const OTHER: &str = "[[volumes]]\nfield = \"g\"\ntransfer = { map = \"plasma\", range = [0, 1], \
    opacity = [[0.1, 0], [0.4, 0.6], [1, 0.8]] }\n";
const ISOSURFACES: &str = "[[isosurfaces]]\nfield = \"f\"\nvalues = [-0.4, 0.3]\ncolors = [\"red\", \"#4080ff\"]\n\
    opacity = 0.5\n";
const LOG: &str = "[[volumes]]\nfield = \"g\"\ntransfer = { map = \"viridis\", scale = \"log\", range = [1e-4, 1], \
    opacity = [[0, 0], [1, 0.9]], opacity_in = \"range\" }\n";
const LIGHT: &str = "[light]\nkind = \"headlight\"\n";

/// Names and contents of the scenes.
const SCENES: [(&str, &[&str]); 5] = [
    ("one volume", &[VOLUME]),
    ("lit", &[VOLUME, LIGHT]),
    ("several volumes", &[VOLUME, OTHER]),
    ("isosurfaces", &[VOLUME, ISOSURFACES]),
    ("log scale", &[LOG]),
];

/// Measures `1e-1` to `1e-7` in both precisions; prints the table, and puts it into the file `readme`.
pub(super) fn run(readme: Option<&Path>, renderer: &Renderer, all: &Renderer, out: &mut dyn Write) -> Result<()> {
    let table = table(renderer, all, SIZE)?;
    say!(out, "{table}")?;
    replace_section(readme, "error", &table)
}

fn table(renderer: &Renderer, all: &Renderer, [width, height]: [u32; 2]) -> Result<String> {
    let f = Sphere::new(LEVEL, LAYERS, SHELL, multi_scale)?;
    // Decades, as of cloud water.
    let g = Sphere::new(LEVEL, LAYERS, SHELL, |p| 10f64.powf(-2.0 + 2.0 * multi_scale(DVec3::new(p.z, p.x, p.y))))?;
    let (grid, layers) = (f.grid()?, Layers::new(f.layers.radius_m().to_vec(), 1.0)?);
    let values = [&f, &g].map(|sphere| sphere.values.iter().map(|v| f64::from(*v)).collect::<Vec<f64>>());
    let shape = Shape::level_fastest(grid.cells(), LAYERS);
    let field = |k: usize| Field::new(values[k].as_slice().into(), shape, Location::Center, None);
    let [ours, others] = [field(0)?, field(1)?];
    let named = [(0, "f"), (1, "g")].map(|(k, name)| NamedField { name, values: values[k].clone() });
    let mut text = String::from(
        "| scene | tolerance | f32: s | frusta | error | reported | f64: s | frusta | error | reported |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (name, contents) in SCENES {
        let mut scene = Scene::parse(&format!(
            "antialias = false\nbackend = \"cpu\"\nbackground = \"transparent\"\nimage = {{ width = {width}, height = {height} }}\n\
             camera = {{ lon = 30, lat = 25, distance = 3.2, fov = 45 }}\n{}",
            contents.concat()
        ))?;
        let data = Data { grid: &grid, layers: &layers, heights: &[], fields: &named };
        let oracle = Oracle::new(&scene, data, PANEL)?;
        let pixel = |i: u32| oracle.pixel(&Ray::of_pixel(&scene, i)).unwrap_or([f64::NAN; 4]);
        let truth: Vec<[f64; 4]> = all.run(|| (0..width * height).into_par_iter().map(pixel).collect());
        for digits in 1..=7 {
            scene.tolerance = 10f64.powi(-digits);
            let _ = write!(text, "| {name} | 1e-{digits} |");
            for precision in [Precision::F32, Precision::F64] {
                scene.precision = precision;
                let fields = || Fields::new([("f", ours), ("g", others)]);
                let frames = (0..FRAMES).map(|_| timed(renderer, &scene, &grid, &layers, fields()));
                let frames = frames.collect::<Result<Vec<_>>>()?;
                let (seconds, frame) = frames.iter().min_by(|a, b| a.0.total_cmp(&b.0)).expect("there are frames");
                let errors = Comparison::new(&frame.pixels, &truth);
                let reported = BoundCheck::new(&frame.error, &errors.pixel_errors);
                let BoundCheck { max, median, median_error, .. } = reported;
                let _ = write!(
                    text,
                    " {seconds:.3} | {} | {:.0e}, {median_error:.0e} | {max:.0e}, {median:.0e} |",
                    frame.report.counts.frusta, errors.max
                );
            }
            text += "\n";
        }
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_scenes_and_tolerances_have_their_errors() {
        let renderer = Renderer::new(1).unwrap();
        let table = table(&renderer, &renderer, [12, 9]).unwrap();
        let rows: Vec<Vec<&str>> = table.lines().skip(2).map(|line| line.split('|').map(str::trim).collect()).collect();
        assert_eq!(rows.len(), 7 * SCENES.len());
        for (i, row) in rows.iter().enumerate() {
            assert_eq!((row.len(), row[1]), (12, SCENES[i / 7].0), "{row:?}");
            let largest = |cell: &str| cell.split(", ").next().unwrap().parse::<f64>().unwrap();
            // One digit is printed: a half more may be rounded away.
            for (error, reported) in [(5, 6), (9, 10)] {
                assert!(largest(row[error]) <= 1.5 * largest(row[reported]), "{row:?}");
            }
            let tolerance: f64 = row[2].parse().unwrap();
            assert!(largest(row[9]) <= tolerance.max(1e-7) && row[4].parse::<u64>().unwrap() > 0, "{row:?}");
        }
    }
}
