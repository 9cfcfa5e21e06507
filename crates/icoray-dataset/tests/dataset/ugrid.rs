//! UGRID's files: polygons, triangles, marks for entries that are missing, and names in attributes.

use crate::made::{Made, Values, value};
use crate::memory::{names, open, open_error, opened, values};
use icoray::{ColumnCount, IcosahedralMesh, Location};
use icoray_dataset::MeshLayout;
use std::collections::HashMap;
use std::f64::consts::FRAC_PI_4;

const LAYERS: usize = 3;

fn degrees(rad: &[f64]) -> Values {
    Values::F64(rad.iter().map(|angle| angle.to_degrees()).collect())
}

impl Made {
    /// A file as other tools write them: names are in the attributes of a variable, tables start at 1.
    pub fn ugrid(faces: usize, nodes: usize, row: usize, table: Vec<i32>) -> Self {
        let mut made = Made::of([("nf", faces), ("nn", nodes), ("row", row), ("height", LAYERS)], []);
        made.add("Mesh2", &[], Values::I32(vec![0]));
        made.last().attributes = vec![
            ("cf_role", "mesh_topology".into()),
            ("topology_dimension", 2.into()),
            ("node_coordinates", "lat_of_node lon_of_node".into()),
            ("face_node_connectivity", "nodes_of_face".into()),
        ];
        made.add("nodes_of_face", &["nf", "row"], Values::I32(table));
        made.last().attributes = vec![("start_index", 1.into()), ("_FillValue", (-999).into())];
        made.add("height", &["height"], Values::F64(vec![0.0, 1e3, 5e3])).attributes = vec![("units", "m".into())];
        made
    }

    /// The triangles of an icosahedral mesh and their nodes.
    pub fn ugrid_triangles() -> Self {
        let mesh = IcosahedralMesh::new(1).unwrap();
        let mut made = Made::ugrid(80, 42, 3, mesh.corner_cell.iter().map(|cell| cell + 1).collect());
        made.nodes([&mesh.lon_center_rad, &mesh.lat_center_rad]);
        made
    }

    pub fn nodes(&mut self, [lon, lat]: [&[f64]; 2]) {
        for (name, rad, standard) in [("lon_of_node", lon, "longitude"), ("lat_of_node", lat, "latitude")] {
            self.add(name, &["nn"], degrees(rad));
            self.last().attributes = vec![("standard_name", standard.into()), ("units", "degrees".into())];
        }
    }

    fn field(&mut self, name: &'static str, dimension: &'static str, columns: usize) {
        let of_layer = |layer| (0..columns).map(move |column| value(0, column, layer));
        let values = (0..LAYERS).flat_map(of_layer).collect();
        self.add(name, &["height", dimension], Values::F64(values));
    }
}

#[test]
fn polygons_are_cells_and_nodes_are_corners() {
    let mesh = IcosahedralMesh::new(1).unwrap();
    // Rows of pentagons repeat a corner.
    let row = |row: &[i32]| {
        let number = |k: usize| if row[..k].contains(&row[k]) { -999 } else { row[k] + 1 };
        (0..6).map(number).collect::<Vec<_>>()
    };
    let table = mesh.cell_corner.chunks_exact(6).flat_map(row).collect();
    let mut made = Made::ugrid(mesh.cells(), mesh.lon_corner_rad.len(), 6, table);
    made.nodes([&mesh.lon_corner_rad, &mesh.lat_corner_rad]);
    made.field("theta", "nf", mesh.cells());
    made.field("vorticity", "nn", mesh.lon_corner_rad.len());
    let file = open(&made);
    let grid = file.mesh().grid().unwrap();
    assert_eq!(
        (file.mesh().layout(), grid.cells(), grid.triangles(), file.mesh().edges()),
        (MeshLayout::Polygons, 42, 80, 120)
    );
    assert_eq!(file.field_info("theta").unwrap().location, Location::Center);
    assert_eq!(file.field_info("vorticity").unwrap().location, Location::Corner);
    assert_eq!(values(&file, "theta", 0)(41, 2), value(0, 41, 2));
    assert_eq!(file.layer_heights("theta").unwrap().height_m, [0.0, 1e3, 5e3]);
    let center = file.mesh().tables().center;
    for cell in 0..grid.cells() {
        let [lon, lat] = [mesh.lon_center_rad[cell], mesh.lat_center_rad[cell]];
        let [its_lon, its_lat] = [center.lon_rad.get(cell), center.lat_rad.get(cell)];
        let cosine = lat.sin() * its_lat.sin() + lat.cos() * its_lat.cos() * (lon - its_lon).cos();
        assert!(cosine > 0.999, "cell {cell}: {its_lon} {its_lat}, expected {lon} {lat}");
    }
}

