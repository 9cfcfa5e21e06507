//! Lit volumes beside surfaces, isosurfaces, other volumes and cuts, and over layers at heights of their own: no pixel
//! is farther from the same picture at a far finer tolerance than both errors, and none is over its tolerance.

use crate::common::{Model, even_heights, over_columns, pixel_difference, scene_of};
use icoray::{Frame, Precision, Scene};
use icoray_test_support as support;
use itertools::iproduct;

const LAYERS: usize = 7;
const FINEST: f64 = 1e-7;

/// Two fields with extrema inside of columns.
fn waves(level: u32) -> Model {
    let up = |layer: usize| layer as f64 / (LAYERS - 1) as f64;
    let mut model = Model::new(level, &even_heights(LAYERS, 0.15), |_, d, layer| {
        [0.3, 1.9].map(|phase| {
            (6.0 * d.x + phase).sin() * (5.0 * d.y - phase).cos() + 0.7 * (9.0 * up(layer) + 4.0 * d.z + phase).sin()
        })
    });
    // Layers follow mountains and get even upwards.
    let mountain = |cell: usize| 0.03 * (1.0 + (8.0 * model.grid.direction(cell as u32).y).sin());
    let height = |cell: usize, layer: usize| 0.15 * up(layer) + mountain(cell) * (1.0 - up(layer));
    model.heights = over_columns(model.grid.cells(), LAYERS, height);
    model
}

/// What is shown beside the volume of `f`.
const BESIDE: [(&str, &str); 7] = [
    ("nothing", ""),
    ("surface", "[[surfaces]]\nlayer = 2\ncolor = \"#805030\"\nopacity = 0.5\n"),
    ("isosurface", "[[isosurfaces]]\nfield = \"g\"\nvalue = 0.2\ncolor = \"orange\"\nopacity = 0.5\n"),
    (
        "two volumes",
        "[[volumes]]\nfield = \"g\"\n[volumes.transfer]\nknots = [{ value = -0.5, color = \"white\", opacity = 0.0 }, \
         { value = 1.0, color = \"red\", opacity = 0.9 }]\n",
    ),
    ("cut", "[[clip]]\ncut = \"inside\"\nlon = [0.0, 30.0]\nlat = [0.0, 60.0]\n"),
    ("native heights", ""),
    (
        "isosurfaces alone",
        "[[isosurfaces]]\nfield = \"f\"\nvalues = [-0.4, 0.5]\ncolors = [\"teal\", \"gold\"]\nopacity = 0.7\n",
    ),
];

const TRANSFERS: [(&str, &str); 2] = [
    (
        "smooth",
        "map = \"viridis\"\nrange = [-1.2, 1.2]\nopacity = [[-1.2, 0.9], [-0.4, 0.5], [0.2, 0.0], [0.5, 0.8]]\n",
    ),
    (
        "steps",
        "knots = [{ value = -0.8, color = \"blue\", opacity = 0.9 }, { value = -0.2, color = \"blue\", opacity = 0.9 }, \
         { value = -0.2, color = \"white\", opacity = 0.0 }, { value = 0.4, color = \"white\", opacity = 0.0 }, \
         { value = 0.4, color = \"yellow\", opacity = 0.6 }, { value = 1.0, color = \"red\", opacity = 0.99 }]\n",
    ),
];

const CAMERAS: [&str; 3] = ["distance = 3.2\nfov = 42", "distance = 1.4\nfov = 60", "distance = 8.0\nfov = 17"];

const LIGHTS: [&str; 3] = [
    "kind = \"headlight\"\n",
    "kind = \"sun\"\nlon = 80\nlat = 10\nspecular = 0.6\nshininess = 100\n",
    "kind = \"sun\"\nlon = -20\nlat = 50\nspecular = 0.4\nshininess = 1\n",
];

fn scene(size: u32, beside: &str, transfer: &str, camera: &str, light: &str) -> Scene {
    let heights = if beside == "native heights" { "native" } else { "mean" };
    let (_, section) = BESIDE.iter().find(|(name, _)| *name == beside).unwrap();
    let (field, volume) = match beside {
        "isosurfaces alone" => ("", String::new()),
        "two volumes" => ("", format!("[[volumes]]\nfield = \"f\"\n[volumes.transfer]\n{transfer}")),
        _ => ("field = \"f\"", format!("[transfer]\n{transfer}")),
    };
    // Which pixels have the edge of a surface in them may depend on where rays end, and so on the tolerance.
    let keys = format!(
        "{field}\nheights = \"{heights}\"\nbackend = \"cpu\"\nantialias = false\nprecision = \"f64\"\n\
         background = \"transparent\"\ncore = \"#304050\"\nimage = {{ width = {size}, height = {size} }}"
    );
    scene_of(&format!("lon = 20\nlat = 35\n{camera}"), &keys, &format!("{volume}{section}[light]\n{light}"))
}

