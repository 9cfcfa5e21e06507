//! Scenes and fields of the tests, and the comparison of the GPU's picture with the CPU's.

pub use crate::common::{LIT, Model, at_centers, count_beyond, icosahedral, laid_out, level_fastest, over_columns};
use glam::DVec3;
use icoray::{Fields, Frame, Grid, Layers, Method, Renderer, Savings, Scene, Scenery};
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

pub const SUN: &str = "[light]\nkind = \"sun\"\nlon = 75\nlat = 40\nspecular = 0";
pub const GLOSSY: &str = "[light]\nkind = \"headlight\"\nambient = 0.1\ndiffuse = 0.6\nspecular = 0.9\nshininess = 200";
pub const SHINY: &str =
    "[light]\nkind = \"sun\"\nlon = 10\nlat = -20\nambient = 0.2\ndiffuse = 0.8\nspecular = 1\nshininess = 30";

/// An opaque core, and none.
pub const CORES: [&str; 2] = ["exaggeration = 60\ncore = \"gray\"", "exaggeration = 60\ncore = \"transparent\""];

pub const EARTH_M: f64 = 6_371_229.0;
pub const THICK_M: [f64; 5] = [0.0, 3e3, 5e3, 12e3, 20e3];

/// The heights of 31 layers 100 m apart, for scenes that are true to scale.
pub fn thin_m() -> Vec<f64> {
    (0..31).map(|k| 100.0 * f64::from(k)).collect()
}

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

/// A whole sphere with the smooth field f and the field g, some of whose values are missing, on layers at heights in
/// metres.
pub fn sphere(level: u32, heights: &[f64]) -> Model {
    let layers = Layers::from_heights(heights, EARTH_M).unwrap();
    let second = |cell: usize, p: DVec3, layer: usize| match (cell * 13 + layer) % 89 {
        0 => f64::NAN,
        1 => f64::INFINITY,
        _ => (6.0 * p.x + 0.3 * layer as f64).cos() * (5.0 * p.y).sin() + 0.3 * p.z,
    };
    let values = |cell, p, layer| [wave(p, layer, heights.len()), second(cell, p, layer)];
    Model { layers, ..Model::new(level, heights, values) }
}

impl Model {
    /// [`compare`] with these fields.
    pub fn compare(&self, name: &str, scene: &Scene, stray: usize) -> Frame {
        compare(name, scene, (&self.grid, &self.layers), self.fields(), stray)
    }

