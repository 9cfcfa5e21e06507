//! Real files, if the test data are present.

use crate::made::{Made, Values};
use crate::memory::{direction_of, expect};
use icoray::{ComputedField, ErrorKind, Location};
use icoray_dataset::Kind;
use icoray_test_support::data_file;
use netcdf::Options;

#[test]
fn jablonowski_williamson_wave() {
    let Some(path) = data_file("mpas_jw_10242.nc") else { return };
    let file = icoray_netcdf::open(path).unwrap();
    let grid = file.mesh().grid().unwrap();
    assert_eq!((grid.cells(), grid.triangles(), file.mesh().edges()), (10242, 20480, 30720));
    assert_eq!(file.sphere_radius_m(), 6_371_229.0);
    let times: Vec<&str> = file.times().iter().flatten().map(String::as_str).collect();
    assert_eq!(times, ["0000-01-01_00:00:00", "0000-01-07_00:00:00", "0000-01-10_00:00:00"]);

    let heights = file.layer_heights("theta").unwrap();
    assert_eq!((heights.variable.as_str(), heights.layers.count()), ("zgrid", 27));
    assert!(heights.height_m[26] > 20_000.0 && heights.height_m[26] < 60_000.0, "{heights:?}");
    // Columns differ by some hundred metres.
    let native = file.native_heights(&grid, "theta", 2).unwrap().unwrap();
    let own = native.over(file.field_info("theta").unwrap(), 0..26).unwrap();
    assert_eq!((own.shape().columns, own.shape().layers), (10242, 27));
    let mut off = 0.0f64;
    for cell in 0..10242 {
        let column: Vec<f64> = (0..27).map(|layer| own.value(cell, layer)).collect();
        assert!(column.windows(2).all(|pair| pair[0] < pair[1]), "cell {cell}: {column:?}");
        off = column.iter().zip(&heights.height_m).fold(off, |off, (own, mean)| off.max((own - mean).abs()));
    }
    assert!(off > 300.0 && (off - heights.deviation_m.unwrap()).abs() < 1e-9, "{off} {:?}", heights.deviation_m);

    let of = |name: &str| {
        let info = file.field_info(name).unwrap();
        (info.location, info.layers, info.precision, info.time_dependent)
    };
    assert_eq!(of("theta"), (Location::Center, 26, Kind::F32, true));
    assert_eq!(of("w"), (Location::Center, 27, Kind::F32, true));
    assert_eq!(of("vorticity"), (Location::Corner, 26, Kind::F32, true));
    for info in file.fields().iter().filter(|info| !info.is_2d()) {
        heights.layers.for_field(info.layers).unwrap();
    }

    // A stable atmosphere: potential temperature rises in every column.
    let theta = file.read_field("theta", 2).unwrap();
    let theta = theta.field().unwrap();
    for cell in (0..grid.cells()).step_by(97) {
        assert!((1..26).all(|layer| theta.value(cell, layer) > theta.value(cell, layer - 1)), "cell {cell}");
    }
    // The wave grows, so the records differ.
    let fastest = |time| {
        let w = file.read_field("w", time).unwrap();
        let ([low, high], missing) = (w.field().unwrap().range().0.unwrap(), w.field().unwrap().range().1);
        assert_eq!(missing, 0);
        high.max(-low)
    };
    assert!(fastest(2) > 2.0 * fastest(0), "{} {}", fastest(2), fastest(0));
    let vorticity = file.read_field("vorticity", 1).unwrap();
    let center = ComputedField::average(&grid, &vorticity.field().unwrap()).unwrap();
    assert_eq!(center.field().range().1, 0);
}

#[test]
fn a_bare_mesh_on_the_unit_sphere() {
    let Some(path) = data_file("mesh.QU.1920km.151026.nc") else { return };
    let file = icoray_netcdf::open(path).unwrap();
    assert_eq!(file.mesh().grid().unwrap().cells(), 162);
    assert_eq!((file.sphere_radius_m(), file.times()), (1.0, &[None][..]));
    // Areas and qualities of the mesh are fields, but none that is likely to be meant.
    assert!(file.fields().iter().all(icoray_dataset::FieldInfo::is_2d) && file.likely_fields().is_empty());
    expect(&file.layers("theta").unwrap_err(), ErrorKind::Field, &["fields in the file: areaCell"]);
}

/// An ocean without land, as MPAS-Tools cull it: 0 for cells in cellsOnVertex and for edges in edgesOnVertex.
#[test]
fn an_ocean_has_holes() {
    let Some(path) = data_file("spherical_grid_500km_landculled.nc") else { return };
    let file = icoray_netcdf::open(path).unwrap();
    let grid = file.mesh().grid().unwrap();
    assert_eq!((grid.cells(), grid.triangles(), file.mesh().tables().cell_corner_row), (1735, 3924, 8));
    let there = (0..3924).filter(|&corner| grid.is_triangle(corner)).count();
    assert_eq!(there, 3924 - 933);
    assert!((300..2000).contains(&grid.void_triangles()), "{}", grid.void_triangles());
    for cell in 0..1735 {
        for corner in grid.triangles_around(cell) {
            assert!(grid.triangle(corner).contains(&cell));
        }
    }
}

