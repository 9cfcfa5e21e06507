//! Pictures against those of the CPU: near its f32, and no farther from its f64 than the errors of both.

use crate::common::Model;
use crate::culled::{Culled, Mark, Style, holes};
use glam::DVec3;
use icoray::{Adapter, Field, Frame, IcosahedralMesh, Layers, Location, Renderer, Scene, Shape};
use icoray_gpu::Gpu;

mod common;
mod data;
mod parts;
mod scenes;
mod volumes;
use common::*;
use scenes::{CLIPS, COASTS, EARTH, ON_CORE};

#[test]
fn transfer_functions_cameras_and_cores() {
    let Some(_) = gpu() else { return };
    let cameras = [("far", FAR), ("pole", POLE), ("inside", INSIDE), ("radial", RADIAL), ("centre", CENTRE)];
    for level in [3, 5] {
        let sphere = sphere(level, &THICK_M);
        for (transfer, text) in TRANSFERS {
            for (k, rest) in [CORES[0].into(), format!("{}\nbackground = \"white\"", CORES[1])].iter().enumerate() {
                for (camera, where_) in cameras {
                    if where_ == CENTRE && k == 0 {
                        continue;
                    }
                    let name = format!("level {level}, {transfer}, {}, {camera}", ["core", "hollow"][k]);
                    sphere.compare(&name, &scene(where_, text, rest), 0);
                }
            }
        }
    }
}

#[test]
fn lights_transfer_functions_and_cores() {
    let Some(_) = gpu() else { return };
    let sphere = sphere(4, &THICK_M);
    // Behind the planet, as [`FAR`] sees it.
    let behind = "[light]\nkind = \"sun\"\nlon = 210\nlat = -25\nspecular = 0.7";
    for (light, lamp) in [("headlight", LIT), ("sun", SUN), ("glossy", GLOSSY), ("shiny", SHINY), ("behind", behind)] {
        for (transfer, text) in TRANSFERS {
            for (camera, where_, core) in [
                ("far", FAR, "core = \"gray\""),
                ("inside", INSIDE, "core = \"transparent\"\nbackground = \"white\""),
                ("radial", RADIAL, "core = \"white\"\nmethod = \"paper\""),
            ] {
                let scene = scene(where_, &format!("{text}\n{lamp}"), &format!("exaggeration = 60\n{core}"));
                sphere.compare(&format!("{light}, {transfer}, {camera}"), &scene, 0);
            }
        }
    }
}

#[test]
fn the_paper_s_method_and_tolerances() {
    let Some(_) = gpu() else { return };
    let sphere = sphere(4, &THICK_M);
    // Sharp highlights need many bisections, loose tolerances none.
    for (transfer, text) in TRANSFERS {
        for (light, lamp, rests) in [
            ("unlit", "", ["method = \"paper\"", "tolerance = 1e-2", "tolerance = 1e-6"].as_slice()),
            ("sun", SUN, &["tolerance = 1e-2", "tolerance = 1e-4"]),
            ("glossy", GLOSSY, &["tolerance = 1e-2", "tolerance = 1e-4"]),
        ] {
            for rest in rests {
                let name = format!("{light}, {transfer}, {rest}");
                let scene = scene(FAR, &format!("{text}\n{lamp}"), &format!("{}\n{rest}", CORES[0]));
                sphere.compare(&name, &scene, 0);
            }
        }
    }
}

