//! Correct meshes are read correctly, with their times and the requested layers of their fields.

use crate::made::{HEIGHT_M, LAYERS, Made, RADIUS_M, RECORDS, Values, value};
use crate::memory::{expect, names, open, open_error, opened};
use icoray::{ErrorKind, Location, Reals};
use icoray_dataset::Kind;

#[test]
fn a_history_has_its_grid_times_and_fields() {
    let file = open(&Made::history());
    let grid = file.mesh().grid().unwrap();
    assert_eq!((grid.cells(), grid.triangles(), file.mesh().edges()), (42, 80, 120));
    assert_eq!(file.sphere_radius_m(), RADIUS_M);
    let times: Vec<&str> = file.times().iter().flatten().map(String::as_str).collect();
    assert_eq!(times, ["2013-10-25_00:00:00", "2013-10-26_00:00:00", "2013-10-27_00:00:00"]);
    for (name, columns, layers) in [("theta", 42, LAYERS), ("w", 42, LAYERS + 1), ("vorticity", 80, LAYERS)] {
        for time in 0..RECORDS {
            let owned = file.read_field(name, time).unwrap();
            let field = owned.field().unwrap();
            assert_eq!((field.shape().columns, field.shape().layers), (columns, layers), "{name}");
            for (column, layer) in [(0, 0), (1, 2), (columns - 1, layers - 1)] {
                assert_eq!(field.value(column, layer), value(time, column, layer), "{name}");
            }
        }
    }
}

/// As xarray's `open_mfdataset` has them, which joins all variables along time.
#[test]
fn tables_over_time_are_those_of_its_first_record() {
    let mut made = Made::history();
    for variable in made.variables.iter_mut().filter(|v| v.dimensions[0] != "Time") {
        variable.dimensions.insert(0, "Time");
        match &mut variable.values {
            Values::F32(values) => *values = values.repeat(RECORDS),
            Values::F64(values) => *values = values.repeat(RECORDS),
            Values::I32(values) => *values = values.repeat(RECORDS),
            Values::Text(values) => *values = values.repeat(RECORDS),
        }
    }
    let (joined, plain) = (open(&made), open(&Made::history()));
    assert!(joined.mesh().is_same(plain.mesh()));
    assert_eq!(joined.layer_heights("theta").unwrap().height_m, plain.layer_heights("theta").unwrap().height_m);
    let grid = joined.mesh().grid().unwrap();
    let own = |file: &icoray_dataset::Dataset| {
        let heights = file.native_heights(&grid, "theta", 1).unwrap().unwrap();
        format!("{:?}", heights.all().unwrap().range())
    };
    assert_eq!(own(&joined), own(&plain));
    // Files of two meshes, joined.
    let mut turned = made.clone();
    turned.f32s("lonCell")[42 * (RECORDS - 1)] += 0.5;
    let parts = ["lonCell(Time = 3, nCells = 42)", "the last record differs from the first, expected one table"];
    expect(&open_error(&turned), ErrorKind::Grid, &parts);
    made.i32s("cellsOnVertex")[240] = 7;
    expect(&open_error(&made), ErrorKind::Grid, &["cellsOnVertex(Time = 3", "record 1 differs from the first"]);
}

#[test]
fn fields_are_listed_with_units_precision_and_location() {
    let file = open(&Made::history());
    assert_eq!(names(&file), ["zgrid", "theta", "w", "vorticity", "rho", "surface_pressure"]);
    let theta = file.field_info("theta").unwrap();
    assert_eq!(
        (theta.description.units.as_deref(), theta.description.long_name.as_deref()),
        (Some("K"), Some("Potential temperature"))
    );
    assert_eq!((theta.location, theta.precision, theta.time_dependent), (Location::Center, Kind::F32, true));
    let vorticity = file.field_info("vorticity").unwrap();
    assert_eq!(
        (vorticity.location, vorticity.precision, vorticity.description.units.as_ref()),
        (Location::Corner, Kind::F64, None)
    );
    assert!(!file.field_info("rho").unwrap().time_dependent);
}

#[test]
fn precision_stays_as_stored() {
    for single in [true, false] {
        let file = open(&Made::mesh(single));
        assert_eq!(matches!(file.mesh().tables().center.lon_rad, Reals::F32(_)), single);
        file.mesh().grid().unwrap();
    }
    let file = open(&Made::history());
    assert!(matches!(file.read_field("theta", 1).unwrap().values(), Reals::F32(_)));
    assert!(matches!(file.read_field("w", 1).unwrap().values(), Reals::F64(_)));
}

#[test]
fn interfaces_are_the_mean_heights() {
    let mut made = Made::history();
    let heights = open(&made).layer_heights("theta").unwrap();
    assert_eq!((heights.variable.as_str(), heights.deviation_m), ("zgrid", Some(0.0)));
    assert_eq!(heights.height_m, HEIGHT_M);
    assert_eq!(heights.layers.radius_m()[4], RADIUS_M + 9000.0);
    assert_eq!(heights.layers.for_field(LAYERS).unwrap().radius_m()[0], RADIUS_M + 50.0);

    // A mountain of 42 m in one of 42 cells lifts the mean by 1 m.
    made.f32s("zgrid")[0] = 42.0;
    let heights = open(&made).layer_heights("theta").unwrap();
    assert_eq!((heights.height_m[0], heights.deviation_m), (1.0, Some(41.0)));
}

