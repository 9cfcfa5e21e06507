//! Fields and heights at corners that have owners of their own, over the tables of parts: ICON's triangles.

use super::*;
use crate::culled::{Culled, Mark, Style};
use icoray::Heights;
use icoray_test_support::is_long;

/// What a rank has of a mesh whose corners have owners: its corners, and all that share a cell with them. Numbers have
/// gaps.
struct LocalPart {
    tables: Culled,
    cells: Rows,
    corners: Rows,
}

impl LocalPart {
    /// The rank that owns the first corner around a cell owns the cell: it need not be that of each corner's first cell.
    fn new(mesh: &IcosahedralMesh, rank: usize, owner: &[usize]) -> Self {
        let rows: Vec<&[i32]> = mesh.corner_cell.chunks_exact(3).collect();
        let mut has = [vec![false; mesh.cells()], vec![false; mesh.cells()]];
        let mut first = vec![usize::MAX; mesh.cells()];
        for (corner, row) in rows.iter().enumerate() {
            for cell in row.iter().map(|cell| *cell as usize) {
                has[0][cell] |= owner[corner] == rank;
                first[cell] = first[cell].min(corner);
            }
        }
        for row in &rows {
            let is_near = row.iter().any(|cell| has[0][*cell as usize]);
            row.iter().for_each(|cell| has[1][*cell as usize] |= is_near);
        }
        let tables = Culled::new(mesh, &has[1], Style::Triangles, Mark::MinusOne, 0);
        let cells = Rows::new(tables.cells.clone(), |cell| 10 * cell as i64, |cell| owner[first[cell]] == rank);
        let number = |corner: usize| 3 * corner as i64 + 1;
        let corners = Rows::new(tables.corners.clone(), number, |corner| owner[corner] == rank);
        LocalPart { tables, cells, corners }
    }
}

/// Two fields at corners, and heights there; none but at own ones.
fn arrays(corners: &Rows) -> Arrays {
    let array =
        |value: fn(usize, usize) -> f64| corners.array(BLOCKED, (true, Location::Corner, None), value, |_| f64::NAN);
    vec![
        ("q", array(|corner, layer| (0.31 * corner as f64).sin() + layer as f64)),
        ("r", array(|corner, layer| (0.17 * corner as f64).cos() * (1.5 + layer as f64))),
        ("heights", array(|corner, layer| 6e3 * layer as f64 + 2e3 * (0.3 * corner as f64).sin())),
    ]
}

/// Averages are computed where the values are, and nothing is copied; what a derived field is made of is copied, as the
/// length of a mean vector is not the mean of lengths.
#[test]
fn corners_of_parts_are_read_where_they_are_own() {
    let (mesh, grid) = icosahedral(3);
    let (cells, count) = (mesh.cells(), mesh.lon_corner_rad.len());
    let derived = "|[[derive]]\nname = \"d\"\nmagnitude = [\"q\", \"r\"]\n";
    for (shown, derived, copied) in [("q", "", 0), ("d", derived, 2 * 8 * count * LAYERS)] {
        let mut scene = scene(&format!("precision = \"f64\"\ntolerance = 1e-6\n{derived}"));
        (scene.scenery.heights, scene.volumes[0].field) = (Heights::Native, shown.into());
        let whole = alone(&grid, &scene, &arrays(&Rows::all(count)));
        for (i, node_of) in [&[0, 0][..], &[0, 0, 0], &[0, 1], &[0, 1, 0, 2]].into_iter().enumerate() {
            // One partition of three, but in the long run.
            let partitions = partitions(count, node_of.len()).into_iter().enumerate();
            for (_, owner) in partitions.filter(|(k, _)| is_long() || *k == i % 3) {
                let drawn = on_nodes(node_of, |ranks| {
                    let part = LocalPart::new(mesh, ranks.rank(), &owner);
                    let grid = part.tables.grid();
                    let decomposition = decomposition(ranks, &grid, &part.cells, Some(&part.corners)).unwrap();
                    let Decomposition::Columns(columns) = &decomposition else { panic!("not columns") };
                    let arrays = arrays(&part.corners);
                    (columns.table_bytes(), render(ranks, &scene, &grid, &decomposition, fields(&arrays)).unwrap())
                });
                let (table_bytes, drawn): (Vec<usize>, Vec<_>) = drawn.into_iter().unzip();
                let (frame, reports) = picture(drawn);
                let is_one_node = node_of.iter().all(|node| *node == 0);
                let off = difference(&frame, &whole);
                let trying = format!("{shown} on nodes {node_of:?}");
                assert!(off <= if is_one_node { 0.0 } else { 1e-5 }, "{trying}: {off}");
                assert!(!frame.report.left_out.iter().any(|what| what == "table cell_corner"), "{trying}");
                if is_one_node {
                    assert_bytes_copied(node_of, &reports, copied, &trying);
                    // Averages of heights, and of the field where it is not derived: each once.
                    let made = |(report, tables): (&FrameReport, &usize)| report.bytes_derived - tables;
                    let made: usize = reports.iter().zip(&table_bytes).map(made).sum();
                    assert!(shown == "d" || made == 2 * 8 * cells * LAYERS, "{trying}: {made} bytes");
                } else {
                    assert_eq!(reports.iter().any(|report| report.bytes_copied > 0), copied > 0, "{trying}");
                }
            }
        }
    }
}

#[test]
fn corners_of_parts_have_one_owner() {
    let mesh = IcosahedralMesh::new(2).unwrap();
    let count = mesh.lon_corner_rad.len();
    let owner = &partitions(count, 3)[0];
    type Damage = fn(&mut Rows);
    let cases: [(Damage, &str); 3] = [
        (|corners| corners.owned.fill(1), "is owned by ranks "),
        (|corners| corners.owned.fill(0), "is owned by no rank, expected one owner"),
        (|of| assert!(of.global.pop().is_some() && of.owned.pop().is_some()), "rows, expected "),
    ];
    for (damage, words) in cases {
        let refused = on_nodes(&[0, 0, 1], |ranks| {
            let mut part = LocalPart::new(&mesh, ranks.rank(), owner);
            if ranks.rank() == 1 {
                damage(&mut part.corners);
            }
            let grid = part.tables.grid();
            refusal(decomposition(ranks, &grid, &part.cells, Some(&part.corners)))
        });
        assert_same_refusal(&refused, ErrorKind::Grid, "rank ");
        assert!(refused[0].1.contains(words), "{}", refused[0].1);
    }
}
