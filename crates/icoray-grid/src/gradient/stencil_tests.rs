//! The stencil in single precision, against the gradients in double precision.

use super::*;
use crate::field::{Field, Location};
use crate::grid::{GridTables, IcosahedralMesh, icosahedral_grid};
use crate::reals::Reals;
use crate::shape::Shape;
use icoray_test_support::Random;
use std::borrow::Cow;

fn radii(layers: usize) -> Vec<f64> {
    (0..layers).map(|l| 1.0 + 0.002 * l as f64 + 1e-4 * ((l * l) % 7) as f64).collect()
}

/// Arrays as models have them, with space for each element.
fn shapes(cells: usize, layers: usize) -> Vec<(Shape, bool)> {
    let (level, cell) = (Shape::level_fastest(cells, layers), Shape::cell_fastest(cells, layers));
    let padded = Shape { column_stride: layers as isize + 3, offset: 2, ..level };
    let turned = Shape { layer_stride: -1, offset: layers - 1, ..level };
    let apart = Shape { column_stride: 2 * layers as isize, layer_stride: 2, ..level };
    let blocks = Shape::blocked(cells, layers, 16);
    let rising = [level, padded, turned, apart, cell, blocks].map(|shape| (shape, false));
    rising.into_iter().chain([(level, true), (turned, true), (cell, true)]).collect()
}

/// A field as an array has it, its values from the innermost layer outwards.
struct Model<'m> {
    grid: &'m Grid<'m>,
    layers: usize,
    values: Values<'m>,
    range: [f64; 2],
    fill: Option<f64>,
}

impl Model<'_> {
    fn array(&self, shape: &Shape, falling: bool) -> Vec<f64> {
        let mut array = vec![7.5; (2 * self.layers + 4) * self.grid.cells() + 64];
        let field = Field::new(array.as_slice().into(), *shape, Location::Center, None).unwrap();
        let elements = if falling { field.elements().upside_down() } else { *field.elements() };
        for cell in 0..self.grid.cells() {
            for layer in 0..self.layers {
                array[elements.at(elements.base(cell), layer)] = (self.values)(cell, layer);
            }
        }
        array
    }

    fn gradients<S: PreparedSample>(
        &self,
        array: &[S],
        reals: Reals,
        of: (Shape, bool),
        wanted: GradientOptions,
    ) -> Gradients<'static> {
        let field = Field::new(reals, of.0, Location::Center, self.fill).unwrap();
        let samples = Samples::new(array, &field, of.1, self.range);
        let cells = 0..self.grid.cells();
        gradients(self.grid, &radii(self.layers), &samples, cells, wanted, Gradients::none()).unwrap()
    }

    /// Whether the stencil of each layout is near the gradients in double precision, of both types of samples, and its
    /// packed form is the same number packed.
    fn check(&self, name: &str) {
        for of in shapes(self.grid.cells(), self.layers) {
            let double = self.array(&of.0, of.1);
            let single: Vec<f32> = double.iter().map(|value| *value as f32).collect();
            let rounded: Vec<f64> = single.iter().map(|value| f64::from(*value)).collect();
            let exact = GradientOptions::default();
            let name = format!("{name}, {} layers, {of:?}", self.layers);
            let found = |packed: bool, is_double: bool| {
                let wanted = GradientOptions { packed, single: true, ..exact };
                match is_double {
                    true => self.gradients(&double, double.as_slice().into(), of, wanted),
                    false => self.gradients(&single, single.as_slice().into(), of, wanted),
                }
            };
            for (is_double, array) in [(true, &double), (false, &rounded)] {
                let expected = self.gradients(array, array.as_slice().into(), of, exact);
                let (whole, packed) = (found(false, is_double), found(true, is_double));
                self.compare(&name, array, of, expected.whole(), whole.whole());
                let Gradients::Packed(packed) = packed else { unreachable!("packed gradients were asked for") };
                let repacked = whole.whole().iter().map(|gradient| u64::of(*gradient));
                assert!(packed.iter().copied().eq(repacked), "{name}: packed otherwise");
            }
        }
    }

    /// Each gradient is exact to some roundings of the largest term of its mean.
    fn compare(&self, name: &str, array: &[f64], of: (Shape, bool), exact: &[[f32; 3]], found: &[[f32; 3]]) {
        const ROUNDINGS: f64 = 12.0;
        let radius = radii(self.layers);
        let field = Field::new(array.into(), of.0, Location::Center, self.fill).unwrap();
        let samples = Samples::new(array, &field, of.1, self.range);
        let value = |cell: u32, layer: usize| samples.get::<f64>(samples.base(cell), layer);
        let mut ring = Ring::default();
        for cell in 0..self.grid.cells() as u32 {
            ring.read(self.grid, cell);
            for layer in 0..self.layers {
                let own = value(cell, layer);
                let along = ring.neighbours.iter().zip(&ring.weight);
                let along = along.map(|(n, weight)| (value(*n, layer) - own).abs() * weight.length() / radius[layer]);
                let beside = [layer.checked_sub(1), (layer + 1 < self.layers).then_some(layer + 1)];
                let slopes = beside.into_iter().flatten().map(|other| {
                    (value(cell, other) - own).abs() / (radius[other] - radius[layer]).abs() * ring.radial.length()
                });
                let sum: f64 = along.chain(slopes).filter(|term| !term.is_nan()).sum();
                let i = cell as usize * self.layers + layer;
                let error = DVec3::from_array(exact[i].map(f64::from)) - DVec3::from_array(found[i].map(f64::from));
                let bound = ROUNDINGS * 0.5 * f64::from(f32::EPSILON) * sum;
                let same = exact[i] == found[i];
                assert!(same || error.length() <= bound, "{name}: {cell} {layer}: {:?} {:?}", exact[i], found[i]);
            }
        }
    }
}

