//! The same values in every layout give the same picture, bit for bit. Programs in C (`tests/c/pictures_layouts.c` and
//! `pictures_tables.c`) compare precisions, widths and bases of numbers.

use icoray::{ErrorKind, Field, Frame, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene, Shape};
use icoray_tests::layouts::LAYOUTS;
use icoray_tests::{covered, scene};

const CAMERA: &str = "lon = 20\nlat = 35\ndistance = 3.5\nfov = 40";
const LOOK: &str = r##"unit_length = 0.1
knots = [ { value = -1, color = "#2040ff", opacity = 0.7 }, { value = 0.0, color = "white", opacity = 0 },
          { value = 1, color = "red", opacity = 0.9 } ]
[light]
kind = "headlight""##;
const FILL: f32 = -9e33;

/// A value that f32 holds, other at each place, missing at some.
fn value(column: usize, layer: usize) -> f32 {
    if column % 37 == 5 && layer % 4 == 1 {
        return FILL;
    }
    ((column * 7919 + layer * 104_729) % 2048) as f32 / 1024.0 - 1.0
}

/// Bits, so that no NaN equals or differs from anything by accident; what was read, so that no garbage was.
fn seen(frame: &Frame) -> Vec<u64> {
    let pixels = frame.pixels.iter().flatten().chain(&frame.error).map(|c| u64::from(c.to_bits()));
    let range = frame.report.value_range.expect("there are values").map(f64::to_bits);
    let counts = [frame.report.missing_values, frame.report.counts.frusta, frame.report.counts.void_frusta];
    pixels.chain(range).chain(counts).collect()
}

/// On the half levels and on the full ones between them.
#[test]
fn every_layout_gives_the_same_picture() {
    let mesh = IcosahedralMesh::new(2).unwrap();
    let grid = Grid::new(mesh.tables()).unwrap();
    let layers = Layers::new([1.0, 1.05, 1.1, 1.2, 1.25, 1.4].to_vec(), 1.0).unwrap();
    let (renderer, scene) = (Renderer::new(2).unwrap(), Scene { tolerance: 1e-2, ..scene(32, CAMERA, LOOK, "") });
    for (location, count) in
        [(Location::Center, 6), (Location::Center, 5), (Location::Corner, 6), (Location::Corner, 5)]
    {
        let columns = if location == Location::Center { grid.cells() } else { grid.triangles() };
        let frames = LAYOUTS.iter().map(|layout| {
            let values = layout.store(columns, count, [f32::NAN, 1e30], value);
            let shape = (layout.shape)(columns, count);
            let field = Field::new(values.as_slice().into(), shape, location, Some(f64::from(FILL))).unwrap();
            renderer.render(&scene, &grid, &layers, &field).unwrap()
        });
        let frames: Vec<Frame> = frames.collect();
        assert!(covered(&frames[0]) > 0.3, "{location:?}");
        for (frame, layout) in frames.iter().zip(LAYOUTS) {
            assert!(seen(frame) == seen(&frames[0]), "{}, {location:?}, {count} layers", layout.name);
        }
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
