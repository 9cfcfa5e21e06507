//! Fields and heights at corners of columns that are spread over ranks.

use super::fields::rich_scene;
use super::*;
use icoray::{Heights, PartCorners};

/// What a rank has at corners, by rows of the whole tables.
struct LocalCorners {
    /// The corner of each column.
    rows: Vec<usize>,
    /// Numbers of corners, where it gives them.
    numbers: Option<(Vec<i64>, Vec<i32>)>,
    is_own: Vec<bool>,
}

impl LocalCorners {
    /// Columns of its own, in an order of its own, some in a halo; ownership has nothing to do with that of cells.
    fn numbered(corners: usize, rank: usize, owner: &[usize]) -> Self {
        let is_here = |corner: &usize| owner[*corner] == rank || (rank % 2 == 1 && Random::at(*corner).below(7) == 0);
        let mut rows: Vec<usize> = (0..corners).filter(is_here).collect();
        rows.sort_by_key(|corner| Random::at(*corner + rank).bits());
        let is_own: Vec<bool> = rows.iter().map(|corner| owner[*corner] == rank).collect();
        let global = rows.iter().map(|corner| *corner as i64).collect();
        let numbers = Some((global, is_own.iter().map(|is_own| i32::from(*is_own)).collect()));
        LocalCorners { rows, numbers, is_own }
    }

    /// All corners; own ones are those whose first cell is.
    fn whole(mesh: &IcosahedralMesh, rank: usize, owner: &[usize]) -> Self {
        let rows: Vec<usize> = (0..mesh.lon_corner_rad.len()).collect();
        let is_own = rows.iter().map(|corner| owner[mesh.corner_cell[3 * corner] as usize] == rank).collect();
        LocalCorners { rows, numbers: None, is_own }
    }

    fn decomposition(&self, ranks: &mut Ranks, grid: &Grid, local: &Local) -> Result<Decomposition, Error> {
        let cells = PartCells { global: local.global.as_slice().into(), owned: Owned::Marked(&local.owned) };
        let corners = self
            .numbers
            .as_ref()
            .map(|(global, marks)| PartCorners { global: global.as_slice().into(), owned: Owned::Marked(marks) });
        Decomposition::with_corners(ranks, grid, &cells, corners.as_ref())
    }

    /// The field t and heights; what is not own is not a number, or falls.
    fn values(&self, layouts: [Layout; 2]) -> (Vec<f32>, Vec<f64>) {
        let own = |corner: usize| self.is_own[self.rows.iter().position(|row| *row == corner).unwrap()];
        let t = layouts[0].lay(&self.rows, |c, l| if own(c) { value(c, l, 3) as f32 } else { f32::NAN });
        let heights = layouts[1].lay(&self.rows, |c, l| if own(c) { height(c, l) } else { -1e3 * l as f64 });
        (t, heights)
    }
}

/// Some columns have none.
fn height(corner: usize, layer: usize) -> f64 {
    let column = 6e3 * layer as f64 + 2e3 * (0.3 * corner as f64).sin();
    if Random::at(corner).below(13) == 2 { FILL } else { column }
}

