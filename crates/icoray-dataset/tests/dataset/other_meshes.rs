//! Meshes of SCRIP, ESMF, HEALPix and FVCOM.

use crate::made::{Made, Values, value};
use crate::made_icon::Angles;
use crate::memory::{expect, open, open_error, opened, values};
use crate::ugrid::cube;
use icoray::{ErrorKind, IcosahedralMesh, Location};

/// Data over columns that have their numbers as values, without coordinates.
fn data(dimension: &'static str, columns: usize) -> Made {
    let mut made = Made { path: "data.nc", ..Made::of([(dimension, columns)], []) };
    made.add("t", &[dimension], Values::F64((0..columns).map(|column| value(0, column, 0)).collect()));
    made
}

/// Data over two rows of three columns, which have their numbers as values.
fn rows() -> Made {
    let mut rows = Made { path: "data.nc", ..Made::of([("lat", 2), ("lon", 3)], []) };
    rows.angles("lat", &["lat"], Angles::Degrees, &[0.05, 0.15]);
    rows.angles("lon", &["lon"], Angles::Degrees, &[0.05, 0.15, 0.25]);
    rows.add("t", &["lat", "lon"], Values::F64((0..6).map(f64::from).collect()));
    rows
}

/// Asserts that a file of a mesh has no field.
fn expect_no_fields(mesh: &Made) {
    let file = open(mesh);
    assert!(file.fields().is_empty(), "{:?}", file.fields());
    expect(&file.first_field().unwrap_err(), ErrorKind::Field, &["a mesh without a field"]);
}

/// SCRIP's file of cells with the corners in `table`, at `nodes`.
fn scrip(nodes: &[Vec<f64>; 2], table: &[i32], row: usize) -> Made {
    let mut made = Made::of([("grid_size", table.len() / row), ("grid_corners", row)], []);
    for (k, (center, corner)) in
        [("grid_center_lon", "grid_corner_lon"), ("grid_center_lat", "grid_corner_lat")].into_iter().enumerate()
    {
        let at: Vec<f64> = table.iter().map(|node| nodes[k][*node as usize]).collect();
        // Any place near the cell.
        made.angles(center, &["grid_size"], Angles::Degrees, &at.iter().copied().step_by(row).collect::<Vec<_>>());
        made.angles(corner, &["grid_size", "grid_corners"], Angles::Degrees, &at);
    }
    made
}

#[test]
fn cells_of_scrip_are_polygons() {
    let mesh = IcosahedralMesh::new(2).unwrap();
    // Rows of pentagons repeat a corner.
    let hexagons = scrip(&[mesh.lon_corner_rad, mesh.lat_corner_rad], &mesh.cell_corner, 6);
    let file = opened(&data("ncol", 162), &[&hexagons]).unwrap();
    assert!(file.mesh().format() != "points");
    assert_eq!((file.mesh().cells(), file.mesh().corners_in_file(), file.mesh().edges()), (162, 320, 480));
    assert_eq!(values(&file, "t", 0)(161, 0), value(0, 161, 0));
    expect_no_fields(&hexagons);
    // A masked cell without a polygon: the places of all cells are there still.
    let mut masked = hexagons;
    ["grid_corner_lon", "grid_corner_lat"].iter().for_each(|name| masked.f64s(name)[42..48].fill(0.0));
    let file = opened(&data("ncol", 162), &[&masked]).unwrap();
    assert_eq!((file.mesh().cells(), file.mesh().format()), (162, "points"));
    let triangles = scrip(&[mesh.lon_center_rad, mesh.lat_center_rad], &mesh.corner_cell, 3);
    let file = opened(&data("ncol", 320), &[&triangles]).unwrap();
    assert_eq!((file.mesh().cells(), file.mesh().corners_in_file()), (320, 162));
    // Rows and columns of a region, whose data have its sides as dimensions.
    let node = |i: usize| [0.1 * (i % 4) as f64, 0.1 * (i / 4) as f64];
    let nodes = [0, 1].map(|k| (0..12).map(|i| node(i)[k]).collect());
    let table: Vec<i32> = [0, 1, 2, 4, 5, 6].iter().flat_map(|i| [*i, i + 1, i + 5, i + 4]).collect();
    let file = opened(&rows(), &[&scrip(&nodes, &table, 4)]).unwrap();
    assert_eq!((file.mesh().cells(), file.mesh().corners_in_file(), file.mesh().format()), (6, 12, "polygons"));
    assert_eq!(values(&file, "t", 0)(4, 0), 4.0);
}

