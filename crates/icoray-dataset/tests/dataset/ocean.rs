//! MPAS-Ocean's files: layers from depths or thicknesses, and a sea floor.

use crate::made::{DEPTH_M, LAYERS, Made, Values, levels};
use crate::memory::{expect, open, values};
use icoray::{ComputedField, ErrorKind};

#[test]
fn values_below_the_sea_floor_are_missing() {
    let file = open(&Made::ocean());
    let grid = file.mesh().grid().unwrap();
    for (name, more) in [("theta", 0), ("rho", 0), ("w", 1)] {
        let owned = file.read_field(name, 1.min(file.times().len() - 1)).unwrap();
        let field = owned.field().unwrap();
        for (cell, layer) in (0..42).flat_map(|c| (0..LAYERS + more).map(move |l| (c, l))) {
            let is_wet = levels(cell) > 0 && layer < levels(cell) + more;
            assert_eq!(field.value(cell, layer).is_finite(), is_wet, "{name} {cell} {layer}");
        }
        assert!(field.range().0.unwrap()[0] >= 0.0, "{name}");
    }
    // Corners have numbers everywhere, and yet no cell has an average below its floor.
    let owned = file.read_field("vorticity", 0).unwrap();
    let center = ComputedField::average(&grid, &owned.field().unwrap()).unwrap();
    for (cell, layer) in (0..42).flat_map(|c| (0..LAYERS).map(move |l| (c, l))) {
        let is_there = center.field().value(cell, layer).is_finite();
        assert!(!is_there || layer < levels(cell), "{cell} {layer}");
    }
    for corner in 0..grid.triangles() as u32 {
        for layer in 0..LAYERS {
            let cells = grid.triangle(corner).map(|cell| cell as usize);
            if cells.iter().all(|&cell| layer < levels(cell)) {
                assert!(cells.iter().all(|&cell| center.field().value(cell, layer).is_finite()));
            }
        }
    }
}

#[test]
fn layers_of_an_ocean_have_its_floor() {
    let file = open(&Made::ocean());
    for (name, from) in [("theta", 1), ("w", 2)] {
        let (all, some) = (file.read_field(name, 0).unwrap(), file.read_layers(name, 0, from..4).unwrap());
        let (all, some) = (all.field().unwrap(), some.field().unwrap());
        for (cell, layer) in (0..42).flat_map(|c| (0..4 - from).map(move |l| (c, l))) {
            let pair = [all.value(cell, layer + from), some.value(cell, layer)];
            assert_eq!(pair[0].to_bits(), pair[1].to_bits(), "{name} {cell} {layer}");
        }
    }
}

#[test]
fn ice_shelves_lie_on_top() {
    let mut made = Made::ocean();
    let mut first = vec![1; 42];
    first[3] = 2;
    made.add("minLevelCell", &["nCells"], Values::I32(first));
    let field = values(&open(&made), "theta", 0);
    let is_there = |cell| [0, 1, 2, 3].map(|layer| field(cell, layer).is_finite());
    assert_eq!((is_there(3), is_there(4)), ([false, true, true, true], [true; 4]));
}

#[test]
fn thicknesses_add_up_to_interfaces() {
    for (name, dimensions) in
        [("restingThickness", &["nCells", "nVertLevels"][..]), ("layerThickness", &["Time", "nCells", "nVertLevels"])]
    {
        let heights = open(&Made::ocean().with_thickness(name, dimensions)).layer_heights("theta").unwrap();
        assert_eq!(heights.variable, name);
        // Of 41 cells with two layers 8 are 1 m shallower.
        let shallow = (0..42).filter(|&cell| levels(cell) == 2).count() as f64;
        let mean = 20.0 - shallow / 41.0;
        for (height, expected) in heights.height_m.iter().zip([0.0, -10.0, -10.0 - mean, -80.0 - mean, -480.0 - mean]) {
            assert!((height - expected).abs() < 1e-9, "{:?}", heights.height_m);
        }
        // At those the second interface is at 29 m.
        let expected = 10.0 + mean - 29.0;
        assert!((heights.deviation_m.unwrap() - expected).abs() < 1e-9, "{:?}", heights.deviation_m);
        assert!(heights.layers.is_falling());
    }
}

#[test]
fn depths_come_before_thicknesses() {
    let mut made = Made::ocean().with_thickness("restingThickness", &["nCells", "nVertLevels"]);
    made.add("refBottomDepth", &["nVertLevels"], Values::F64(DEPTH_M.to_vec()));
    let heights = open(&made).layer_heights("theta").unwrap();
    assert_eq!((heights.variable.as_str(), heights.deviation_m), ("refBottomDepth", None));
    assert_eq!(heights.height_m, [0.0, -10.0, -30.0, -100.0, -500.0]);
}

#[test]
fn floors_and_thicknesses_that_are_none_are_named() {
    let spoilt = |made: &Made| {
        let file = open(made);
        (file.read_field("theta", 0).err(), file.layers("theta").err())
    };
    let mut made = Made::ocean();
    made.variable("maxLevelCell").values = Values::I32([vec![4; 41], vec![5]].concat());
    let (error, _) = spoilt(&made);
    expect(&error.unwrap(), ErrorKind::Field, &["made.nc", "maxLevelCell of cell 42 is 5, expected 0 to 4"]);
    let mut made = Made::ocean();
    made.variable("maxLevelCell").values = Values::F64(vec![4.0; 42]);
    let (error, _) = spoilt(&made);
    expect(&error.unwrap(), ErrorKind::Field, &["maxLevelCell(nCells = 42) of double", "of integer"]);
    let mut made = Made::ocean().with_thickness("restingThickness", &["nCells", "nVertLevels"]);
    made.f64s("restingThickness")[1] = 0.0;
    let (_, error) = spoilt(&made);
    expect(&error.unwrap(), ErrorKind::Layers, &["restingThickness of cell 1, layer 1: 0", "positive thickness"]);
    let (_, error) = spoilt(&Made::ocean());
    expect(
        &error.unwrap(),
        ErrorKind::Layers,
        &["no heights for the 4 layers of theta", "zgrid", "refBottomDepth", "layerThickness"],
    );
}

/// The floor at corners is computed before the tables are checked.
#[test]
fn corners_of_cells_that_there_are_not_have_no_water() {
    let mut made = Made::ocean();
    let cells = made.i32s("cellsOnVertex");
    (cells[0], cells[4], cells[8]) = (i32::MIN, i32::MAX, 0);
    let file = open(&made);
    file.mesh().grid().unwrap_err();
    let vorticity = values(&file, "vorticity", 0);
    assert!((0..3).all(|corner| vorticity(corner, 0).is_nan()));
}