/// Without the tables of corners and edges the ocean has the same triangles.
#[test]
fn a_part_of_the_oceans_tables_is_enough() {
    let Some(path) = data_file("spherical_grid_500km_landculled.nc") else { return };
    let file = icoray_netcdf::open(path).unwrap();
    let tables = file.mesh().tables();
    let mut made = Made::of(
        [("nCells", tables.cells()), ("nVertices", tables.corners()), ("maxEdges", 8)],
        [("sphere_radius", 1.0.into())],
    );
    let angles = |reals: icoray::Reals| Values::F64((0..reals.len()).map(|i| reals.get(i)).collect());
    let index = |indices: icoray::Indices| Values::I32(indices.iter().map(|i| i as i32).collect());
    made.add("lonCell", &["nCells"], angles(tables.center.lon_rad));
    made.add("latCell", &["nCells"], angles(tables.center.lat_rad));
    made.add("lonVertex", &["nVertices"], angles(tables.corner.lon_rad));
    made.add("latVertex", &["nVertices"], angles(tables.corner.lat_rad));
    made.add("nEdgesOnCell", &["nCells"], index(tables.cell_corner_count.unwrap()));
    made.add("verticesOnCell", &["nCells", "maxEdges"], index(tables.cell_corner));
    let (_folder, path) = made.write(Options::NETCDF4);
    let part = icoray_netcdf::open(&path).unwrap();
    let (grid, expected) = (part.mesh().grid().unwrap(), file.mesh().grid().unwrap());
    assert_eq!(grid.void_triangles(), expected.void_triangles());
    for corner in 0..3924 {
        assert_eq!(grid.is_triangle(corner), expected.is_triangle(corner), "{corner}");
        if expected.is_triangle(corner) {
            let [found, known] = [&grid, &expected].map(|grid| {
                let mut cells = grid.triangle(corner);
                cells.sort_unstable();
                cells
            });
            assert_eq!(found, known, "{corner}");
        }
    }
}

/// ICON without tables: the points of triangles are matched, also where bounds differ in the last digits and at the
/// poles.
#[test]
fn triangles_of_icon_are_rebuilt_from_their_bounds() {
    let Some(path) = data_file("psyplot_icon_test.nc") else { return };
    let file = icoray_netcdf::open(path).unwrap();
    let grid = file.mesh().grid().unwrap();
    assert_eq!((grid.cells(), grid.triangles(), file.mesh().edges()), (2562, 5120, 7680));
    assert_eq!((grid.void_triangles(), file.mesh().tables().cell_corner_row), (0, 6));
    // The file's own centres lie in the middle of the triangles that were found, whose sides are 0.06 to 0.08.
    let tables = file.mesh().tables();
    for triangle in 0..5120 {
        let points = grid.triangle(triangle).map(|cell| direction_of(tables.center, cell as usize));
        let centre = direction_of(tables.corner, triangle as usize);
        let off: f64 = (0..3).map(|k| (points.iter().map(|p| p[k]).sum::<f64>() / 3.0 - centre[k]).powi(2)).sum();
        assert!(off.sqrt() < 1e-2, "{triangle}: {}", off.sqrt());
    }
    let dates: Vec<&str> = file.times().iter().flatten().map(String::as_str).collect();
    assert_eq!(dates, ["1979-01-31_18:00:00", "1979-02-28_18:00:00"]);
    let heights = file.layer_heights("t2m").unwrap();
    assert!(heights.is_of_pressure && (heights.height_m[0] - 110.9).abs() < 0.1, "{heights:?}");
    // Averages keep the mean, and the cold is in the north of Asia in January.
    let owned = file.read_field("t2m", 0).unwrap();
    let at_corners = owned.field().unwrap();
    assert_eq!((at_corners.location(), at_corners.shape().layers), (Location::Corner, 2));
    let center = ComputedField::average(&grid, &at_corners).unwrap();
    let field = center.field();
    let coldest = (0..2562).min_by(|&a, &b| field.value(a, 0).total_cmp(&field.value(b, 0))).unwrap();
    let (lon, lat) = (tables.center.lon_rad.get(coldest).to_degrees(), tables.center.lat_rad.get(coldest).to_degrees());
    assert!(lat > 55.0 && lon.rem_euclid(360.0) > 60.0, "{lon} {lat}");
    let mean = |field: &icoray::Field| {
        (0..field.shape().columns).map(|c| field.value(c, 1)).sum::<f64>() / field.shape().columns as f64
    };
    assert!((mean(&field) - mean(&at_corners)).abs() < 0.2);
}

#[test]
fn meshes_that_are_not_rendered_are_refused() {
    let Some(path) = data_file("favba_planar_mesh.nc") else { return };
    expect(&icoray_netcdf::open(path).unwrap_err(), ErrorKind::Unsupported, &["on_a_sphere is NO"]);
}
