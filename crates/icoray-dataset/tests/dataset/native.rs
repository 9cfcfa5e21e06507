//! Native heights: those of each column.

use crate::made::{LAYERS, Made, RECORDS, Values, levels};
use crate::made_icon::{self, Angles};
use crate::memory::{expect, open, opened};
use icoray::{ComputedField, ErrorKind, Field, Location, Reals, Shape};
use icoray_dataset::{Dataset, NativeHeights};

fn read(file: &Dataset, field: &str, time: usize) -> NativeHeights {
    let grid = file.mesh().grid().unwrap();
    file.native_heights(&grid, field, time).unwrap().unwrap()
}

/// A column's heights.
fn column(field: &Field, cell: usize) -> Vec<f64> {
    (0..field.shape().layers).map(|layer| field.value(cell, layer)).collect()
}

#[test]
fn heights_of_mpas_are_those_of_zgrid() {
    let mut made = Made::history();
    made.f32s("zgrid").iter_mut().enumerate().for_each(|(i, z)| *z += (i / (LAYERS + 1)) as f32);
    let zgrid = made.f32s("zgrid").clone();
    let file = open(&made);
    let info = file.native_info("theta").unwrap();
    assert_eq!(file.find_native_info("theta").unwrap(), Some(info.clone()));
    assert_eq!((info.description.as_str(), info.time_dependent), ("zgrid of each column", false));
    let heights = read(&file, "theta", 2);
    assert_eq!(info.bytes, 4 * zgrid.len());
    assert!(matches!(heights.all().unwrap().samples(), Reals::F32(_)));
    // Layers of theta lie between interfaces, those of w on them.
    let means = file.layer_heights("theta").unwrap();
    for (name, layers, interfaces) in [("theta", 0..LAYERS, 0..LAYERS + 1), ("theta", 1..3, 1..4), ("w", 1..3, 1..3)] {
        let info = file.field_info(name).unwrap();
        let own = heights.over(info, layers.clone()).unwrap();
        let radii = means.layers_over(info, layers.clone()).unwrap();
        assert_eq!(radii.radius_m(), &means.layers.radius_m()[interfaces.clone()], "{name}");
        assert_eq!((own.shape().layers, own.location()), (radii.count(), Location::Center));
        assert!(radii.for_field(layers.len()).is_ok());
        for cell in 0..42 {
            let expected = &zgrid[cell * (LAYERS + 1)..][interfaces.clone()];
            assert!(column(&own, cell).iter().zip(expected).all(|(a, b)| *a == f64::from(*b)), "{name} {cell}");
        }
    }
    let info = file.field_info("w").unwrap();
    for error in [heights.over(info, 3..6).unwrap_err(), means.layers_over(info, 3..6).unwrap_err()] {
        expect(&error, ErrorKind::Field, &["w: layers 3..6, expected some of 0..5"]);
    }
}

/// Metres of a column's interfaces from the top, as the made ocean has them: the last layer of shallow cells is 1 m
/// thinner.
fn ocean(cell: usize, top: f64) -> Vec<f64> {
    match levels(cell) {
        0 => vec![f64::NAN; LAYERS + 1],
        2 => [0.0, -10.0, -29.0, -29.0, -29.0].map(|z| z + top).to_vec(),
        _ => [0.0, -10.0, -30.0, -100.0, -500.0].map(|z| z + top).to_vec(),
    }
}

fn expect_columns(file: &Dataset, time: usize, tops: impl Fn(usize) -> f64) {
    let heights = read(file, "theta", time);
    let own = heights.over(file.field_info("theta").unwrap(), 0..LAYERS).unwrap();
    for cell in 0..42 {
        for (found, expected) in column(&own, cell).into_iter().zip(ocean(cell, tops(cell))) {
            assert_eq!(found.is_nan(), expected.is_nan(), "{cell}");
            assert!(found.is_nan() || (found - expected).abs() < 1e-9, "{cell}: {found} {expected}");
        }
    }
}

#[test]
fn heights_of_the_ocean_are_its_thicknesses_added_up() {
    let over_times = &["Time", "nCells", "nVertLevels"][..];
    let mut made = Made::ocean().with_thickness("layerThickness", over_times);
    let file = open(&made);
    let description = file.native_info("theta").unwrap().description;
    assert_eq!(
        description,
        "layerThickness of each column added up from the sea floor (bottomDepth), those of each time"
    );
    expect_columns(&file, 1, |_| 0.0);
    // At the last time the first layer is thicker, and the sea surface higher.
    let thickness = made.f64s("layerThickness");
    let last = (RECORDS - 1) * 42 * LAYERS;
    thickness[last..].iter_mut().step_by(LAYERS).for_each(|first| *first += 2.5);
    // What is at rest does not count.
    made.remove("bottomDepth");
    made = made.with_thickness("restingThickness", &["nCells", "nVertLevels"]);
    let file = open(&made);
    expect_columns(&file, 1, |_| 0.0);
    let heights = read(&file, "theta", RECORDS - 1);
    assert_eq!(column(&heights.all().unwrap(), 5), [2.5, -10.0, -29.0, -29.0, -29.0]);
    let grid = file.mesh().grid().unwrap();
    let error = file.native_heights(&grid, "theta", RECORDS).unwrap_err();
    expect(&error, ErrorKind::Layers, &["made.nc: variable layerThickness(Time = 3", "has no record 3"]);
}

