//! Pictures against those of the CPU: near its f32, and no farther from its f64 than the errors of both.

use icoray::{Adapter, Field, Frame, Grid, GridTables, IcosahedralMesh, Layers, Location, Renderer, Scene, Shape};
use icoray_gpu::Gpu;

mod common;
mod data;
mod lines;
mod lit;
mod native;
mod parts;
mod scenes;
mod volumes;
use common::*;

#[test]
fn transfer_functions_cameras_and_cores() {
    let Some(_) = gpu() else { return };
    let cameras = [("far", FAR), ("pole", POLE), ("inside", INSIDE), ("radial", RADIAL), ("centre", CENTRE)];
    for level in [3, 5] {
        let sphere = Sphere::new(level, &THICK_M);
        for (transfer, text) in TRANSFERS {
            for (k, rest) in [CORES[0].into(), format!("{}\nbackground = \"white\"", CORES[1])].iter().enumerate() {
                for (camera, where_) in cameras {
                    if where_ == CENTRE && k == 0 {
                        continue;
                    }
                    let name = format!("level {level}, {transfer}, {}, {camera}", ["core", "hollow"][k]);
                    sphere.compare(&name, &scene(where_, text, rest));
                }
            }
        }
    }
}

#[test]
fn the_paper_s_method_and_tolerances() {
    let Some(_) = gpu() else { return };
    let sphere = Sphere::new(4, &THICK_M);
    for (transfer, text) in TRANSFERS {
        for rest in ["method = \"paper\"", "tolerance = 1e-2", "tolerance = 1e-6"] {
            let name = format!("{transfer}, {rest}");
            sphere.compare(&name, &scene(FAR, text, &format!("{}\n{rest}", CORES[0])));
        }
    }
}

/// 31 layers 100 m apart, true to scale.
#[test]
fn thin_layers_on_a_real_earth() {
    let Some(_) = gpu() else { return };
    let heights: Vec<f64> = (0..31).map(|k| 100.0 * f64::from(k)).collect();
    let sphere = Sphere::new(5, &heights);
    for (transfer, text) in TRANSFERS {
        for (k, rest) in ["core = \"gray\"", "core = \"transparent\""].into_iter().enumerate() {
            for (camera, where_) in [("far", FAR), ("limb", LIMB), ("inside", IN_THIN)] {
                let name = format!("100 m, {transfer}, {}, {camera}", ["core", "hollow"][k]);
                sphere.compare(&name, &scene(where_, text, rest));
            }
        }
    }
}

#[test]
fn meshes_with_holes() {
    let Some(_) = gpu() else { return };
    each_mesh_with_holes(|hole, grid, layers, field| {
        for (camera, where_) in [("far", FAR), ("inside", INSIDE)] {
            for rest in [CORES[0].into(), format!("{}\nbackground = \"transparent\"", CORES[1])] {
                let name = format!("{hole}, {camera}, {rest:?}");
                compare(&name, &scene(where_, SMOOTH, &rest), grid, layers, field);
            }
        }
    });
}

/// One field in all layouts and precisions, with missing values, on rising and falling layers.
#[test]
fn layouts_and_missing_values() {
    let Some(_) = gpu() else { return };
    let (_, grid) = icosahedral(3);
    let (cells, count) = (grid.cells(), THICK_M.len());
    let layers = Layers::from_heights(&THICK_M, EARTH_M).unwrap();
    let mut falling_m = THICK_M;
    falling_m.reverse();
    let falling = Layers::from_heights(&falling_m, EARTH_M).unwrap();
    let scene = scene(FAR, RAMP_OF_GAPS, "exaggeration = 60");
    let level_fastest = Shape::level_fastest(cells, count);
    let shapes = [
        ("level-fastest", level_fastest),
        ("cell-fastest", Shape::cell_fastest(cells, count)),
        ("blocks", Shape::blocked(cells, count, 48)),
        ("padded", Shape { column_stride: 7, offset: 2, ..level_fastest }),
        ("backwards", Shape { column_stride: -5, offset: 5 * (cells - 1), ..level_fastest }),
    ];
    let mut first: Option<Frame> = None;
    for (name, shape) in shapes {
        for is_falling in [false, true] {
            let there = |layer: usize| if is_falling { count - 1 - layer } else { layer };
            let data = laid_out(&shape, f64::NAN, |cell, layer| with_gaps(&grid, cell, there(layer), count));
            let layers = if is_falling { &falling } else { &layers };
            let field = Field::new(data.as_slice().into(), shape, Location::Center, Some(FILL)).unwrap();
            let frame = compare(&format!("{name}, falling {is_falling}"), &scene, &grid, layers, &field);
            assert!(frame.report.counts.void_frusta > 0 && frame.report.missing_values > 0);
            // The device reads the same numbers.
            let first = first.get_or_insert_with(|| frame.clone());
            assert!(frame.pixels == first.pixels && frame.error == first.error, "{name}");
        }
    }
}