/// Numbers of pixels that are farther from `fine` than both errors, farther than the tolerance, and of larger errors.
fn wrong(frame: &Frame, fine: &Frame, tolerance: f64) -> [usize; 3] {
    let mut wrong = [0; 3];
    for i in 0..frame.pixels.len() {
        let off = pixel_difference(frame, fine, i);
        // Pixels are stored in f32.
        let slack = fine.error[i] + f32::EPSILON;
        wrong[0] += usize::from(off > frame.error[i] + slack);
        wrong[1] += usize::from(off > tolerance as f32 + slack);
        // What rounding of stored normals does comes on top, the more the smaller a gradient is beside its neighbours.
        wrong[2] += usize::from(frame.error[i] > 1.000_1 * tolerance as f32 + 1e-5);
    }
    wrong
}

#[test]
fn no_lit_pixel_is_farther_off_than_its_error() {
    let data = waves(3);
    let (size, all) = support::count((20, false), (28, true));
    let mut failures = Vec::new();
    let mut pixels = 0;
    for ((i, (beside, _)), (j, (name, transfer)), (k, camera), (l, light)) in iproduct!(
        BESIDE.iter().enumerate().skip(1),
        TRANSFERS.iter().enumerate(),
        CAMERAS.iter().enumerate(),
        LIGHTS.iter().enumerate()
    ) {
        // The short run takes each pair of them once.
        if !all && (k != (i + j) % 3 || l != (i + 2 * j) % 3) {
            continue;
        }
        let mut scene = scene(size, beside, transfer, camera, light);
        scene.tolerance = FINEST;
        let fine = data.draw(&scene);
        for tolerance in [1e-2, 1e-3, 1e-4, 1e-5] {
            scene.tolerance = tolerance;
            let frame = data.draw(&scene);
            pixels += frame.pixels.len();
            let wrong = wrong(&frame, &fine, tolerance);
            if wrong != [0; 3] {
                failures.push(format!("{beside}, {name}, {camera:?}, {light:?}, {tolerance}: {wrong:?}"));
            }
        }
    }
    assert!(
        failures.is_empty(),
        "of {pixels} pixels some are beyond their error, beyond the tolerance, and report more than it:\n{}",
        failures.join("\n")
    );
}

#[test]
fn a_lit_volume_alone_reports_no_error_above_its_tolerance() {
    let data = waves(3);
    let size = support::count(40, 160);
    let precisions = [Precision::F64, Precision::F32];
    for (precision, (name, transfer), k, tolerance) in iproduct!(precisions, TRANSFERS, 0..3, [1e-2, 1e-3]) {
        // Beside steps the error contains rounding in f32, too.
        if precision == Precision::F32 && name == "steps" {
            continue;
        }
        let scene = scene(size, "nothing", transfer, CAMERAS[k], LIGHTS[k]);
        let error = data.draw(&Scene { precision, tolerance, ..scene }).report.error;
        let what = format!("{name} {:?} {precision:?} {tolerance}: {error}", LIGHTS[k]);
        assert!(error.max > 0.01 * tolerance && error.pixels_over_tolerance == 0, "{what}");
    }
}

#[test]
fn pixels_that_rounding_puts_above_the_tolerance_are_counted() {
    let mut scene = scene(24, "nothing", TRANSFERS[1].1, CAMERAS[0], LIGHTS[0]);
    (scene.precision, scene.lighting, scene.tolerance) = (Precision::F32, None, 1e-6);
    let frame = waves(3).draw(&scene);
    let over = frame.error.iter().filter(|error| **error > 1e-6).count();
    assert!(over > 0, "{}", frame.report.error);
    assert_eq!(frame.report.error.pixels_over_tolerance, over as u64);
    let text = frame.report.error.to_string();
    assert!(text.ends_with(&format!("above the tolerance in {over} pixels")), "{text}");
}

/// Gradients vanish at the edges of what is flat, and are small beside those of other vertices; that is no reason to
/// say that a picture is bad.
#[test]
fn flat_parts_of_a_field_raise_no_false_alarm() {
    // Hills with a flat top on flat ground, the same on all layers.
    let data = Model::new(4, &even_heights(LAYERS, 0.12), |_, d, _| {
        let near = [[1.0, 0.0, 0.0], [0.0, 0.8, 0.6]].map(|at| d.dot(at.into()));
        [((near[0].max(near[1]) - 0.6) / 0.3).clamp(0.0, 1.0)]
    });
    let transfer =
        "[transfer]\nmap = \"viridis\"\nrange = [0, 1]\nopacity = [[0.2, 0], [0.9, 0.8]]\nunit_length = 0.05\n";
    let keys = "field = \"f\"\nbackend = \"cpu\"\nantialias = false\nimage = { width = 120, height = 90 }";
    for beside in ["", "[[surfaces]]\nlayer = 2\ncolor = \"#805030\"\nopacity = 0.5\n"] {
        let scene = scene_of("lon = 45\nlat = 20", keys, &format!("{transfer}{beside}[light]"));
        let error = data.draw(&scene).report.error;
        assert!(error.pixels_over_tolerance == 0 && error.max > 1e-5, "{beside:?}: {error:?}");
    }
}