/// The value of a cell and a layer.
type Values<'v> = &'v dyn Fn(usize, usize) -> f64;

/// Numbers without order in -1 to 1.
fn random(cell: usize, layer: usize) -> f64 {
    2.0 * Random::at(cell * 1_000_003 + layer).unit() - 1.0
}

const LAYERS: [usize; 6] = [2, 5, 16, 17, 33, 50];

/// Fields of any size over any range: rough ones, small changes of large values, values beside which a float has no
/// room for differences.
#[test]
fn the_stencil_is_exact_to_rounding() {
    let grid = icosahedral_grid(2);
    let smooth = |cell: usize, layer: usize| {
        let at = (1.0 + 0.01 * layer as f64) * grid.direction(cell as u32);
        (3.0 * at.x).sin() * (5.0 * at.y).cos() + at.z * at.z
    };
    let offset = |cell: usize, layer: usize| 1e6 + random(cell, layer);
    let huge = |cell: usize, layer: usize| 3e38 * random(cell, layer);
    let tiny = |cell: usize, layer: usize| 1e-36 * random(cell, layer);
    let spikes = |cell: usize, layer: usize| random(cell, layer) * if cell.is_multiple_of(5) { 1e33 } else { 1.0 };
    let fields: [(&str, Values, [f64; 2]); 8] = [
        ("random", &random, [-1.0, 1.0]),
        ("smooth", &smooth, [0.1, 0.3]),
        ("offset", &offset, [1e6 - 1.0, 1e6 + 1.0]),
        ("huge", &huge, [-3e38, 3e38]),
        ("huge over a usual range", &huge, [0.0, 1.0]),
        ("tiny", &tiny, [0.0, 1e-36]),
        ("tiny over a usual range", &tiny, [0.0, 1.0]),
        ("spikes", &spikes, [1.0, 0.0]),
    ];
    for (name, values, range) in fields {
        for layers in LAYERS {
            Model { grid: &grid, layers, values, range, fill: None }.check(name);
        }
    }
}

/// Where values are missing, alone, in rows and over whole columns, gradients are those in double precision; marked by
/// NaN or by a number, which may be a usual one.
#[test]
fn missing_values_are_left_out_of_the_stencil() {
    let grid = icosahedral_grid(2);
    for fill in [f64::NAN, f64::INFINITY, f64::from(-9e33f32), 0.0, 0.25] {
        let value = |cell: usize, layer: usize| match cell % 11 {
            0 if layer % 13 == cell % 7 => fill,
            1 if layer < 3 => fill,
            2 if cell.is_multiple_of(3) => fill,
            _ => random(cell, layer),
        };
        for layers in LAYERS {
            let fill = Some(fill).filter(|fill| fill.is_finite());
            Model { grid: &grid, layers, values: &value, range: [-1.0, 1.0], fill }.check(&format!("{fill:?}"));
        }
    }
}