/// Tables in 64 bits, counted from 1, with rotated rows, both windings, and edges in another order than cells.
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
    let field = at_centers(&values, THICK_M.len());
    for where_ in [FAR, INSIDE, RADIAL] {
        compare(where_, &scene(where_, SMOOTH, "exaggeration = 60"), &grid, &layers, &field);
    }
}

#[test]
fn a_field_at_corners_and_one_of_a_single_value() {
    let Some(_) = gpu() else { return };
    let sphere = Sphere::new(3, &THICK_M);
    let (grid, layers, count) = (&sphere.grid, &sphere.layers, THICK_M.len());
    let values = corner_values(grid, count);
    let field = level_fastest(&values, count, Location::Corner);
    compare("corners", &scene(FAR, SMOOTH, "exaggeration = 60"), grid, layers, &field);
    // A value on a step belongs to the span above it.
    let same = vec![-0.5f32; grid.cells() * count];
    let shape = Shape::cell_fastest(grid.cells(), count);
    let field = Field::new(same.as_slice().into(), shape, Location::Center, None).unwrap();
    let clear = scene(FAR, STEPS, &format!("{}\nbackground = \"transparent\"", CORES[1]));
    let frame = compare("on a step", &clear, grid, layers, &field);
    let absorbed = frame.pixels.iter().map(|p| p[3]).fold(0.0, f32::max);
    assert!(absorbed == 0.0, "blue is clear, orange is not: {absorbed}");
}

/// The CPU draws scenes that the shaders do not support, and the report says why.
#[test]
fn other_scenes_are_left_to_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let sphere = Sphere::new(1, &[0.0, 1e4]);
    let (grid, layers, field) = (&sphere.grid, &sphere.layers, sphere.field());
    let renderer = renderer(&gpu);
    let double = scene(FAR, RAMP, "precision = \"f64\"");
    let frame = renderer.render(&double, grid, layers, &field).unwrap();
    assert_eq!(frame.report.device.name, None);
    assert!(frame.report.device.left_to_cpu.is_some_and(|reason| reason.contains("f64")));
    let cpu = Renderer::new(1).unwrap().render(&double, grid, layers, &field).unwrap();
    assert!(frame.pixels == cpu.pixels && frame.error == cpu.error);
    // A field that does not fit the grid is the caller's error.
    let wrong = at_centers(&sphere.values[..6], 2);
    assert!(renderer.render(&scene(FAR, RAMP, ""), grid, layers, &wrong).is_err());
    for adapter in [Adapter::Number(999), Adapter::Name("no such device".into())] {
        assert!(Gpu::new(Some(adapter)).unwrap_err().to_string().contains("no adapter"));
    }
}

/// A picture of several dispatches, more than one of which shows the planet.
#[test]
fn a_picture_in_bands_has_no_seam() {
    let Some(_) = gpu() else { return };
    let sphere = Sphere::new(3, &THICK_M);
    let small = scene("lon = 30\nlat = 25\ndistance = 40\nfov = 6", SMOOTH, "exaggeration = 60");
    for (width, height) in [(4096, 130), (1, 200), (201, 1)] {
        let scene = Scene { width, height, ..small.clone() };
        let frame = sphere.compare(&format!("{width} x {height}"), &scene);
        assert!(frame.report.counts.rays > 0);
    }
}

/// A field that exceeds lavapipe's limit of 128 MiB per binding.
#[test]
fn a_field_beyond_a_binding_is_drawn() {
    let Some(gpu) = gpu() else { return };
    let (_, grid) = icosahedral(6);
    let count = 830;
    let heights: Vec<f64> = (0..count).map(|k| 100.0 * k as f64).collect();
    let layers = Layers::from_heights(&heights, EARTH_M).unwrap();
    let of_cell = |c: u32| (0..count).map(move |k| (0.001 * f64::from(c) + 0.1 * k as f64).sin() as f32);
    let values: Vec<f32> = (0..grid.cells() as u32).flat_map(of_cell).collect();
    let field = at_centers(&values, count);
    let scene = Scene { width: 8, height: 8, ..scene(FAR, SMOOTH, "exaggeration = 10") };
    let frame = renderer(&gpu).render(&scene, &grid, &layers, &field).unwrap();
    let cpu = Renderer::new(2).unwrap().render(&scene, &grid, &layers, &field).unwrap();
    let (rmse, max) = apart(&frame, &cpu);
    assert!(frame.report.device.name.is_some() && rmse <= RMSE && max <= MAX, "{rmse}, {max}");
}

/// The cached entry triangles of a picture with another camera, grid or size do not change the next picture.
#[test]
fn pictures_do_not_depend_on_the_one_before() {
    let Some(_) = gpu() else { return };
    let spheres = [4, 2].map(|level| Sphere::new(level, &THICK_M));
    let draw = |sphere: &Sphere, camera: &str, [width, height]: [u32; 2]| {
        let scene = Scene { width, height, ..scene(camera, SMOOTH, "exaggeration = 60") };
        let frame = compare(camera, &scene, &sphere.grid, &sphere.layers, &sphere.field());
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
