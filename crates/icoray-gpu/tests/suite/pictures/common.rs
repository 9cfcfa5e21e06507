//! Scenes and fields of the tests, and the comparison of the GPU's picture with the CPU's.

pub use crate::common::{LIT, at_centers, count_beyond, icosahedral, laid_out, level_fastest, over_columns};
use crate::culled::{Culled, Mark, Style, holes};
use glam::DVec3;
use icoray::{Counts, Field, Frame, Grid, IcosahedralMesh, Layers, Method, Renderer, Savings, Scene};
use icoray_gpu::Gpu;
use icoray_test_support::{Need, skip_because};
use std::cell::OnceCell;
use std::sync::{Arc, Mutex, PoisonError};

pub const RMSE: f64 = 2e-5;
pub const MAX: f64 = 1e-3;

pub const RAMP: &str = "map = \"viridis\"\nrange = [-1, 1]\nopacity = [[-1, 0.5], [-0.2, 0.05], [0.1, 0.8], [1, 0.3]]";
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
/// A part of the planet.
pub const CLOSE: &str = "lon = 50\nlat = 40\ndistance = 1.6\nfov = 20";
/// Just above and inside a shell with its top at 3 km, looking along the limb.
pub const LIMB: &str = "eye = [1.001, 0.007, 0.003]\ntarget = [0.9, 0.6, 0.1]\nfov = 30";
pub const IN_THIN: &str = "eye = [1.0003, 0.007, 0.011]\ntarget = [1.0003, 0.4, 0.1]\nfov = 60";

/// An opaque core, and none.
pub const CORES: [&str; 2] = ["exaggeration = 60\ncore = \"gray\"", "exaggeration = 60\ncore = \"transparent\""];

pub const EARTH_M: f64 = 6_371_229.0;
pub const THICK_M: [f64; 5] = [0.0, 3e3, 5e3, 12e3, 20e3];

/// This test's device. If there is none, skips the test.
///
/// Tests that run side by side have a device each, as lavapipe compiles the shaders of a device one after the other.
/// Later tests use them again, with their pipelines.
pub fn gpu() -> Option<Arc<Gpu>> {
    static OPEN: Mutex<Vec<Arc<Gpu>>> = Mutex::new(Vec::new());
    thread_local!(static OWN: OnceCell<Option<Arc<Gpu>>> = const { OnceCell::new() });
    let open = || {
        let mut all = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(free) = all.iter().find(|gpu| Arc::strong_count(gpu) == 1) {
            return Some(Arc::clone(free));
        }
        let new = Gpu::new(None).inspect_err(|reason| skip_because(Need::Gpu, reason)).ok()?;
        all.push(Arc::new(new));
        all.last().cloned()
    };
    OWN.with(|own| own.get_or_init(open).clone())
}

/// A renderer that draws on the device.
pub fn renderer(gpu: &Arc<Gpu>) -> Renderer {
    Renderer::new(1).unwrap().with_device(Arc::clone(gpu) as _)
}

/// A CPU renderer without the savings that devices lack, so that its counts are the same.
pub fn cpu(threads: usize) -> Renderer {
    Renderer::new(threads).unwrap().with_savings(Savings { ends: true, ..Savings::NONE })
}

pub fn wave(p: DVec3, layer: usize, layers: usize) -> f64 {
    let phase = 2.0 * layer as f64 / layers as f64;
    let fine = (17.0 * p.x + phase).sin() * (15.0 * p.y - phase).cos();
    0.6 * (3.0 * p.x + phase).sin() * (4.0 * p.y).cos() + 0.3 * p.z + 0.15 * fine
}

pub fn values(grid: &Grid, layers: usize) -> Vec<f32> {
    over_columns(grid.cells(), layers, |cell, layer| wave(grid.direction(cell as u32), layer, layers) as f32)
}

/// A whole sphere with a smooth field on layers at heights in metres.
pub struct Sphere {
    pub tables: &'static IcosahedralMesh,
    pub grid: Grid<'static>,
    pub layers: Layers,
    pub values: Vec<f32>,
}

impl Sphere {
    pub fn new(level: u32, heights: &[f64]) -> Self {
        let (tables, grid) = icosahedral(level);
        let layers = Layers::from_heights(heights, EARTH_M).unwrap();
        Sphere { values: values(&grid, heights.len()), tables, grid, layers }
    }

    pub fn field(&self) -> Field<'_> {
        at_centers(&self.values, self.layers.count())
    }

    /// [`compare`] with this sphere.
    pub fn compare(&self, name: &str, scene: &Scene) -> Frame {
        compare(name, scene, &self.grid, &self.layers, &self.field())
    }
}

/// Values at corners, level-fastest.
pub fn corner_values(grid: &Grid, layers: usize) -> Vec<f64> {
    let middle = |t: u32| grid.triangle(t).map(|c| grid.direction(c)).iter().sum::<DVec3>().normalize();
    over_columns(grid.triangles(), layers, |t, layer| wave(middle(t as u32), layer, layers))
}

/// The fill value of [`with_gaps`].
pub const FILL: f64 = -9e33;
/// A transfer function for [`with_gaps`].
pub const RAMP_OF_GAPS: &str =
    "map = \"viridis\"\nrange = [999999, 1000001]\nopacity = [[999999, 0.5], [1000000, 0.05], [1000001, 0.8]]";

