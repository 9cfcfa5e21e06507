//! Files with places of columns and no table of neighbours.

use crate::made::{Made, Values};
use crate::made_icon::Angles;
use crate::memory::{open, open_error, values};
use icoray::{ErrorKind, IcosahedralMesh, Location};

/// A field over columns at the places of a mesh's cells, under names of the coordinates.
pub fn made([lon, lat]: [&'static str; 2], units: [&'static str; 2], angle: impl Fn(f64) -> f64) -> Made {
    let mesh = IcosahedralMesh::new(2).unwrap();
    let mut made = Made::of([("ncol", mesh.cells()), ("lev", 3), ("time", 1)], []);
    for (name, unit, rad) in [(lon, units[0], &mesh.lon_center_rad), (lat, units[1], &mesh.lat_center_rad)] {
        made.add(name, &["ncol"], Values::F64(rad.iter().map(|rad| angle(*rad)).collect()));
        made.last().attributes = vec![("units", unit.into())];
    }
    made.add("PS", &["time", "ncol"], Values::F64((0..mesh.cells()).map(|cell| cell as f64).collect()));
    made
}

#[test]
fn columns_are_cells_for_any_name_of_coordinates() {
    let degrees = ["degrees_east", "degrees_north"];
    for (names, units, scale) in [
        (["lon", "lat"], degrees, 180.0 / std::f64::consts::PI),
        (["grid_center_lon", "grid_center_lat"], ["radians", "radians"], 1.0),
        (["mesh2d_face_x", "mesh2d_face_y"], degrees, 180.0 / std::f64::consts::PI),
        (["lonCell", "latCell"], ["rad", "rad"], 1.0),
    ] {
        let file = open(&made(names, units, |rad| scale * rad));
        assert!(file.mesh().in_words().starts_with("points: 162 cells, 320 corners"));
        assert_eq!(file.mesh().grid().unwrap().void_triangles(), 0);
        let fields: Vec<_> = file.fields().iter().map(|info| (info.name.as_str(), info.location)).collect();
        assert_eq!(fields, [("PS", Location::Center)], "{names:?}");
        assert_eq!(values(&file, "PS", 0)(161, 0), 161.0);
    }
}

#[test]
fn tables_and_bounds_go_before_columns() {
    let mut made = Made::mesh(false);
    made.add("PS", &["nCells"], Values::F64(vec![1.0; 42]));
    assert!(open(&made).mesh().format() != "points");
    made.remove_all(&["verticesOnCell", "cellsOnVertex", "edgesOnVertex", "verticesOnEdge", "cellsOnEdge"]);
    let without = open(&made);
    assert_eq!(without.mesh().format(), "points");
    assert_eq!((without.mesh().cells(), without.mesh().corners()), (42, 80));
    let mut icon = Made::icon_data(Angles::Degrees);
    assert!(open(&icon).mesh().format() != "points");
    icon.remove_all(&["clon_bnds", "clat_bnds"]);
    let without = open(&icon);
    assert_eq!(without.mesh().format(), "points");
    assert_eq!(without.mesh().cells(), 80);
}

#[test]
fn columns_that_make_no_mesh_are_named() {
    let message = |spoil: fn(&mut [f64])| {
        let mut made = made(["lon", "lat"], ["radian", "radian"], |rad| rad);
        spoil(made.f64s("lat"));
        let error = open_error(&made);
        assert_eq!(error.kind(), ErrorKind::Grid);
        error.to_string()
    };
    let nan = message(|lat| lat[7] = f64::NAN);
    assert!(nan.contains("made.nc: lon and lat: center[7]") && nan.contains("NaN"), "{nan}");
    let line = message(|lat| lat.fill(0.0));
    assert!(line.contains("the 162 points span no area"), "{line}");
}

/// A field of 7 rows of 12 whose values identify row, column and layer.
fn rows(is_curvilinear: bool, is_level_last: bool) -> Made {
    let mut made = Made::of([("time", 1), ("lev", 3), ("y", 7), ("x", 12)], []);
    let [lon, lat] = [|i: usize| 30.0 * (i % 12) as f64, |i: usize| 25.0 * (i / 12) as f64 - 75.0];
    let (all, dimensions) = (0..84, ["y", "x"]);
    if is_curvilinear {
        made.add("nav_lon", &dimensions, Values::F64(all.clone().map(lon).collect()));
        made.add("nav_lat", &dimensions, Values::F64(all.map(lat).collect()));
    } else {
        made.add("lat", &["y"], Values::F64((0..7).map(|y| lat(12 * y)).collect()));
        made.add("lon", &["x"], Values::F64((0..12).map(lon).collect()));
    }
    let value = |column: usize, layer: usize| (100 * layer + column) as f32;
    let of_layer = |i: usize| if is_level_last { value(i / 3, i % 3) } else { value(i % 84, i / 84) };
    let order: &[&'static str] = if is_level_last { &["time", "y", "x", "lev"] } else { &["time", "lev", "y", "x"] };
    made.add("to", order, Values::F32((0..252).map(of_layer).collect()));
    made
}

#[test]
fn rows_and_columns_are_columns() {
    for (is_curvilinear, is_level_last) in [(true, false), (false, false), (true, true), (false, true)] {
        let file = open(&rows(is_curvilinear, is_level_last));
        assert_eq!((file.mesh().cells(), file.mesh().format()), (84, "points"));
        assert_eq!(file.mesh().grid().unwrap().void_triangles(), 0);
        let center = file.mesh().tables().center;
        let [lon, lat] = [center.lon_rad, center.lat_rad].map(|angle| angle.get(30).to_degrees().round());
        assert_eq!([lon, lat], [180.0, -25.0]);
        assert_eq!(file.fields().iter().map(|info| (info.name.as_str(), info.layers)).collect::<Vec<_>>(), [("to", 3)]);
        let field = file.read_layers("to", 0, 1..3).unwrap();
        assert_eq!(field.field().unwrap().value(83, 1), 283.0, "{is_curvilinear} {is_level_last}");
        assert_eq!(field.field().unwrap().value(0, 0), 100.0);
    }
}
