//! Columns that are spread over ranks, each of which has the whole grid's tables: bitwise the picture of the whole
//! field.

use crate::common::{
    assert_same_refusal, at_centers, bits, difference, icosahedral, laid_out, on_nodes, picture, pictures, refusal,
    render_decomposed,
};
use icoray::{
    Decomposition, Error, ErrorKind, Field, Fields, FrameReport, Grid, IcosahedralMesh, Layers, Location, Owned,
    OwnedReals, PartCells, Ranks, Rendered, Renderer, Scene, Shape,
};
use icoray_test_support::Random;

mod corners;
mod fields;
mod part_corners;

const LAYERS: usize = 4;
const FILL: f64 = -9e33;

/// What a rank has: columns in an order of its own, and what it says of them.
#[derive(Clone)]
struct Local {
    /// The cell of each column.
    cells: Vec<usize>,
    global: Vec<i64>,
    owned: Vec<i32>,
}

/// Each rank's columns; those of odd ranks have a halo, mixed with their own, those of even ones begin with their own.
fn locals(mesh: &IcosahedralMesh, ranks: usize, owner: &[usize]) -> Vec<Local> {
    let local = |rank: usize| {
        let mut has: Vec<bool> = owner.iter().map(|owner| *owner == rank).collect();
        for row in mesh.corner_cell.chunks_exact(3).filter(|_| rank % 2 == 1) {
            if row.iter().any(|cell| owner[*cell as usize] == rank) {
                row.iter().for_each(|cell| has[*cell as usize] = true);
            }
        }
        let mut cells: Vec<usize> = (0..owner.len()).filter(|cell| has[*cell]).collect();
        cells.sort_by_key(|cell| Random::at(*cell).bits());
        let owned = cells.iter().map(|cell| i32::from(owner[*cell] == rank)).collect();
        let global = cells.iter().map(|cell| *cell as i64).collect();
        Local { cells, global, owned }
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
#[derive(Debug, Clone, Copy)]
enum Layout {
    LevelFastest,
    CellFastest,
    Blocked,
}

impl Layout {
    fn shape(self, columns: usize) -> Shape {
        match self {
            Layout::LevelFastest => Shape::level_fastest(columns, LAYERS),
            Layout::CellFastest => Shape::cell_fastest(columns, LAYERS),
            Layout::Blocked => Shape::blocked(columns, LAYERS, 8),
        }
    }

    /// The values of some cells, as they lie; `value` is of a cell and a layer.
    fn lay<S: Copy + Default>(self, cells: &[usize], value: impl Fn(usize, usize) -> S) -> Vec<S> {
        laid_out(&self.shape(cells.len()), S::default(), |column, layer| value(cells[column], layer))
    }
}

fn value(cell: usize, layer: usize, step: usize) -> f64 {
    if Random::at(cell).below(31) == step { FILL } else { (0.37 * (cell + 50 * step) as f64).sin() + layer as f64 }
}

fn layers() -> Layers {
    Layers::from_heights(&[0.0, 5e3, 12e3, 20e3], 6371e3).unwrap()
}

fn scene(rest: &str) -> Scene {
    Scene::parse(&format!(
        "field = \"q\"\nexaggeration = 60\n{rest}\n[image]\nwidth = 61\nheight = 50\n\
         [camera]\nlon = 20\nlat = 35\ndistance = 3.2\nfov = 45\n\
         [transfer]\nmap = \"viridis\"\nrange = [-1, 4]\nopacity = [[-1, 0.8], [0, 0.1], [4, 0.9]]\n"
    ))
    .unwrap()
}

fn decomposition(ranks: &mut Ranks, grid: &Grid, local: &Local) -> Result<Decomposition, Error> {
    let cells = PartCells { global: local.global.as_slice().into(), owned: Owned::Marked(&local.owned) };
    Decomposition::new(ranks, grid, &cells)
}

fn render<'f>(
    ranks: &mut Ranks,
    scene: &Scene,
    grid: &Grid,
    decomposition: &Decomposition,
    fields: impl Into<Fields<'f>>,
) -> Result<Rendered, Error> {
    assert!(matches!(decomposition, Decomposition::Columns(_)), "{decomposition:?}");
    render_decomposed(ranks, scene, (grid, decomposition), &layers(), fields)
}

/// Checks that the ranks of each node have copied so many bytes together.
fn assert_bytes_copied(node_of: &[usize], reports: &[FrameReport], expected: usize, trying: &str) {
    for node in node_of {
        let ranks = reports.iter().zip(node_of).filter(|(_, of)| *of == node);
        assert_eq!(ranks.map(|(report, _)| report.bytes_copied).sum::<u64>(), expected as u64, "{trying}");
    }
}

/// In 32 and 64 bits by turns: the memory grows, and is then more than what is asked for.
#[test]
fn columns_make_the_very_picture_of_the_whole() {
    let (mesh, grid) = icosahedral(3);
    let all: Vec<usize> = (0..mesh.cells()).collect();
    let scenes = [
        scene(""),
        scene("precision = \"f64\"\n[light]\nkind = \"headlight\""),
        scene("ranks = \"tiles\"\ncore = \"transparent\""),
    ];
    // The values of a step as they lie, and the mark of what is missing.
    let lay = |layout: Layout, cells: &[usize], step: usize, value: &dyn Fn(usize, usize) -> f64| match step {
        1 => (OwnedReals::F64(layout.lay(cells, value)), FILL),
        _ => (OwnedReals::F32(layout.lay(cells, |c, l| value(c, l) as f32)), f64::from(FILL as f32)),
    };
    fn field((values, fill): &(OwnedReals, f64), shape: Shape) -> Field<'_> {
        Field::new(values.as_reals(), shape, Location::Center, Some(*fill)).unwrap()
    }
    let whole = [0, 1, 2].map(|step| {
        let values = lay(Layout::LevelFastest, &all, step, &|c, l| value(c, l, step));
        let field = field(&values, Shape::level_fastest(all.len(), LAYERS));
        Renderer::new(1).unwrap().render(&scenes[step], &grid, &layers(), &field).unwrap()
    });
    assert!(whole.iter().all(|frame| frame.report.missing_values > 0));
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
        for (k, owner) in partitions(all.len(), node_of.len()).iter().enumerate() {
            let locals = locals(mesh, node_of.len(), owner);
            let layout = [Layout::LevelFastest, Layout::CellFastest, Layout::Blocked][(i + k) % 3];
            let drawn = on_nodes(node_of, |ranks| {
                let local = &locals[ranks.rank()];
                let grid = Grid::new(mesh.tables()).unwrap();
                let decomposition = decomposition(ranks, &grid, local).unwrap();
                let shape = layout.shape(local.cells.len());
                // What is in a halo is not read.
                let own = |c: usize| local.owned[local.cells.iter().position(|cell| *cell == c).unwrap()] == 1;
                let value = |c, l, step| if own(c) { value(c, l, step) } else { 1e30 };
                [0, 1, 2].map(|step| {
                    let values = lay(layout, &local.cells, step, &|c, l| value(c, l, step));
                    render(ranks, &scenes[step], &grid, &decomposition, &field(&values, shape)).unwrap()
                })
            });
            for (step, (frame, reports)) in pictures(drawn).into_iter().enumerate() {
                let trying = format!("nodes {node_of:?}, partition {k}, {layout:?}, step {step}");
                assert!(bits(&frame) == bits(&whole[step]), "{trying}");
                let size = if step == 1 { 8 } else { 4 };
                assert_bytes_copied(node_of, &reports, all.len() * LAYERS * size, &trying);
                for report in &reports {
                    assert!(report.timing.copy_s > 0.0 && report.timing.prepare_s >= 0.0, "{trying}");
                    assert_eq!(report.value_range, whole[step].report.value_range);
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
    let all: Vec<usize> = (0..mesh.cells()).collect();
    let asked = |scheme: &str| scene(&format!("precision = \"f64\"\ntolerance = 1e-7\nranks = \"{scheme}\""));
    let values = Layout::LevelFastest.lay(&all, |c, l| value(c, l, 99));
    let field = at_centers(&values, LAYERS);
    let whole = Renderer::new(1).unwrap().render(&asked("auto"), &grid, &layers(), &field).unwrap();
    let locals = locals(mesh, 3, &partitions(all.len(), 3)[1]);
    let (frame, reports) = picture(on_nodes(&[0, 1, 0], |ranks| {
        let local = &locals[ranks.rank()];
        let decomposition = decomposition(ranks, &grid, local).unwrap();
        let values = Layout::LevelFastest.lay(&local.cells, |c, l| value(c, l, 99));
        render(ranks, &asked("fragments"), &grid, &decomposition, &at_centers(&values, LAYERS)).unwrap()
    }));
    assert!(reports[0].counts.fragments > 0);
    assert!(difference(&frame, &whole) <= 1e-6);
}

/// The tables are the part's own only where that fits on all ranks.
#[test]
fn ranks_agree_on_the_kind_of_their_tables() {
    let (mesh, grid) = icosahedral(2);
    let cells = mesh.cells();
    let kinds = |locals: Vec<Local>| {
        on_nodes(&vec![0; locals.len()], |ranks| match decomposition(ranks, &grid, &locals[ranks.rank()]).unwrap() {
            Decomposition::Whole => "whole",
            Decomposition::Columns(columns) if columns.has_parts() => "parts",
            Decomposition::Columns(_) => "columns",
        })
    };
    let all = Local { cells: Vec::new(), global: (0..cells as i64).collect(), owned: vec![1; cells] };
    let none = Local { cells: Vec::new(), global: Vec::new(), owned: Vec::new() };
    assert_eq!(kinds(vec![all.clone()]), ["whole"]);
    assert_eq!(kinds(vec![none.clone(), all.clone()]), ["columns"; 2]);
    let halo = |own: bool| Local { owned: (0..cells).map(|c| i32::from((c < 9) == own)).collect(), ..all.clone() };
    assert_eq!(kinds(vec![halo(true), halo(false), none.clone()]), ["columns"; 3]);
    assert_eq!(kinds(vec![halo(true), halo(false)]), ["parts"; 2]);
}

/// Columns that do not fit on one rank are the same error on all; correct ones are accepted afterwards.
#[test]
fn columns_that_do_not_fit_are_refused_on_all_ranks() {
    let (mesh, grid) = icosahedral(2);
    let owner = &partitions(mesh.cells(), 3)[0];
    type Damage = fn(&mut Local);
    let cases: [(Damage, &str); 7] = [
        (|l| l.global[4] = 162, "rank 1: cell_global row 4: 162, expected 0 to 161, a row of the grid's tables"),
        (|l| l.global[5] = -1, "rank 1: cell_global row 5: -1, expected 0 to 161, a row"),
        (|l| l.global[5] = l.global[2], "rank 1: cell_global rows 2 and 5: both "),
        (|l| l.owned.fill(1), "is owned by ranks "),
        (|l| l.owned.fill(0), "of the whole grid is owned by no rank"),
        (|l| l.owned.truncate(3), "rank 1: is_owned: 3 rows, expected "),
        (|l| (l.global, l.owned) = (Vec::new(), Vec::new()), "of the whole grid is owned by no rank"),
    ];
    for (damage, words) in cases {
        let mut locals = locals(mesh, 3, owner);
        damage(&mut locals[1]);
        let right = self::locals(mesh, 3, owner);
        let refusals = on_nodes(&[0, 1, 0], |ranks| {
            let refusal = refusal(decomposition(ranks, &grid, &locals[ranks.rank()]));
            decomposition(ranks, &grid, &right[ranks.rank()]).unwrap();
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
        decomposition(ranks, &Grid::new(tables).unwrap(), &locals[ranks.rank()]).unwrap_err().to_string()
    });
    assert!(found.iter().all(|f| *f == found[0]), "{found:?}");
    let words = "or the whole grid on all ranks, which has 162 cells on rank 0 and 42 on rank 2";
    assert!(found[0].contains(words), "{}", found[0]);
}
