//! Scenes of more than one volume in packets of rays, in single precision, against single rays in double
//! precision, pixel by pixel.

use crate::common::{TwoFields, bits, count_beyond, difference, pixel_difference};
use glam::DVec3;
use icoray::{Heights, Precision, Scene};

const LAYERS: usize = 12;
const TOP: f64 = 4e-3;

const CAMERAS: [&str; 3] = [
    "lon = 20\nlat = 35\ndistance = 3.2\nfov = 45",
    "lon = -100\nlat = -60\ndistance = 1.6\nfov = 75",
    "eye = [1.02, 0.3, 0.1]\ntarget = [0, 1.2, 0.3]\nfov = 100",
];
const LIGHTS: [&str; 3] = [
    "[light]\nkind = \"none\"\n",
    "[light]\nkind = \"headlight\"\n",
    "[light]\nkind = \"sun\"\nlon = 80\nlat = 10\nspecular = 0.6\nshininess = 40\n",
];

const ONE: &str = "[[volumes]]\nfield = \"f\"\ntransfer = { map = \"viridis\", range = [-2.2, 2.2], \
    opacity = [[-2.2, 0.9], [-0.4, 0.5], [0.0, 0.0], [0.5, 0.8]] }\n";
const THIN: &str = "[[volumes]]\nfield = \"f\"\ntransfer = { map = \"viridis\", range = [-2.2, 2.2], \
    opacity = [[-0.9, 0.0], [-0.7, 0.8], [-0.5, 0.0], [1.0, 0.0], [1.5, 0.9]] }\n";
const OTHER: &str = "[[volumes]]\nfield = \"g\"\ntransfer = { map = \"plasma\", range = [-1.5, 1.5], \
    opacity = [[-1.0, 0.7], [-0.6, 0.0], [0.3, 0.0], [1.2, 0.95]] }\n";
const DENSE: &str = "[[volumes]]\nfield = \"g\"\ntransfer = { map = \"plasma\", range = [-1.5, 1.5], \
    opacity = [[-1.0, 0.9999], [0.3, 0.0], [1.2, 0.9999]], unit_length = 1e-5 }\n";
const FRONT: &str = "[[volumes]]\nfield = \"g\"\ntransfer = { unit_length = 1, knots = [ \
    { value = -0.6, color = \"yellow\", extinction = 1e9 }, { value = 0.3, color = \"blue\", extinction = 0 } ] }\n";
const STEPS: &str = "[[volumes]]\nfield = \"g\"\ntransfer = { knots = [ \
    { value = -1.3, color = \"blue\", opacity = 0.9 }, { value = -0.6, color = \"blue\", opacity = 0.9 }, \
    { value = -0.6, color = \"white\", opacity = 0 }, { value = 0.4, color = \"white\", opacity = 0 }, \
    { value = 0.4, color = \"yellow\", opacity = 0.6 }, { value = 1.9, color = \"red\", opacity = 0.99 } ] }\n";
const BY_OTHER: &str = "[[volumes]]\nfield = \"f\"\ntransfer = { map = \"viridis\", range = [-2.2, 2.2] }\n\
    opacity = { field = \"g\", values = [[-1.0, 0.7], [-0.6, 0.0], [0.3, 0.0], [1.2, 0.95]] }\n";
const REGION: &str = "[[clip]]\ncut = \"inside\"\nlon = [-60, 60]\nlat = [-10, 70]\n";
const SHELL: &str = "[[clip]]\ncut = \"outside\"\nheight_m = [0.0007, 0.0031]\n";
const HALF: &str = "[[clip]]\ncut = \"inside\"\nhalf_space = { towards = [40, 20], distance = 0.4 }\n";
const SLAB: &str = "[[clip]]\ncut = \"inside\"\nlayers = [2, 5]\nlon = [-150, 40]\nlat = [-90, 90]\n";
const ISO: &str = "[[isosurfaces]]\nfield = \"g\"\nvalue = 0.35\ncolor_by = \"f\"\nopacity = 0.6\n\
    transfer = { map = \"viridis\", range = [-2, 2] }\n";
const OWN_ISO: &str = "[[isosurfaces]]\nfield = \"f\"\nvalues = [-0.45, 0.9]\ncolors = [\"red\", \"#4080ff\"]\n";
const SURFACE: &str = "[[surfaces]]\nlayer = 3\nfield = \"g\"\nopacity = 0.5\n\
    transfer = { map = \"magma\", range = [-1.5, 1.5] }\n";
const HIGH: &str = "[[surfaces]]\nheight_m = 0.0017\ncolor = \"#80a060\"\nopacity = 0.4\n";
const CELLS: &str = "[[lines]]\npattern = \"cells\"\non = 3\ncolor = \"black\"\n";

