//! What is drawn, and how the GPU's picture is compared with the CPU's.

use glam::DVec3;
use icoray::{
    Counts, Field, Frame, Grid, IcosahedralMesh, Layers, Location, Precision, Renderer, Savings, Scene, Shape,
};
use icoray_gpu::Gpu;
use icoray_test_support::{Need, skip_because};
use std::sync::{Arc, OnceLock};

pub const RMSE: f64 = 2e-5;
pub const MAX: f64 = 1e-3;

pub const RAMP: &str =
    "map = \"viridis\"\nrange = [-1, 1]\nopacity = [[-1, 0.5], [-0.2, 0.05], [0.1, 0.8], [1, 0.3]]";
pub const SMOOTH: &str = "knots = [ { value = -0.8, color = \"blue\", extinction = 4 }, { value = -0.2, color = \"white\", extinction = 0 }, \
     { value = 0.3, color = \"yellow\", extinction = 1 }, { value = 0.8, color = \"red\", extinction = 9 } ]";
pub const DENSE: &str = "knots = [ { value = -0.9, color = \"red\", extinction = 3 }, { value = 0.1, color = \"blue\", extinction = 900 }, \
     { value = 0.9, color = \"white\", extinction = 1e5 } ]";
pub const STEPS: &str = "knots = [ { value = -0.9, color = \"red\", extinction = 1e6 }, { value = -0.5, color = \"orange\", extinction = 1e6 }, \
     { value = -0.5, color = \"blue\", extinction = 0 }, { value = 0.9, color = \"white\", extinction = 5 } ]";
pub const SPIKE: &str = "knots = [ { value = 0.1, color = \"red\", extinction = 0 }, { value = 0.1000005, color = \"green\", extinction = 1e5 }, \
     { value = 0.100001, color = \"blue\", extinction = 0 }, { value = 0.9, color = \"white\", extinction = 5 } ]";
pub const TRANSFERS: [(&str, &str); 5] =
    [("ramp", RAMP), ("smooth", SMOOTH), ("dense", DENSE), ("steps", STEPS), ("spike", SPIKE)];

pub const FAR: &str = "lon = 30\nlat = 25\ndistance = 3.2\nfov = 45";
pub const POLE: &str = "lon = 25\nlat = 89.999\ndistance = 1.4\nfov = 90";
pub const INSIDE: &str = "eye = [1.02, 0.3, 0.1]\ntarget = [0, 1.2, 0.3]\nfov = 90";
pub const CENTRE: &str = "eye = [0, 0, 0]\ntarget = [0.3, 1, 0.2]\nfov = 110";
pub const RADIAL: &str = "eye = [0, 0, 2]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nfov = 50";
/// Just above and inside a shell that ends 3 km up, looking along the limb.
pub const LIMB: &str = "eye = [1.001, 0.007, 0.003]\ntarget = [0.9, 0.6, 0.1]\nfov = 30";
pub const IN_THIN: &str = "eye = [1.0003, 0.007, 0.011]\ntarget = [1.0003, 0.4, 0.1]\nfov = 60";

pub const EARTH_M: f64 = 6_371_229.0;
pub const THICK_M: [f64; 5] = [0.0, 3e3, 5e3, 12e3, 20e3];

/// The device. Where there is none, skips the test.
pub fn gpu() -> Option<Arc<Gpu>> {
    static GPU: OnceLock<Result<Arc<Gpu>, String>> = OnceLock::new();
    let open = || Gpu::new(None).map(Arc::new).map_err(|reason| reason.to_string());
    GPU.get_or_init(open).clone().inspect_err(|reason| skip_because(Need::Gpu, reason)).ok()
}

/// A renderer that draws on it.
pub fn renderer(gpu: &Arc<Gpu>) -> Renderer {
    Renderer::new(1).unwrap().with_device(Arc::clone(gpu) as _)
}

/// A renderer that looks at all that a device looks at, one frustum after the other, so that it counts the same.
pub fn cpu(threads: usize) -> Renderer {
    Renderer::new(threads).unwrap().with_savings(Savings { ends: true, ..Savings::NONE })
}

pub fn wave(p: DVec3, layer: usize, layers: usize) -> f64 {
    let phase = 2.0 * layer as f64 / layers as f64;
    let fine = (17.0 * p.x + phase).sin() * (15.0 * p.y - phase).cos();
    0.6 * (3.0 * p.x + phase).sin() * (4.0 * p.y).cos() + 0.3 * p.z + 0.15 * fine
}

pub fn values(grid: &Grid, layers: usize) -> Vec<f32> {
    let all = (0..grid.cells() as u32).flat_map(|cell| (0..layers).map(move |layer| (cell, layer)));
    all.map(|(cell, layer)| wave(grid.direction(cell), layer, layers) as f32).collect()
}