/// Values around 1e6, which f32 cannot resolve before normalisation, with NaN, [`FILL`] and infinities between them.
pub fn with_gaps(grid: &Grid, cell: usize, layer: usize, layers: usize) -> f64 {
    match (cell * 31 + layer * 7) % 97 {
        0 => f64::NAN,
        1 => FILL,
        2 => f64::NEG_INFINITY,
        _ => 1e6 + wave(grid.direction(cell as u32), layer, layers),
    }
}

/// Calls `draw` with the name, grid, layers and field of each mesh with holes, in all styles of tables and marks.
pub fn each_mesh_with_holes(draw: impl Fn(&str, &Grid, &Layers, &Field)) {
    let whole = IcosahedralMesh::new(3).unwrap();
    let layers = Layers::from_heights(&THICK_M, EARTH_M).unwrap();
    let marks = [Mark::BeforeFirst, Mark::MinusOne, Mark::BehindLast];
    for (i, (hole, stays)) in holes(&whole).iter().enumerate() {
        let style = if i % 2 == 0 { Style::Corners } else { Style::Triangles };
        let culled = Culled::new(&whole, stays, style, marks[i % 3], (i % 2) as i32);
        let grid = culled.grid();
        let values = values(&grid, THICK_M.len());
        draw(hole, &grid, &layers, &at_centers(&values, THICK_M.len()));
    }
}

pub fn scene(camera: &str, transfer: &str, rest: &str) -> Scene {
    let text = format!(
        "field = \"f\"\nantialias = false\n{rest}\n[image]\nwidth = 48\nheight = 40\n[camera]\n{camera}\n[transfer]\n{transfer}\n"
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

/// Checks that the mean error of a device is at least that of the CPU in double precision, but for this part of it, and
/// hardly more than that of packets, `narrow`, which have the rounding of single precision too.
pub fn assert_reported_error(name: &str, ours: f64, (wide, narrow): (f64, f64), apart: f64) {
    const ROUNDING: f64 = 1e-5;
    let range = (1.0 - apart) * wide - 1e-7..=((1.0 + apart) * wide).max(1.5 * narrow) + ROUNDING;
    assert!(range.contains(&ours), "{name}: {ours:e}, expected {wide:e} and rounding, as {narrow:e} of packets");
}

/// Draws a scene on the GPU and on the CPU, compares them, and returns the GPU's frame.
pub fn compare(name: &str, scene: &Scene, grid: &Grid, layers: &Layers, field: &Field) -> Frame {
    let gpu = gpu().expect("the test has opened it");
    let drawn = renderer(&gpu).render(scene, grid, layers, field).unwrap();
    assert_eq!(drawn.report.device.left_to_cpu, None, "{name}");
    assert!(drawn.report.device.name.is_some(), "{name}");
    // One ray at a time, in double precision.
    let expected = cpu(1).render(scene, grid, layers, field).unwrap();
    let (rmse, max) = apart(&drawn, &expected);
    let counts = drawn.report.counts;
    println!("{name}: rmse {rmse:.1e}, max {max:.1e}");
    assert!(drawn.pixels.iter().flatten().chain(&drawn.error).all(|x| x.is_finite()), "{name}");
    // If only one of the two bisects a piece for the accuracy of its light, they differ by several times the tolerance
    // at single pixels; so do pieces of the paper's scheme, which has no tolerance, where rounding decides on which side of
    // a kink a shade lies.
    let times = match (&scene.lighting, scene.method) {
        (None, _) => 1.0,
        (Some(_), Method::Paper) => 4.0,
        (Some(_), Method::Exact) => 4.0 * (scene.tolerance / 1e-3).max(1.0),
    };
    assert!(rmse <= times * RMSE && max <= times * MAX, "{name}: rmse {rmse:e}, max {max:e}");
    assert_eq!(count_beyond(&drawn, &expected, 0.0), 0, "{name}: pixels beyond their errors");
    // A device counts more where normals cancel.
    let apart = if scene.lighting.is_some() { 0.05 } else { 0.02 };
    let (ours, theirs) = (drawn.report.error, expected.report.error);
    assert_eq!(ours.certainty, theirs.certainty, "{name}");
    let packets = Renderer::new(1).unwrap().render(scene, grid, layers, field).unwrap();
    assert_reported_error(name, ours.mean, (theirs.mean, packets.report.error.mean), apart);
    let Counts { rays, columns, frusta, void_frusta, .. } = expected.report.counts;
    assert_eq!(counts.rays, rays, "{name}");
    // A ray through a vertex or along a layer may meet either of two frusta.
    let ours = [counts.columns, counts.frusta, counts.void_frusta];
    for (ours, theirs) in ours.into_iter().zip([columns, frusta, void_frusta]) {
        let allowed = 10.0 + 0.002 * theirs as f64;
        assert!(ours.abs_diff(theirs) as f64 <= allowed, "{name}: {ours}, expected about {theirs}");
    }
    assert_eq!(drawn.report.value_range, expected.report.value_range, "{name}");
    drawn
}
