//! Meshes and fields in groups, whose variables have their paths as names.

use crate::columns;
use crate::made::{Made, RECORDS, Values};
use crate::made_icon::Angles;
use crate::memory::{expect, names, open};
use icoray::ErrorKind;

/// The same file with its fields in the group `run` and all else in `grid`; `fields` are the names of the former.
fn grouped(made: &Made, fields: &[&str]) -> Made {
    let mut grouped = made.clone();
    for variable in &mut grouped.variables {
        let group = if fields.contains(&variable.name) { "run" } else { "grid" };
        variable.name = format!("{group}/{}", variable.name).leak();
    }
    grouped
}

/// Triangles of UGRID, whose topology names the other variables without their group.
fn ugrid() -> Made {
    let mut made = Made::ugrid_triangles();
    made.add("q", &["nf"], Values::F64((0..80).map(f64::from).collect()));
    made
}

/// Columns with coordinates alone.
fn columns() -> Made {
    columns::made(["lon", "lat"], ["degrees_east", "degrees_north"], f64::to_degrees)
}

#[test]
fn every_convention_is_found_in_groups() {
    for made in [Made::history(), Made::icon_data(Angles::Degrees), Made::dynamico(Angles::Radians), ugrid(), columns()]
    {
        let expected = open(&made);
        let file = open(&grouped(&made, &names(&expected)));
        assert!(file.mesh().is_same(expected.mesh()), "{:?}", names(&expected));
        let paths: Vec<String> = names(&expected).iter().map(|name| format!("run/{name}")).collect();
        assert_eq!(names(&file), paths);
        assert_eq!(file.times(), expected.times());
        for (path, name) in paths.iter().zip(names(&expected)) {
            for time in [0, RECORDS - 1].into_iter().filter(|time| *time < expected.times().len()) {
                let [found, expected] = [(&file, path.as_str()), (&expected, name)].map(|(dataset, name)| {
                    let owned = dataset.read_field(name, time).unwrap();
                    (format!("{:?}", owned.values()), dataset.layer_heights(name).map(|h| h.height_m).ok())
                });
                assert_eq!(found, expected, "{path}");
            }
        }
    }
}

#[test]
fn a_field_in_a_group_has_its_path() {
    let file = open(&grouped(&columns(), &["PS"]));
    let parts = ["there is no field PS; fields in the file: run/PS"];
    expect(&file.field_info("PS").unwrap_err(), ErrorKind::Field, &parts);
}