#[test]
fn thin_layers_on_a_real_earth() {
    let Some(_) = gpu() else { return };
    let sphere = sphere(5, &thin_m());
    let (gray, hollow) = ("core = \"gray\"", "core = \"transparent\"");
    for (camera, where_) in [("far", FAR), ("limb", LIMB), ("inside", IN_THIN)] {
        for (transfer, text) in TRANSFERS {
            for (rest, lamp) in [(gray, ""), (hollow, ""), (gray, LIT), (gray, SHINY)] {
                let name = format!("100 m, {transfer}, {rest}, {lamp:?}, {camera}");
                sphere.compare(&name, &scene(where_, &format!("{text}\n{lamp}"), rest), 0);
            }
        }
        let shell = "[[clip]]\nheight_m = [850, 1730]";
        for clip in [CLIPS[0].1, shell, "[[clip]]\nlayers = [3, 12]\nlon = [0, 60]"] {
            let scene = scene(where_, &format!("{SMOOTH}\n{clip}"), gray);
            sphere.compare(&format!("100 m, {clip}, {camera}"), &scene, 0);
        }
    }
}

/// All holes, in all styles of tables and marks.
#[test]
fn meshes_with_holes() {
    let Some(_) = gpu() else { return };
    let [core, hollow] = CORES;
    let clear = &format!("{hollow}\nbackground = \"transparent\"");
    let volume = |camera, beside: &str, rest| scene(camera, &format!("{SMOOTH}\n{beside}"), rest);
    let painted = "transfer = { map = \"turbo\", range = [-0.5, 0.5] }\nopacity = 0.5";
    let surface =
        |place, lamp| scene_of(FAR, &format!("[[surfaces]]\n{place}\nfield = \"f\"\n{painted}\n{lamp}"), hollow);
    let scenes = [
        ("far", volume(FAR, "", core)),
        ("far, hollow", volume(FAR, "", clear)),
        ("inside", volume(INSIDE, "", core)),
        ("inside, hollow", volume(INSIDE, "", clear)),
        ("sun", volume(FAR, SUN, core)),
        ("glossy, hollow", volume(FAR, GLOSSY, hollow)),
        ("cuts", volume(FAR, CLIPS[8].1, core)),
        ("ground and lines", volume(FAR, &format!("{EARTH}{ON_CORE}{COASTS}"), core)),
        ("a surface alone", surface("layer = 2", "")),
        ("a lit surface alone", surface("layer = 2", LIT)),
        ("a surface between layers alone", surface("height_m = 8000", "")),
    ];
    let (whole, sphere) = (IcosahedralMesh::new(3).unwrap(), sphere(4, &THICK_M));
    scenes[8..].iter().for_each(|(what, scene)| drop(sphere.compare(what, scene, 0)));
    let marks = [Mark::BeforeFirst, Mark::MinusOne, Mark::BehindLast];
    for (i, (hole, stays)) in holes(&whole).iter().enumerate() {
        let style = if i % 2 == 0 { Style::Corners } else { Style::Triangles };
        let culled = Culled::new(&whole, stays, style, marks[i % 3], (i % 2) as i32);
        let grid = culled.grid();
        let values = values(&grid, THICK_M.len());
        for (what, scene) in &scenes {
            let field = &at_centers(&values, THICK_M.len());
            compare(&format!("{hole}, {what}"), scene, (&grid, &sphere.layers), field, 0);
        }
    }
}

