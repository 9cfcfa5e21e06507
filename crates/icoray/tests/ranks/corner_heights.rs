//! Heights at corners, as ICON has them: the picture of the same heights averaged by hand to cells, alone and over ranks.

use crate::common::*;
use crate::culled::{Culled, Mark, Style, directions, holes};
use crate::spread::{Rows, Spread, partitions, without_holes};
use icoray::{
    ErrorKind, Field, Fields, Frame, Grid, Heights, IcosahedralMesh, Layers, Location, OwnedReals, Renderer, Scene,
    Shape,
};

const LAYERS: usize = 4;
const FILL: f64 = -9e9;

fn layers() -> Layers {
    Layers::from_heights(&[0.0, 4e3, 10e3, 18e3], 6371e3).unwrap()
}

fn scene(camera: &str, keys: &str, tables: &str) -> Scene {
    let keys = format!(
        "heights = \"native\"\nexaggeration = 60\ntolerance = 1e-4\ncore = \"#405060\"\n{keys}\n\
         image = {{ width = 60, height = 52 }}"
    );
    crate::common::scene(camera, HAZE, &format!("{keys}|{tables}"))
}

fn scenes() -> Vec<Scene> {
    vec![scene(FAR, "", ""), scene(NEAR, "", LIT), scene(FAR, "precision = \"f64\"", LIT)]
}

/// Heights of all corners: steep, equal between two layers at some, of few digits so that they are the same in f32. Some
/// columns have none, and neither has any around the cells 12 and 100.
fn corner_heights(mesh: &IcosahedralMesh) -> Vec<f64> {
    let without = |corner: usize| {
        let cells = &mesh.corner_cell[3 * corner..][..3];
        corner % 11 == 4 || cells.contains(&12) || cells.contains(&100)
    };
    let at = directions(&mesh.lon_corner_rad, &mesh.lat_corner_rad);
    let column = |(corner, p): (usize, &glam::DVec3)| {
        let ground = (1e3 * (7.0 * p.x).sin() * (5.0 * p.y).cos() + (corner * 7919 % 13) as f64 * 60.0).round();
        let second = if corner.is_multiple_of(5) { ground } else { 4e3 + (0.7 * ground).round() };
        let column = [ground, second, 10e3 + (0.4 * ground).round(), 18e3];
        if without(corner) { [FILL; LAYERS] } else { column }
    };
    at.iter().enumerate().flat_map(column).collect()
}

/// The mean over the corners around each cell that have heights, rounded to the precision of the heights.
fn averaged(grid: &Grid, heights: &[f64], round: impl Fn(f64) -> f64) -> Vec<f64> {
    over_columns(grid.cells(), LAYERS, |cell, layer| {
        let around = grid.corners_of(cell as u32).map(|corner| heights[corner as usize * LAYERS + layer]);
        let there: Vec<f64> = around.filter(|height| *height != FILL).collect();
        if there.is_empty() { f64::NAN } else { round(there.iter().sum::<f64>() / there.len() as f64) }
    })
}

fn level_fastest(columns: usize) -> Shape {
    Shape::level_fastest(columns, LAYERS)
}

fn corners(values: &[f64]) -> Field<'_> {
    Field::new(values.into(), level_fastest(values.len() / LAYERS), Location::Corner, Some(FILL)).unwrap()
}

/// The field f at cells or corners and heights at corners. Those of other ranks are no numbers, or fall.
fn arrays(mesh: &IcosahedralMesh, location: Location, [cells, corners]: [&Rows; 2]) -> Arrays {
    let (f, heights) = (waves(mesh, location, LAYERS), corner_heights(mesh));
    let rows = if location == Location::Center { cells } else { corners };
    let f = rows.array(level_fastest, (false, location, None), |row, layer| f[row * LAYERS + layer], |_| f64::NAN);
    let height = |corner: usize, layer: usize| heights[corner * LAYERS + layer];
    let falling = |layer: usize| [4.0, 3.0, f64::NAN, 1e9][layer];
    let heights = corners.array(level_fastest, (true, Location::Corner, Some(FILL)), height, falling);
    vec![("f", f), ("heights", heights)]
}

