//! Columns that are spread over ranks, each of which has the whole grid's tables: bitwise the picture of the whole
//! field.

use crate::common::*;
use crate::spread::Rows;
use icoray::{
    Decomposition, DistributedGrid, Error, ErrorKind, Fields, Frame, FrameReport, Grid, IcosahedralMesh, Location,
    Ranks, Rendered, Renderer, Scene, Shape,
};
use icoray_test_support::Random;

mod corners;
mod part_corners;
mod several;

const LAYERS: usize = HEIGHT_M.len();
const FILL: f64 = -9e33;

/// Each rank's columns in an order of its own; those of odd ranks have a halo, mixed with their own, those of even ones
/// begin with their own.
fn locals(mesh: &IcosahedralMesh, ranks: usize, owner: &[usize]) -> Vec<Rows> {
    let local = |rank: usize| {
        let mut has: Vec<bool> = owner.iter().map(|owner| *owner == rank).collect();
        for row in mesh.corner_cell.chunks_exact(3).filter(|_| rank % 2 == 1) {
            if row.iter().any(|cell| owner[*cell as usize] == rank) {
                row.iter().for_each(|cell| has[*cell as usize] = true);
            }
        }
        let mut cells: Vec<usize> = (0..owner.len()).filter(|cell| has[*cell]).collect();
        cells.sort_by_key(|cell| Random::at(*cell).bits());
        Rows::new(cells, |cell| cell as i64, |cell| owner[cell] == rank)
    };
    (0..ranks).map(local).collect()
}

fn partitions(cells: usize, ranks: usize) -> [Vec<usize>; 3] {
    [
        (0..cells).map(|cell| cell * ranks / cells).collect(),
        (0..cells).map(|cell| Random::at(cell).below(ranks)).collect(),
        // The first has nothing where there are others, the last a single cell.
        (0..cells).map(|cell| if cell == 77 { ranks - 1 } else { (ranks - 1).min(1 + cell % ranks / 2) }).collect(),
    ]
}

/// How a rank's values lie in memory.
type Layout = fn(usize) -> Shape;

const LEVEL_FASTEST: Layout = |columns| Shape::level_fastest(columns, LAYERS);
const CELL_FASTEST: Layout = |columns| Shape::cell_fastest(columns, LAYERS);
const BLOCKED: Layout = |columns| Shape::blocked(columns, LAYERS, 8);

fn value(cell: usize, layer: usize, step: usize) -> f64 {
    if Random::at(cell).below(31) == step { FILL } else { (0.37 * (cell + 50 * step) as f64).sin() + layer as f64 }
}

fn scene(rest: &str) -> Scene {
    let rest = format!("exaggeration = 60\nimage = {{ width = 61, height = 50 }}\n{rest}");
    let transfer = "map = \"viridis\"\nrange = [-1, 4]\nopacity = [[-1, 0.8], [0, 0.1], [4, 0.9]]";
    let mut scene = crate::common::scene(FAR, transfer, &rest);
    scene.volumes[0].field = "q".into();
    scene
}

fn decomposition(ranks: &mut Ranks, grid: &Grid, cells: &Rows, corners: Option<&Rows>) -> Result<Decomposition, Error> {
    Decomposition::with_corners(ranks, grid, &cells.cells(), corners.map(Rows::corners).as_ref())
}

fn alone(grid: &Grid, scene: &Scene, arrays: &Arrays) -> Frame {
    Renderer::new(1).unwrap().render(scene, grid, &earth_layers(), fields(arrays)).unwrap()
}

fn render<'f>(
    ranks: &mut Ranks,
    scene: &Scene,
    grid: &Grid,
    decomposition: &Decomposition,
    fields: impl Into<Fields<'f>>,
) -> Result<Rendered, Error> {
    assert!(matches!(decomposition, Decomposition::Columns(_)), "{decomposition:?}");
    let data = DistributedGrid { grid, decomposition: Some(decomposition), layers: &earth_layers() };
    Renderer::new(1)?.render_decomposed(ranks, scene, data, fields)
}

