//! ICON's files: with tables, or with the bounds of each triangle alone; and ICON-O's mask of water.

use crate::made::{Made, RECORDS, Values, value};
use crate::made_icon::{Angles, LAYERS};
use crate::memory::{direction_of, expect, names, open, open_error, opened, opened_with, spoilt, values};
use icoray::{ComputedField, ErrorKind, Location};
use icoray_dataset::{Dataset, DatasetOptions, MeshLayout};

/// The places of each triangle's points, sorted.
fn triangles(file: &Dataset) -> Vec<Vec<[i64; 3]>> {
    let grid = file.mesh().grid().unwrap();
    assert_eq!(grid.void_triangles(), 0);
    let tables = file.mesh().tables();
    let place = |cell: u32| direction_of(tables.center, cell as usize).map(|x| (1e4 * x).round() as i64);
    let of = |t| {
        let mut points = grid.triangle(t).map(place).to_vec();
        points.sort_unstable();
        points
    };
    (0..grid.triangles() as u32).map(of).collect()
}

#[test]
fn bounds_give_the_triangles_that_the_tables_give() {
    let with_tables = open(&Made::icon_grid());
    assert_eq!(with_tables.mesh().layout(), MeshLayout::Triangles);
    let expected = triangles(&with_tables);
    assert_eq!((with_tables.mesh().cells(), expected.len(), with_tables.mesh().edges()), (42, 80, 120));
    for angles in [Angles::Radians, Angles::Degrees, Angles::Degrees32] {
        let file = open(&Made::icon_data(angles));
        assert_eq!(triangles(&file), expected);
    }
}

#[test]
fn fields_lie_on_triangles_and_layers_on_the_standard_atmosphere() {
    let file = open(&Made::icon_data(Angles::Radians));
    assert_eq!(names(&file), ["ta"], "bounds are no field");
    let dates: Vec<&str> = file.times().iter().flatten().map(String::as_str).collect();
    assert_eq!(dates, ["1979-01-31_18:00:00", "1979-02-01_00:00:00", "1979-02-01_06:00:00"]);
    let info = file.field_info("ta").unwrap();
    assert_eq!((info.location, info.columns, info.layers), (Location::Corner, 80, LAYERS));
    assert_eq!(info.description.units.as_deref(), Some("K"));
    for time in 0..RECORDS {
        let field = values(&file, "ta", time);
        for (column, layer) in [(0, 0), (1, 2), (79, 1)] {
            assert_eq!(field(column, layer), value(time, column, layer));
        }
    }
    let heights = file.layer_heights("ta").unwrap();
    assert!(heights.is_of_pressure && heights.variable == "lev");
    let tabled = [110.9, 1457.3, 5574.4];
    for (height, tabled) in heights.height_m.iter().zip(tabled) {
        assert!((height - tabled).abs() < 6.0, "{:?}", heights.height_m);
    }
    assert_eq!(file.layers("ta").unwrap().count(), LAYERS);
}

#[test]
fn grid_and_heights_may_be_in_files_of_their_own() {
    let mut data = Made::icon_data(Angles::Degrees);
    data.remove_all(&["clon", "clat", "clon_bnds", "clat_bnds"]);
    // Levels are counted, and z_ifc has the heights of one interface more.
    data.variable("lev").attributes.clear();
    let mut heights = Made { dimensions: vec![("ncells", 80), ("height_2", LAYERS + 1)], ..Made::icon_grid() };
    heights.variables.clear();
    let z = (0..=LAYERS)
        .rev()
        .flat_map(|l| (0..80).map(move |c| 1e3 * l as f32 + if c == 0 && l == 0 { 80.0 } else { 0.0 }));
    heights.add("z_ifc", &["height_2", "ncells"], Values::F32(z.collect()));
    let grid = Made::icon_grid();
    let file = opened(&data, &[&grid, &heights]).unwrap();
    assert_eq!(file.mesh().grid().unwrap().triangles(), file.field_info("ta").unwrap().columns);
    let found = file.layer_heights("ta").unwrap();
    assert_eq!((found.variable.as_str(), found.deviation_m), ("z_ifc", Some(79.0)));
    assert_eq!(found.height_m, [3000.0, 2000.0, 1000.0, 1.0]);
    let layers = file.layers("ta").unwrap();
    assert!(layers.is_falling() && layers.count() == LAYERS);

    let error = open_error(&data);
    expect(&error, ErrorKind::Grid, &["made.nc", "no mesh is known", "vertex_of_cell", "another file"]);
    let error = opened(&data, &[&grid]).unwrap().layers("ta").unwrap_err();
    expect(&error, ErrorKind::Layers, &["no heights for the 3 layers of ta", "lev(lev)", "z_ifc", "another file"]);
}

