//! Fields at edges, as values at the centres beside them.

use crate::made::{Made, Values};
use crate::memory::{direction, expect, open, open_error, opened, values};
use glam::DVec3;
use icoray::{ErrorKind, IcosahedralMesh, Location};
use icoray_dataset::Dataset;

/// Axis and speed of a rotation of the whole sphere.
const OMEGA: DVec3 = DVec3::new(3.0, -5.0, 7.0);
const LAYERS: usize = 3;
const EDGES: usize = 120;

/// The component of the rotation along a great circle from one place to another, which is the same on all of it.
fn normal_component([a, b]: [DVec3; 2]) -> f64 {
    OMEGA.dot(a.cross(b).normalize())
}

fn place([lon, lat]: [f64; 2]) -> DVec3 {
    direction(lon, lat).into()
}

/// The rotation at a place, eastward and northward.
fn rotation(lon: f64, lat: f64) -> [f64; 2] {
    let east = DVec3::new(-lon.sin(), lon.cos(), 0.0);
    let wind = OMEGA.cross(place([lon, lat]));
    [wind.dot(east), wind.dot(place([lon, lat]).cross(east))]
}

/// MPAS's cells beside each edge.
fn beside(made: &mut Made) -> Vec<[i32; 2]> {
    made.i32s("cellsOnEdge").as_chunks().0.iter().map(|pair| pair.map(|cell| cell - 1)).collect()
}

/// Adds the rotation on layers, each as much again as that below, as components normal to edges between centres.
fn add_rotation(made: &mut Made, name: &'static str, edge: &'static str, beside: &[[i32; 2]], at: [&[f64]; 2]) {
    let place = |centre: i32| place(at.map(|angles| angles[centre as usize]));
    let component = |edge: usize| normal_component(beside[edge].map(place));
    let values = (0..LAYERS).flat_map(|layer| (0..EDGES).map(move |edge| (layer + 1) as f64 * component(edge)));
    made.add(name, &["time", "lev", edge], Values::F64(values.collect()));
}

fn mpas() -> Made {
    let (mesh, mut made) = (IcosahedralMesh::new(1).unwrap(), Made::mesh(false));
    made.dimensions.extend([("time", 0), ("lev", LAYERS)]);
    let beside = beside(&mut made);
    add_rotation(&mut made, "u", "nEdges", &beside, [&mesh.lon_center_rad, &mesh.lat_center_rad]);
    made.add("rho_edge", &["time", "nEdges"], Values::F32((0..EDGES).map(|edge| edge as f32).collect()));
    made.add("v", &["time", "lev", "nEdges"], Values::F64(vec![0.0; LAYERS * EDGES]));
    made.add("dcEdge", &["nEdges"], Values::F64(vec![1.0; EDGES]));
    made.add("layerThickEdgeFlux", &["time", "nEdges"], Values::F64(vec![1.0; EDGES]));
    made.last().attributes = vec![("units", "m".into())];
    made.add("A_veloc_v", &["time", "nEdges"], Values::F64(vec![1.0; EDGES]));
    made
}

/// Asserts that the fields are the rotation at all places but those in `missing`.
fn expect_rotation(file: &Dataset, name: &str, at: [&[f64]; 2], missing: &[usize]) {
    for (part, ending) in ["zonal", "meridional"].into_iter().enumerate() {
        let owned = file.read_field(&format!("{name}_{ending}"), 0).unwrap();
        let field = owned.field().unwrap();
        assert_eq!((field.shape().columns, field.shape().layers), (at[0].len(), LAYERS));
        for (column, layer) in (0..at[0].len()).flat_map(|column| (0..LAYERS).map(move |layer| (column, layer))) {
            let expected = (layer + 1) as f64 * rotation(at[0][column], at[1][column])[part];
            let value = field.value(column, layer);
            let is_right = if missing.contains(&column) { value.is_nan() } else { (value - expected).abs() < 1e-9 };
            assert!(is_right, "{ending} of column {column}, layer {layer}: {value}, expected {expected}");
        }
    }
}