fn draw(grid: &Grid, scene: &Scene, arrays: &Arrays) -> Frame {
    Renderer::new(2).unwrap().render(scene, grid, &layers(), fields(arrays)).unwrap()
}

/// What one process draws of a grid of these rows, of heights averaged by hand.
fn expected(mesh: &IcosahedralMesh, scene: &Scene, location: Location, grid: &Grid, rows: [&Rows; 2]) -> Frame {
    let mut arrays = arrays(mesh, location, rows);
    let Array { values: OwnedReals::F64(heights), .. } = &arrays[1].1 else { panic!("heights in f32") };
    let by_hand = averaged(grid, heights, |height| height);
    let average = |cell: usize, layer: usize| by_hand[cell * LAYERS + layer];
    arrays[1].1 = Array::new(level_fastest(grid.cells()), true, Location::Center, None, average);
    draw(grid, scene, &arrays)
}

/// The rows of a mesh without its cells that do not stay.
fn rows_of(culled: &Culled) -> [Rows; 2] {
    [&culled.cells, &culled.corners].map(|rows| Rows::own(rows.clone()))
}

/// In both precisions and all layouts, from both ends.
#[test]
fn heights_at_corners_are_averaged_to_the_bit() {
    let (mesh, grid) = icosahedral(3);
    let heights = corner_heights(mesh);
    let all = [&Rows::all(grid.cells()), &Rows::all(grid.triangles())];
    let (f, heights_of_f64) = (&arrays(mesh, Location::Center, all)[0].1, corners(&heights));
    let renderer = Renderer::new(2).unwrap();
    for (i, scene) in scenes().into_iter().enumerate() {
        let shape = [Shape::level_fastest, Shape::cell_fastest, |c, l| Shape::blocked(c, l, 7)][i];
        let draw = |scene: &Scene, heights: Field| {
            let fields = Fields::new([("f", f.field())]).with_heights(heights);
            renderer.render(scene, &grid, &layers(), fields).unwrap()
        };
        for is_wide in [true, false] {
            let height = |corner: usize, layer: usize| heights[corner * LAYERS + layer];
            let shape = shape(grid.triangles(), LAYERS);
            let given = Array::new(shape, is_wide, Location::Corner, Some(FILL), height);
            let round = |height: f64| if is_wide { height } else { f64::from(height as f32) };
            let by_hand = averaged(&grid, &heights, round);
            let [frame, again, by_hand] =
                [given.field(), given.field(), at_centers(&by_hand, LAYERS)].map(|heights| draw(&scene, heights));
            assert!(bits(&frame) == bits(&by_hand) && bits(&again) == bits(&by_hand), "scene {i}");
            let bytes = [&frame, &by_hand].map(|frame| frame.report.bytes_derived);
            assert_eq!(bytes[0] - bytes[1], grid.cells() * LAYERS * if is_wide { 8 } else { 4 });
            assert!(!frame.report.left_out.iter().any(|what| what == "table cell_corner"), "it is read");
        }
        // Mean layers are another picture, and read none of it.
        let mut mean = scene.clone();
        mean.scenery.heights = Heights::Mean;
        let [native, mean] = [&scene, &mean].map(|scene| draw(scene, heights_of_f64));
        assert!(bits(&native) != bits(&mean), "scene {i}");
    }
}

#[test]
fn averages_beside_holes_are_of_the_corners_that_are_there() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    for (i, (name, stays)) in holes(&mesh).iter().enumerate() {
        let style = [Style::Corners, Style::Triangles][i % 2];
        let culled = Culled::new(&mesh, stays, style, Mark::MinusOne, 0);
        let (grid, scene, [cells, corners]) = (culled.grid(), &scenes()[i % 3], rows_of(&culled));
        let rows = [&cells, &corners];
        let frame = draw(&grid, scene, &arrays(&mesh, Location::Center, rows));
        assert!(bits(&frame) == bits(&expected(&mesh, scene, Location::Center, &grid, rows)), "{name}");
    }
}

