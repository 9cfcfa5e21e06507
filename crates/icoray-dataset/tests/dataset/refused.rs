//! Wrong datasets are refused with the name of the fault.

use crate::made::{Made, RADIUS_M, Values};
use crate::memory::{expect, open, opened, spoilt};
use icoray::ErrorKind;

#[test]
fn every_missing_position_is_named() {
    for table in ["lonCell", "latCell", "lonVertex", "latVertex"] {
        let error = spoilt(Made::mesh(false), |made| made.remove(table));
        expect(&error, ErrorKind::Grid, &["made.nc", table, "is missing", "another file"]);
    }
}

#[test]
fn tables_of_another_shape_or_type_are_named() {
    let error = spoilt(Made::mesh(false), |made| {
        made.variable("latCell").dimensions = vec!["nVertices"];
        made.variable("latCell").values = Values::F64(vec![0.0; 80]);
    });
    expect(&error, ErrorKind::Grid, &["latCell(nVertices = 80) of double, expected latCell(nCells)"]);
    let error = spoilt(Made::mesh(false), |made| made.variable("cellsOnVertex").values = Values::F64(vec![1.0; 240]));
    expect(&error, ErrorKind::Grid, &["cellsOnVertex", "of double", "of integer"]);
    let error = spoilt(Made::mesh(false), |made| made.variable("lonCell").values = Values::I32(vec![1; 42]));
    expect(&error, ErrorKind::Grid, &["lonCell", "of integer", "float or double"]);
    let error = spoilt(Made::mesh(false), |made| {
        made.dimensions.iter_mut().find(|d| d.0 == "vertexDegree").unwrap().1 = 4;
        for table in ["cellsOnVertex", "edgesOnVertex"] {
            made.variable(table).values = Values::I32(vec![1; 320]);
        }
    });
    expect(&error, ErrorKind::Unsupported, &["vertexDegree is 4, expected 3"]);
    let error = spoilt(Made::mesh(false), |made| {
        made.dimensions.iter_mut().find(|d| d.0 == "TWO").unwrap().1 = 1;
        made.variable("verticesOnEdge").values = Values::I32(vec![1; 120]);
    });
    expect(&error, ErrorKind::Grid, &["verticesOnEdge", "rows of 1, expected 2"]);
}

#[test]
fn a_table_that_contradicts_itself_is_named_with_the_file() {
    let mut made = Made::mesh(false);
    made.i32s("cellsOnVertex")[4] = 99;
    let file = open(&made);
    expect(
        &file.mesh().grid().unwrap_err(),
        ErrorKind::Grid,
        &["made.nc", "corner_cell(", ", 2)", "cellsOnVertex", "99"],
    );
}

#[test]
fn planes_and_radii_that_are_none_are_refused() {
    let error = spoilt(Made::mesh(false), |made| made.set("on_a_sphere", "NO              "));
    expect(&error, ErrorKind::Unsupported, &["on_a_sphere is NO:", "only meshes on a sphere"]);
    let error = spoilt(Made::mesh(false), |made| made.set("sphere_radius", -1.0f32));
    expect(&error, ErrorKind::Grid, &["sphere_radius: -1"]);
}

#[test]
fn heights_that_are_none_are_refused() {
    let refused = |parts: &[&str], spoil: &dyn Fn(&mut Made)| {
        let mut made = Made::history();
        spoil(&mut made);
        expect(&open(&made).layers("theta").unwrap_err(), ErrorKind::Layers, parts);
    };
    let parts = ["made.nc", "no heights for the 4 layers of theta", "zgrid", "refBottomDepth"];
    refused(&parts, &|made| made.remove("zgrid"));
    let parts = ["zgrid: layer 1 lies at 100 m", "sphere_radius is 50;", "`radius`"];
    refused(&parts, &|made| made.set("sphere_radius", 50.0));
    refused(&["zgrid of column 2, layer 2: NaN"], &|made| made.f32s("zgrid")[7] = f32::NAN);
    refused(&["made.nc: zgrid: layers 2 and 3", "strictly rising"], &|made| {
        made.f32s("zgrid").iter_mut().skip(2).step_by(5).for_each(|z| *z = 100.0);
    });
    refused(&["zgrid(nCells = 42)", "expected zgrid(nCells, nVertLevelsP1)"], &|made| {
        made.variable("zgrid").dimensions = vec!["nCells"];
        made.f32s("zgrid").truncate(42);
    });
}

#[test]
fn errors_of_unknown_fields_and_times_list_the_known_ones() {
    let file = open(&Made::history());
    let error = file.read_field("tehta", 0).unwrap_err();
    expect(&error, ErrorKind::Field, &["no field tehta", "zgrid, theta, w, vorticity, rho"]);
    let error = file.read_field("verticesOnCell", 0).unwrap_err();
    expect(&error, ErrorKind::Field, &["verticesOnCell(nCells = 42, maxEdges = 6) of integer is not a field"]);
    let error = opened(&Made::mesh(true), &[&Made::history()]).unwrap().read_field("theta", 0).unwrap_err();
    expect(
        &error,
        ErrorKind::Field,
        &["no field theta, but made.nc has theta: give that file among those with fields"],
    );
    file.read_field("a/b", 0).unwrap_err();
    file.read_field(&"x".repeat(5000), 0).unwrap_err();
    file.read_field("", 0).unwrap_err();
    for (name, time) in [("theta", 3), ("rho", 3), ("theta", usize::MAX)] {
        expect(
            &file.read_field(name, time).unwrap_err(),
            ErrorKind::Field,
            &[name, "expected 0 to 2", "3 time records"],
        );
    }
}

#[test]
fn files_of_two_meshes_are_refused() {
    let mut fields = Made { variables: Vec::new(), ..Made::mesh(false) };
    fields.dimensions[0].1 = 162;
    let mesh = Made::mesh(false);
    let error = opened(&fields, &[&mesh]).unwrap_err();
    expect(&error, ErrorKind::Grid, &["nCells is 162, expected 42"]);
    assert_eq!(opened(&mesh, &[&mesh]).unwrap().sphere_radius_m(), RADIUS_M);
}