#[test]
fn without_a_depth_heights_are_counted_from_the_sea_surface() {
    let mut made = Made::ocean().with_thickness("restingThickness", &["nCells", "nVertLevels"]);
    made.remove("bottomDepth");
    let file = open(&made);
    let described = file.native_info("theta").unwrap().description;
    assert_eq!(described, "restingThickness of each column added up down from the sphere");
    expect_columns(&file, 0, |_| 0.0);
    let ssh = (0..RECORDS * 42).map(|i| (i / 42) as f64 + 0.01 * (i % 42) as f64);
    made.add("ssh", &["Time", "nCells"], Values::F64(ssh.collect()));
    let file = open(&made);
    let described = file.native_info("theta").unwrap().description;
    assert!(described.ends_with("down from the sea surface (ssh), those of each time"), "{described}");
    expect_columns(&file, 2, |cell| 2.0 + 0.01 * cell as f64);
    // Without a sea floor columns end where layers have no thickness; below an ice shelf the first ones have none.
    made.remove("maxLevelCell");
    expect_columns(&open(&made), 1, |cell| 1.0 + 0.01 * cell as f64);
    made.add("maxLevelCell", &["nCells"], Values::I32((0..42).map(|c| levels(c) as i32).collect()));
    made.add("minLevelCell", &["nCells"], Values::I32((0..42).map(|c| if c == 3 { 2 } else { 1 }).collect()));
    let below_ice = column(&read(&open(&made), "theta", 0).all().unwrap(), 3);
    let expected = [0.03, 0.03, -19.97, -89.97, -489.97];
    assert!(below_ice.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{below_ice:?}");
    // The thickness of ice is not water's.
    let means = |made: &Made| open(made).layer_heights("theta").unwrap().height_m;
    let expected = means(&made);
    made.f64s("restingThickness")[3 * LAYERS] = 0.0;
    assert_eq!(means(&made), expected);
}

#[test]
fn thicknesses_that_are_none_are_named() {
    let mut made = Made::ocean().with_thickness("layerThickness", &["Time", "nCells", "nVertLevels"]);
    let thickness = made.f64s("layerThickness");
    // Layer 2 of cell 12 (from 1) at the second time.
    thickness[42 * LAYERS + 11 * LAYERS + 2] = -3.0;
    let file = open(&made);
    let grid = file.mesh().grid().unwrap();
    let error = file.native_heights(&grid, "theta", 1).unwrap_err();
    expect(&error, ErrorKind::Layers, &["made.nc: layerThickness of cell 12, layer 2: -3, expected a thickness"]);
    assert!(file.native_heights(&grid, "theta", 0).is_ok());
    made.add("ssh", &["nCells", "nVertLevels"], Values::F64(vec![0.0; 42 * LAYERS]));
    made.remove("bottomDepth");
    let error = open(&made).native_heights(&grid, "theta", 0).unwrap_err();
    expect(&error, ErrorKind::Layers, &["variable ssh(nCells = 42, nVertLevels = 4)", "expected a height"]);
}

#[test]
fn heights_over_triangles_are_averaged() {
    let mut made = Made::icon_data(Angles::Degrees);
    // Of pressures all columns have the same heights.
    let file = open(&made);
    let grid = file.mesh().grid().unwrap();
    assert_eq!(file.find_native_info("ta").unwrap(), None);
    let error = file.native_info("ta").unwrap_err();
    let parts = ["made.nc: ta has no native heights", "looked for a coordinate lev(lev)", "z_ifc, ", " and 80 cells"];
    expect(&error, ErrorKind::Layers, &parts);
    assert!(file.native_heights(&grid, "ta", 0).unwrap().is_none());

    made.variable("lev").attributes.clear();
    made.dimensions.push(("height_2", made_icon::LAYERS + 1));
    let z: Vec<f64> = (0..=made_icon::LAYERS)
        .flat_map(|l| (0..80).map(move |c| 3e3 - 1e3 * l as f64 + (c * 7 % 50) as f64))
        .collect();
    made.add("z_ifc", &["height_2", "ncells"], Values::F64(z.clone()));
    let file = open(&made);
    let heights = read(&file, "ta", 0);
    assert_eq!(file.native_info("ta").unwrap().description, "z_ifc of each triangle, averaged to cells");
    let shape = Shape::cell_fastest(80, made_icon::LAYERS + 1);
    let corners = Field::new(z.as_slice().into(), shape, Location::Corner, None).unwrap();
    let expected = ComputedField::average(&grid, &corners).unwrap();
    let info = file.field_info("ta").unwrap();
    let own = heights.over(info, 1..3).unwrap();
    assert_eq!(own.shape().layers, 3);
    for cell in 0..grid.cells() {
        assert_eq!(column(&own, cell), column(&expected.field(), cell)[1..4]);
    }
    assert_eq!(file.layer_heights("ta").unwrap().layers_over(info, 1..3).unwrap().count(), 3);
}

/// Thicknesses of another run, of fewer layers than the floor counts.
#[test]
fn thicknesses_of_other_layers_do_not_fit() {
    let mut other = Made { dimensions: vec![("nCells", 42), ("nVertLevels", 2)], ..Made::mesh(true) };
    other.variables.clear();
    other.add("restingThickness", &["nCells", "nVertLevels"], Values::F32(vec![10.0; 84]));
    let file = opened(&Made::ocean(), &[&other]).unwrap();
    let heights = read(&file, "theta", 1);
    assert_eq!(column(&heights.all().unwrap(), 1), [0.0, -10.0, -20.0]);
    let error = heights.over(file.field_info("theta").unwrap(), 0..LAYERS).unwrap_err();
    expect(&error, ErrorKind::Field, &["theta: 3 layers have heights, expected 4 or 5"]);
}