#[test]
fn components_normal_to_edges_are_vectors_at_cells() {
    let mesh = IcosahedralMesh::new(1).unwrap();
    let at: [&[f64]; 2] = [&mesh.lon_center_rad, &mesh.lat_center_rad];
    let mut made = mpas();
    let file = open(&made);
    let names: Vec<&str> = file.fields().iter().map(|info| info.name.as_str()).collect();
    assert_eq!(
        names,
        ["u_zonal", "u_meridional", "rho_edge", "layerThickEdgeFlux", "A_veloc_v"],
        "v lies along edges, dcEdge is of the mesh"
    );
    let info = file.field_info("u_zonal").unwrap();
    assert_eq!((info.location, info.columns, info.is_from_edges()), (Location::Center, 42, true));
    assert_eq!(info.description.long_name.as_deref(), Some("u, zonal component"));
    expect_rotation(&file, "u", at, &[]);
    let (density, beside) = (values(&file, "rho_edge", 0), beside(&mut made));
    for (cell, value) in (0..42).map(|cell| (cell, density(cell, 0))) {
        let own: Vec<f64> = (0..EDGES).filter(|e| beside[*e].contains(&(cell as i32))).map(|e| e as f64).collect();
        assert!((value - own.iter().sum::<f64>() / own.len() as f64).abs() < 1e-5, "cell {cell}: {value}");
    }
    expect(&file.field_info("u").unwrap_err(), ErrorKind::Field, &["at cells are u_zonal and u_meridional"]);
    expect(
        &file.field_info("v").unwrap_err(),
        ErrorKind::Field,
        &["v(time = 1, lev = 3, nEdges = 120)", "normal", "`at` picks"],
    );
    // All but one edge of cell 7 lack a value, or a neighbour; cell 8 lacks one edge alone.
    let of = |cell: i32| (0..EDGES).filter(|edge| beside[*edge].contains(&cell)).collect::<Vec<_>>();
    let away: Vec<usize> = of(7)[1..].iter().copied().chain([of(8)[0]]).collect();
    let mut rim = made.clone();
    for &edge in &away {
        (0..LAYERS).for_each(|layer| made.f64s("u")[layer * EDGES + edge] = f64::NAN);
        let other = beside[edge].iter().position(|cell| ![7, 8].contains(cell)).unwrap();
        rim.i32s("cellsOnEdge")[2 * edge + other] = [0, i32::MIN, 43][edge % 3];
    }
    expect_rotation(&open(&made), "u", at, &[7]);
    let mut empty = made.clone();
    empty.dimensions.push(("Time", 0));
    empty.variable("cellsOnEdge").dimensions.insert(0, "Time");
    empty.i32s("cellsOnEdge").clear();
    expect(&open_error(&empty), ErrorKind::Grid, &["cellsOnEdge(Time = 0, nEdges = 120, TWO = 2)", "has no record"]);
    expect_rotation(&open(&rim), "u", at, &[7]);
}

#[test]
fn components_normal_to_edges_of_triangles_are_vectors_at_triangles() {
    let mesh = IcosahedralMesh::new(1).unwrap();
    let at: [&[f64]; 2] = [&mesh.lon_corner_rad, &mesh.lat_corner_rad];
    let beside: Vec<[i32; 2]> = mesh.edge_corner.as_chunks().0.to_vec();
    let mut grid = Made { path: "grid.nc", ..Made::icon_grid() };
    grid.dimensions.extend([("edge", EDGES), ("nc", 2)]);
    let by_place = (0..2 * EDGES).map(|i| beside[i % EDGES][i / EDGES] + 1).collect();
    let mut data = Made::of([("edge", EDGES), ("cell", 80), ("lev", LAYERS), ("time", 0)], []);
    add_rotation(&mut data, "vn", "edge", &beside, at);
    data.last().attributes = vec![("long_name", "velocity normal to edge".into())];
    let error = opened(&data, &[&grid]).unwrap().field_info("vn").unwrap_err();
    let parts =
        ["vn(time = 1, lev = 3, edge = 120)", "adjacent_cell_of_edge", "is missing", "give that file as `mesh`"];
    expect(&error, ErrorKind::Field, &parts);
    grid.add("adjacent_cell_of_edge", &["nc", "edge"], Values::I32(by_place));
    let file = opened(&data, &[&grid]).unwrap();
    assert_eq!(file.field_info("vn_zonal").unwrap().location, Location::Corner);
    expect_rotation(&file, "vn", at, &[]);
    grid.i32s("adjacent_cell_of_edge")[5] = 82;
    let error = opened(&data, &[&grid]).unwrap().read_field("vn_zonal", 0).unwrap_err();
    expect(&error, ErrorKind::Grid, &["grid.nc: adjacent_cell_of_edge: cell 82 beside edge 6, expected 1 to 80"]);
}

