//! Scenes under light.

use super::common::*;
use crate::culled::{Culled, Mark, Style, holes};
use glam::DVec3;
use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Shape};

const HEAD: &str = "[light]\nkind = \"headlight\"";
const SUN: &str = "[light]\nkind = \"sun\"\nlon = 75\nlat = 40\nspecular = 0";
const GLOSSY: &str =
    "[light]\nkind = \"headlight\"\nambient = 0.1\ndiffuse = 0.6\nspecular = 0.9\nshininess = 200";
const SHINY: &str =
    "[light]\nkind = \"sun\"\nlon = 10\nlat = -20\nambient = 0.2\ndiffuse = 0.8\nspecular = 1\nshininess = 3";
/// Behind the planet, as [`FAR`] sees it.
const BEHIND: &str = "[light]\nkind = \"sun\"\nlon = 210\nlat = -25\nspecular = 0.7";
const LIGHTS: [(&str, &str); 5] =
    [("headlight", HEAD), ("sun", SUN), ("glossy", GLOSSY), ("shiny", SHINY), ("behind", BEHIND)];

#[test]
fn lights_transfer_functions_and_cores() {
    let Some(_) = gpu() else { return };
    let sphere = Sphere::new(4, &THICK_M);
    let (grid, field) = (sphere.grid(), sphere.field());
    let layers = &sphere.layers;
    for (light, lamp) in LIGHTS {
        for (transfer, text) in TRANSFERS {
            for (camera, where_, core) in [
                ("far", FAR, "core = \"gray\""),
                ("inside", INSIDE, "core = \"transparent\"\nbackground = \"white\""),
                ("radial", RADIAL, "core = \"white\"\nmethod = \"paper\""),
            ] {
                let name = format!("{light}, {transfer}, {camera}");
                let scene = scene(where_, &format!("{text}\n{lamp}"), &format!("exaggeration = 60\n{core}"));
                compare(&name, &scene, &grid, layers, &field);
            }
        }
    }
}

/// A sharp highlight asks for many cuts, a loose tolerance for none.
#[test]
fn lit_to_tolerances() {
    let Some(_) = gpu() else { return };
    let sphere = Sphere::new(3, &THICK_M);
    let (grid, field) = (sphere.grid(), sphere.field());
    let layers = &sphere.layers;
    for (light, lamp) in [("sun", SUN), ("glossy", GLOSSY)] {
        for (transfer, text) in TRANSFERS {
            for tolerance in ["1e-2", "1e-4"] {
                let name = format!("{light}, {transfer}, {tolerance}");
                let rest = format!("exaggeration = 60\ncore = \"gray\"\ntolerance = {tolerance}");
                compare(&name, &scene(FAR, &format!("{text}\n{lamp}"), &rest), &grid, layers, &field);
            }
        }
    }
}

/// Of more turns than some drivers take: tiles are drawn right, or left to the CPU.
#[test]
fn rays_that_take_many_cuts_are_drawn_right_or_not_at_all() {
    let Some(gpu) = gpu() else { return };
    let sphere = Sphere::new(3, &THICK_M);
    let (grid, field) = (sphere.grid(), sphere.field());
    let layers = &sphere.layers;
    for tolerance in ["1e-5", "1e-6", "1e-7"] {
        let rest = format!("exaggeration = 60\ncore = \"gray\"\ntolerance = {tolerance}");
        let scene = scene(FAR, &format!("{RAMP}\n{SUN}"), &rest);
        let drawn = renderer(&gpu).render(&scene, &grid, layers, &field).unwrap();
        let alone = Renderer::new(1).unwrap().render(&scene, &grid, layers, &field).unwrap();
        let (rmse, max) = apart(&drawn, &alone);
        println!("{tolerance}: rmse {rmse:.1e}, max {max:.1e}, {:?}", drawn.report.left_to_cpu);
        assert!(drawn.report.device.is_some(), "{tolerance}");
        assert!(rmse <= 1e-6 && max <= 1e-5, "{tolerance}: rmse {rmse:e}, max {max:e}");
    }
}

/// 31 layers 100 m apart, true to scale.
#[test]
fn lit_thin_layers_on_a_real_earth() {
    let Some(_) = gpu() else { return };
    let heights: Vec<f64> = (0..31).map(|k| 100.0 * f64::from(k)).collect();
    let sphere = Sphere::new(5, &heights);
    let (grid, field) = (sphere.grid(), sphere.field());
    let layers = &sphere.layers;
    for (transfer, text) in TRANSFERS {
        for (light, lamp) in [("headlight", HEAD), ("shiny", SHINY)] {
            for (camera, where_) in [("far", FAR), ("limb", LIMB), ("inside", IN_THIN)] {
                let name = format!("100 m, {light}, {transfer}, {camera}");
                let scene = scene(where_, &format!("{text}\n{lamp}"), "core = \"gray\"");
                compare(&name, &scene, &grid, layers, &field);
            }
        }
    }
}