/// ESMF's file of the squares of a cube, as a table with a further column or with all nodes behind each other.
fn esmf(is_ragged: bool) -> Made {
    let ([lon, lat], faces) = cube(3);
    let count = faces.len() / 4;
    let mut made = Made::of(
        [("nodeCount", lon.len()), ("elementCount", count), ("all", 4 * count), ("row", 5), ("coordDim", 2)],
        [],
    );
    let pairs: Vec<f64> = lon.into_iter().zip(lat).flat_map(|(lon, lat)| [lon, lat]).collect();
    made.angles("nodeCoords", &["nodeCount", "coordDim"], Angles::Degrees, &pairs);
    made.add("numElementConn", &["elementCount"], Values::I32(vec![4; count]));
    let rows = faces.chunks(4).flat_map(|face| face.iter().map(|node| node + 1).chain((!is_ragged).then_some(-1)));
    let dimensions: &[&str] = if is_ragged { &["all"] } else { &["elementCount", "row"] };
    made.add("elementConn", dimensions, Values::I32(rows.collect()));
    made
}

#[test]
fn elements_of_esmf_are_polygons() {
    for is_ragged in [false, true] {
        let mesh = esmf(is_ragged);
        for (columns, corners) in [(54, 56), (56, 54)] {
            let file = opened(&data("ncol", columns), &[&mesh]).unwrap();
            assert_eq!(
                (file.mesh().cells(), file.mesh().corners_in_file()),
                (columns, corners),
                "at faces or at nodes"
            );
            assert_eq!(file.mesh().grid().unwrap().void_triangles(), 0);
            assert_eq!(file.field_info("t").unwrap().location, Location::Center);
        }
        let mut middles = mesh.clone();
        middles.angles("centerCoords", &["elementCount", "coordDim"], Angles::Degrees, &[0.0; 108]);
        expect_no_fields(&middles);
        middles.dimensions.push(("few", 7));
        middles.variable("centerCoords").dimensions[0] = "few";
        middles.f64s("centerCoords").truncate(14);
        let error = opened(&data("ncol", 54), &[&middles]).unwrap_err();
        expect(&error, ErrorKind::Grid, &["elementConn: 7 middles of faces, expected 54, one per face"]);
        // Data of another grid.
        let file = opened(&rows(), &[&mesh]).unwrap();
        assert_eq!((file.mesh().cells(), file.mesh().format()), (6, "points"));
        let mut spoilt = mesh.clone();
        spoilt.i32s("elementConn")[2] = 57;
        let error = opened(&data("ncol", 54), &[&spoilt]).unwrap_err();
        expect(&error, ErrorKind::Grid, &["made.nc: elementConn: node 57 of element 0, expected 1 to 56"]);
        for (element, count) in [(53, 6), (0, i32::MAX)] {
            let mut short = mesh.clone();
            short.i32s("numElementConn")[element] = count;
            let error = opened(&data("ncol", 54), &[&short]).unwrap_err();
            expect(
                &error,
                ErrorKind::Grid,
                &[&format!("element {element} has {count} nodes by numElementConn, expected at most")],
            );
        }
    }
}

