use crate::{Grid, GridTables, IcosahedralMesh, LonLat};

/// The tables of `mesh` with these numbers of cells, corners and edges, and the lengths that follow.
fn counted(mesh: &IcosahedralMesh, [cells, corners, edges]: [usize; 3]) -> GridTables<'_> {
    GridTables {
        center: LonLat::of(&mesh.lon_center_rad[..cells], &mesh.lat_center_rad[..cells]),
        corner: LonLat::of(&mesh.lon_corner_rad[..corners], &mesh.lat_corner_rad[..corners]),
        cell_corner: mesh.cell_corner[..6 * cells].into(),
        corner_cell: mesh.corner_cell[..3 * corners].into(),
        corner_edge: mesh.corner_edge[..3 * corners].into(),
        edge_corner: mesh.edge_corner[..2 * edges].into(),
        ..mesh.tables()
    }
}

#[test]
fn swapped_numbers_are_refused_as_such() {
    // As in C, in which arrays have no length: they continue behind the numbers of rows.
    let edge_corner = IcosahedralMesh::new(3).unwrap().edge_corner;
    let mesh = IcosahedralMesh { edge_corner, ..IcosahedralMesh::new(4).unwrap() };
    let refusal = |counts| Grid::new(counted(&mesh, counts)).unwrap_err().to_string();
    let [cells, corners, edges] = [642, 1280, 1920];
    for (counts, words) in [
        ([corners, cells, edges], "cells and corners look swapped"),
        ([edges, corners, cells], "cells and edges look swapped"),
        ([cells, edges, corners], "corners and edges look swapped"),
        // Not the numbers of a sphere: the table of edges names corners that are not there.
        ([corners, cells, edges - 1], "expected 0 to 641; the numbers of cells and corners look swapped"),
    ] {
        assert!(refusal(counts).contains(words), "{}", refusal(counts));
    }
}

#[test]
fn a_hole_is_named_and_one_row_too_few_too() {
    let mut mesh = IcosahedralMesh::new(3).unwrap();
    fn holes(tables: GridTables) -> String {
        let grid = Grid::new(tables).unwrap();
        let text = grid.describe_holes().unwrap_or_default();
        let numbers = text.split(" void triangle").filter_map(|part| part.rsplit(' ').next()?.parse::<usize>().ok());
        assert_eq!(numbers.sum::<usize>(), grid.void_triangles(), "{text}");
        text
    }
    assert_eq!(holes(counted(&mesh, [642, 1280, 1920])), "");
    for (counts, name) in [([641, 1280, 1920], "cells"), ([642, 1279, 1920], "corners")] {
        let one = holes(counted(&mesh, counts));
        assert!(one.starts_with("1 hole, closed by ") && one.contains(" beside corner "), "{one}");
        assert!(one.ends_with(&format!("; one more of {name} makes a closed sphere: check their number")), "{one}");
    }
    // Two cells that are not there.
    mesh.corner_cell.iter_mut().filter(|cell| [0, 641].contains(*cell)).for_each(|cell| *cell = -1);
    mesh.cell_corner[..6].fill(-1);
    mesh.cell_corner[6 * 641..].fill(-1);
    let two = holes(mesh.tables());
    assert!(two.starts_with("2 holes, closed by ") && !two.contains("check their number"), "{two}");
    // One at each pole.
    assert!(two.contains(" N") && two.contains(" S") && !two.contains('-'), "{two}");
}

#[test]
fn degrees_and_the_other_base_are_recognised() {
    let mesh = IcosahedralMesh::new(2).unwrap();
    let degrees = |angles: &[f64]| angles.iter().map(|angle| angle.to_degrees()).collect::<Vec<f64>>();
    let (lon, lat) = (degrees(&mesh.lon_corner_rad), degrees(&mesh.lat_corner_rad));
    let corner = LonLat::of(&lon, &lat);
    let error = Grid::new(GridTables { corner, ..mesh.tables() }).unwrap_err().to_string();
    assert!(error.contains("corner[") && error.ends_with("; these look like degrees"), "{error}");
    let error = Grid::new(GridTables { index_base: 1, ..mesh.tables() }).unwrap_err().to_string();
    assert!(error.ends_with("; numbers begin at 0: set index_base = 0"), "{error}");
    let add_one = |table: &[i32]| table.iter().map(|number| number + 1).collect::<Vec<_>>();
    let mut other = mesh.clone();
    other.corner_cell = add_one(&mesh.corner_cell);
    other.edge_corner = add_one(&mesh.edge_corner);
    other.corner_edge = add_one(&mesh.corner_edge);
    other.cell_corner = add_one(&mesh.cell_corner);
    let error = Grid::new(other.tables()).unwrap_err().to_string();
    assert!(error.ends_with("; numbers begin at 1: set index_base = 1"), "{error}");
    let grid = Grid::new(GridTables { index_base: 1, ..other.tables() }).unwrap();
    assert_eq!(grid.cell_name(50), "cell 51 (counted from 1)");
    // Other faults are not explained so.
    let mut other = mesh.clone();
    other.corner_cell.swap(0, 60);
    let error = Grid::new(other.tables()).unwrap_err().to_string();
    assert!(!error.contains("index_base"), "{error}");
}

/// Points of a model's arrays that are no cells, such as halos and padding, lie among the cells.
#[test]
fn cells_without_corners_are_not_of_the_sphere() {
    let mut mesh = IcosahedralMesh::new(2).unwrap();
    let (plain, row) = (mesh.tables(), 6);
    let angles = |of: crate::Reals| (0..of.len()).map(|i| of.get(i)).chain([0.0; 3]).collect::<Vec<f64>>();
    let (lon, lat) = (angles(plain.center.lon_rad), angles(plain.center.lat_rad));
    mesh.cell_corner.extend([-1; 3 * 6]);
    let grid = |mesh: &IcosahedralMesh| {
        let center = LonLat::of(&lon, &lat);
        let tables = GridTables { center, cell_corner: mesh.cell_corner.as_slice().into(), ..mesh.tables() };
        Grid::new(tables).map(|grid| (grid.cells(), grid.void_triangles())).map_err(|e| e.to_string())
    };
    assert_eq!(grid(&mesh), Ok((165, 0)));
    // One that has a corner is of it.
    let last = mesh.cell_corner.len() - row;
    mesh.cell_corner[last] = 0;
    assert!(grid(&mesh).unwrap_err().contains("expected 2 (a closed sphere"));
}
