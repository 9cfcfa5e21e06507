//! Pictures against those of the CPU: near its f32, and no farther from its f64 than both say that they may be.

use glam::DVec3;
use icoray::{
    Adapter, Field, Frame, Grid, GridTables, IcosahedralMesh, Layers, Location, Renderer, Scene, Shape,
};
use icoray_gpu::Gpu;

mod common;
mod data;
mod lit;
mod parts;
use crate::culled::{Culled, Mark, Style, holes};
use common::*;

#[test]
fn transfer_functions_cameras_and_cores() {
    let Some(_) = gpu() else { return };
    for level in [3, 5] {
        let sphere = Sphere::new(level, &THICK_M);
        let (grid, field) = (sphere.grid(), sphere.field());
        let layers = &sphere.layers;
        for (transfer, text) in TRANSFERS {
            let cores = [
                "exaggeration = 60\ncore = \"gray\"",
                "exaggeration = 60\nbackground = \"white\"\ncore = \"transparent\"",
            ];
            for (k, rest) in cores.into_iter().enumerate() {
                for (camera, where_) in
                    [("far", FAR), ("pole", POLE), ("inside", INSIDE), ("radial", RADIAL), ("centre", CENTRE)]
                {
                    if where_ == CENTRE && k == 0 {
                        continue;
                    }
                    let name = format!("level {level}, {transfer}, {}, {camera}", ["core", "hollow"][k]);
                    compare(&name, &scene(where_, text, rest), &grid, layers, &field);
                }
            }
        }
    }
}

#[test]
fn the_paper_s_method_and_tolerances() {
    let Some(_) = gpu() else { return };
    let sphere = Sphere::new(4, &THICK_M);
    let (grid, field) = (sphere.grid(), sphere.field());
    let layers = &sphere.layers;
    for (transfer, text) in TRANSFERS {
        for rest in ["method = \"paper\"", "tolerance = 1e-2", "tolerance = 1e-6"] {
            let name = format!("{transfer}, {rest}");
            let rest = format!("exaggeration = 60\ncore = \"gray\"\n{rest}");
            compare(&name, &scene(FAR, text, &rest), &grid, layers, &field);
        }
    }
}

/// 31 layers 100 m apart, true to scale.
#[test]
fn thin_layers_on_a_real_earth() {
    let Some(_) = gpu() else { return };
    let heights: Vec<f64> = (0..31).map(|k| 100.0 * f64::from(k)).collect();
    let sphere = Sphere::new(5, &heights);
    let (grid, field) = (sphere.grid(), sphere.field());
    let layers = &sphere.layers;
    for (transfer, text) in TRANSFERS {
        for (k, rest) in ["core = \"gray\"", "core = \"transparent\""].into_iter().enumerate() {
            for (camera, where_) in [("far", FAR), ("limb", LIMB), ("inside", IN_THIN)] {
                let name = format!("100 m, {transfer}, {}, {camera}", ["core", "hollow"][k]);
                compare(&name, &scene(where_, text, rest), &grid, layers, &field);
            }
        }
    }
}

#[test]
fn meshes_with_holes() {
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
        for (camera, where_) in [("far", FAR), ("inside", INSIDE)] {
            for rest in [
                "exaggeration = 60\ncore = \"gray\"",
                "exaggeration = 60\ncore = \"transparent\"\nbackground = \"transparent\"",
            ] {
                let name = format!("{hole}, {camera}, {rest:?}");
                compare(&name, &scene(where_, SMOOTH, rest), &grid, &layers, &field);
            }
        }
    }
}