#[test]
fn a_limited_area_has_holes() {
    let mut made = Made::icon_data(Angles::Degrees);
    let kept: Vec<usize> = (0..80).filter(|t| t % 5 != 0).collect();
    made.dimensions[0].1 = kept.len();
    for variable in &mut made.variables {
        let row = if variable.name.ends_with("_bnds") { 3 } else { 1 };
        let stays = |i: usize| !(i / row % 80).is_multiple_of(5);
        match &mut variable.values {
            Values::F64(v) if v.len() >= 80 => {
                *v = (0..v.len()).filter(|&i| stays(i)).map(|i| v[i]).collect();
            }
            Values::F32(v) if v.len() >= 80 => {
                *v = (0..v.len()).filter(|&i| stays(i)).map(|i| v[i]).collect();
            }
            _ => {}
        }
    }
    let file = open(&made);
    let grid = file.mesh().grid().unwrap();
    assert_eq!(grid.triangles(), kept.len());
    assert!(grid.void_triangles() >= 16, "{}", grid.void_triangles());
    assert_eq!(values(&file, "ta", 1)(0, 0), value(1, 1, 0));
}

#[test]
fn triangles_that_are_none_are_named() {
    let data = || Made::icon_data(Angles::Degrees);
    let error = spoilt(data(), |made| {
        made.remove("clat_bnds");
        made.remove("clat");
    });
    expect(&error, ErrorKind::Grid, &["made.nc", "clat_bnds or clat_vertices", "vertex_of_cell"]);
    let error = spoilt(data(), |made| {
        let same = made.f64s("clon_bnds")[6];
        made.f64s("clon_bnds")[7] = same;
        let same = made.f64s("clat_bnds")[6];
        made.f64s("clat_bnds")[7] = same;
    });
    expect(&error, ErrorKind::Grid, &["the bounds of triangle 2 are", "expected three different points"]);
    let error = spoilt(data(), |made| made.f64s("clat_bnds")[4] = f64::NAN);
    expect(&error, ErrorKind::Grid, &["the bounds of triangle 1 are", "NaN"]);
    let error = spoilt(data(), |made| made.variable("clat").attributes = vec![("units", "furlong".into())]);
    expect(&error, ErrorKind::Grid, &["clat is in \"furlong\", expected radian or degrees"]);
    let error = spoilt(data(), |made| {
        made.dimensions.push(("fewer", 79));
        made.variable("clon_bnds").dimensions[0] = "fewer";
        made.f64s("clon_bnds").truncate(3 * 79);
    });
    expect(&error, ErrorKind::Grid, &["clon_bnds(fewer = 79, vertices = 3)", "expected the same dimensions"]);
    let error = spoilt(Made::icon_grid(), |grid| grid.dimensions[2].1 = 4);
    expect(&error, ErrorKind::Grid, &["vertex_of_cell(nv = 4, cell = 80)", "expected the 3 nodes"]);
    let error = spoilt(Made::icon_grid(), |grid| grid.remove("vlon"));
    expect(&error, ErrorKind::Grid, &["variable vlon is missing", "another file"]);
    let error = spoilt(Made::icon_grid(), |plane| plane.set("grid_geometry", 2));
    expect(&error, ErrorKind::Unsupported, &["grid_geometry is 2", "only meshes on a sphere"]);
    let error = spoilt(Made::icon_grid(), |grid| grid.i32s("vertex_of_cell")[5] = 43);
    expect(&error, ErrorKind::Grid, &["made.nc", "vertex_of_cell: node 43 of element 5, expected 1 to 42"]);
}