/// One field in all layouts and precisions, with missing values, on rising and falling layers, and under light; 1e6
/// away from 0 and near it.
#[test]
fn layouts_and_missing_values() {
    let Some(_) = gpu() else { return };
    let (_, grid) = icosahedral(3);
    let (cells, count) = (grid.cells(), THICK_M.len());
    let lit = scene(FAR, &format!("{RAMP_OF_GAPS}\n{SHINY}"), CORES[0]);
    let scenes = [("unlit", scene(FAR, RAMP_OF_GAPS, "exaggeration = 60")), ("lit", lit)];
    let near_zero = scene(FAR, &format!("{RAMP}\n{GLOSSY}"), "exaggeration = 60");
    let level_fastest = Shape::level_fastest(cells, count);
    let shapes = [
        ("level-fastest", level_fastest),
        ("cell-fastest", Shape::cell_fastest(cells, count)),
        ("blocks", Shape::blocked(cells, count, 48)),
        ("padded", Shape { column_stride: 7, offset: 2, ..level_fastest }),
        ("backwards", Shape { column_stride: -5, offset: 5 * (cells - 1), ..level_fastest }),
    ];
    let mut firsts: [Option<Frame>; 2] = Default::default();
    for (name, shape) in shapes {
        for is_falling in [false, true] {
            let there = |layer: usize| if is_falling { count - 1 - layer } else { layer };
            let heights: Vec<f64> = (0..count).map(|layer| THICK_M[there(layer)]).collect();
            let layers = Layers::from_heights(&heights, EARTH_M).unwrap();
            let data = laid_out(&shape, f64::NAN, |cell, layer| with_gaps(&grid, cell, there(layer), count));
            let field = Field::new(data.as_slice().into(), shape, Location::Center, Some(FILL)).unwrap();
            for ((light, scene), first) in scenes.iter().zip(&mut firsts) {
                let name = format!("{name}, {light}, falling {is_falling}");
                let frame = compare(&name, scene, (&grid, &layers), &field, 0);
                assert!(frame.report.counts.void_frusta > 0 && frame.report.missing_values > 0);
                // The device reads the same numbers.
                let first = first.get_or_insert_with(|| frame.clone());
                assert!(frame.pixels == first.pixels && frame.error == first.error, "{name}");
            }
            // Near 0, f32 has enough digits.
            let narrow: Vec<f32> = data.iter().map(|x| (x - 1e6) as f32).collect();
            let field = Field::new(narrow.as_slice().into(), shape, Location::Center, None).unwrap();
            compare(&format!("{name}, falling {is_falling}, f32"), &near_zero, (&grid, &layers), &field, 0);
        }
    }
}

/// Tables counted from 1, with rotated rows, both windings, and edges in another order than cells.
#[test]
fn tables_of_any_order() {
    let Some(_) = gpu() else { return };
    let mesh = IcosahedralMesh::new(3).unwrap();
    let mut shuffled = Culled::new(&mesh, &vec![true; mesh.cells()], Style::Corners, Mark::MinusOne, 1);
    shuffled.shuffle();
    let grid = shuffled.grid();
    let layers = Layers::from_heights(&THICK_M, EARTH_M).unwrap();
    let values = values(&grid, THICK_M.len());
    let field = at_centers(&values, THICK_M.len());
    for where_ in [FAR, INSIDE, RADIAL] {
        compare(where_, &scene(where_, SMOOTH, "exaggeration = 60"), (&grid, &layers), &field, 0);
    }
}

/// Fields at corners, which are averaged before gradients are computed; plateaus, which have no gradient and only
/// ambient light; and one value, which lies on a step.
#[test]
fn fields_at_corners_plateaus_and_a_single_value() {
    let Some(_) = gpu() else { return };
    let sphere = sphere(3, &THICK_M);
    let (grid, count) = (&sphere.grid, THICK_M.len());
    let middle = |t: u32| grid.triangle(t).map(|c| grid.direction(c)).iter().sum::<DVec3>().normalize();
    let corners = over_columns(grid.triangles(), count, |t, layer| wave(middle(t as u32), layer, count));
    let corners = level_fastest(&corners, count, Location::Corner);
    let flat: Vec<f32> = sphere.values[0].iter().map(|x| x.clamp(-0.3, 0.3)).collect();
    let same = vec![-0.5f32; grid.cells() * count];
    let clear = format!("{}\nbackground = \"transparent\"", CORES[1]);
    let [.., frame] = [
        ("corners", scene(FAR, SMOOTH, "exaggeration = 60"), corners),
        ("lit corners", scene(FAR, &format!("{SMOOTH}\n{SUN}"), "exaggeration = 60"), corners),
        ("plateaus", scene(FAR, &format!("{RAMP}\n{GLOSSY}"), "exaggeration = 60"), at_centers(&flat, count)),
        ("on a step", scene(FAR, STEPS, &clear), at_centers(&same, count)),
    ]
    .map(|(name, scene, field)| compare(name, &scene, (grid, &sphere.layers), &field, 0));
    // A value on a step belongs to the span above it.
    let absorbed = frame.pixels.iter().map(|p| p[3]).fold(0.0, f32::max);
    assert!(absorbed == 0.0, "blue is clear, orange is not: {absorbed}");
}