/// A mesh of UGRID with a table of its edges: `beside` has the faces left and right of each, `ends` its nodes.
fn ugrid(table: &'static str, [nodes, faces]: [[&[f64]; 2]; 2], rows: &[i32], ends: &[i32]) -> Made {
    let table_from_1 = rows.iter().map(|node| node + 1).collect();
    let mut made = Made::ugrid(faces[0].len(), nodes[0].len(), rows.len() / faces[0].len(), table_from_1);
    made.nodes(nodes);
    made.dimensions.extend([("edge", EDGES), ("two", 2), ("time", 0), ("lev", LAYERS)]);
    let names = [("face_coordinates", "face_x face_y".into()), (table, "of_edges".into())];
    made.variable("Mesh2").attributes.extend(names);
    for (name, angles) in ["face_x", "face_y"].into_iter().zip(faces) {
        made.add(name, &["nf"], Values::F64(angles.to_vec())).attributes = vec![("units", "radians".into())];
    }
    made.add("of_edges", &["edge", "two"], Values::I32(ends.to_vec()));
    made
}

/// The ends of each edge, as seen from outside with the first place beside it on the left of the way between them.
fn ends_with_left(ends: &[i32], beside: &[[i32; 2]], [nodes, faces]: [[&[f64]; 2]; 2]) -> Vec<i32> {
    let place = |at: [&[f64]; 2], i: i32| place(at.map(|angles| angles[i as usize]));
    let turned = ends.as_chunks().0.iter().zip(beside).map(|([one, other], [left, _])| {
        let is_left = place(nodes, *one).cross(place(nodes, *other)).dot(place(faces, *left)) > 0.0;
        if is_left { [*one, *other] } else { [*other, *one] }
    });
    turned.flatten().collect()
}

/// Shifts the middles of faces by a fifth of the way to their first node, off the circles through both of an edge's;
/// returns the largest deviation of the zonal component from that of the rotation there.
fn with_middles_elsewhere(made: &mut Made, [nodes, faces]: [[&[f64]; 2]; 2], rows: &[i32]) -> f64 {
    let row = rows.len() / faces[0].len();
    let places = (0..faces[0].len()).map(|face| {
        let node = rows[face * row] as usize;
        let (from, to) = (place(faces.map(|angles| angles[face])), place(nodes.map(|angles| angles[node])));
        let DVec3 { x, y, z } = from.lerp(to, 0.2);
        [y.atan2(x), z.atan2(x.hypot(y))]
    });
    let places: Vec<[f64; 2]> = places.collect();
    for (k, name) in ["face_x", "face_y"].into_iter().enumerate() {
        *made.f64s(name) = places.iter().map(|place| place[k]).collect();
    }
    let zonal = values(&open(made), "un_zonal", 0);
    places
        .iter()
        .enumerate()
        .map(|(face, [lon, lat])| (zonal(face, 0) - rotation(*lon, *lat)[0]).abs())
        .fold(0.0, f64::max)
}