fn fields<'f>(q: &'f [f64], (t, heights): &'f (Vec<f32>, Vec<f64>), shapes: [Shape; 3]) -> Fields<'f> {
    let q = Field::new(q.into(), shapes[0], Location::Center, Some(FILL)).unwrap();
    let t = Field::new(t.as_slice().into(), shapes[1], Location::Corner, Some(f64::from(FILL as f32))).unwrap();
    let heights = Field::new(heights.as_slice().into(), shapes[2], Location::Corner, Some(FILL)).unwrap();
    Fields::new([("q", q), ("t", t)]).with_heights(heights)
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
    use Layout::{Blocked, CellFastest, LevelFastest};
    let (mesh, grid) = icosahedral(3);
    let (cells, corners) = (mesh.cells(), mesh.lon_corner_rad.len());
    let all: Vec<usize> = (0..cells).collect();
    let q = LevelFastest.lay(&all, |c, l| value(c, l, 1));
    let at_corners = LocalCorners::whole(mesh, 0, &vec![0; cells]).values([LevelFastest; 2]);
    let shapes = [cells, corners, corners].map(|columns| LevelFastest.shape(columns));
    // Also of the field at corners alone.
    let plain = Scene { volumes: vec![mixed_scene("t").volumes.swap_remove(0)], ..scene("") };
    let scenes = [mixed_scene("q"), mixed_scene("t"), plain];
    let whole = scenes.each_ref().map(|scene| {
        let fields = fields(&q, &at_corners, shapes);
        Renderer::new(1).unwrap().render(scene, &grid, &layers(), fields).unwrap()
    });
    assert!(whole[2].report.value_range.is_some_and(|[low, high]| low < high));
    let layouts = [[LevelFastest, CellFastest], [Blocked, LevelFastest]];
    for (i, node_of) in [&[0, 0][..], &[0, 0, 0], &[0, 1], &[2, 1, 1, 0]].into_iter().enumerate() {
        let ranks = node_of.len();
        let owner = &partitions(cells, ranks)[i % 3];
        let locals = locals(mesh, ranks, owner);
        let of_corners = &partitions(corners, ranks)[(i + 1) % 3];
        for is_numbered in [true, false] {
            let drawn = on_nodes(node_of, |ranks| {
                let (rank, grid) = (ranks.rank(), Grid::new(mesh.tables()).unwrap());
                let local = &locals[rank];
                let mine = match is_numbered {
                    true => LocalCorners::numbered(corners, rank, of_corners),
                    false => LocalCorners::whole(mesh, rank, owner),
                };
                let decomposition = mine.decomposition(ranks, &grid, local).unwrap();
                let Decomposition::Columns(columns) = &decomposition else { panic!("not columns") };
                assert_eq!(columns.of_field_at(Location::Corner), mine.rows.len());
                assert_eq!(columns.of_field_at(Location::Center), local.cells.len());
                let [of_t, of_heights] = layouts[i % 2];
                let q = LevelFastest.lay(&local.cells, |c, l| value(c, l, 1));
                let at_corners = mine.values([of_t, of_heights]);
                let count = mine.rows.len();
                let shapes = [LevelFastest.shape(local.cells.len()), of_t.shape(count), of_heights.shape(count)];
                scenes
                    .each_ref()
                    .map(|scene| render(ranks, scene, &grid, &decomposition, fields(&q, &at_corners, shapes)).unwrap())
            });
            for (k, (frame, reports)) in pictures(drawn).into_iter().enumerate() {
                let trying = format!("nodes {node_of:?}, numbers {is_numbered}, scene {k}");
                assert!(bits(&frame) == bits(&whole[k]), "{trying}");
                let bytes = [cells * 8 + corners * (4 + 8), cells * 8 + corners * (4 + 8), corners * 4][k] * LAYERS;
                assert_bytes_copied(node_of, &reports, bytes, &trying);
            }
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
        let mut mine = LocalCorners::numbered(corners, ranks.rank(), &vec![0; corners]);
        if ranks.rank() == 1 {
            (mine.rows, mine.numbers) = (Vec::new(), None);
        }
        let decomposition = mine.decomposition(ranks, &grid, &locals[ranks.rank()]).unwrap();
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
            let mut mine = LocalCorners::numbered(corners, ranks.rank(), owner);
            if let (1, Some((global, marks))) = (ranks.rank(), &mut mine.numbers) {
                // Without the halo, which has corner 0 perhaps.
                let own = global.iter().zip(&*marks).filter(|(_, mark)| **mark == 1).map(|(corner, _)| *corner);
                *global = own.collect();
                *marks = vec![1; global.len()];
                damage(global, marks);
            }
            refusal(mine.decomposition(ranks, &grid, &locals[ranks.rank()]))
        });
        assert_same_refusal(&refused, ErrorKind::Grid, words);
    }
    // A single rank has all of them, as they are in the tables.
    let alone = |damage: fn(&mut Vec<i64>)| {
        let mut global: Vec<i64> = (0..corners as i64).collect();
        damage(&mut global);
        let all: Vec<i64> = (0..cells as i64).collect();
        let part = PartCells { global: all.as_slice().into(), owned: Owned::First(cells) };
        let corners = PartCorners { owned: Owned::First(global.len()), global: global.as_slice().into() };
        Decomposition::with_corners(&mut Ranks::alone(), &grid, &part, Some(&corners))
    };
    assert!(matches!(alone(|_| ()), Ok(Decomposition::Whole)));
    let (_, words) = refusal(alone(|global| global.swap(4, 9)));
    assert_eq!(words, "corner_global row 4: 9, expected 4: one rank has corners in the tables' order");
    let (_, words) = refusal(alone(|global| global.truncate(319)));
    assert_eq!(words, "corner_global: 319 rows, expected 320, one per corner");
    // With parts, either all ranks have a number for each corner of their tables, or none has.
    let refused = on_nodes(&[0, 0], |ranks| {
        let all: Vec<i64> = (0..cells as i64).collect();
        let marks: Vec<i32> = (0..cells).map(|cell| i32::from(cell % 2 == ranks.rank())).collect();
        let part = PartCells { global: all.as_slice().into(), owned: Owned::Marked(&marks) };
        let corners = PartCorners { global: all.as_slice().into(), owned: Owned::First(0) };
        let corners = (ranks.rank() == 1).then_some(&corners);
        refusal(Decomposition::with_corners(ranks, &grid, &part, corners))
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
    let wide = vec![0.5; 4000];
    let cases: [(ErrorKind, &str); 2] = [
        (ErrorKind::Mpi, "rank 1: has \"q\" at corners, but \"q\" at centres on rank 0"),
        (ErrorKind::Field, "rank 1: \"q\": 5 columns, expected "),
    ];
    for (is_short, (kind, words)) in cases.into_iter().enumerate() {
        let refusals = on_nodes(&[0, 1, 0], |ranks| {
            let mine = LocalCorners::numbered(corners, ranks.rank(), &partitions(corners, 3)[1]);
            let decomposition = mine.decomposition(ranks, &grid, &locals[ranks.rank()]).unwrap();
            let columns = if is_short == 1 { 5 } else { mine.rows.len() };
            let odd = Field::level_fastest(&wide[..columns * LAYERS], LAYERS, Location::Corner).unwrap();
            let good = at_centers(&wide[..locals[ranks.rank()].cells.len() * LAYERS], LAYERS);
            refusal(render(ranks, &scene(""), &grid, &decomposition, &if ranks.rank() == 1 { odd } else { good }))
        });
        assert_same_refusal(&refusals, kind, words);
        assert!(is_short == 0 || refusals[0].1.contains("one per row of corner_global"), "{}", refusals[0].1);
    }
}
