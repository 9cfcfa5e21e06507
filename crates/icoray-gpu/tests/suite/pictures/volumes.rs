//! Scenes of several volumes, or of one whose opacity is that of another field.

use super::common::*;
use super::scenes::VIEWS;
use crate::contents::{BY_OTHER, DENSE, HIGH, ISO, ONE, OTHER, OWN_ISO, REGION, SHELL, STEPS, SURFACE, THIN};
use icoray::Fields;

const CLEAR: &str = "[[volumes]]\nfield = \"f\"\ntransfer = { map = \"gray\", range = [-1, 1], \
    opacity = [[-1, 0], [1, 0]] }\n";

const SCENES: [(&str, &[&str]); 13] = [
    ("two", &[ONE, OTHER]),
    ("thin", &[THIN, OTHER]),
    ("of one field", &[ONE, THIN]),
    ("dense", &[ONE, DENSE]),
    ("opacity of another field", &[BY_OTHER]),
    ("four", &[ONE, OTHER, BY_OTHER, THIN]),
    ("four, opacity of another field first", &[BY_OTHER, THIN, OTHER, ONE]),
    ("four, the first one clear", &[CLEAR, OTHER, THIN, ONE]),
    ("cut, with an isosurface", &[ONE, OTHER, REGION, ISO]),
    ("with all", &[THIN, OTHER, SHELL, OWN_ISO, SURFACE, HIGH]),
    // Where transfer functions jump, which the CPU crosses in double precision.
    ("steps", &[ONE, STEPS]),
    ("steps, thin", &[STEPS, THIN]),
    ("steps, cut", &[STEPS, ONE, REGION]),
];

/// The volumes and surfaces of the scene of this name.
pub fn contents(name: &str) -> String {
    SCENES.iter().find(|(known, _)| *known == name).unwrap().1.concat()
}

#[test]
fn several_volumes() {
    let Some(_) = gpu() else { return };
    let both = sphere(4, &THICK_M);
    for (k, (what, contents)) in SCENES.into_iter().enumerate() {
        for (view, where_, lamp) in VIEWS {
            let scene = scene_of(where_, &format!("{}{lamp}", contents.concat()), CORES[k % 2]);
            let drawn = both.compare(&format!("{what}, {view}"), &scene, 0);
            assert!(drawn.pixels.iter().any(|pixel| pixel[0] != pixel[2]), "{what}, {view}: nothing is seen");
        }
        if contents.contains(&REGION) || contents.contains(&SHELL) {
            both.compare_edges(what, &scene_of(FAR, &contents.concat(), CORES[0]));
        }
    }
}

/// Values far from 0, fields in f64, and layers of 100 m on an Earth that is true to scale.
#[test]
fn several_volumes_of_other_fields_and_layers() {
    let Some(_) = gpu() else { return };
    let sphere = sphere(4, &thin_m());
    let far: Vec<f64> = sphere.values[0].iter().map(|x| 1e6 - f64::from(*x).sin()).collect();
    let shifted = "[[volumes]]\nfield = \"g\"\ntransfer = { map = \"plasma\", range = [999999, 1000001], \
        opacity = [[999999.2, 0.7], [999999.8, 0.0], [1000000.3, 0.0], [1000000.8, 0.95]] }\n";
    let fields = Fields::new([
        ("f", at_centers(&sphere.values[0], sphere.layers.count())),
        ("g", at_centers(&far, sphere.layers.count())),
    ]);
    for (camera, where_) in [("far", FAR), ("limb", LIMB), ("inside", IN_THIN)] {
        for lamp in ["", LIT] {
            let scene = scene_of(where_, &format!("{ONE}{shifted}{lamp}"), "core = \"gray\"");
            let name = format!("100 m, {camera}, {lamp}");
            compare(&name, &scene, (&sphere.grid, &sphere.layers), fields.clone(), 0);
        }
    }
}

/// More volumes than devices are given are left to the CPU, with the reason.
#[test]
fn too_many_volumes_are_drawn_by_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let sphere = sphere(2, &THICK_M);
    let scene = scene_of(FAR, &ONE.repeat(5), CORES[0]);
    let drawn = renderer(&gpu).render(&scene, &sphere.grid, &sphere.layers, sphere.fields()).unwrap();
    let reason = drawn.report.device.left_to_cpu.unwrap();
    assert_eq!(reason, "the scene shows 5 volumes, expected at most 4");
}