#[test]
fn edges_of_ugrid_are_known_by_their_faces_or_their_nodes() {
    let mesh = IcosahedralMesh::new(1).unwrap();
    let cells: [&[f64]; 2] = [&mesh.lon_center_rad, &mesh.lat_center_rad];
    let corners: [&[f64]; 2] = [&mesh.lon_corner_rad, &mesh.lat_corner_rad];
    let beside_cells = beside(&mut Made::mesh(false));
    let beside_corners: Vec<[i32; 2]> = mesh.edge_corner.as_chunks().0.to_vec();
    let polygons = (mesh.cell_corner.clone(), [corners, cells], beside_cells.clone(), mesh.edge_corner.clone());
    let triangles = (mesh.corner_cell.clone(), [cells, corners], beside_corners, beside_cells.concat());
    for (rows, places, beside, ends) in [polygons, triangles] {
        for table in ["edge_face_connectivity", "edge_node_connectivity"] {
            let of_nodes = ends_with_left(&ends, &beside, places);
            let of_edges = if table == "edge_node_connectivity" { of_nodes } else { beside.concat() };
            let mut made = ugrid(table, places, &rows, &of_edges);
            add_rotation(&mut made, "un", "edge", &beside, places[1]);
            made.last().attributes = vec![("long_name", "velocity normal to edges".into())];
            let sums = (0..EDGES).map(|edge| f64::from(beside[edge][0] + beside[edge][1]));
            made.add("sum", &["time", "edge"], Values::F64(sums.collect()));
            let file = open(&made);
            expect_rotation(&file, "un", places[1], &[]);
            let face = 7;
            let own: Vec<f64> =
                beside.iter().filter(|pair| pair.contains(&face)).map(|[a, b]| f64::from(a + b)).collect();
            let mean = own.iter().sum::<f64>() / own.len() as f64;
            assert!((values(&file, "sum", 0)(face as usize, 0) - mean).abs() < 1e-9, "{table}");
            let off = with_middles_elsewhere(&mut made, places, &rows);
            assert!(off < 0.08 * OMEGA.length(), "{table}: {off}");
            // A table of other shape is none.
            made.variable("of_edges").dimensions.reverse();
            made.variable("of_edges").dimensions[0] = "row";
            made.variable("of_edges").values = Values::I32(vec![0; EDGES * (rows.len() / places[1][0].len())]);
            expect(&open(&made).field_info("un_zonal").unwrap_err(), ErrorKind::Field, &["there is no field un_zonal"]);
        }
    }
}

/// FESOM2's elements left and right of each edge, of which the right one may be missing.
#[test]
fn edges_of_fesom_have_a_table() {
    let mesh = IcosahedralMesh::new(1).unwrap();
    let beside: Vec<[i32; 2]> = mesh.edge_corner.as_chunks().0.to_vec();
    let mut made = Made::of([("nod2", 42), ("elem", 80), ("n2", 2), ("n3", 3), ("edg_n", EDGES)], []);
    made.dimensions.extend([("time", 0), ("lev", LAYERS)]);
    made.add("elements", &["elem", "n3"], Values::I32(mesh.corner_cell.iter().map(|cell| cell + 1).collect()));
    made.add("nodes", &["n2", "nod2"], Values::F64([&mesh.lon_center_rad[..], &mesh.lat_center_rad].concat()));
    made.add(
        "edge_tri",
        &["n2", "edg_n"],
        Values::I32((0..2 * EDGES).map(|i| beside[i % EDGES][i / EDGES] + 1).collect()),
    );
    add_rotation(&mut made, "un", "edg_n", &beside, [&mesh.lon_corner_rad, &mesh.lat_corner_rad]);
    made.last().attributes = vec![("long_name", "velocity normal to edges".into())];
    // Two edges of element 3 lack their other element.
    let of_element: Vec<usize> = (0..EDGES).filter(|edge| beside[*edge].contains(&3)).collect();
    for edge in &of_element[..2] {
        let other = beside[*edge].iter().position(|element| *element != 3).unwrap();
        made.i32s("edge_tri")[other * EDGES + edge] = [0, -999][other];
    }
    let file = open(&made);
    assert_eq!(file.field_info("un_zonal").unwrap().location, Location::Corner);
    let zonal = values(&file, "un_zonal", 0);
    assert!(zonal(3, 0).is_nan());
    let expected = rotation(mesh.lon_corner_rad[70], mesh.lat_corner_rad[70])[0];
    assert!((zonal(70, 0) - expected).abs() < 1e-9);
}
