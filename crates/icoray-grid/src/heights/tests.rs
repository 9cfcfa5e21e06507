//! Heights of synthetic columns, in all layouts, against the definition.

use super::*;
use crate::grid::{IcosahedralMesh, OwnedGrid, OwnedTables, icosahedral_grid};
use crate::shape::Shape;

const PLANET_M: f64 = 6.4e6;
const CELLS: usize = 642;
const LAYERS: usize = 4;

fn layers(falling: bool) -> Layers {
    let mut mean = vec![100.0, 900.0, 2500.0, 8000.0];
    if falling {
        mean.reverse();
    }
    Layers::from_heights(&mean, PLANET_M).unwrap()
}

/// Height of a layer counted from the innermost: mountains that fade out upwards; the second layer has no thickness at
/// some.
fn height(cell: usize, layer: usize) -> f64 {
    let ground = (cell * 37 % 5000) as f64 - 500.0;
    let above = [0.0, 1000.0, 3000.0, 9000.0][layer];
    if layer == 1 && cell.is_multiple_of(3) { ground } else { ground + above - 0.2 * ground * layer as f64 }
}

/// The array in a layout, layers as they are given.
fn laid_out(shape: &Shape, falling: bool, missing: impl Fn(usize, usize) -> bool) -> Vec<f64> {
    let (_, last) = shape.extent().unwrap();
    let mut values = vec![f64::NAN; last as usize + 1];
    let elements = ElementIndexer::new(shape).unwrap();
    for (cell, layer) in (0..shape.columns).flat_map(|c| (0..shape.layers).map(move |l| (c, l))) {
        let given = if falling { shape.layers - 1 - layer } else { layer };
        let value = if missing(cell, layer) { -9999.0 } else { height(cell, layer) };
        values[elements.at(elements.base(cell), given)] = value;
    }
    values
}

fn shapes() -> [Shape; 3] {
    [Shape::level_fastest(CELLS, LAYERS), Shape::cell_fastest(CELLS, LAYERS), Shape::blocked(CELLS, LAYERS, 48)]
}

fn field(values: Reals, shape: Shape) -> Field {
    Field::new(values, shape, Location::Center, Some(-9999.0)).unwrap()
}

#[test]
fn radii_are_those_of_the_definition_in_every_layout() {
    let grid = icosahedral_grid(3);
    for (shape, falling, exaggeration) in shapes().into_iter().flat_map(|s| [(s, false, 1.0), (s, true, 50.0)]) {
        let wide = laid_out(&shape, falling, |cell, _| cell == 77);
        let narrow: Vec<f32> = wide.iter().map(|v| *v as f32).collect();
        let layers = layers(falling);
        for samples in [Reals::from(wide.as_slice()), narrow.as_slice().into()] {
            for count in [LAYERS, LAYERS - 1] {
                let mean = layers.for_field(count).unwrap().shell(exaggeration).unwrap();
                let heights = Heights::new(&field(samples, shape), &layers, &grid, count, exaggeration).unwrap();
                let expected = |cell: usize, layer: usize| {
                    if cell == 77 || cell >= CELLS {
                        return mean[layer];
                    }
                    let at = |layer| match samples {
                        Reals::F32(_) => f64::from(height(cell, layer) as f32),
                        Reals::F64(_) => height(cell, layer),
                    };
                    let height = if count == LAYERS { at(layer) } else { 0.5 * (at(layer) + at(layer + 1)) };
                    1.0 + exaggeration * height / PLANET_M
                };
                let mut bounds = [mean[0], mean[count - 1]];
                assert_eq!(heights.layers(), count);
                for (cell, layer) in (0..CELLS).flat_map(|c| (0..count).map(move |l| (c, l))) {
                    let radius = heights.radius(cell as u32, layer);
                    assert!((radius - expected(cell, layer)).abs() < 1e-15, "{shape:?} {cell} {layer}");
                    assert!(layer == 0 || radius >= heights.radius(cell as u32, layer - 1));
                    bounds = [bounds[0].min(radius), bounds[1].max(radius)];
                }
                assert_eq!(heights.bounds(), bounds);
                let three = heights.radii([3, 77, CELLS as u32 + 5], 1);
                assert_eq!(three, [heights.radius(3, 1), mean[1], mean[1]]);
            }
        }
    }
}

/// The message about heights of which some are changed.
fn error(falling: bool, exaggeration: f64, change: impl Fn(&mut [f64])) -> String {
    let shape = Shape::level_fastest(CELLS, LAYERS);
    let mut values = laid_out(&shape, falling, |_, _| false);
    change(&mut values);
    let field = field(values.as_slice().into(), shape);
    let error = Heights::new(&field, &layers(falling), &icosahedral_grid(3), LAYERS, exaggeration).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Layers);
    error.to_string()
}

#[test]
fn bad_heights_are_named_by_the_first_cell_and_the_layer_as_given() {
    let text = error(false, 1.0, |values| {
        values[4 * 600] = 1e5;
        values[4 * 500 + 2] = -1e5;
    });
    assert!(text.contains("cell 500 (counted from 0), layers 3 and 2 of 4: -100000 m lies below"), "{text}");
    let text = error(true, 1.0, |values| values[4 * 500 + 1] = -1e5);
    assert!(text.contains("cell 500 (counted from 0), layers 2 and 3 of 4: -100000 m lies below"), "{text}");
    for mark in [f64::NAN, f64::INFINITY, -9999.0] {
        let text = error(true, 1.0, |values| values[4 * 3 + 1] = mark);
        assert!(text.contains("cell 3 (counted from 0), layer 2 of 4: missing, but"), "{text}");
    }
    let text = error(false, 50.0, |values| values[4 * 9] = -2e5);
    assert!(text.contains("cell 9 (counted from 0), heights -200000 to"), "{text}");
    assert!(text.contains("are stretched to -10000000 to"), "{text}");
}

#[test]
fn cells_that_have_numbers_are_named_by_them() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let tables = OwnedTables::of_points(mesh.tables().center).unwrap();
    let cell_number = (0..CELLS as u64).map(|cell| 7 * cell + 2).collect();
    let numbered = OwnedGrid::new(OwnedTables { cell_number, number_base: 1, ..tables }).unwrap();
    assert_eq!(numbered.grid().cell_name(500), "cell 3503 of the whole grid");
}

#[test]
fn heights_of_another_shape_or_place_are_refused() {
    let grid = icosahedral_grid(3);
    let values = vec![0.0; CELLS * (LAYERS + 1)];
    for (shape, place) in [
        (Shape::level_fastest(CELLS, LAYERS - 1), Location::Center),
        (Shape::level_fastest(CELLS, LAYERS + 1), Location::Center),
        (Shape::level_fastest(CELLS - 1, LAYERS), Location::Center),
        (Shape::level_fastest(CELLS, LAYERS), Location::Corner),
    ] {
        let field = Field::new(values.as_slice().into(), shape, place, None).unwrap();
        let error = Heights::new(&field, &layers(false), &grid, LAYERS, 1.0).unwrap_err();
        let expected = format!("{} columns of {} layers at {place:?}, expected 642 of 4", shape.columns, shape.layers);
        assert!(error.to_string().contains(&expected), "{error}");
    }
    let field = field(values[..CELLS * LAYERS].into(), Shape::level_fastest(CELLS, LAYERS));
    let heights = |count| Heights::new(&field, &layers(false), &grid, count, 1.0);
    assert_eq!(heights(LAYERS - 2).unwrap_err().kind(), ErrorKind::Field);
    assert_eq!(heights(LAYERS).unwrap().radius(5, 3), 1.0, "no thickness at all");
}