#[test]
fn tiles_of_whole_grids_are_bitwise_one_process() {
    let (mesh, grid) = icosahedral(3);
    let all = [&Rows::all(grid.cells()), &Rows::all(grid.triangles())];
    let arrays = arrays(mesh, Location::Corner, all);
    for scene in scenes() {
        let expected = expected(mesh, &scene, Location::Corner, &grid, all);
        for count in 1..=3 {
            let (frame, _) = picture(on_ranks(count, |ranks| {
                Renderer::new(1).unwrap().render_over(ranks, &scene, &grid, &layers(), fields(&arrays)).unwrap()
            }));
            assert!(bits(&frame) == bits(&expected), "{count} ranks");
        }
    }
}

/// A rank's own field at centres and heights at corners.
fn own_of(mesh: &IcosahedralMesh, spread: &Spread, rank: usize) -> Arrays {
    arrays(mesh, Location::Center, [&spread.cells[rank], &spread.corners[rank]])
}

/// The rims of parts get the corners that other ranks own.
#[test]
fn parts_are_those_of_one_process() {
    let (mesh, grid) = icosahedral(3);
    let all = [&Rows::all(grid.cells()), &Rows::all(grid.triangles())];
    for (i, scene) in scenes().into_iter().enumerate() {
        let scene = Scene { antialias: false, ..scene };
        let expected = expected(mesh, &scene, Location::Center, &grid, all);
        for node_of in [&[0][..], &[0, 0], &[0, 0, 0], &[0, 1], &[0, 1, 0], &[2, 1, 0]] {
            let (partition, owner) = partitions(mesh, node_of.len()).swap_remove((i + node_of.len()) % 4);
            let spread = Spread::new(mesh, node_of.len(), &owner);
            let (frame, reports) = spread.draw(node_of, &scene, &layers(), |rank| vec![own_of(mesh, &spread, rank)]);
            let trying = format!("scene {i}, {partition} on {node_of:?}");
            if node_of.iter().all(|node| *node == 0) {
                assert!(bits(&frame) == bits(&expected), "{trying}");
                let copied: u64 = reports.iter().map(|report| report.bytes_copied).sum();
                // The field; heights are averaged where they are.
                let all = mesh.cells() * LAYERS * 4;
                assert_eq!(copied, if node_of.len() > 1 { all as u64 } else { 0 }, "{trying}");
            } else {
                let wrong = count_beyond(&frame, &expected, 1e-6);
                assert!(wrong <= 3, "{trying}: {wrong} pixels");
            }
        }
    }
}

/// Beside the mesh's own holes: the rows of tables have the order that they have in the whole.
#[test]
fn parts_of_meshes_with_holes_are_bitwise_one_process() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    for (i, (name, stays)) in holes(&mesh).iter().enumerate() {
        let culled = Culled::new(&mesh, stays, Style::Corners, Mark::BeforeFirst, 1);
        let (scene, [cells, corners]) = (&scenes()[i % 3], rows_of(&culled));
        let expected = expected(&mesh, scene, Location::Center, &culled.grid(), [&cells, &corners]);
        let ranks = 2 + i % 2;
        let (partition, owner) = partitions(&mesh, ranks).swap_remove(i % 4);
        let spread = Spread::with_corners(&mesh, ranks, &without_holes(owner, stays));
        let (frame, _) = spread.draw(&vec![0; ranks], scene, &layers(), |rank| vec![own_of(&mesh, &spread, rank)]);
        assert!(bits(&frame) == bits(&expected), "{name}, {partition} on {ranks}");
    }
}