/// Missing values, infinities among them, in both layouts and precisions, on rising and on falling layers; 1e6 away from 0.
#[test]
fn lit_beside_missing_values() {
    let Some(_) = gpu() else { return };
    let tables = IcosahedralMesh::new(4).unwrap();
    let grid = Grid::new(tables.tables()).unwrap();
    let (cells, count) = (grid.cells(), THICK_M.len());
    let fill = -9e33;
    let value = |cell: usize, layer: usize| match (cell * 31 + layer * 7) % 97 {
        0 => f64::NAN,
        1 => fill,
        2 => f64::NEG_INFINITY,
        _ => 1e6 + wave(grid.direction(cell as u32), layer, count),
    };
    let transfer = "map = \"viridis\"\nrange = [999999, 1000001]\nopacity = [[999999, 0.5], [1000000, 0.05], [1000001, 0.8]]";
    let scene = scene(FAR, &format!("{transfer}\n{SHINY}"), "exaggeration = 60\ncore = \"gray\"");
    for is_falling in [false, true] {
        let mut heights = THICK_M;
        if is_falling {
            heights.reverse();
        }
        let there = |layer: usize| if is_falling { count - 1 - layer } else { layer };
        let layers = Layers::from_heights(&heights, EARTH_M).unwrap();
        for (name, shape) in [
            ("level-fastest", Shape::level_fastest(cells, count)),
            ("cell-fastest", Shape::cell_fastest(cells, count)),
        ] {
            let mut data = vec![f64::NAN; cells * count];
            for cell in 0..cells {
                for layer in 0..count {
                    let at = cell as isize * shape.column_stride + there(layer) as isize * shape.layer_stride;
                    data[at as usize] = value(cell, layer);
                }
            }
            let field = Field::new(data.as_slice().into(), shape, Location::Center, Some(fill)).unwrap();
            let name = format!("lit, missing, {name}, falling {is_falling}");
            let frame = compare(&name, &scene, &grid, &layers, &field);
            assert!(frame.report.counts.void_frusta > 0 && frame.report.missing_values > 0);
            // Near 0 f32 has digits enough.
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
    let whole = IcosahedralMesh::new(3).unwrap();
    let marks = [Mark::BeforeFirst, Mark::MinusOne, Mark::BehindLast];
    for (i, (hole, stays)) in holes(&whole).iter().enumerate() {
        let style = if i % 2 == 0 { Style::Corners } else { Style::Triangles };
        let culled = Culled::new(&whole, stays, style, marks[i % 3], (i % 2) as i32);
        let grid = culled.grid();
        let layers = Layers::from_heights(&THICK_M, EARTH_M).unwrap();
        let values = values(&grid, THICK_M.len());
        let shape = Shape::level_fastest(grid.cells(), THICK_M.len());
        let field = Field::new(values.as_slice().into(), shape, Location::Center, None).unwrap();
        for (k, lamp) in [SUN, GLOSSY].into_iter().enumerate() {
            let rest = ["exaggeration = 60\ncore = \"gray\"", "exaggeration = 60\ncore = \"transparent\""][k];
            let name = format!("lit, {hole}, {rest:?}");
            compare(&name, &scene(FAR, &format!("{SMOOTH}\n{lamp}"), rest), &grid, &layers, &field);
        }
    }
}

/// A plateau has no gradient and ambient light only; a field at corners is averaged first.
#[test]
fn lit_plateaus_and_fields_at_corners() {
    let Some(_) = gpu() else { return };
    let tables = IcosahedralMesh::new(3).unwrap();
    let grid = Grid::new(tables.tables()).unwrap();
    let layers = Layers::from_heights(&THICK_M, EARTH_M).unwrap();
    let count = THICK_M.len();
    let flat: Vec<f32> = values(&grid, count).iter().map(|x| x.clamp(-0.3, 0.3)).collect();
    let shape = Shape::level_fastest(grid.cells(), count);
    let field = Field::new(flat.as_slice().into(), shape, Location::Center, None).unwrap();
    compare(
        "plateaus",
        &scene(FAR, &format!("{RAMP}\n{GLOSSY}"), "exaggeration = 60"),
        &grid,
        &layers,
        &field,
    );
    let middle = |t: u32| grid.triangle(t).map(|c| grid.direction(c)).iter().sum::<DVec3>().normalize();
    let values: Vec<f64> = (0..grid.triangles() as u32)
        .flat_map(|t| (0..count).map(move |layer| (t, layer)))
        .map(|(t, layer)| wave(middle(t), layer, count))
        .collect();
    let shape = Shape::level_fastest(grid.triangles(), count);
    let field = Field::new(values.as_slice().into(), shape, Location::Corner, None).unwrap();
    compare(
        "lit corners",
        &scene(FAR, &format!("{SMOOTH}\n{SUN}"), "exaggeration = 60"),
        &grid,
        &layers,
        &field,
    );
}
