//! UGRID's files: polygons, triangles, marks for entries that are missing, and names in attributes.

use crate::made::{Made, Values, value};
use crate::memory::{open, open_error};
use icoray::{IcosahedralMesh, Location};
use icoray_dataset::Convention;

const LAYERS: usize = 3;

fn mesh() -> IcosahedralMesh {
    IcosahedralMesh::new(1).unwrap()
}

fn degrees(rad: &[f64]) -> Values {
    Values::F64(rad.iter().map(|angle| angle.to_degrees()).collect())
}

impl Made {
    /// A file as other tools write them: names are in the attributes of a variable, tables start at 1.
    fn ugrid(faces: usize, nodes: usize, row: usize, table: Vec<i32>) -> Self {
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
        made.add("height", &["height"], Values::F64(vec![0.0, 1e3, 5e3]));
        made.last().attributes = vec![("units", "m".into())];
        made
    }

    fn nodes(&mut self, [lon, lat]: [&[f64]; 2]) {
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
    let mesh = mesh();
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
        (file.mesh().convention(), grid.cells(), grid.triangles(), file.mesh().edges()),
        (Convention::Cf, 42, 80, 120)
    );
    assert_eq!(file.field_info("theta").unwrap().location, Location::Center);
    assert_eq!(file.field_info("vorticity").unwrap().location, Location::Corner);
    assert_eq!(file.read_field("theta", 0).unwrap().field().unwrap().value(41, 2), value(0, 41, 2));
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
    let mesh = mesh();
    let table = mesh.corner_cell.iter().map(|cell| cell + 1).collect();
    let mut made = Made::ugrid(80, mesh.cells(), 3, table);
    made.nodes([&mesh.lon_center_rad, &mesh.lat_center_rad]);
    made.field("ta", "nf", 80);
    let file = open(&made);
    assert_eq!((file.mesh().convention(), file.mesh().cells(), file.mesh().corners()), (Convention::Icon, 42, 80));
    let icon = open(&Made::icon_grid());
    let tables = |file: &icoray_dataset::Dataset| {
        let grid = file.mesh().grid().unwrap();
        (grid.cells(), grid.triangles(), file.mesh().edges())
    };
    assert_eq!(tables(&file), tables(&icon));
    assert_eq!(file.field_info("ta").unwrap().location, Location::Corner);
}

#[test]
fn a_node_that_is_not_there_is_named() {
    let mesh = mesh();
    let mut table: Vec<i32> = mesh.corner_cell.iter().map(|cell| cell + 1).collect();
    table[7] = 43;
    let mut made = Made::ugrid(80, mesh.cells(), 3, table);
    made.nodes([&mesh.lon_center_rad, &mesh.lat_center_rad]);
    let error = open_error(&made).to_string();
    assert!(error.contains("nodes_of_face of face 2 is 43, expected 1 to 42"), "{error}");
}