/// Whether a triangle's layer is water: every fourth triangle is land, every third is shallow.
fn is_wet(triangle: usize, layer: usize) -> bool {
    !triangle.is_multiple_of(4) && (layer == 0 || !triangle.is_multiple_of(3))
}

/// Temperatures of 20 in water and 0 on land, as ICON-O writes them, and 2D and interface fields.
fn sea() -> Made {
    let mut made = Made::icon_data(Angles::Radians);
    made.remove("ta");
    made.dimensions.push(("lev_2", LAYERS + 1));
    let of = |layers: usize| {
        let places = (0..RECORDS * layers).flat_map(|i| (0..80).map(move |t| (i % layers, t)));
        places.map(|(l, t)| if is_wet(t, l.min(LAYERS - 1)) { 20.0 } else { 0.0 }).collect::<Vec<f32>>()
    };
    made.add("to", &["time", "lev", "ncells"], Values::F32(of(LAYERS)));
    made.add("w", &["time", "lev_2", "ncells"], Values::F32(of(LAYERS + 1)));
    made.add("zos", &["time", "ncells"], Values::F32(of(1)));
    let wet = (0..LAYERS).flat_map(|l| (0..80).map(move |t| f32::from(u8::from(is_wet(t, l)))));
    made.add("wet_c", &["lev", "ncells"], Values::F32(wet.collect()));
    made
}

#[test]
fn a_layer_that_is_picked_has_its_land() {
    let options = DatasetOptions { at: vec![("lev".into(), 1)], ..DatasetOptions::default() };
    let field = values(&opened_with(&sea(), &[], options).unwrap(), "to", 1);
    assert!((0..80).all(|triangle| field(triangle, 0).is_finite() == is_wet(triangle, 1)));
}

#[test]
fn land_is_missing() {
    let file = open(&sea());
    for (name, layers) in [("to", LAYERS), ("w", LAYERS + 1), ("zos", 2)] {
        let owned = file.read_field(name, 1).unwrap();
        let field = owned.field().unwrap();
        assert_eq!(field.shape().layers, layers, "{name}");
        for (triangle, layer) in (0..80).flat_map(|t| (0..layers).map(move |l| (t, l))) {
            let expected = match name {
                "to" => is_wet(triangle, layer),
                "w" => (layer.saturating_sub(1)..=layer.min(LAYERS - 1)).any(|l| is_wet(triangle, l)),
                _ => is_wet(triangle, 0),
            };
            assert_eq!(!field.value(triangle, layer).is_nan(), expected, "{name} {triangle} {layer}");
        }
    }
    // Some layers have their own water.
    let owned = file.read_layers("to", 0, 1..3).unwrap();
    for triangle in 0..80 {
        assert_eq!(!owned.field().unwrap().value(triangle, 0).is_nan(), is_wet(triangle, 1));
    }
}

/// A coast has the temperature of the water beside it, not a mean with the zeros of the land.
#[test]
fn coasts_are_as_warm_as_their_water() {
    let file = open(&sea());
    let grid = file.mesh().grid().unwrap();
    let owned = file.read_field("to", 0).unwrap();
    let average = ComputedField::average(&grid, &owned.field().unwrap()).unwrap();
    let (range, missing) = average.field().range();
    assert!(range == Some([20.0, 20.0]) && missing < 42 * LAYERS as u64, "{range:?} {missing}");
}

#[test]
fn the_mask_may_be_in_another_file_and_must_fit() {
    let mut data = sea();
    let wet = data.variable("wet_c").clone();
    data.remove("wet_c");
    let mut mask = Made { attributes: Vec::new(), variables: vec![wet], ..data.clone() };
    mask.dimensions.retain(|(name, _)| *name != "time");
    let missing = |file: Dataset| file.read_field("to", 0).unwrap().field().unwrap().range().1;
    assert_eq!(missing(open(&data)), 0);
    assert!(missing(opened(&data, &[&mask]).unwrap()) > 60);
    let mut data = sea();
    data.variable("wet_c").dimensions = vec!["lev"];
    data.variable("wet_c").values = Values::F32(vec![1.0; LAYERS]);
    let error = open(&data).read_field("to", 0).unwrap_err();
    expect(&error, ErrorKind::Field, &["wet_c(lev = 3)", "expected wet_c over layers and 80 triangles"]);
}