#[test]
fn triangles_are_corners_and_nodes_are_cells() {
    let mut made = Made::ugrid_triangles();
    made.field("ta", "nf", 80);
    let file = open(&made);
    assert_eq!((file.mesh().layout(), file.mesh().cells(), file.mesh().corners()), (MeshLayout::Triangles, 42, 80));
    let icon = open(&Made::icon_grid());
    let words = "UGRID: 42 cells, 80 corners, 120 edges; corners are the triangles of the file, cells its points";
    assert_eq!(file.mesh().in_words(), words);
    assert_eq!(icon.mesh().format(), "ICON");
    let tables = |file: &icoray_dataset::Dataset| {
        let grid = file.mesh().grid().unwrap();
        (grid.cells(), grid.triangles(), file.mesh().edges())
    };
    assert_eq!(tables(&file), tables(&icon));
    assert_eq!(file.field_info("ta").unwrap().location, Location::Corner);
}

#[test]
fn a_node_that_is_not_there_is_named() {
    let mut made = Made::ugrid_triangles();
    made.i32s("nodes_of_face")[7] = 43;
    let error = open_error(&made).to_string();
    assert!(error.contains("nodes_of_face of face 2 is 43, expected 1 to 42"), "{error}");
}

/// A cube whose sides have `n` × `n` squares: nodes as longitude and latitude, and rows of 4 nodes.
pub fn cube(n: i32) -> ([Vec<f64>; 2], Vec<i32>) {
    let mut known = HashMap::new();
    let mut places = [Vec::new(), Vec::new()];
    let mut node = |p: [i32; 3]| {
        *known.entry(p).or_insert_with(|| {
            let [x, y, z] = p.map(|k| (f64::from(k) / f64::from(n) * FRAC_PI_4).tan());
            places[0].push(y.atan2(x));
            places[1].push(z.atan2(x.hypot(y)));
            places[0].len() as i32 - 1
        })
    };
    let mut faces = Vec::new();
    for (axis, sign) in (0..3).flat_map(|axis| [(axis, -n), (axis, n)]) {
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            for [a, b] in [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]] {
                let mut p = [0; 3];
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (sign, 2 * a - n, 2 * b - n);
                faces.push(node(p));
            }
        }
    }
    (places, faces)
}

/// Each corner joins four squares, or three at the cube's corners. The fields' values are sines of latitudes.
#[test]
fn squares_are_cells_or_their_nodes_are() {
    let ([lon, lat], faces) = cube(6);
    let (count, nodes) = (faces.len() / 4, lon.len());
    let z: Vec<f64> = lat.iter().map(|lat| lat.sin()).collect();
    let made = |fields: &[(&'static str, &'static str)]| {
        let mut made = Made::ugrid(count, nodes, 4, faces.iter().map(|node| node + 1).collect());
        made.nodes([&lon, &lat]);
        for &(name, dimension) in fields {
            let mean = |face: &[i32]| face.iter().map(|node| z[*node as usize]).sum::<f64>() / 4.0;
            let values = if dimension == "nn" { z.clone() } else { faces.chunks_exact(4).map(mean).collect() };
            made.add(name, &[dimension], Values::F64(values));
        }
        open(&made)
    };
    for (fields, cells, locations) in [
        (&[("at_faces", "nf")][..], count, &[Location::Center][..]),
        (&[("at_nodes", "nn")], nodes, &[Location::Center]),
        (&[("at_faces", "nf"), ("at_nodes", "nn")], count, &[Location::Center, Location::Corner]),
    ] {
        let file = made(fields);
        let grid = file.mesh().grid().unwrap();
        assert_eq!((grid.cells(), grid.void_triangles(), grid.triangles()), (cells, 0, 2 * (cells - 2)), "{fields:?}");
        assert!(file.mesh().in_words().contains("corners are triangles"), "{}", file.mesh().in_words());
        for ((name, _), location) in fields.iter().zip(locations) {
            let field = file.read_field(name, 0).unwrap();
            let field = field.field().unwrap();
            assert_eq!(
                (field.location(), field.shape().columns),
                (*location, ColumnCount::new(&grid, *location).columns)
            );
            let tables = file.mesh().tables();
            let at = if *location == Location::Center { tables.center } else { tables.corner };
            for column in 0..field.shape().columns {
                assert!((field.value(column, 0) - at.lat_rad.get(column).sin()).abs() < 0.03, "{name} at {column}");
            }
        }
    }
}