/// Checks that the ranks of each node have copied so many bytes together.
fn assert_bytes_copied(node_of: &[usize], reports: &[FrameReport], expected: usize, trying: &str) {
    for node in node_of {
        let ranks = reports.iter().zip(node_of).filter(|(_, of)| *of == node);
        assert_eq!(ranks.map(|(report, _)| report.bytes_copied).sum::<u64>(), expected as u64, "{trying}");
    }
}

/// Checks that the frames which ranks on nodes make one after the other are those of one process to the bit, and that
/// each node copies so many bytes for each; returns the reports.
fn assert_made<const N: usize>(
    node_of: &[usize],
    expected: &[(Frame, usize); N],
    trying: &str,
    make: impl Fn(&mut Ranks) -> [Rendered; N] + Sync,
) -> [Vec<FrameReport>; N] {
    let mut made = pictures(on_nodes(node_of, make)).into_iter();
    expected.each_ref().map(|(whole, bytes)| {
        let (frame, reports) = made.next().unwrap();
        assert!(bits(&frame) == bits(whole), "nodes {node_of:?}, {trying}");
        assert_bytes_copied(node_of, &reports, *bytes, &format!("nodes {node_of:?}, {trying}"));
        reports
    })
}

/// In 32 and 64 bits by turns: the memory grows, and is then more than what is asked for.
#[test]
fn columns_make_the_very_picture_of_the_whole() {
    let (mesh, grid) = icosahedral(3);
    let cells = mesh.cells();
    let scenes = [
        scene(""),
        scene("precision = \"f64\"|[light]\nkind = \"headlight\""),
        scene("ranks = \"tiles\"\ncore = \"transparent\""),
    ];
    // What is in a halo is not read.
    let arrays = |rows: &Rows, layout: Layout, step: usize| {
        let form = (step == 1, Location::Center, Some(FILL));
        vec![("q", rows.array(layout, form, |cell, layer| value(cell, layer, step), |_| 1e30))]
    };
    let whole = [0, 1, 2].map(|step| {
        let frame = alone(&grid, &scenes[step], &arrays(&Rows::all(cells), LEVEL_FASTEST, step));
        (frame, cells * LAYERS * if step == 1 { 8 } else { 4 })
    });
    assert!(whole.iter().all(|(frame, _)| frame.report.missing_values > 0));
    let nodes: [&[usize]; 8] = [
        &[0, 0],
        &[0, 1],
        &[0, 0, 0],
        &[0, 1, 0],
        &[0, 1, 1, 0],
        &[0, 1, 2, 3],
        &[0, 0, 0, 0, 0, 0, 0, 0],
        &[2, 1, 1, 0, 0, 1, 0, 1],
    ];
    for (i, node_of) in nodes.into_iter().enumerate() {
        for (k, owner) in partitions(cells, node_of.len()).iter().enumerate() {
            let locals = locals(mesh, node_of.len(), owner);
            let layout = [LEVEL_FASTEST, CELL_FASTEST, BLOCKED][(i + k) % 3];
            let reports = assert_made(node_of, &whole, &format!("partition {k}"), |ranks| {
                let local = &locals[ranks.rank()];
                let grid = Grid::new(mesh.tables()).unwrap();
                let decomposition = decomposition(ranks, &grid, local, None).unwrap();
                [0, 1, 2].map(|step| {
                    let arrays = arrays(local, layout, step);
                    render(ranks, &scenes[step], &grid, &decomposition, fields(&arrays)).unwrap()
                })
            });
            for (reports, (whole, _)) in reports.iter().zip(&whole) {
                for report in reports {
                    assert!(report.timing.copy_s > 0.0 && report.timing.prepare_s >= 0.0, "{node_of:?}, {k}");
                    assert_eq!(report.value_range, whole.report.value_range);
                    let sharing = "tiles: every rank has the whole grid, the field is assembled once per node";
                    assert_eq!(report.ranks.sharing.unwrap().to_string(), sharing);
                }
            }
        }
    }
}

