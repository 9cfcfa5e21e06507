//! Fields of one value per column.

use crate::made::{LAYERS, Made, RADIUS_M, RECORDS, Values, value};
use crate::made_icon::Angles;
use crate::made_ocean::levels;
use crate::memory::{expect, open};
use icoray::{ErrorKind, Location};

#[test]
fn a_2d_field_has_the_same_values_on_any_layers() {
    let file = open(&Made::history());
    let info = file.field_info("surface_pressure").unwrap();
    assert!(info.is_2d() && info.time_dependent && info.layer_dimension.is_empty());
    assert_eq!((info.location, info.columns, info.layers), (Location::Center, 42, 1));
    for time in 0..RECORDS {
        for layers in [0..2, 3..9] {
            let owned = file.read_layers("surface_pressure", time, layers.clone()).unwrap();
            let field = owned.field().unwrap();
            assert_eq!((field.shape().columns, field.shape().layers), (42, layers.len()));
            assert_eq!(owned.bytes(), 42 * 4, "the values are in memory once");
            for (column, layer) in (0..42).flat_map(|c| (0..layers.len()).map(move |l| (c, l))) {
                assert_eq!(field.value(column, layer), value(time, column, 0));
            }
        }
    }
    let whole = file.read_field("surface_pressure", 0).unwrap();
    assert_eq!(whole.field().unwrap().shape().layers, file.layers("surface_pressure").unwrap().count());
    let error = file.read_layers("surface_pressure", 0, 1..1).unwrap_err();
    expect(&error, ErrorKind::Field, &["surface_pressure: layers 1..1"]);
    let error = file.read_field("surface_pressure", 3).unwrap_err();
    expect(&error, ErrorKind::Field, &["time index 3", "expected 0 to 2"]);
}

#[test]
fn a_2d_field_lies_on_the_sphere() {
    let file = open(&Made::history());
    let heights = file.layer_heights("surface_pressure").unwrap();
    assert_eq!((heights.variable.as_str(), heights.height_m[0]), ("sphere", 0.0));
    assert_eq!(heights.layers.radius_m()[0], RADIUS_M);
    assert_eq!(file.native_heights_in_words("surface_pressure").unwrap(), None);
    let error = file.native_info("surface_pressure").unwrap_err();
    expect(&error, ErrorKind::Layers, &["surface_pressure has no native heights", "2D field"]);
    // A mesh on the unit sphere, and a file without heights.
    let mut made = Made::history();
    made.remove("zgrid");
    made.set("sphere_radius", 1.0);
    let layers = open(&made).layers("surface_pressure").unwrap();
    assert_eq!(layers.radius_m(), [1.0, 1.001]);
}

#[test]
fn fields_with_layers_are_likelier() {
    let likely = |made: &Made| {
        let file = open(made);
        file.likely_fields().iter().map(|info| info.name.clone()).collect::<Vec<_>>()
    };
    let mut made = Made::history();
    let cells = made.dimension("nCells");
    for (name, dimensions) in [("ter", &["nCells"][..]), ("areaCell", &["nCells"]), ("xCell", &["nCells"])] {
        made.add(name, dimensions, Values::F64(vec![1.0; cells]));
    }
    assert_eq!(likely(&made), ["theta", "w", "vorticity", "rho", "surface_pressure", "ter"]);
    for name in ["theta", "w", "vorticity", "rho", "zgrid"] {
        made.remove(name);
    }
    assert_eq!(likely(&made), ["surface_pressure", "ter"]);
    let file = open(&made);
    let names: Vec<&str> = file.fields().iter().map(|info| info.name.as_str()).collect();
    assert_eq!(names, ["surface_pressure", "ter", "areaCell"], "positions are no fields");
}

#[test]
fn one_layer_is_2d_too() {
    // Shallow water: one level.
    let mut made = Made::mesh(false);
    made.dimensions.extend([("nVertLevels", 1), ("Time", 0)]);
    let h: Vec<f64> = (0..2 * 42).map(f64::from).collect();
    made.add("h", &["Time", "nCells", "nVertLevels"], Values::F64(h));
    let file = open(&made);
    let h = file.read_field("h", 1).unwrap();
    assert_eq!((h.field().unwrap().value(3, 0), h.field().unwrap().value(3, 1)), (45.0, 45.0));
    // ICON's temperature 2 m above the ground, whose height is one number, and a pressure without one.
    let mut made = Made::icon_data(Angles::Radians);
    made.dimensions.push(("height", 1));
    let values: Vec<f32> = (0..RECORDS * 80).map(|i| i as f32).collect();
    made.add("t_2m", &["time", "height", "ncells"], Values::F32(values.clone()));
    made.add("pres_sfc", &["time", "ncells"], Values::F32(values));
    let file = open(&made);
    for name in ["t_2m", "pres_sfc"] {
        let info = file.field_info(name).unwrap();
        assert!(info.is_2d() && info.location == Location::Corner, "{name}");
        let owned = file.read_field(name, 2).unwrap();
        assert_eq!(owned.field().unwrap().value(7, 1), 167.0, "{name}");
    }
}

/// Where there is no water at all there is no sea surface; elsewhere there is, however shallow.
#[test]
fn a_sea_surface_lies_on_water() {
    let file = open(&Made::ocean());
    let owned = file.read_layers("surface_pressure", 0, 0..LAYERS).unwrap();
    let field = owned.field().unwrap();
    for (cell, layer) in (0..42).flat_map(|c| (0..LAYERS).map(move |l| (c, l))) {
        assert_eq!(field.value(cell, layer).is_nan(), levels(cell) == 0, "{cell} {layer}");
    }
}