/// A whole sphere with a smooth field on layers at heights in metres.
pub struct Sphere {
    pub tables: IcosahedralMesh,
    pub layers: Layers,
    pub values: Vec<f32>,
}

impl Sphere {
    pub fn new(level: u32, heights: &[f64]) -> Self {
        let tables = IcosahedralMesh::new(level).unwrap();
        let layers = Layers::from_heights(heights, EARTH_M).unwrap();
        let values = values(&Grid::new(tables.tables()).unwrap(), heights.len());
        Sphere { tables, layers, values }
    }

    pub fn grid(&self) -> Grid<'_> {
        Grid::new(self.tables.tables()).unwrap()
    }

    pub fn field(&self) -> Field<'_> {
        let shape = Shape::level_fastest(self.tables.cells(), self.layers.count());
        Field::new(self.values.as_slice().into(), shape, Location::Center, None).unwrap()
    }
}

pub fn scene(camera: &str, transfer: &str, rest: &str) -> Scene {
    let text = format!(
        "field = \"f\"\nantialias = false\n{rest}\n[image]\nwidth = 72\nheight = 60\n[camera]\n{camera}\n[transfer]\n{transfer}\n"
    );
    Scene::parse(&text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// The root of the mean square of the differences, and the largest.
pub fn apart(one: &Frame, other: &Frame) -> (f64, f64) {
    let channels = one.pixels.iter().flatten().zip(other.pixels.iter().flatten());
    let off: Vec<f64> = channels.map(|(a, b)| f64::from((a - b).abs())).collect();
    let squares: f64 = off.iter().map(|d| d * d).sum();
    ((squares / off.len() as f64).sqrt(), off.iter().copied().fold(0.0, f64::max))
}

/// Draws on both and compares; gives the GPU's frame.
pub fn compare(name: &str, scene: &Scene, grid: &Grid, layers: &Layers, field: &Field) -> Frame {
    let gpu = gpu().expect("looked for before");
    let drawn = renderer(&gpu).render(scene, grid, layers, field).unwrap();
    assert_eq!(drawn.report.left_to_cpu, None, "{name}");
    assert!(drawn.report.device.is_some(), "{name}");
    let renderer = cpu(1);
    let cpu = |precision| {
        let scene = Scene { precision, ..scene.clone() };
        renderer.render(&scene, grid, layers, field).unwrap()
    };
    let (narrow, wide) = (cpu(Precision::F32), cpu(Precision::F64));
    let (rmse, max) = apart(&drawn, &narrow);
    let of_cpu = apart(&narrow, &wide);
    let counts = drawn.report.counts;
    println!("{name}: rmse {rmse:.1e}, max {max:.1e}; cpu f32 to f64 {:.1e}, {:.1e}", of_cpu.0, of_cpu.1);
    assert!(drawn.pixels.iter().flatten().chain(&drawn.error).all(|x| x.is_finite()), "{name}");
    // Where one cuts a piece for its light's sake and the other just not, they differ by a part of the tolerance, as f32 and
    // f64 do on the CPU.
    let is_loose = scene.lighting.is_some() && scene.tolerance > 1e-3;
    let times = if is_loose { scene.tolerance / 1e-3 } else { 1.0 };
    assert!(rmse <= times * RMSE && max <= times * MAX, "{name}: rmse {rmse:e}, max {max:e}");
    let all = drawn.pixels.iter().zip(&wide.pixels).zip(drawn.error.iter().zip(&wide.error));
    for (i, ((pixel, exact), (error, other))) in all.enumerate() {
        let off = pixel.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off <= error + other, "{name}, pixel {i}: {off:e} off, admitted {error:e} and {other:e}");
    }
    // Errors are as large as the CPU's but for rounding, and so are reports.
    let (ours, theirs) = (drawn.report.error, narrow.report.error);
    assert_eq!(ours.certainty, theirs.certainty, "{name}");
    assert!(
        ours.mean <= 1.02 * theirs.mean + 1e-7 && ours.mean >= 0.98 * theirs.mean - 1e-7,
        "{name}: {ours}, {theirs}"
    );
    let Counts { rays, columns, frusta, void_frusta, .. } = narrow.report.counts;
    assert_eq!(counts.rays, rays, "{name}");
    // A ray through a vertex or along a layer meets the one or the other frustum.
    for (ours, theirs) in
        [(counts.columns, columns), (counts.frusta, frusta), (counts.void_frusta, void_frusta)]
    {
        assert!(
            ours.abs_diff(theirs) as f64 <= 10.0 + 0.002 * theirs as f64,
            "{name}: {ours}, expected about {theirs}"
        );
    }
    assert_eq!(drawn.report.value_range, narrow.report.value_range, "{name}");
    drawn
}