#[test]
fn corners_of_four_cells_of_mpas_are_cut() {
    let ([lon, lat], faces) = cube(3);
    let file = opened(&data("ncol", 54), &[&esmf(false)]).unwrap();
    let mut made = Made::of([("nCells", 54), ("nVertices", 56), ("maxEdges", 4)], []);
    made.add("verticesOnCell", &["nCells", "maxEdges"], Values::I32(faces.iter().map(|node| node + 1).collect()));
    let center = file.mesh().tables().center;
    for (name, angle) in [("lonCell", center.lon_rad), ("latCell", center.lat_rad)] {
        made.add(name, &["nCells"], Values::F64((0..54).map(|cell| angle.get(cell)).collect()));
    }
    for (name, angles) in [("lonVertex", &lon), ("latVertex", &lat), ("vorticity", &lon)] {
        made.add(name, &["nVertices"], Values::F64(angles.clone()));
    }
    let cut = open(&made);
    assert_eq!((cut.mesh().corners_in_file(), cut.mesh().grid().unwrap().void_triangles()), (56, 0));
    assert_eq!(cut.read_field("vorticity", 0).unwrap().field().unwrap().shape().columns, cut.mesh().corners());
}

/// Data over HEALPix's pixels of 4 × 4 in each of 12, or over the first `columns` of them.
fn healpix(columns: usize, attributes: Vec<(&'static str, Values)>) -> Made {
    let mut made = data("cell", columns);
    made.variable("t").attributes = vec![("grid_mapping", "crs".into())];
    made.add("crs", &[], Values::I32(vec![0]));
    made.last().attributes = [vec![("grid_mapping_name", "healpix".into())], attributes].concat();
    made
}

#[test]
fn pixels_of_healpix_are_columns() {
    let new = vec![("refinement_level", 2.into()), ("indexing_scheme", "nested".into())];
    let file = open(&healpix(192, new.clone()));
    assert_eq!(file.mesh().format(), "points");
    let center = file.mesh().tables().center;
    let at = [center.lon_rad.get(3), center.lat_rad.get(3)].map(f64::to_degrees);
    assert!((at[0] - 45.0).abs() < 1e-9 && (at[1] - 30.0).abs() < 1e-9, "{at:?}");
    assert_eq!(values(&file, "t", 0)(191, 0), value(0, 191, 0));
    let ring = open(&healpix(192, vec![("healpix_nside", 4.into()), ("healpix_order", "ring".into())]));
    assert!((ring.mesh().tables().center.lat_rad.get(3).to_degrees() - 78.284147605).abs() < 1e-8);
    // A part, with the numbers of its pixels.
    let mut part = healpix(48, new);
    part.add("cell", &["cell"], Values::I32((0..48).map(|i| 191 - i).collect()));
    let file = open(&part);
    assert_eq!((file.mesh().cells(), file.fields().len()), (48, 1));
    assert!(file.mesh().tables().center.lat_rad.get(0) < 0.0 && file.mesh().grid().unwrap().void_triangles() > 0);
    part.i32s("cell")[7] = 192;
    expect(&open_error(&part), ErrorKind::Grid, &["data.nc: crs: pixel 192 of column 7, expected 0 to 191"]);
    let other = healpix(48, vec![("healpix_nside", 3.into()), ("healpix_order", "NEST".into())]);
    expect(&open_error(&other), ErrorKind::Grid, &["crs: expected refinement_level", "a power of two"]);
    let no_order = healpix(48, vec![("healpix_nside", 2.into())]);
    expect(
        &open_error(&no_order),
        ErrorKind::Grid,
        &["indexing_scheme or healpix_order \"\", expected nested or ring"],
    );
    let nestling = healpix(48, vec![("healpix_nside", 2.into()), ("healpix_order", "nestling".into())]);
    expect(&open_error(&nestling), ErrorKind::Grid, &["\"nestling\", expected nested or ring"]);
    let thirds = open(&healpix(108, vec![("healpix_nside", 3.into()), ("healpix_order", "ring".into())]));
    assert!((thirds.mesh().tables().center.lat_rad.get(0).sin() - 26.0 / 27.0).abs() < 1e-12);
    assert_eq!(thirds.mesh().grid().unwrap().void_triangles(), 0);
    // Values that were never written.
    for level in [24, 14] {
        let mut huge = healpix(0, vec![("refinement_level", level.into()), ("indexing_scheme", "nested".into())]);
        huge.dimensions[0].1 = 12 << (2 * level);
        expect(&open_error(&huge), ErrorKind::Grid, &["pixels of the whole sphere, expected at most 357913941"]);
    }
    // Coordinates of any numbering.
    let mut places = healpix(12, vec![("indexing_scheme", "nuniq".into())]);
    let place = |k: usize| (0..12).map(|i| [0.5 * (i % 4) as f64, 0.5 * (i / 4) as f64][k]).collect::<Vec<_>>();
    places.angles("lon", &["cell"], Angles::Degrees, &place(0));
    places.angles("lat", &["cell"], Angles::Degrees, &place(1));
    assert_eq!(open(&places).mesh().tables().center.lat_rad.get(4), 0.5);
}

#[test]
fn layers_of_fvcom_lie_between_the_floor_and_the_sea_surface() {
    let mesh = IcosahedralMesh::new(1).unwrap();
    let dimensions = [("node", 42), ("nele", 80), ("three", 3), ("siglay", 2), ("siglev", 3), ("time", 0)];
    let mut made = Made::of(dimensions, []);
    made.angles("lon", &["node"], Angles::Degrees, &mesh.lon_center_rad);
    made.angles("lat", &["node"], Angles::Degrees, &mesh.lat_center_rad);
    let by_place = (0..240).map(|i| mesh.corner_cell[3 * (i % 80) + i / 80] + 1);
    made.add("nv", &["three", "nele"], Values::I32(by_place.collect()));
    let sigma = [0.0, -0.25, -1.0].into_iter().flat_map(|sigma| [sigma; 42]);
    made.add("siglev", &["siglev", "node"], Values::F64(sigma.collect()));
    made.add("siglay", &["siglay", "node"], Values::F64([[-0.125; 42], [-0.625; 42]].concat()));
    made.add("h", &["node"], Values::F64((0..42).map(|node| 100.0 + 10.0 * f64::from(node % 2)).collect()));
    made.add("zeta", &["time", "node"], Values::F64([[2.0; 42], [3.0; 42]].concat()));
    made.add("temp", &["time", "siglay", "node"], Values::F64(vec![1.0; 168]));
    made.add("u", &["time", "siglay", "nele"], Values::F64(vec![1.0; 320]));
    let file = open(&made);
    let grid = file.mesh().grid().unwrap();
    let location = |name: &str| file.field_info(name).unwrap().location;
    assert_eq!([location("temp"), location("u")], [Location::Center, Location::Corner]);
    assert_eq!(file.first_field().unwrap().name, "temp");
    for name in ["temp", "u"] {
        let heights = file.layer_heights(name).unwrap();
        assert_eq!((heights.height_m, heights.deviation_m), (vec![2.0, 2.0 - 0.25 * 107.0, -105.0], Some(5.0)));
        let native = file.native_heights(&grid, name, 1).unwrap().unwrap();
        let all = native.all().unwrap();
        assert_eq!([0, 1, 2].map(|layer| all.value(1, layer)), [3.0, 3.0 - 0.25 * 113.0, -110.0], "{name}");
    }
    assert!(file.native_info("temp").unwrap().time_dependent);
    let mut empty = made.clone();
    empty.dimensions.push(("Time", 0));
    empty.variable("siglev").dimensions.insert(0, "Time");
    empty.f64s("siglev").clear();
    let error = open(&empty).layer_heights("temp").unwrap_err();
    expect(&error, ErrorKind::Grid, &["siglev(Time = 0, siglev = 3, node = 42) of double has no record"]);
    made.remove("h");
    expect(&open(&made).layer_heights("temp").unwrap_err(), ErrorKind::Layers, &["siglev", "variable h is missing"]);
}
