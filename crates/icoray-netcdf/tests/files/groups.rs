//! Variables in groups of NetCDF-4 files.

use crate::made::{Made, RECORDS, value};
use netcdf::{Extents, NcTypeDescriptor, Options};

/// Values of a variable over times, `columns` and `layers`.
fn values(columns: usize, layers: usize) -> Vec<f32> {
    let of_record = move |time| (0..columns * layers).map(move |i| value(time, i / layers, i % layers) as f32);
    (0..RECORDS).flat_map(of_record).collect()
}

fn add<T: NcTypeDescriptor>(group: &mut netcdf::GroupMut<'_>, name: &str, dimensions: &[&str], values: &[T]) {
    let mut variable = group.add_variable::<T>(name, dimensions).unwrap();
    variable.put_values(values, Extents::All).unwrap();
}

#[test]
fn variables_of_groups_have_their_paths() {
    let made = Made::history();
    let cells = made.dimension("nCells");
    let (_folder, path) = made.write(Options::NETCDF4);
    let mut file = netcdf::append(&path).unwrap();
    let mut physics = file.add_group("physics").unwrap();
    physics.add_dimension("lev", 2).unwrap();
    add(&mut physics, "lev", &["lev"], &[100.0, 300.0]);
    physics.variable_mut("lev").unwrap().put_attribute("units", "m").unwrap();
    add(&mut physics.add_group("clouds").unwrap(), "q", &["Time", "nCells", "lev"], &values(cells, 2));
    let mut other = file.add_group("other").unwrap();
    other.add_dimension("nCells", 5).unwrap();
    add(&mut other, "r", &["nCells"], &[0.0f32; 5]);
    let mut run = file.add_group("run").unwrap();
    run.add_dimension("time", RECORDS).unwrap();
    add(&mut run, "time", &["time"], &[0.0, 1.0, 2.0]);
    add(&mut run, "s", &["time", "nCells"], &values(cells, 1));
    file.close().unwrap();

    let lines = icoray_netcdf::contents(&path).unwrap();
    for shown in [
        format!("physics/clouds/q(Time = {RECORDS}, nCells = {cells}, physics/lev = 2) of float"),
        "physics/lev(physics/lev = 2) of double  [m]".to_owned(),
        "other/r(other/nCells = 5) of float".to_owned(),
        format!("run/s(run/time = {RECORDS}, nCells = {cells}) of float"),
    ] {
        assert!(lines.contains(&shown), "{shown}: {lines:#?}");
    }
    let file = icoray_netcdf::open(&path).unwrap();
    for (name, layers) in [("physics/clouds/q", 2), ("run/s", 1)] {
        let info = file.field_info(name).unwrap();
        assert!(info.layers == layers && info.time_dependent, "{info:?}");
        let read = file.read_field(name, 1).unwrap();
        let field = read.field().unwrap();
        for (column, layer) in [(0, 0), (cells - 1, layers - 1)] {
            assert_eq!(field.value(column, layer), f64::from(value(1, column, layer) as f32), "{name}");
        }
    }
    let heights = file.layer_heights("physics/clouds/q").unwrap();
    assert_eq!((heights.variable.as_str(), heights.height_m), ("physics/lev", vec![100.0, 300.0]));
    assert!(file.field_info("other/r").is_err());
}

#[test]
fn attributes_of_groups_count_where_the_file_has_none() {
    let mut made = Made::history();
    made.attributes.retain(|(name, _)| *name != "sphere_radius");
    let (_folder, path) = made.write(Options::NETCDF4);
    let radius_m = || icoray_netcdf::open(&path).unwrap().sphere_radius_m();
    let of_earth = radius_m();
    let mut file = netcdf::append(&path).unwrap();
    let mut model = file.add_group("model").unwrap();
    model.add_group("mesh").unwrap().add_attribute("sphere_radius", 3_389_500.0).unwrap();
    file.close().unwrap();
    assert_eq!(radius_m(), 3_389_500.0);
    let mut file = netcdf::append(&path).unwrap();
    file.add_attribute("sphere_radius", 1_000_000.0).unwrap();
    file.close().unwrap();
    assert_eq!((radius_m(), of_earth > 6e6), (1_000_000.0, true), "the file's own comes first");
}