/// Every layout, both precisions, missing values, falling layers: the values of one field.
#[test]
fn layouts_and_missing_values() {
    let Some(_) = gpu() else { return };
    let tables = IcosahedralMesh::new(3).unwrap();
    let grid = Grid::new(tables.tables()).unwrap();
    let (cells, count) = (grid.cells(), THICK_M.len());
    let layers = Layers::from_heights(&THICK_M, EARTH_M).unwrap();
    let mut falling_m = THICK_M;
    falling_m.reverse();
    let falling = Layers::from_heights(&falling_m, EARTH_M).unwrap();
    let fill = -9e33;
    let value = |cell: usize, layer: usize| match (cell * 31 + layer * 7) % 97 {
        0 => f64::NAN,
        1 => fill,
        2 => f64::NEG_INFINITY,
        // Far from 0, so that f32 has no digits left for those that are not normalised.
        _ => 1e6 + wave(grid.direction(cell as u32), layer, count),
    };
    let transfer = "map = \"viridis\"\nrange = [999999, 1000001]\nopacity = [[999999, 0.5], [1000000, 0.05], [1000001, 0.8]]";
    let scene = scene(FAR, transfer, "exaggeration = 60");
    let shapes = [
        ("level-fastest", Shape::level_fastest(cells, count)),
        ("cell-fastest", Shape::cell_fastest(cells, count)),
        ("blocks", Shape::blocked(cells, count, 48)),
        ("padded", Shape { column_stride: 7, offset: 2, ..Shape::level_fastest(cells, count) }),
        (
            "backwards",
            Shape { column_stride: -5, offset: 5 * (cells - 1), ..Shape::level_fastest(cells, count) },
        ),
    ];
    let mut first: Option<Frame> = None;
    for (name, shape) in shapes {
        for is_falling in [false, true] {
            let (_, end) = shape.extent().unwrap();
            let mut data = vec![f64::NAN; end as usize + 1];
            for cell in 0..cells {
                for layer in 0..count {
                    let there = if is_falling { count - 1 - layer } else { layer };
                    let base = match shape.block {
                        0 => cell as isize * shape.column_stride,
                        block => (cell % block) as isize + (cell / block) as isize * shape.block_stride,
                    };
                    let place = shape.offset as isize + base + there as isize * shape.layer_stride;
                    data[place as usize] = value(cell, layer);
                }
            }
            let layers = if is_falling { &falling } else { &layers };
            let field = Field::new(data.as_slice().into(), shape, Location::Center, Some(fill)).unwrap();
            let frame = compare(&format!("{name}, falling {is_falling}"), &scene, &grid, layers, &field);
            assert!(frame.report.counts.void_frusta > 0 && frame.report.missing_values > 0);
            // The device has the same numbers, wherever they lay.
            let first = first.get_or_insert_with(|| frame.clone());
            assert!(frame.pixels == first.pixels && frame.error == first.error, "{name}");
        }
    }
}

/// Tables in 64 bits that count from 1, rows turned, wound either way, columns of sides in another order than those of cells.
#[test]
fn tables_of_any_order_and_width() {
    let Some(_) = gpu() else { return };
    let plain = IcosahedralMesh::new(3).unwrap();
    let long = |rows: &[i32]| rows.iter().map(|&n| i64::from(n) + 1).collect::<Vec<i64>>();
    let turned = |rows: &[i32], salt: usize| {
        let turn = |(t, row): (usize, &[i32])| {
            let k = (t * salt + t / 5) % 6;
            let [a, b, c] = if k < 3 { [0, 1, 2] } else { [0, 2, 1] }.map(|i| row[(i + k) % 3]);
            [a, b, c]
        };
        rows.chunks_exact(3).enumerate().flat_map(turn).collect::<Vec<i32>>()
    };
    let (cells, sides) = (long(&turned(&plain.corner_cell, 5)), long(&turned(&plain.corner_edge, 7)));
    let (corners, ends) = (long(&plain.cell_corner), long(&plain.edge_corner));
    let tables = GridTables {
        index_base: 1,
        cell_corner: corners.as_slice().into(),
        corner_cell: cells.as_slice().into(),
        corner_edge: sides.as_slice().into(),
        edge_corner: ends.as_slice().into(),
        ..plain.tables()
    };
    let grid = Grid::new(tables).unwrap();
    let layers = Layers::from_heights(&THICK_M, EARTH_M).unwrap();
    let values = values(&grid, THICK_M.len());
    let shape = Shape::level_fastest(grid.cells(), THICK_M.len());
    let field = Field::new(values.as_slice().into(), shape, Location::Center, None).unwrap();
    for where_ in [FAR, INSIDE, RADIAL] {
        compare(where_, &scene(where_, SMOOTH, "exaggeration = 60"), &grid, &layers, &field);
    }
}

#[test]
fn a_field_at_corners_and_one_of_a_single_value() {
    let Some(_) = gpu() else { return };
    let tables = IcosahedralMesh::new(3).unwrap();
    let grid = Grid::new(tables.tables()).unwrap();
    let layers = Layers::from_heights(&THICK_M, EARTH_M).unwrap();
    let count = THICK_M.len();
    let middle = |t: u32| grid.triangle(t).map(|c| grid.direction(c)).iter().sum::<DVec3>().normalize();
    let values: Vec<f64> = (0..grid.triangles() as u32)
        .flat_map(|t| (0..count).map(move |layer| (t, layer)))
        .map(|(t, layer)| wave(middle(t), layer, count))
        .collect();
    let shape = Shape::level_fastest(grid.triangles(), count);
    let field = Field::new(values.as_slice().into(), shape, Location::Corner, None).unwrap();
    compare("corners", &scene(FAR, SMOOTH, "exaggeration = 60"), &grid, &layers, &field);
    // Exactly on a step, which counts as above.
    let same = vec![-0.5f32; grid.cells() * count];
    let shape = Shape::cell_fastest(grid.cells(), count);
    let field = Field::new(same.as_slice().into(), shape, Location::Center, None).unwrap();
    let frame = compare(
        "on a step",
        &scene(FAR, STEPS, "exaggeration = 60\ncore = \"transparent\"\nbackground = \"transparent\""),
        &grid,
        &layers,
        &field,
    );
    let absorbed = frame.pixels.iter().map(|p| p[3]).fold(0.0, f32::max);
    assert!(absorbed == 0.0, "blue is clear, orange is not: {absorbed}");
}