/// The CPU draws scenes that the shaders do not support, and the report says why.
#[test]
fn other_scenes_are_left_to_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let sphere = sphere(1, &[0.0, 1e4]);
    let (grid, layers, field) = (&sphere.grid, &sphere.layers, at_centers(&sphere.values[0], sphere.layers.count()));
    let renderer = renderer(&gpu);
    let double = scene(FAR, RAMP, "precision = \"f64\"");
    let frame = renderer.render(&double, grid, layers, &field).unwrap();
    assert_eq!(frame.report.device.name, None);
    assert!(frame.report.device.left_to_cpu.is_some_and(|reason| reason.contains("f64")));
    let cpu = Renderer::new(1).unwrap().render(&double, grid, layers, &field).unwrap();
    assert!(frame.pixels == cpu.pixels && frame.error == cpu.error);
    // A field that does not fit the grid is the caller's error.
    let wrong = at_centers(&sphere.values[0][..6], 2);
    assert!(renderer.render(&scene(FAR, RAMP, ""), grid, layers, &wrong).is_err());
    for adapter in [Adapter::Number(999), Adapter::Name("no such device".into())] {
        assert!(Gpu::new(Some(adapter)).unwrap_err().to_string().contains("no adapter"));
    }
}

/// A picture of several dispatches, more than one of which shows the planet.
#[test]
fn a_picture_in_bands_has_no_seam() {
    let Some(_) = gpu() else { return };
    let sphere = sphere(3, &THICK_M);
    let small = scene("lon = 30\nlat = 25\ndistance = 40\nfov = 6", SMOOTH, "exaggeration = 60");
    for (width, height) in [(4096, 130), (1, 200), (201, 1)] {
        let scene = Scene { width, height, ..small.clone() };
        let frame = sphere.compare(&format!("{width} x {height}"), &scene, 0);
        assert!(frame.report.counts.rays > 0);
    }
}

/// A field that exceeds lavapipe's limit of 128 MiB per binding.
#[test]
fn a_field_beyond_a_binding_is_drawn() {
    let Some(_) = gpu() else { return };
    let heights: Vec<f64> = (0..830).map(|k| 100.0 * f64::from(k)).collect();
    let layers = Layers::from_heights(&heights, EARTH_M).unwrap();
    let model = Model::new(6, &heights, |cell, _, k| [(0.001 * cell as f64 + 0.1 * k as f64).sin()]);
    let scene = Scene { width: 8, height: 8, ..scene(FAR, SMOOTH, "exaggeration = 10") };
    Model { layers, ..model }.compare("beyond a binding", &scene, 0);
}

/// Rays with more loop iterations than some drivers support: tiles are correct, or drawn by the CPU.
#[test]
fn rays_with_many_bisections_are_correct_or_left_to_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let sphere = sphere(3, &THICK_M);
    let (grid, layers, field) = (&sphere.grid, &sphere.layers, at_centers(&sphere.values[0], sphere.layers.count()));
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

/// The cached entry triangles of a picture with another camera, grid or size do not change the next picture.
#[test]
fn pictures_do_not_depend_on_the_one_before() {
    let Some(_) = gpu() else { return };
    let spheres = [4, 2].map(|level| sphere(level, &THICK_M));
    let draw = |sphere: &Model, camera: &str, [width, height]: [u32; 2]| {
        let scene = Scene { width, height, ..scene(camera, SMOOTH, "exaggeration = 60") };
        let frame = sphere.compare(camera, &scene, 0);
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