    /// [`compare_edges`] with these fields.
    pub fn compare_edges(&self, name: &str, scene: &Scene) {
        compare_edges(name, scene, (&self.grid, &self.layers), self.fields());
    }
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

/// A scene of a volume of f.
pub fn scene(camera: &str, transfer: &str, rest: &str) -> Scene {
    scene_of(camera, &format!("[transfer]\n{transfer}"), &format!("field = \"f\"\n{rest}"))
}

/// A scene of these tables, with the keys `rest`.
pub fn scene_of(camera: &str, tables: &str, rest: &str) -> Scene {
    let text = format!("antialias = false\n{rest}\n[image]\nwidth = 48\nheight = 40\n[camera]\n{camera}\n{tables}\n");
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

/// Draws a scene on the GPU and on the CPU, compares them, and returns the GPU's frame. None but `stray` pixels may
/// differ by more than their errors.
pub fn compare<'f>(
    name: &str,
    scene: &Scene,
    (grid, layers): (&Grid, &Layers),
    fields: impl Into<Fields<'f>>,
    stray: usize,
) -> Frame {
    let gpu = gpu().expect("the test has opened it");
    let fields = fields.into();
    // On the CPU in packets, which save what they can, and one ray at a time in double precision.
    let [drawn, packets, wide] = [renderer(&gpu), Renderer::new(2).unwrap(), cpu(2)]
        .map(|renderer| renderer.render(scene, grid, layers, fields.clone()).unwrap());
    let [ours, narrow, theirs] = [&drawn, &packets, &wide].map(|frame| &frame.report);
    assert_eq!(ours.device.left_to_cpu, None, "{name}");
    assert!(ours.device.name.is_some(), "{name}");
    let (rmse, max) = apart(&drawn, &wide);
    let beyond = [&wide, &packets].map(|other| count_beyond(&drawn, other, 0.0));
    println!(
        "{name}: rmse {rmse:.1e}, max {max:.1e}; beyond {beyond:?}; errors {}, {}, {}; {:?}, {:?}",
        ours.error, narrow.error, theirs.error, ours.counts, theirs.counts
    );
    assert!(drawn.pixels.iter().flatten().chain(&drawn.error).all(|x| x.is_finite()), "{name}");
    assert!(beyond.iter().all(|count| *count <= stray), "{name}: {beyond:?} pixels beyond their errors");
    assert_eq!(ours.error.certainty, theirs.error.certainty, "{name}");
    assert_eq!(ours.value_range, theirs.value_range, "{name}");
    assert_eq!(ours.counts.rays, theirs.counts.rays, "{name}");
    let is_lit = scene.lighting.is_some();
    let has_several = !scene.has_one_field_of_volume();
    if !has_several && scene.scenery == Scenery::default() {
        // If only one of the two bisects a piece for the accuracy of its light, they differ by several times the
        // tolerance at single pixels; so do pieces of the paper's scheme, which has no tolerance, where rounding
        // decides on which side of a kink a shade lies.
        let times = match (is_lit, scene.method) {
            (false, _) => 1.0,
            (true, Method::Paper) => 4.0,
            (true, Method::Exact) => 4.0 * (scene.tolerance / 1e-3).max(1.0),
        };
        assert!(rmse <= times * RMSE && max <= times * MAX, "{name}: rmse {rmse:e}, max {max:e}");
        // A device counts more where normals cancel.
        let apart = if is_lit { 0.05 } else { 0.02 };
        assert_reported_error(name, ours.error.mean, (theirs.error.mean, narrow.error.mean), apart);
    } else {
        assert!(rmse <= 3e-4 + 0.02 * stray as f64, "{name}: rmse {rmse:e}");
        // The CPU takes several volumes through frusta with steps or surfaces in double precision.
        let most = if has_several { 4.0 } else { 1.2 } * narrow.error.mean.max(theirs.error.mean) + 1e-5;
        assert!(ours.error.mean <= most, "{name}: {}, expected at most {most}", ours.error.mean);
        if is_lit || !scene.scenery.lines.is_empty() {
            // Rays end elsewhere: those of devices not at lines.
            return drawn;
        }
    }
    // Of several volumes a frustum counts as void in which each of them misses a value, in double precision one in
    // which all fields do.
    let void_frusta = if has_several { ours.counts.void_frusta } else { theirs.counts.void_frusta };
    let found = [ours.counts.columns, ours.counts.frusta, ours.counts.void_frusta];
    // A ray through a vertex or along a layer may meet either of two frusta.
    for (ours, theirs) in found.into_iter().zip([theirs.counts.columns, theirs.counts.frusta, void_frusta]) {
        let allowed = 10.0 + 0.002 * theirs as f64;
        assert!(ours.abs_diff(theirs) as f64 <= allowed, "{name}: {ours}, expected about {theirs}");
    }
    drawn
}

/// The edge pixels of a scene with and without a device: rays on it have the signatures of those on the CPU.
pub fn compare_edges<'f>(name: &str, scene: &Scene, (grid, layers): (&Grid, &Layers), fields: impl Into<Fields<'f>>) {
    let scene = Scene { antialias: true, ..scene.clone() };
    let gpu = gpu().expect("the test has opened it");
    let fields = fields.into();
    let [drawn, expected] = [renderer(&gpu), Renderer::new(2).unwrap()]
        .map(|renderer| renderer.render(&scene, grid, layers, fields.clone()).unwrap());
    let [ours, theirs] = [&drawn, &expected].map(|frame| frame.report.edge_pixels);
    let (rmse, max) = apart(&drawn, &expected);
    println!("{name}: {ours} edge pixels, expected {theirs}; rmse {rmse:.1e}, max {max:.1e}");
    assert!(drawn.report.device.name.is_some() && theirs > 0, "{name}");
    assert!(ours.abs_diff(theirs) * 100 <= theirs + 100, "{name}: {ours} edge pixels, expected {theirs}");
    assert!(rmse <= 2e-3, "{name}: rmse {rmse:e}");
}
