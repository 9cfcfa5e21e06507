//! Scenes under light.

use super::common::*;
use icoray::{Field, Layers, Location, Renderer, Shape};

const SUN: &str = "[light]\nkind = \"sun\"\nlon = 75\nlat = 40\nspecular = 0";
const GLOSSY: &str = "[light]\nkind = \"headlight\"\nambient = 0.1\ndiffuse = 0.6\nspecular = 0.9\nshininess = 200";
const SHINY: &str =
    "[light]\nkind = \"sun\"\nlon = 10\nlat = -20\nambient = 0.2\ndiffuse = 0.8\nspecular = 1\nshininess = 3";
/// Behind the planet, as [`FAR`] sees it.
const BEHIND: &str = "[light]\nkind = \"sun\"\nlon = 210\nlat = -25\nspecular = 0.7";
const LIGHTS: [(&str, &str); 5] =
    [("headlight", LIT), ("sun", SUN), ("glossy", GLOSSY), ("shiny", SHINY), ("behind", BEHIND)];

#[test]
fn lights_transfer_functions_and_cores() {
    let Some(_) = gpu() else { return };
    let sphere = Sphere::new(4, &THICK_M);
    for (light, lamp) in LIGHTS {
        for (transfer, text) in TRANSFERS {
            for (camera, where_, core) in [
                ("far", FAR, "core = \"gray\""),
                ("inside", INSIDE, "core = \"transparent\"\nbackground = \"white\""),
                ("radial", RADIAL, "core = \"white\"\nmethod = \"paper\""),
            ] {
                let name = format!("{light}, {transfer}, {camera}");
                let scene = scene(where_, &format!("{text}\n{lamp}"), &format!("exaggeration = 60\n{core}"));
                sphere.compare(&name, &scene);
            }
        }
    }
}

/// Sharp highlights need many bisections, loose tolerances none.
#[test]
fn lit_to_tolerances() {
    let Some(_) = gpu() else { return };
    let sphere = Sphere::new(3, &THICK_M);
    for (light, lamp) in [("sun", SUN), ("glossy", GLOSSY)] {
        for (transfer, text) in TRANSFERS {
            for tolerance in ["1e-2", "1e-4"] {
                let name = format!("{light}, {transfer}, {tolerance}");
                let rest = format!("{}\ntolerance = {tolerance}", CORES[0]);
                sphere.compare(&name, &scene(FAR, &format!("{text}\n{lamp}"), &rest));
            }
        }
    }
}

/// Rays with more loop iterations than some drivers support: tiles are correct, or drawn by the CPU.
#[test]
fn rays_with_many_bisections_are_correct_or_left_to_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let sphere = Sphere::new(3, &THICK_M);
    let (grid, layers, field) = (&sphere.grid, &sphere.layers, sphere.field());
    for tolerance in ["1e-5", "1e-6", "1e-7"] {
        let rest = format!("{}\ntolerance = {tolerance}", CORES[0]);
        let scene = scene(FAR, &format!("{RAMP}\n{SUN}"), &rest);
        let drawn = renderer(&gpu).render(&scene, grid, layers, &field).unwrap();
        let alone = Renderer::new(1).unwrap().render(&scene, grid, layers, &field).unwrap();
        let (rmse, max) = apart(&drawn, &alone);
        println!("{tolerance}: rmse {rmse:.1e}, max {max:.1e}, {:?}", drawn.report.device.left_to_cpu);
        assert!(drawn.report.device.name.is_some(), "{tolerance}");
        assert!(rmse <= 1e-6 && max <= 1e-5, "{tolerance}: rmse {rmse:e}, max {max:e}");
    }
}

/// 31 layers 100 m apart, true to scale.
#[test]
fn lit_thin_layers_on_a_real_earth() {
    let Some(_) = gpu() else { return };
    let heights: Vec<f64> = (0..31).map(|k| 100.0 * f64::from(k)).collect();
    let sphere = Sphere::new(5, &heights);
    for (transfer, text) in TRANSFERS {
        for (light, lamp) in [("headlight", LIT), ("shiny", SHINY)] {
            for (camera, where_) in [("far", FAR), ("limb", LIMB), ("inside", IN_THIN)] {
                let name = format!("100 m, {light}, {transfer}, {camera}");
                let scene = scene(where_, &format!("{text}\n{lamp}"), "core = \"gray\"");
                sphere.compare(&name, &scene);
            }
        }
    }
}

/// Missing values, infinities among them, in both layouts and precisions, on rising and on falling layers; 1e6 away
/// from 0.
#[test]
fn lit_beside_missing_values() {
    let Some(_) = gpu() else { return };
    let (_, grid) = icosahedral(4);
    let (cells, count) = (grid.cells(), THICK_M.len());
    let scene = scene(FAR, &format!("{RAMP_OF_GAPS}\n{SHINY}"), "exaggeration = 60\ncore = \"gray\"");
    for is_falling in [false, true] {
        let mut heights = THICK_M;
        if is_falling {
            heights.reverse();
        }
        let there = |layer: usize| if is_falling { count - 1 - layer } else { layer };
        let layers = Layers::from_heights(&heights, EARTH_M).unwrap();
        for (name, shape) in
            [("level-fastest", Shape::level_fastest(cells, count)), ("cell-fastest", Shape::cell_fastest(cells, count))]
        {
            let data = laid_out(&shape, f64::NAN, |cell, layer| with_gaps(&grid, cell, there(layer), count));
            let field = Field::new(data.as_slice().into(), shape, Location::Center, Some(FILL)).unwrap();
            let name = format!("lit, missing, {name}, falling {is_falling}");
            let frame = compare(&name, &scene, &grid, &layers, &field);
            assert!(frame.report.counts.void_frusta > 0 && frame.report.missing_values > 0);
            // Near 0, f32 has enough digits.
            let narrow: Vec<f32> = data.iter().map(|x| (x - 1e6) as f32).collect();
            let field = Field::new(narrow.as_slice().into(), shape, Location::Center, None).unwrap();
            let scene = super::common::scene(FAR, &format!("{RAMP}\n{GLOSSY}"), "exaggeration = 60");
            compare(&format!("{name}, f32"), &scene, &grid, &layers, &field);
        }
    }
}

#[test]
fn lit_meshes_with_holes() {
    let Some(_) = gpu() else { return };
    each_mesh_with_holes(|hole, grid, layers, field| {
        for (k, lamp) in [SUN, GLOSSY].into_iter().enumerate() {
            let rest = CORES[k];
            let name = format!("lit, {hole}, {rest:?}");
            compare(&name, &scene(FAR, &format!("{SMOOTH}\n{lamp}"), rest), grid, layers, field);
        }
    });
}

/// Plateaus have no gradient and only ambient light; fields at corners are averaged first.
#[test]
fn lit_plateaus_and_fields_at_corners() {
    let Some(_) = gpu() else { return };
    let sphere = Sphere::new(3, &THICK_M);
    let (grid, layers, count) = (&sphere.grid, &sphere.layers, THICK_M.len());
    let flat: Vec<f32> = sphere.values.iter().map(|x| x.clamp(-0.3, 0.3)).collect();
    let glossy = scene(FAR, &format!("{RAMP}\n{GLOSSY}"), "exaggeration = 60");
    compare("plateaus", &glossy, grid, layers, &at_centers(&flat, count));
    let values = corner_values(grid, count);
    let sun = scene(FAR, &format!("{SMOOTH}\n{SUN}"), "exaggeration = 60");
    compare("lit corners", &sun, grid, layers, &level_fastest(&values, count, Location::Corner));
}