/// The differences are formed first: a constant field has no gradient at all.
#[test]
fn a_constant_field_has_no_gradient() {
    let grid = icosahedral_grid(2);
    for value in [0.1, 1e6 + 0.1, -3e38, 1e-40] {
        for layers in LAYERS {
            let values = |_: usize, _: usize| value;
            let model = Model { grid: &grid, layers, values: &values, range: [0.0, 3.0], fill: None };
            let of = (Shape::level_fastest(grid.cells(), layers), false);
            let array: Vec<f32> = model.array(&of.0, of.1).iter().map(|value| *value as f32).collect();
            let wanted = GradientOptions { packed: true, single: true, ..GradientOptions::default() };
            let Gradients::Packed(all) = model.gradients(&array, array.as_slice().into(), of, wanted) else {
                unreachable!("packed gradients were asked for")
            };
            assert!(all.iter().all(|gradient| *gradient == 0), "{value}, {layers} layers");
        }
    }
}

/// Every gradient that is wanted has the bits that it has where all are, beside missing values too, and memory stays as
/// it was elsewhere.
#[test]
fn bits_do_not_depend_on_the_layers_that_are_wanted() {
    const LAYERS: usize = 50;
    let grid = icosahedral_grid(3);
    let value = |cell: usize, layer: usize| match (cell * 31 + layer * 7) % 97 {
        0 => f64::NAN,
        1 => 3e38,
        _ => random(cell, layer),
    };
    let shift = OccupancyMask::shift(LAYERS);
    let blocks = (0..grid.triangles() as u32).map(|t| if t % 5 < 2 { 1 << (t % 25) } else { 0 }).collect();
    let visible = OccupancyMask { blocks: Cow::Owned(blocks), shift, ..OccupancyMask::default() };
    let model = Model { grid: &grid, layers: LAYERS, values: &value, range: [-1.0, 1.0], fill: None };
    for of in shapes(grid.cells(), LAYERS) {
        let array: Vec<f32> = model.array(&of.0, of.1).iter().map(|value| *value as f32).collect();
        let field = Field::new(array.as_slice().into(), of.0, Location::Center, None).unwrap();
        let samples = Samples::new(&array, &field, of.1, model.range);
        let found = |visible, memory| {
            let wanted = GradientOptions { visible, single: true, ..GradientOptions::default() };
            gradients(&grid, &radii(LAYERS), &samples, 0..grid.cells(), wanted, memory).unwrap()
        };
        let all = found(None, Gradients::none());
        let some = found(Some(&visible), Gradients::Whole(vec![[9.0; 3]; all.whole().len()].into()));
        let mut counts = [0; 2];
        for (i, (all, some)) in all.whole().iter().zip(some.whole()).enumerate() {
            let (cell, layer) = ((i / LAYERS) as u32, i % LAYERS);
            let is_wanted = visible.layers_over(&grid, cell, LAYERS).contains(&layer);
            assert_eq!(*some, if is_wanted { *all } else { [9.0; 3] }, "{cell} {layer} of {of:?}");
            counts[usize::from(is_wanted)] += 1;
        }
        assert!(counts.iter().all(|count| *count > 1000), "{counts:?}");
    }
}

/// Corners of a cell in any order, and rows of cells either way round.
#[test]
fn tables_in_any_order_have_the_same_rings() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let ordered = Grid::new(mesh.tables()).unwrap();
    let mut mixed = IcosahedralMesh::new(3).unwrap();
    for (cell, row) in mixed.cell_corner.chunks_exact_mut(6).enumerate() {
        // A pentagon repeats a corner, which is any.
        row.rotate_left(cell % 6);
        row.swap(cell % 5, 5);
    }
    for (corner, row) in mixed.corner_cell.chunks_exact_mut(3).enumerate() {
        row.rotate_left(corner % 3);
    }
    let tables = GridTables { corner_edge: mesh.corner_edge[..].into(), ..mixed.tables() };
    let mixed = Grid::new(tables).unwrap();
    for cell in 0..ordered.cells() as u32 {
        let [first, second] = [&ordered, &mixed].map(|grid| ring::RingWeights::of(grid, cell, 3.0));
        let first = first.expect("a table in order");
        let Some(second) = second else {
            // A corner that is repeated elsewhere than beside itself.
            assert_eq!(first.count, 5, "cell {cell}");
            continue;
        };
        assert_eq!(first.count, second.count);
        for (neighbour, weight) in first.neighbours.iter().zip(first.along).take(first.count) {
            let k = second.neighbours.iter().position(|other| other == neighbour).unwrap();
            let error = weight.iter().zip(second.along[k]).map(|(a, b)| (a - b).abs());
            assert!(error.fold(0.0, f32::max) < 1e-5, "cell {cell}");
        }
    }
}
