//! Fields and heights at corners of columns that are spread over ranks.

use super::several::rich_scene;
use super::*;
use crate::spread::owner_of_corner;
use icoray::{Field, Heights, Owned, PartCells, PartCorners};

/// Columns of its own at corners, in an order of its own, some in a halo; ownership has nothing to do with that of cells.
fn numbered(corners: usize, rank: usize, owner: &[usize]) -> Rows {
    let is_here = |corner: &usize| owner[*corner] == rank || (rank % 2 == 1 && Random::at(*corner).below(7) == 0);
    let mut rows: Vec<usize> = (0..corners).filter(is_here).collect();
    rows.sort_by_key(|corner| Random::at(*corner + rank).bits());
    Rows::new(rows, |corner| corner as i64, |corner| owner[corner] == rank)
}

/// Some columns have none.
fn height(corner: usize, layer: usize) -> f64 {
    let column = 6e3 * layer as f64 + 2e3 * (0.3 * corner as f64).sin();
    if Random::at(corner).below(13) == 2 { FILL } else { column }
}

/// The field q at centres, and t and heights at corners; what is not own there is not a number, or falls.
fn arrays(cells: &Rows, corners: &Rows, layouts: [Layout; 2]) -> Arrays {
    let at_corners = |is_wide| (is_wide, Location::Corner, Some(FILL));
    let of_q = (true, Location::Center, Some(FILL));
    vec![
        ("q", cells.array(LEVEL_FASTEST, of_q, |c, l| value(c, l, 1), |_| f64::NAN)),
        ("t", corners.array(layouts[0], at_corners(false), |c, l| value(c, l, 3), |_| f64::NAN)),
        ("heights", corners.array(layouts[1], at_corners(true), height, |layer| -1e3 * layer as f64)),
    ]
}

/// The fields q at centres and t at corners, on heights at corners.
fn mixed_scene(first: &str) -> Scene {
    let mut scene = rich_scene();
    scene.volumes.iter_mut().zip([first, if first == "q" { "t" } else { "q" }]).for_each(|(v, f)| v.field = f.into());
    scene.scenery.heights = Heights::Native;
    scene
}

#[test]
fn fields_at_corners_make_the_very_picture_of_the_whole() {
    let (mesh, grid) = icosahedral(3);
    let (cells, corners) = (mesh.cells(), mesh.lon_corner_rad.len());
    // Also of the field at corners alone.
    let plain = Scene { volumes: vec![mixed_scene("t").volumes.swap_remove(0)], ..scene("") };
    let scenes = [mixed_scene("q"), mixed_scene("t"), plain];
    let of_whole = arrays(&Rows::all(cells), &Rows::all(corners), [LEVEL_FASTEST; 2]);
    let bytes = [cells * 8 + corners * (4 + 8), cells * 8 + corners * (4 + 8), corners * 4];
    let whole = [0, 1, 2].map(|k| (alone(&grid, &scenes[k], &of_whole), bytes[k] * LAYERS));
    assert!(whole[2].0.report.value_range.is_some_and(|[low, high]| low < high));
    let layouts = [[LEVEL_FASTEST, CELL_FASTEST], [BLOCKED, LEVEL_FASTEST]];
    for (i, node_of) in [&[0, 0][..], &[0, 0, 0], &[0, 1], &[2, 1, 1, 0]].into_iter().enumerate() {
        let ranks = node_of.len();
        let owner = &partitions(cells, ranks)[i % 3];
        let locals = locals(mesh, ranks, owner);
        let of_corners = &partitions(corners, ranks)[(i + 1) % 3];
        for is_numbered in [true, false] {
            assert_made(node_of, &whole, &format!("numbers {is_numbered}"), |ranks| {
                let (rank, grid) = (ranks.rank(), Grid::new(mesh.tables()).unwrap());
                let local = &locals[rank];
                // Without numbers there are all corners, and those are own whose first cell is.
                let owns = |corner: usize| owner_of_corner(mesh, owner, corner) == rank;
                let mine = match is_numbered {
                    true => numbered(corners, rank, of_corners),
                    false => Rows::new((0..corners).collect(), |corner| corner as i64, owns),
                };
                let decomposition = decomposition(ranks, &grid, local, is_numbered.then_some(&mine)).unwrap();
                let Decomposition::Columns(columns) = &decomposition else { panic!("not columns") };
                assert_eq!(columns.of_field_at(Location::Corner), mine.rows.len());
                assert_eq!(columns.of_field_at(Location::Center), local.rows.len());
                let arrays = arrays(local, &mine, layouts[i % 2]);
                scenes.each_ref().map(|scene| render(ranks, scene, &grid, &decomposition, fields(&arrays)).unwrap())
            });
        }
    }
}

/// Statistics of conditions count each corner once.
#[test]
fn a_rank_without_corners_has_none_of_a_field() {
    let (mesh, grid) = icosahedral(2);
    let corners = mesh.lon_corner_rad.len();
    let locals = locals(mesh, 2, &partitions(mesh.cells(), 2)[0]);
    let summaries = on_nodes(&[0, 0], |ranks| {
        let rank = ranks.rank();
        let mine = if rank == 0 { numbered(corners, 0, &vec![0; corners]) } else { Rows::default() };
        let decomposition = decomposition(ranks, &grid, &locals[rank], (rank == 0).then_some(&mine)).unwrap();
        let values: Vec<f64> = mine.rows.iter().map(|corner| *corner as f64).collect();
        let field = Field::level_fastest(&values, 1, Location::Corner);
        let asked = [icoray::Statistic::Max, icoray::Statistic::Mean];
        let summary = Renderer::new(1).unwrap().summary(ranks, &field.unwrap(), Some(&decomposition), &asked).unwrap();
        asked.map(|statistic| summary.get(statistic).unwrap())
    });
    let most = corners as f64 - 1.0;
    assert_eq!(summaries, [[most, most / 2.0]; 2]);
}

