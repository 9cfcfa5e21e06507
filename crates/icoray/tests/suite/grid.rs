//! The grid's checks: correct tables pass in every order of real files, and errors name the fault.

use crate::common::assert_grid_error;
use crate::culled::{Culled, Mark, Style};
use crate::holes::assert_closed;
use icoray::{ErrorKind, Grid, GridTables, IcosahedralMesh, LonLat};

fn mesh(level: u32) -> IcosahedralMesh {
    IcosahedralMesh::new(level).unwrap()
}

#[test]
fn bisected_meshes_are_closed_and_have_the_known_counts() {
    for level in 0..=5 {
        let mesh = mesh(level);
        let grid = Grid::new(mesh.tables()).unwrap();
        let n = 4usize.pow(level);
        assert_eq!((grid.cells(), grid.triangles(), grid.tables().edges()), (10 * n + 2, 20 * n, 30 * n));
        assert_closed(&grid, "whole");
    }
    assert_eq!(IcosahedralMesh::new(13).unwrap_err().kind(), ErrorKind::Argument);
}

/// Rows in any order, Fortran numbering, 2 spare columns of garbage: the same triangles and neighbours.
#[test]
fn shuffled_rows_and_base_one_change_nothing() {
    let mesh = mesh(2);
    let plain = Grid::new(mesh.tables()).unwrap();
    let mut shuffled = Culled::new(&mesh, &vec![true; mesh.cells()], Style::Corners, Mark::MinusOne, 1);
    shuffled.shuffle();
    let (mut cell_corner, mut count) = (Vec::new(), Vec::new());
    for row in shuffled.cell_corner.chunks_exact(6) {
        let mut distinct = row.to_vec();
        distinct.dedup();
        count.push(distinct.len() as i32);
        distinct.resize(8, -77);
        cell_corner.extend(distinct);
    }
    let tables = GridTables {
        cell_corner: cell_corner.as_slice().into(),
        cell_corner_row: 8,
        cell_corner_count: Some(count.as_slice().into()),
        ..shuffled.tables()
    };
    let shuffled = Grid::new(tables).unwrap();
    for t in 0..plain.triangles() as u32 {
        for k in 0..3 {
            let cell = plain.triangle(t)[k];
            let place = shuffled.triangle(t).iter().position(|&c| c == cell).unwrap();
            assert_eq!(shuffled.across(t, place), plain.across(t, k));
        }
    }
    for c in 0..plain.cells() as u32 {
        assert!(plain.corners_of(c).eq(shuffled.corners_of(c)));
        assert_eq!(plain.corners_of(c).count(), if c < 12 { 5 } else { 6 });
    }
}

#[test]
fn single_precision_coordinates_are_taken() {
    let mesh = mesh(4);
    let f32s = |v: &[f64]| v.iter().map(|x| *x as f32).collect::<Vec<f32>>();
    let (lon, lat) = (f32s(&mesh.lon_center_rad), f32s(&mesh.lat_center_rad));
    let tables = GridTables {
        center: LonLat { lon_rad: lon.as_slice().into(), lat_rad: lat.as_slice().into() },
        ..mesh.tables()
    };
    Grid::new(tables).unwrap();
}