#[test]
fn ocean_layers_fall_from_the_surface() {
    let mut made = Made::history();
    made.remove("zgrid");
    made.add("refBottomDepth", &["nVertLevels"], Values::F64(vec![10.0, 30.0, 100.0, 5500.0]));
    let heights = open(&made).layer_heights("theta").unwrap();
    let height_m = vec![0.0, -10.0, -30.0, -100.0, -5500.0];
    assert_eq!((heights.variable.as_str(), heights.height_m), ("refBottomDepth", height_m));
    assert!(heights.layers.is_falling());
}

#[test]
fn missing_values_are_missing() {
    let mut made = Made::history();
    made.f32s("rho")[..2].copy_from_slice(&[-9e33, 1e20]);
    made.variable("rho").attributes = vec![("_FillValue", (-9e33f32).into()), ("missing_value", 1e20f64.into())];
    made.f64s("w")[3] = 9.969209968386869e36;
    let file = open(&made);
    let rho = file.read_field("rho", 0).unwrap();
    assert_eq!(rho.fill(), f64::from(-9e33f32));
    assert_eq!(rho.field().unwrap().range(), (Some([value(0, 0, 2), value(0, 41, 3)]), 2));
    assert_eq!(file.read_field("w", 0).unwrap().field().unwrap().range().1, 1, "a value that was never written");
}

#[test]
fn the_mesh_may_be_in_another_file() {
    let mut mesh = Made::mesh(false);
    mesh.set("sphere_radius", 1.0);
    let mut fields = Made::history();
    for variable in Made::mesh(true).variables {
        fields.remove(variable.name);
    }
    let file = opened(&fields, &[&mesh]).unwrap();
    assert_eq!(file.sphere_radius_m(), RADIUS_M, "the fields' file comes first");
    assert_eq!(file.mesh().grid().unwrap().cells(), file.field_info("theta").unwrap().columns);
    assert_eq!(file.layers("theta").unwrap().count(), LAYERS);
    let error = open_error(&fields).to_string();
    assert!(error.contains("lonCell is missing") && error.contains("another file"), "{error}");
}

#[test]
fn a_file_without_records_still_gives_fields_without_time() {
    let mut made = Made::mesh(false);
    made.dimensions.extend([("nVertLevels", 2), ("Time", 0)]);
    made.add("rho", &["nCells", "nVertLevels"], Values::F64(vec![1.0; 84]));
    made.add("theta", &["Time", "nCells", "nVertLevels"], Values::F64(Vec::new()));
    let file = open(&made);
    assert_eq!(file.times(), [None]);
    file.read_field("rho", 0).unwrap();
    let error = file.read_field("theta", 0).unwrap_err().to_string();
    assert!(error.contains("holds no time record"), "{error}");
}

#[test]
fn some_layers_are_those_of_all() {
    let file = open(&Made::history());
    for (name, columns) in [("theta", 42), ("w", 42), ("vorticity", 80)] {
        let owned = file.read_layers(name, 2, 1..3).unwrap();
        let field = owned.field().unwrap();
        assert_eq!((field.shape().layers, owned.values().len()), (2, 2 * columns));
        for (column, layer) in [(0, 0), (5, 1), (columns - 1, 1)] {
            assert_eq!(field.value(column, layer), value(2, column, layer + 1), "{name}");
        }
    }
    for layers in [0..LAYERS + 1, 2..2, LAYERS..LAYERS + 1] {
        let error = file.read_layers("theta", 0, layers).unwrap_err();
        expect(&error, ErrorKind::Field, &["theta: layers ", "expected some of 0..4"]);
    }
}

#[test]
fn dates_are_those_of_the_file() {
    let dates = |made: &Made| open(made).times().to_vec();
    let mut made = Made::history();
    made.remove("xtime");
    assert_eq!(dates(&made), vec![None; RECORDS]);
    // A mean over a month says when it began.
    let text = |day: usize| format!("{:<64}", format!("0001-{day:02}-01_00:00:00")).into_bytes();
    let begins: Vec<u8> = (1..=RECORDS).flat_map(text).collect();
    made.add("xtime_startMonthly", &["Time", "StrLen"], Values::Text(begins));
    assert_eq!(dates(&made)[2].as_deref(), Some("0001-03-01_00:00:00"));
    made.remove("xtime_startMonthly");
    made.add("Time", &["Time"], Values::I32(vec![0, 59, 365]));
    made.last().attributes = vec![("units", "days since 2000-01-01".into()), ("calendar", "noleap".into())];
    let expected = ["2000-01-01_00:00:00", "2000-03-01_00:00:00", "2001-01-01_00:00:00"];
    assert_eq!(dates(&made), expected.map(|date| Some(date.to_owned())));
    made.last().attributes = vec![("units", "months since 2000-01-01".into())];
    assert_eq!(dates(&made), vec![None; RECORDS]);
}