/// What the GPU's kernel has not is left to the CPU, in words.
#[test]
fn other_scenes_are_left_to_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let tables = IcosahedralMesh::new(1).unwrap();
    let grid = Grid::new(tables.tables()).unwrap();
    let layers = Layers::from_heights(&[0.0, 1e4], EARTH_M).unwrap();
    let values = values(&grid, 2);
    let field =
        Field::new(values.as_slice().into(), Shape::level_fastest(grid.cells(), 2), Location::Center, None)
            .unwrap();
    let renderer = renderer(&gpu);
    let double = scene(FAR, RAMP, "precision = \"f64\"");
    let frame = renderer.render(&double, &grid, &layers, &field).unwrap();
    assert_eq!(frame.report.device, None);
    assert!(frame.report.left_to_cpu.is_some_and(|reason| reason.contains("f64")));
    let alone = Renderer::new(1).unwrap().render(&double, &grid, &layers, &field).unwrap();
    assert!(frame.pixels == alone.pixels && frame.error == alone.error);
    // A field that does not fit is the caller's error, not a reason.
    let wrong =
        Field::new(values.as_slice().into(), Shape::level_fastest(3, 2), Location::Center, None).unwrap();
    assert!(renderer.render(&scene(FAR, RAMP, ""), &grid, &layers, &wrong).is_err());
    for adapter in [Adapter::Number(999), Adapter::Name("no such device".into())] {
        assert!(Gpu::new(Some(adapter)).unwrap_err().to_string().contains("no adapter"));
    }
}

/// A picture of several dispatches, each of some rows, with the planet in more than one.
#[test]
fn a_picture_in_bands_has_no_seam() {
    let Some(_) = gpu() else { return };
    let sphere = Sphere::new(3, &THICK_M);
    let (grid, field) = (sphere.grid(), sphere.field());
    let layers = &sphere.layers;
    let small = scene("lon = 30\nlat = 25\ndistance = 40\nfov = 6", SMOOTH, "exaggeration = 60");
    for (width, height) in [(4096, 130), (1, 200), (201, 1)] {
        let scene = Scene { width, height, ..small.clone() };
        let frame = compare(&format!("{width} x {height}"), &scene, &grid, layers, &field);
        assert!(frame.report.counts.rays > 0);
    }
}

/// More than lavapipe's 128 MiB for a binding.
#[test]
fn a_field_beyond_a_binding_is_drawn() {
    let Some(gpu) = gpu() else { return };
    let tables = IcosahedralMesh::new(6).unwrap();
    let grid = Grid::new(tables.tables()).unwrap();
    let count = 830;
    let heights: Vec<f64> = (0..count).map(|k| 100.0 * k as f64).collect();
    let layers = Layers::from_heights(&heights, EARTH_M).unwrap();
    let of_cell = |c: u32| (0..count).map(move |k| (0.001 * f64::from(c) + 0.1 * k as f64).sin() as f32);
    let values: Vec<f32> = (0..grid.cells() as u32).flat_map(of_cell).collect();
    let shape = Shape::level_fastest(grid.cells(), count);
    let field = Field::new(values.as_slice().into(), shape, Location::Center, None).unwrap();
    let scene = Scene { width: 8, height: 8, ..scene(FAR, SMOOTH, "exaggeration = 10") };
    let frame = renderer(&gpu).render(&scene, &grid, &layers, &field).unwrap();
    let cpu = Renderer::new(2).unwrap().render(&scene, &grid, &layers, &field).unwrap();
    let (rmse, max) = apart(&frame, &cpu);
    assert!(frame.report.device.is_some() && rmse <= RMSE && max <= MAX, "{rmse}, {max}");
}

/// Where the last picture's rays entered is where the next one's are sought from: of another camera, grid or size too.
#[test]
fn pictures_do_not_depend_on_the_one_before() {
    let Some(_) = gpu() else { return };
    let spheres = [4, 2].map(|level| Sphere::new(level, &THICK_M));
    let draw = |sphere: &Sphere, camera: &str, [width, height]: [u32; 2]| {
        let scene = Scene { width, height, ..scene(camera, SMOOTH, "exaggeration = 60") };
        let frame = compare(camera, &scene, &sphere.grid(), &sphere.layers, &sphere.field());
        (frame.pixels, frame.error)
    };
    let first = draw(&spheres[0], FAR, [72, 60]);
    assert!(first == draw(&spheres[0], FAR, [72, 60]));
    for camera in [POLE, INSIDE, RADIAL] {
        draw(&spheres[1], camera, [72, 60]);
        assert!(first == draw(&spheres[0], FAR, [72, 60]), "{camera}");
    }
    draw(&spheres[0], POLE, [40, 90]);
    assert!(first == draw(&spheres[0], FAR, [72, 60]));
}