/// Fragments of what nodes have put together are as near as those of any part.
#[test]
fn a_scene_may_ask_for_fragments_of_columns() {
    let (mesh, grid) = icosahedral(3);
    let asked = |scheme: &str| scene(&format!("precision = \"f64\"\ntolerance = 1e-7\nranks = \"{scheme}\""));
    let arrays = |rows: &Rows| {
        let form = (true, Location::Center, None);
        vec![("q", rows.array(LEVEL_FASTEST, form, |cell, layer| value(cell, layer, 99), |_| f64::NAN))]
    };
    let whole = alone(&grid, &asked("auto"), &arrays(&Rows::all(mesh.cells())));
    let locals = locals(mesh, 3, &partitions(mesh.cells(), 3)[1]);
    let (frame, reports) = picture(on_nodes(&[0, 1, 0], |ranks| {
        let local = &locals[ranks.rank()];
        let decomposition = decomposition(ranks, &grid, local, None).unwrap();
        render(ranks, &asked("fragments"), &grid, &decomposition, fields(&arrays(local))).unwrap()
    }));
    assert!(reports[0].counts.fragments > 0);
    assert!(difference(&frame, &whole) <= 1e-6);
}

/// The tables are the part's own only where that fits on all ranks.
#[test]
fn ranks_agree_on_the_kind_of_their_tables() {
    let (mesh, grid) = icosahedral(2);
    let cells = mesh.cells();
    let kinds = |locals: Vec<Rows>| {
        on_nodes(&vec![0; locals.len()], |ranks| {
            match decomposition(ranks, &grid, &locals[ranks.rank()], None).unwrap() {
                Decomposition::Whole => "whole",
                Decomposition::Columns(columns) if columns.has_parts() => "parts",
                Decomposition::Columns(_) => "columns",
            }
        })
    };
    let (all, none) = (Rows::all(cells), Rows::default());
    assert_eq!(kinds(vec![all.clone()]), ["whole"]);
    assert_eq!(kinds(vec![none.clone(), all.clone()]), ["columns"; 2]);
    let halo = |own: bool| Rows::new((0..cells).collect(), |cell| cell as i64, |cell| (cell < 9) == own);
    assert_eq!(kinds(vec![halo(true), halo(false), none.clone()]), ["columns"; 3]);
    assert_eq!(kinds(vec![halo(true), halo(false)]), ["parts"; 2]);
}

/// Columns that do not fit on one rank are the same error on all; correct ones are accepted afterwards.
#[test]
fn columns_that_do_not_fit_are_refused_on_all_ranks() {
    let (mesh, grid) = icosahedral(2);
    let owner = &partitions(mesh.cells(), 3)[0];
    type Damage = fn(&mut Rows);
    let cases: [(Damage, &str); 7] = [
        (|l| l.global[4] = 162, "rank 1: cell_global row 4: 162, expected 0 to 161, a row of the grid's tables"),
        (|l| l.global[5] = -1, "rank 1: cell_global row 5: -1, expected 0 to 161, a row"),
        (|l| l.global[5] = l.global[2], "rank 1: cell_global rows 2 and 5: both "),
        (|l| l.owned.fill(1), "is owned by ranks "),
        (|l| l.owned.fill(0), "of the whole grid is owned by no rank"),
        (|l| l.owned.truncate(3), "rank 1: is_owned: 3 rows, expected "),
        (|l| *l = Rows::default(), "of the whole grid is owned by no rank"),
    ];
    for (damage, words) in cases {
        let mut locals = locals(mesh, 3, owner);
        damage(&mut locals[1]);
        let right = self::locals(mesh, 3, owner);
        let refusals = on_nodes(&[0, 1, 0], |ranks| {
            let refusal = refusal(decomposition(ranks, &grid, &locals[ranks.rank()], None));
            decomposition(ranks, &grid, &right[ranks.rank()], None).unwrap();
            refusal
        });
        assert_same_refusal(&refusals, ErrorKind::Grid, "");
        assert!(refusals[0].1.contains(words), "{}", refusals[0].1);
    }
    // Tables of two grids.
    let other = IcosahedralMesh::new(1).unwrap();
    let locals = locals(mesh, 3, owner);
    let found = on_nodes(&[0, 1, 0], |ranks| {
        let tables = if ranks.rank() == 2 { other.tables() } else { mesh.tables() };
        refusal(decomposition(ranks, &Grid::new(tables).unwrap(), &locals[ranks.rank()], None))
    });
    assert_same_refusal(&found, ErrorKind::Grid, "");
    let words = "or the whole grid on all ranks, which has 162 cells on rank 0 and 42 on rank 2";
    assert!(found[0].1.contains(words), "{}", found[0].1);
}