/// What is in each scene.
const SCENES: [&[&str]; 21] = [
    &[ONE, REGION],
    &[ONE, SHELL],
    &[THIN, HALF, SHELL],
    &[ONE, SLAB],
    &[STEPS, REGION],
    &[ONE, ISO],
    &[THIN, OWN_ISO],
    &[OWN_ISO],
    &[ISO, REGION, SLAB],
    &[ONE, SURFACE, CELLS],
    &[THIN, HIGH],
    &[SURFACE],
    &[ONE, OTHER],
    &[THIN, OTHER],
    &[THIN, STEPS],
    &[ONE, DENSE],
    &[ONE, FRONT],
    &[BY_OTHER],
    &[BY_OTHER, THIN, OTHER],
    &[ONE, OTHER, REGION, ISO],
    &[THIN, OTHER, SHELL, HALF, SLAB, OWN_ISO, SURFACE, HIGH, CELLS],
];

/// Two fields between layers with heights of their own.
fn waves(level: u32) -> TwoFields {
    let values = |d: DVec3, up: f64| {
        let f = (4.0 * d.x + 3.0 * up).sin() + (5.0 * d.y * d.z - up).cos();
        [f, (5.0 * d.z - 2.0 * up).cos() * (3.0 * d.y + 1.0).sin() + 0.3 * up]
    };
    TwoFields::new((level, LAYERS, TOP), values, |d| 1.5e-3 * (3.0 * d.x + 1.0).sin().abs())
}

fn scene(contents: &[&str], keys: &str, camera: &str, light: &str) -> Scene {
    Scene::parse(&format!(
        "antialias = false\nbackend = \"cpu\"\nbackground = \"transparent\"\nexaggeration = 50\n{keys}\n\
         [image]\nwidth = 56\nheight = 48\n[camera]\n{camera}\n{}{light}",
        contents.concat()
    ))
    .unwrap()
}

/// Checks packets against single rays, of which no more than `beyond` pixels in a thousand may differ by more than
/// both errors.
fn compare(model: &TwoFields, scene: &Scene, beyond: usize, name: &str) {
    let mut exact = scene.clone();
    exact.precision = Precision::F64;
    let [packets, exact] = [scene, &exact].map(|scene| model.draw(scene, 2).unwrap());
    assert!(packets.pixels.as_flattened().iter().all(|channel| channel.is_finite()), "{name}: no number");
    let wrong = count_beyond(&packets, &exact, 4.0 * f32::EPSILON);
    let of = |i: usize| (i, pixel_difference(&packets, &exact, i), packets.error[i], exact.error[i]);
    let worst = (0..packets.pixels.len()).map(of).max_by(|a, b| (a.1 - a.2 - a.3).total_cmp(&(b.1 - b.2 - b.3)));
    let most = exact.pixels.len() * beyond / 1000;
    assert!(wrong <= most, "{name}: {wrong} pixels, {:e}; {worst:?}", difference(&packets, &exact));
    assert!(exact.pixels.iter().any(|p| p[3] > 0.2), "{name}: nothing is seen");
    // Single rays are in double precision.
    assert!(bits(&packets) != bits(&exact), "{name}: no packets");
}

/// All scenes with all lights, one of the cameras and tolerances each, on concentric and on native layers.
#[test]
fn packets_show_the_pictures_of_single_rays() {
    let model = waves(4);
    for (i, contents) in SCENES.into_iter().enumerate() {
        for (k, light) in LIGHTS.into_iter().enumerate() {
            for heights in [Heights::Mean, Heights::Native] {
                let tolerance = ["1e-2", "1e-3", "1e-4"][(i + k) % 3];
                let camera = CAMERAS[(i + 2 * k + usize::from(heights == Heights::Native)) % 3];
                let core = if i % 2 == 0 { "core = \"#405060\"" } else { "core = \"transparent\"" };
                let keys = format!("tolerance = {tolerance}\n{core}");
                let mut scene = scene(contents, &keys, camera, light);
                scene.scenery.heights = heights;
                // The errors of several volumes and of light are estimates.
                compare(&model, &scene, 2, &format!("{i} {heights:?} {keys} {camera} {light}"));
            }
        }
    }
}

#[test]
fn missing_values_are_void_in_packets_of_several_fields() {
    let mut model = waves(3);
    let [f, g] = &mut model.values;
    f.iter_mut().step_by(31).for_each(|value| *value = f32::NAN);
    g.iter_mut().skip(5).step_by(47).for_each(|value| *value = f32::NAN);
    for (i, contents) in SCENES.into_iter().enumerate() {
        let scene = scene(contents, "core = \"#405060\"", CAMERAS[i % 3], LIGHTS[i % 2]);
        compare(&model, &scene, 2, &format!("{i}"));
    }
}

#[test]
fn threads_and_lanes_change_no_bit() {
    let model = waves(3);
    for (i, contents) in SCENES.into_iter().enumerate() {
        let scene = scene(contents, "core = \"#405060\"", CAMERAS[i % 2], LIGHTS[i % 3]);
        let whole = bits(&model.draw(&scene, 1).unwrap());
        assert!(whole == bits(&model.draw(&scene, 3).unwrap()), "{i}: threads");
    }
}