#[test]
fn bad_heights_on_one_rank_are_the_error_of_all() {
    let (mesh, grid) = icosahedral(2);
    let scene = scene(FAR, "", "");
    let all = waves(mesh, Location::Center, LAYERS);
    type Damage = fn(&mut Vec<f64>);
    let cases: [(Damage, &str); 3] = [
        (|h| h[LAYERS * 7 + 2] = -5e3, "heights: corner 7 (counted from 0), layers 3 and 2 of 4: -5000 m lies below"),
        (|h| h[LAYERS * 9 + 1] = FILL, "heights: corner 9 (counted from 0), layer 2 of 4: missing, but"),
        (|h| h.truncate(300 * LAYERS), "heights: 300 columns of 4 layers at Corner, expected 320 of 4 at Corner"),
    ];
    for (damage, words) in cases {
        let refused = on_ranks(3, |ranks| {
            let mut heights = corner_heights(mesh);
            if ranks.rank() == 1 {
                damage(&mut heights);
            }
            let fields = Fields::new([("f", at_centers(&all, LAYERS))]).with_heights(corners(&heights));
            refusal(Renderer::new(1).unwrap().render_over(ranks, &scene, &grid, &layers(), fields))
        });
        assert_same_refusal(&refused, ErrorKind::Layers, &format!("rank 1: {words}"));
    }
    // Of parts, on the rank that has the values.
    let (_, owner) = partitions(mesh, 2).swap_remove(0);
    let spread = Spread::new(mesh, 2, &owner);
    let Rows { rows, owned, .. } = &spread.corners[1];
    let column = (0..rows.len()).find(|column| owned[*column] == 1 && rows[*column] % 11 != 4).unwrap();
    let refused = spread.render(&[0, 0], &scene, &layers(), |rank| {
        let mut arrays = own_of(mesh, &spread, rank);
        if let (OwnedReals::F64(heights), 1) = (&mut arrays[1].1.values, rank) {
            heights[column * LAYERS + 3] = -7e3;
        }
        vec![arrays]
    });
    let words = format!("rank 1: heights: corner {} (counted from 1), layers 4 and 3 of 4: -7000 m", column + 1);
    assert_same_refusal(&refused.into_iter().map(refusal).collect::<Vec<_>>(), ErrorKind::Layers, &words);
}

/// No rank waits for halos that another does not send, or reads columns of another length.
#[test]
fn ranks_that_have_heights_at_other_places_are_an_error() {
    let (mesh, grid) = icosahedral(2);
    let scene = scene(FAR, "", "");
    let (_, owner) = partitions(mesh, 3).swap_remove(1);
    let spread = Spread::new(mesh, 3, &owner);
    let whole = |rank: usize, rows: [&Rows; 2]| {
        let mut arrays = arrays(mesh, Location::Center, rows);
        if rank == 1 {
            arrays[1].1 = Array::new(level_fastest(rows[0].rows.len()), true, Location::Center, None, |_, _| 0.0);
        }
        arrays
    };
    let tiles = on_ranks(3, |ranks| {
        let arrays = whole(ranks.rank(), [&Rows::all(grid.cells()), &Rows::all(grid.triangles())]);
        refusal(Renderer::new(1).unwrap().render_over(ranks, &scene, &grid, &layers(), fields(&arrays)))
    });
    let start = "rank 1: has heights at centres, but heights of 4 layers of 64 bits at corners on rank 0";
    assert_same_refusal(&tiles, ErrorKind::Mpi, start);
    for node_of in [&[0, 0, 0], &[0, 1, 0]] {
        let own = |rank: usize| vec![whole(rank, [&spread.cells[rank], &spread.corners[rank]])];
        let parts = spread.render(node_of, &scene, &layers(), own);
        let start = "rank 1: has heights at centres, but heights at corners on rank 0";
        assert_same_refusal(&parts.into_iter().map(refusal).collect::<Vec<_>>(), ErrorKind::Mpi, start);
    }
}
