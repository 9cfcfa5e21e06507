//! The same values in every layout, precision, width and base of numbers give the same picture, bit for bit.

use icoray::{ErrorKind, Field, Frame, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene, Shape};
use icoray_tests::layouts::{LAYOUTS, Layout, Numbered};
use icoray_tests::{covered, scene};

const CAMERA: &str = "lon = 20\nlat = 35\ndistance = 3.5\nfov = 40";
const TRANSFER: &str = r##"unit_length = 0.1
knots = [ { value = -1, color = "#2040ff", opacity = 0.7 }, { value = 0.0, color = "white", opacity = 0 },
          { value = 1, color = "red", opacity = 0.9 } ]"##;
const LIGHT: &str = "[light]\nkind = \"headlight\"";
const FILL: f32 = -9e33;

/// A value that f32 holds, other at each place, missing at some.
fn value(column: usize, layer: usize) -> f32 {
    if column % 37 == 5 && layer % 4 == 1 {
        return FILL;
    }
    ((column * 7919 + layer * 104_729) % 2048) as f32 / 1024.0 - 1.0
}

/// How a field is placed.
#[derive(Debug, Clone, Copy)]
struct Case {
    location: Location,
    /// On the half levels, or on the full ones between them.
    layers: usize,
    is_single: bool,
}

impl Case {
    /// The case whose number has these bits, of eight.
    fn new(number: usize) -> Self {
        let location = if number & 1 == 0 { Location::Center } else { Location::Corner };
        Case { location, layers: 6 - (number >> 1 & 1), is_single: number & 4 == 0 }
    }
}

struct Stage {
    renderer: Renderer,
    layers: Layers,
    scenes: [Scene; 2],
}

impl Stage {
    fn new() -> Self {
        let radii = [1.0, 1.05, 1.1, 1.2, 1.25, 1.4];
        Stage {
            renderer: Renderer::new(2).unwrap(),
            layers: Layers::new(radii.to_vec(), 1.0).unwrap(),
            scenes: ["", LIGHT].map(|light| {
                let scene = scene(32, CAMERA, &format!("{TRANSFER}\n{light}"), "");
                Scene { tolerance: 1e-2, ..scene }
            }),
        }
    }

    /// The unlit and the lit picture of `layout`, read as `shape`.
    fn frames(&self, grid: &Grid, case: Case, layout: &Layout, shape: Shape) -> [Frame; 2] {
        let (columns, layers) = (shape.columns, shape.layers);
        let single = layout.store(columns, layers, [f32::NAN, 1e30], value);
        let double = layout.store(columns, layers, [f64::NAN, 1e30], |c, l| f64::from(value(c, l)));
        let samples = if case.is_single { single.as_slice().into() } else { double.as_slice().into() };
        let field = Field::new(samples, shape, case.location, Some(f64::from(FILL))).unwrap();
        let render = |scene| self.renderer.render(scene, grid, &self.layers, &field).unwrap();
        [render(&self.scenes[0]), render(&self.scenes[1])]
    }
}

fn columns(grid: &Grid, case: Case) -> usize {
    if case.location == Location::Center { grid.cells() } else { grid.triangles() }
}

/// Bits, so that no NaN equals or differs from anything by accident; what was read, so that no garbage was.
fn seen(frames: &[Frame; 2]) -> Vec<u64> {
    let bits = |f: &Frame| {
        let pixels = f.pixels.iter().flatten().chain(&f.error).map(|c| u64::from(c.to_bits()));
        let range = f.report.value_range.expect("there are values").map(f64::to_bits);
        let counts = [f.report.missing_values, f.report.counts.frusta, f.report.counts.void_frusta];
        pixels.chain(range).chain(counts).collect::<Vec<_>>()
    };
    frames.iter().flat_map(bits).collect()
}