/// Each damage, and words that must be in the message: table, row, value, expectation.
#[test]
fn damage_is_named() {
    type Damage = fn(&mut IcosahedralMesh);
    let cases: &[(Damage, &[&str])] = &[
        (
            |m| m.corner_cell[31] = 9999,
            &["corner_cell[10][1] (MPAS cellsOnVertex, ICON vertex_of_cell)", "9999", "0 to 161"],
        ),
        (|m| m.corner_edge[30] = -5, &["corner_edge[10]", "-5", "0 to 479"]),
        (|m| m.edge_corner[7] = 321, &["edge_corner[3]", "321", "0 to 319"]),
        // Marks of what is missing, where by the other tables nothing is.
        (|m| m.edge_corner[7] = 320, &["edge_corner[3]", "[10, 320]", "one of them 25"]),
        (|m| m.edge_corner[7] = -1, &["edge_corner[3]", "[10, -1]", "one of them 25"]),
        (|m| m.corner_edge[30] = -1, &["corner_edge[10]", "-1", "0 to 479"]),
        (|m| m.cell_corner[600] = -1, &["cell_corner[100]", "-1", "0 to 319"]),
        (|m| m.cell_corner[600] = 1 << 30, &["cell_corner[100]", "1073741824"]),
        (|m| m.corner_cell[30] = -1, &["corner_cell[", "and corner_cell[10] (MPAS", "and [-1, ", "expected 2"]),
        (|m| m.corner_cell[32] = 162, &["corner_cell[", "and corner_cell[10]", ", 162], ", "expected 2"]),
        (|m| m.corner_cell[31] = m.corner_cell[30], &["corner_cell[10]", "three different cells"]),
        (|m| m.corner_edge.swap(30, 60), &["edge_corner[", "corner_edge[10]"]),
        (|m| m.corner_edge[31] = m.corner_edge[30], &["corner_edge[10]", "one side per cell"]),
        (|m| m.edge_corner[6] = m.edge_corner[7], &["edge_corner[3]"]),
        (|m| m.lon_center_rad[5] = f64::NAN, &["center[5]", "NaN"]),
        (|m| m.lat_center_rad[6] = 45.0, &["center[6]", "45", "radians"]),
        (|m| m.lat_corner_rad[7] = f64::INFINITY, &["corner[7]", "inf"]),
        (|m| m.lon_center_rad.truncate(161), &["center latitude: 162 entries, expected 161"]),
        (|m| m.edge_corner.truncate(958), &["162 cells - 479 edges + 320 corners", "expected 2"]),
        (
            |m| m.corner_edge.truncate(957),
            &["corner_edge (MPAS edgesOnVertex, ICON edge_of_cell): 957 entries, expected 960"],
        ),
        (
            |m| {
                let (a, b) = (m.corner_cell[30] as usize, m.corner_cell[31] as usize);
                m.lon_center_rad[a] = m.lon_center_rad[b];
                m.lat_center_rad[a] = m.lat_center_rad[b];
            },
            &["span no area"],
        ),
        (|m| m.cell_corner.fill(0), &["cell_corner[0]", "1 different corners", "expected the 5"]),
        (|m| m.cell_corner[601] = 319, &["cell_corner[100][1]", "corner 319"]),
        (|m| m.cell_corner[600] = m.cell_corner[601], &["cell_corner[100]", "5 different corners", "6"]),
        (
            // One centre moved to the far side of the sphere: its triangles fold over.
            |m| {
                m.lat_center_rad[50] = -m.lat_center_rad[50];
                m.lon_center_rad[50] = (m.lon_center_rad[50] + 3.0) % 6.0;
            },
            &["same side of edge"],
        ),
    ];
    for (i, (damage, words)) in cases.iter().enumerate() {
        let mut mesh = mesh(2);
        damage(&mut mesh);
        assert_grid_error(Grid::new(mesh.tables()), words, &format!("case {i}"));
    }
}

/// The same six tables in 64 bits: the same grid, and numbers that 32 bits would wrap into the range are refused.
#[test]
fn wide_numbers_are_not_wrapped() {
    let mesh = mesh(2);
    let plain = Grid::new(mesh.tables()).unwrap();
    for base in [0, 1] {
        let rows = [&mesh.cell_corner, &mesh.corner_cell, &mesh.corner_edge, &mesh.edge_corner];
        let right = rows.map(|table| table.iter().map(|v| i64::from(*v) + base).collect::<Vec<i64>>());
        let check = |table: &[Vec<i64>; 4], count: Option<&[i64]>, words: &[&str]| {
            let grid = Grid::new(GridTables {
                index_base: base as i32,
                cell_corner: table[0].as_slice().into(),
                corner_cell: table[1].as_slice().into(),
                corner_edge: table[2].as_slice().into(),
                edge_corner: table[3].as_slice().into(),
                cell_corner_count: count.map(Into::into),
                ..mesh.tables()
            });
            if !words.is_empty() {
                return assert_grid_error(grid, words, &format!("base {base}"));
            }
            let grid = grid.unwrap();
            for t in 0..grid.triangles() as u32 {
                assert_eq!(grid.triangle(t), plain.triangle(t));
                assert_eq!([0, 1, 2].map(|k| grid.across(t, k)), [0, 1, 2].map(|k| plain.across(t, k)));
            }
        };
        check(&right, None, &[]);
        check(&right, Some(&[6; 162]), &[]);
        for (k, (name, columns)) in
            [("cell_corner", 6), ("corner_cell", 3), ("corner_edge", 3), ("edge_corner", 2)].into_iter().enumerate()
        {
            let row = [format!("{name}[10][1] (MPAS "), format!("{name}(2, 11) (MPAS ")][base as usize].clone();
            for wrong in [(1 << 32) + 5, -(1 << 32) + 5, i64::MAX, i64::MIN] {
                let mut damaged = right.clone();
                damaged[k][10 * columns + 1] = wrong;
                check(&damaged, None, &[&row, &format!(": {wrong}, expected {base} to"), name]);
            }
        }
        for mark in [base - 1, -1, 162 + base] {
            let mut damaged = right.clone();
            damaged[1][31] = mark;
            let row = ["and corner_cell[10] (", "and corner_cell(:, 11) ("][base as usize];
            check(&damaged, None, &["corner_cell", row, &format!(", {mark}, ")]);
        }
        let mut count = [6; 162];
        count[7] = (1 << 32) + 6;
        let row = ["cell_corner_count[7] (MPAS nEdgesOnCell)", "cell_corner_count(8) (MPAS"][base as usize];
        check(&right, Some(&count), &[row, "4294967302", "3 to 6"]);
    }
}