#[test]
fn corners_that_do_not_fit_are_refused_on_all_ranks() {
    let (mesh, grid) = icosahedral(2);
    let (cells, corners) = (mesh.cells(), mesh.lon_corner_rad.len());
    let locals = locals(mesh, 3, &partitions(cells, 3)[1]);
    let owner = &partitions(corners, 3)[0];
    type Damage = fn(&mut Vec<i64>, &mut Vec<i32>);
    let cases: [(Damage, &str); 6] = [
        (
            |global, _| global[3] = 320,
            "rank 1: corner_global row 3: 320, expected 0 to 319, a row of the grid's tables",
        ),
        (|global, _| global[3] = -1, "rank 1: corner_global row 3: -1, expected 0 to 319"),
        (|global, _| global[3] = global[8], "rank 1: corner_global rows 3 and 8: both "),
        (|_, marks| marks.fill(0), "rank 1: corner 107 of the whole grid is owned by no rank"),
        (|_, marks| marks.truncate(5), "rank 1: is_corner_owned: 5 rows, expected "),
        (
            |global, marks| {
                global.push(0);
                marks.push(1);
            },
            "rank 0: corner 0 is owned by ranks 0 and 1, expected one owner",
        ),
    ];
    for (damage, words) in cases {
        let refused = on_nodes(&[0, 1, 0], |ranks| {
            let mut mine = numbered(corners, ranks.rank(), owner);
            if ranks.rank() == 1 {
                // Without the halo, which has corner 0 perhaps.
                mine = Rows::own(mine.rows.into_iter().filter(|corner| owner[*corner] == 1).collect());
                damage(&mut mine.global, &mut mine.owned);
            }
            refusal(decomposition(ranks, &grid, &locals[ranks.rank()], Some(&mine)))
        });
        assert_same_refusal(&refused, ErrorKind::Grid, words);
    }
    // A single rank has all of them, as they are in the tables.
    let alone = |damage: fn(&mut Vec<i64>)| {
        let (mut mine, all) = (Rows::all(corners), Rows::all(cells));
        damage(&mut mine.global);
        let count = mine.global.len();
        let corners = PartCorners { owned: Owned::First(count), ..mine.corners() };
        let cells = PartCells { owned: Owned::First(cells), ..all.cells() };
        Decomposition::with_corners(&mut Ranks::alone(), &grid, &cells, Some(&corners))
    };
    assert!(matches!(alone(|_| ()), Ok(Decomposition::Whole)));
    let (_, words) = refusal(alone(|global| global.swap(4, 9)));
    assert_eq!(words, "corner_global row 4: 9, expected 4: one rank has corners in the tables' order");
    let (_, words) = refusal(alone(|global| global.truncate(319)));
    assert_eq!(words, "corner_global: 319 rows, expected 320, one per corner");
    // With parts, either all ranks have a number for each corner of their tables, or none has.
    let refused = on_nodes(&[0, 0], |ranks| {
        let own = |cell: usize| cell % 2 == ranks.rank();
        let part = Rows::new((0..cells).collect(), |cell| cell as i64, own);
        let corners = PartCorners { owned: Owned::First(0), ..part.corners() };
        let corners = (ranks.rank() == 1).then_some(&corners);
        refusal(Decomposition::with_corners(ranks, &grid, &part.cells(), corners))
    });
    assert_same_refusal(
        &refused,
        ErrorKind::Grid,
        "rank 0: corner_global: missing here and given on other ranks, expected on all or none",
    );
}

#[test]
fn fields_that_ranks_have_at_other_places_are_an_error() {
    let (mesh, grid) = icosahedral(2);
    let corners = mesh.lon_corner_rad.len();
    let locals = locals(mesh, 3, &partitions(mesh.cells(), 3)[1]);
    let cases: [(ErrorKind, &str); 2] = [
        (ErrorKind::Mpi, "rank 1: has \"q\" at corners, but \"q\" at centres on rank 0"),
        (ErrorKind::Field, "rank 1: \"q\": 5 columns, expected "),
    ];
    for (is_short, (kind, words)) in cases.into_iter().enumerate() {
        let refusals = on_nodes(&[0, 1, 0], |ranks| {
            let mine = numbered(corners, ranks.rank(), &partitions(corners, 3)[1]);
            let local = &locals[ranks.rank()];
            let decomposition = decomposition(ranks, &grid, local, Some(&mine)).unwrap();
            let (columns, location) = match (ranks.rank(), is_short) {
                (1, 0) => (mine.rows.len(), Location::Corner),
                (1, _) => (5, Location::Corner),
                _ => (local.rows.len(), Location::Center),
            };
            let array = Array::new(LEVEL_FASTEST(columns), true, location, None, |_, _| 0.5);
            refusal(render(ranks, &scene(""), &grid, &decomposition, &array.field()))
        });
        assert_same_refusal(&refusals, kind, words);
        assert!(is_short == 0 || refusals[0].1.contains("one per row of corner_global"), "{}", refusals[0].1);
    }
}