#[test]
fn every_layout_gives_the_same_picture() {
    let mesh = IcosahedralMesh::new(2).unwrap();
    let (narrow, wide) =
        ([0, 1].map(|b| Numbered::<i32>::new(&mesh, b)), [0, 1].map(|b| Numbered::<i64>::new(&mesh, b)));
    let grids = [
        ("i32, base 0", narrow[0].tables(&mesh)),
        ("i32, base 1", narrow[1].tables(&mesh)),
        ("i64, base 0", wide[0].tables(&mesh)),
        ("i64, base 1", wide[1].tables(&mesh)),
    ]
    .map(|(name, tables)| (name, Grid::new(tables).unwrap()));
    let stage = Stage::new();
    for case in (0..8).map(Case::new) {
        let columns = columns(&grids[0].1, case);
        let shape = |layout: &Layout| (layout.shape)(columns, case.layers);
        let plain = stage.frames(&grids[0].1, case, &LAYOUTS[0], shape(&LAYOUTS[0]));
        assert!(plain.iter().all(|f| covered(f) > 0.3), "{case:?}");
        assert!(plain[0].report.counts.void_frusta > 0 || case.location == Location::Corner);
        let expected = seen(&plain);
        for (numbers, grid) in &grids {
            // Where numbers and values lie are independent: every layout once, and the plain and a blocked one with
            // all.
            let all = if numbers == &grids[0].0 { LAYOUTS } else { &[LAYOUTS[0], LAYOUTS[2]] };
            for layout in all {
                let found = seen(&stage.frames(grid, case, layout, shape(layout)));
                assert!(found == expected, "{}, {numbers}, {case:?}", layout.name);
            }
        }
    }
}

/// At centres no value is computed before it is drawn: f32 and f64 hold the same ones.
#[test]
fn both_precisions_of_an_array_give_the_same_picture() {
    let mesh = IcosahedralMesh::new(2).unwrap();
    let grid = Grid::new(mesh.tables()).unwrap();
    let stage = Stage::new();
    for layout in LAYOUTS {
        let both = [true, false].map(|is_single| {
            let case = Case { location: Location::Center, layers: 6, is_single };
            seen(&stage.frames(&grid, case, layout, (layout.shape)(grid.cells(), 6)))
        });
        assert!(both[0] == both[1], "{}", layout.name);
    }
}

/// The comparison can fail: a wrong stride or block, that stays inside the array, is seen.
#[test]
fn a_wrong_shape_gives_another_picture() {
    let mesh = IcosahedralMesh::new(2).unwrap();
    let grid = Grid::new(mesh.tables()).unwrap();
    let stage = Stage::new();
    let case = Case { location: Location::Center, layers: 6, is_single: true };
    let blocked = &LAYOUTS[2];
    let right = (blocked.shape)(grid.cells(), 6);
    let expected = seen(&stage.frames(&grid, case, blocked, right));
    let wrong = [
        Shape { block: right.block - 1, ..right },
        Shape { block_stride: right.block_stride - 1, ..right },
        Shape { layer_stride: right.layer_stride - 1, ..right },
        Shape { block: 0, ..right },
        Shape { offset: 1, ..right },
    ];
    for shape in wrong {
        assert!(seen(&stage.frames(&grid, case, blocked, shape)) != expected, "{shape:?}");
    }
}

/// Each value is where the model put it, and an array that is one element short is refused at either end.
#[test]
fn values_are_found_and_short_arrays_refused() {
    for columns in [1, 49, 50, 51, 100, 162] {
        for layers in [1, 2, 7] {
            for layout in LAYOUTS {
                let shape = (layout.shape)(columns, layers);
                let array = layout.store(columns, layers, [f64::NAN, 1e30], |c, l| (c * layers + l) as f64);
                let made = |array: &[f64], shape| Field::new(array.into(), shape, Location::Center, None).map(|_| ());
                let field = Field::new(array.as_slice().into(), shape, Location::Center, None).unwrap();
                for i in 0..columns * layers {
                    assert_eq!(field.value(i / layers, i % layers), i as f64, "{} {columns} {layers}", layout.name);
                }
                assert_eq!(field.range(), (Some([0.0, (columns * layers - 1) as f64]), 0), "{}", layout.name);
                let (low, high) = shape.extent().unwrap();
                made(&array[..=high as usize], shape).unwrap();
                let short = made(&array[..high as usize], shape).unwrap_err();
                assert_eq!(short.kind(), ErrorKind::Field, "{}", layout.name);
                let offset = shape.offset - low as usize;
                made(&array[low as usize..], Shape { offset, ..shape }).unwrap();
                if let Some(offset) = offset.checked_sub(1) {
                    let early = made(&array[low as usize..], Shape { offset, ..shape });
                    assert!(early.is_err(), "{}", layout.name);
                }
            }
        }
    }
}