/// The same file in the other order, from 0 or 1, with the attributes that declare both and without.
#[test]
fn tables_may_be_transposed_and_count_from_0_or_1() {
    let mesh = IcosahedralMesh::new(1).unwrap();
    let corner_cells = |base: i32, is_transposed: bool| -> Vec<i32> {
        let at = |i: usize| mesh.corner_cell[if is_transposed { 3 * (i % 80) + i / 80 } else { i }] + base;
        (0..240).map(at).collect()
    };
    for (base, is_transposed, is_declared) in
        [(0, true, true), (1, true, false), (1, false, false), (0, false, false), (0, true, false)]
    {
        let mut made = Made::ugrid_triangles();
        *made.i32s("nodes_of_face") = corner_cells(base, is_transposed);
        let table = made.variable("nodes_of_face");
        table.attributes = if is_declared { vec![("start_index", base.into())] } else { Vec::new() };
        table.dimensions = if is_transposed { vec!["row", "nf"] } else { vec!["nf", "row"] };
        if is_declared {
            made.variable("Mesh2").attributes.push(("face_dimension", "nf".into()));
        }
        let file = open(&made);
        let read = file.mesh().tables().corner_cell.iter().map(|cell| cell as i32).collect::<Vec<_>>();
        assert_eq!(read, mesh.corner_cell, "from {base}, transposed: {is_transposed}, declared: {is_declared}");
    }
}

#[test]
fn coordinates_are_no_fields_and_the_topology_goes_before_names() {
    let (mesh, mut made) = (IcosahedralMesh::new(1).unwrap(), Made::ugrid_triangles());
    made.add("middle_x", &["nf"], degrees(&mesh.lon_corner_rad));
    made.add("middle_y", &["nf"], degrees(&mesh.lat_corner_rad));
    made.variable("Mesh2").attributes.push(("face_coordinates", "middle_x middle_y".into()));
    made.add("depth", &["nn"], Values::F64(vec![1.0; 42]));
    // A name that uxarray gives, as the table of a mesh with other coordinates has it.
    made.variable("Mesh2").attributes[3].1 = "face_node_connectivity".into();
    made.variable("nodes_of_face").name = "face_node_connectivity";
    // A mesh of fewer variables: edges between two nodes of a river.
    made.add("river", &[], Values::I32(vec![0]));
    made.last().attributes = vec![
        ("cf_role", "mesh_topology".into()),
        ("node_coordinates", "lat_of_node lon_of_node".into()),
        ("face_node_connectivity", "river_faces".into()),
    ];
    made.add("river_faces", &["row", "row"], Values::I32(vec![1; 9]));
    made.variable("depth").attributes = vec![("mesh", "Mesh2".into())];
    let file = open(&made);
    assert_eq!(names(&file), ["depth"]);
    assert_eq!((file.mesh().cells(), file.mesh().corners()), (42, 80));
    // Values at edges, of which the file has no table.
    made.dimensions.push(("edges", 120));
    made.add("flow", &["edges"], Values::F64(vec![1.0; 120]));
    let error = open(&made).field_info("flow").unwrap_err().to_string();
    assert!(error.contains("flow(edges = 120)") && !error.contains("adjacent_cell_of_edge"), "{error}");
}

/// A face of four nodes is two corners of the mesh whose cells are the nodes: heights at faces belong to both.
#[test]
fn heights_at_faces_that_are_cut_are_those_of_nodes() {
    let ([lon, lat], faces) = cube(4);
    let (count, nodes) = (faces.len() / 4, lon.len());
    let mut made = Made::ugrid(count, nodes, 4, faces.iter().map(|node| node + 1).collect());
    made.nodes([&lon, &lat]);
    made.dimensions.push(("lev", 3));
    let mut data = Made { path: "data.nc", ..Made::of([("lev", 3), ("nn", nodes)], []) };
    data.add("t", &["lev", "nn"], Values::F64(vec![1.0; 3 * nodes]));
    let height = |i: usize| [0.0, 1e3, 3e3][i / count] + if i / count == 0 { 0.0 } else { (i % count) as f64 };
    made.add("z_ifc", &["lev", "nf"], Values::F64((0..3 * count).map(height).collect()));
    let file = opened(&data, &[&made]).unwrap();
    assert_eq!((file.mesh().corners_in_file(), file.mesh().corners()), (count, 2 * count));
    let mean = 0.5 * (count - 1) as f64;
    assert_eq!(file.layer_heights("t").unwrap().height_m, [0.0, 1e3 + mean, 3e3 + mean]);
    let grid = file.mesh().grid().unwrap();
    let native = file.native_heights(&grid, "t", 0).unwrap().unwrap();
    let heights = native.all().unwrap();
    assert_eq!(heights.shape().columns, nodes);
    let highest = (0..nodes).map(|node| heights.value(node, 2) - 3e3);
    assert!(highest.clone().all(|above| (0.0..count as f64).contains(&above)), "{:?}", highest.collect::<Vec<_>>());
}
