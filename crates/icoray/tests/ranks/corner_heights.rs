//! Heights at corners, as ICON has them: the picture of the same heights averaged by hand to cells, alone and over ranks.

use crate::common::{
    FAR, LIT, NEAR, assert_same_refusal, at_centers, bits, columns_of, count_beyond, icosahedral, laid_out,
    level_fastest, on_ranks, over_columns, picture, refusal, render_decomposed, waves,
};
use crate::culled::{Culled, Mark, Style, directions, holes};
use crate::spread::{Spread, partitions, without_holes};
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
    let mut scene = Scene::parse(&format!(
        "field = \"f\"\nexaggeration = 60\ntolerance = 1e-4\ncore = \"#405060\"\n{keys}\n[image]\nwidth = 60\nheight = 52\n\
         [camera]\n{camera}\n[transfer]\nmap = \"viridis\"\nrange = [-1.5, 2.5]\n\
         opacity = [[-1.5, 0.5], [0, 0.05], [0.4, 0.8], [2.5, 0.3]]\n{tables}\n"
    ))
    .unwrap();
    scene.scenery.heights = Heights::Native;
    scene
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

/// A field at all cells or corners.
fn values(mesh: &IcosahedralMesh, location: Location) -> Vec<f32> {
    waves(mesh, location, LAYERS).into_iter().map(|value| value as f32).collect()
}

fn corners(values: &[f64]) -> Field<'_> {
    let shape = Shape::level_fastest(values.len() / LAYERS, LAYERS);
    Field::new(values.into(), shape, Location::Corner, Some(FILL)).unwrap()
}

fn fields<'f>(f: Field<'f>, heights: Field<'f>) -> Fields<'f> {
    Fields::new([("f", f)]).with_heights(heights)
}

/// What one process draws, of heights averaged by hand.
fn expected(mesh: &IcosahedralMesh, scene: &Scene, location: Location) -> Frame {
    let grid = Grid::new(mesh.tables()).unwrap();
    let (values, heights) = (values(mesh, location), averaged(&grid, &corner_heights(mesh), |height| height));
    let fields = fields(level_fastest(&values, LAYERS, location), at_centers(&heights, LAYERS));
    Renderer::new(2).unwrap().render(scene, &grid, &layers(), fields).unwrap()
}

/// In both precisions and all layouts, from both ends.
#[test]
fn heights_at_corners_are_averaged_to_the_bit() {
    let (mesh, grid) = icosahedral(3);
    let (field, heights) = (values(mesh, Location::Center), corner_heights(mesh));
    let count = grid.triangles();
    let renderer = Renderer::new(2).unwrap();
    for (i, scene) in scenes().into_iter().enumerate() {
        let shape = [Shape::level_fastest, Shape::cell_fastest, |c, l| Shape::blocked(c, l, 7)][i](count, LAYERS);
        let wide = laid_out(&shape, f64::NAN, |corner, layer| heights[corner * LAYERS + layer]);
        let narrow = OwnedReals::F32(wide.iter().map(|height| *height as f32).collect());
        type Round = fn(f64) -> f64;
        let cases: [(OwnedReals, f64, Round); 2] =
            [(OwnedReals::F64(wide), FILL, |h| h), (narrow, f64::from(FILL as f32), |h| f64::from(h as f32))];
        for (given, fill, round) in &cases {
            let given = Field::new(given.as_reals(), shape, Location::Corner, Some(*fill)).unwrap();
            let by_hand = averaged(&grid, &heights, round);
            let draw = |heights| {
                let fields = fields(at_centers(&field, LAYERS), heights);
                renderer.render(&scene, &grid, &layers(), fields).unwrap()
            };
            let [frame, again, by_hand] = [given, given, at_centers(&by_hand, LAYERS)].map(draw);
            assert!(bits(&frame) == bits(&by_hand) && bits(&again) == bits(&by_hand), "scene {i}");
            let bytes = [&frame, &by_hand].map(|frame| frame.report.bytes_derived);
            assert_eq!(bytes[0] - bytes[1], grid.cells() * LAYERS * if *fill == FILL { 8 } else { 4 });
            assert!(!frame.report.left_out.iter().any(|what| what == "table cell_corner"), "it is read");
        }
        // Mean layers are another picture, and read none of it.
        let mut mean = scene.clone();
        mean.scenery.heights = Heights::Mean;
        let [native, mean] = [&scene, &mean].map(|scene| {
            let fields = fields(at_centers(&field, LAYERS), corners(&heights));
            renderer.render(scene, &grid, &layers(), fields).unwrap()
        });
        assert!(bits(&native) != bits(&mean), "scene {i}");
    }
}

#[test]
fn averages_beside_holes_are_of_the_corners_that_are_there() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let (all, heights) = (values(&mesh, Location::Center), corner_heights(&mesh));
    for (i, (name, stays)) in holes(&mesh).iter().enumerate() {
        let style = [Style::Corners, Style::Triangles][i % 2];
        let culled = Culled::new(&mesh, stays, style, Mark::MinusOne, 0);
        let grid = culled.grid();
        let kept = columns_of(&all, &culled.cells, LAYERS);
        let heights = columns_of(&heights, &culled.corners, LAYERS);
        let by_hand = averaged(&grid, &heights, |height| height);
        let scene = &scenes()[i % 3];
        let [frame, by_hand] = [corners(&heights), at_centers(&by_hand, LAYERS)].map(|heights| {
            let fields = fields(at_centers(&kept, LAYERS), heights);
            Renderer::new(1).unwrap().render(scene, &grid, &layers(), fields).unwrap()
        });
        assert!(bits(&frame) == bits(&by_hand), "{name}");
    }
}

#[test]
fn tiles_of_whole_grids_are_bitwise_one_process() {
    let (mesh, grid) = icosahedral(3);
    let (values, heights) = (values(mesh, Location::Corner), corner_heights(mesh));
    for scene in scenes() {
        let expected = expected(mesh, &scene, Location::Corner);
        for count in 1..=3 {
            let (frame, _) = picture(on_ranks(count, |ranks| {
                let fields = fields(level_fastest(&values, LAYERS, Location::Corner), corners(&heights));
                Renderer::new(1).unwrap().render_over(ranks, &scene, &grid, &layers(), fields).unwrap()
            }));
            assert!(bits(&frame) == bits(&expected), "{count} ranks");
        }
    }
}

/// A rank's field at centres and its heights at corners, not numbers where they are not its own.
fn own_of(mesh: &IcosahedralMesh, culled: &Culled, owner: &[usize], rank: usize) -> (Vec<f32>, Vec<f64>) {
    let mut field = columns_of(&values(mesh, Location::Center), &culled.cells, LAYERS);
    let mut heights = columns_of(&corner_heights(mesh), &culled.corners, LAYERS);
    for (column, _) in culled.cells.iter().enumerate().filter(|(_, cell)| owner[**cell] != rank) {
        field[column * LAYERS..][..LAYERS].fill(f32::NAN);
    }
    let is_here = |cell: &&i32| culled.cells.binary_search(&(**cell as usize)).is_ok();
    let first = |corner: usize| mesh.corner_cell[3 * corner..][..3].iter().find(is_here);
    for (column, corner) in culled.corners.iter().enumerate() {
        if first(*corner).is_none_or(|cell| owner[*cell as usize] != rank) {
            // Heights that fall are not looked at either.
            heights[column * LAYERS..][..LAYERS].copy_from_slice(&[4.0, 3.0, f64::NAN, 1e9]);
        }
    }
    (field, heights)
}

/// The rims of parts get the corners that other ranks own.
#[test]
fn parts_are_those_of_one_process() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    for (i, scene) in scenes().into_iter().enumerate() {
        let scene = Scene { antialias: false, ..scene };
        let expected = expected(&mesh, &scene, Location::Center);
        for node_of in [&[0][..], &[0, 0], &[0, 0, 0], &[0, 1], &[0, 1, 0], &[2, 1, 0]] {
            let (partition, owner) = partitions(&mesh, node_of.len()).swap_remove((i + node_of.len()) % 4);
            let spread = Spread::new(&mesh, node_of.len(), &owner);
            let (frame, reports) = picture(spread.on_nodes(node_of, |ranks, culled, grid, decomposition| {
                let (field, heights) = own_of(&mesh, culled, &owner, ranks.rank());
                let fields = fields(at_centers(&field, LAYERS), corners(&heights));
                render_decomposed(ranks, &scene, (grid, &decomposition.unwrap()), &layers(), fields).unwrap()
            }));
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
    let heights = corner_heights(&mesh);
    for (i, (name, stays)) in holes(&mesh).iter().enumerate() {
        let culled = Culled::new(&mesh, stays, Style::Corners, Mark::BeforeFirst, 1);
        let grid = culled.grid();
        let kept = columns_of(&values(&mesh, Location::Center), &culled.cells, LAYERS);
        let by_hand = averaged(&grid, &columns_of(&heights, &culled.corners, LAYERS), |height| height);
        let scene = &scenes()[i % 3];
        let by_hand = fields(at_centers(&kept, LAYERS), at_centers(&by_hand, LAYERS));
        let expected = Renderer::new(2).unwrap().render(scene, &grid, &layers(), by_hand).unwrap();
        let ranks = 2 + i % 2;
        let (partition, owner) = partitions(&mesh, ranks).swap_remove(i % 4);
        let owner = without_holes(owner, stays);
        let spread = Spread::with_corners(&mesh, ranks, &owner);
        let (frame, _) = picture(spread.on_nodes(&vec![0; ranks], |ranks, culled, grid, decomposition| {
            let (field, heights) = own_of(&mesh, culled, &owner, ranks.rank());
            let fields = fields(at_centers(&field, LAYERS), corners(&heights));
            render_decomposed(ranks, scene, (grid, &decomposition.unwrap()), &layers(), fields).unwrap()
        }));
        assert!(bits(&frame) == bits(&expected), "{name}, {partition} on {ranks}");
    }
}

#[test]
fn bad_heights_on_one_rank_are_the_error_of_all() {
    let (mesh, grid) = icosahedral(2);
    let scene = scene(FAR, "", "");
    let (all, good) = (values(mesh, Location::Center), corner_heights(mesh));
    type Damage = fn(&mut Vec<f64>);
    let cases: [(Damage, &str); 3] = [
        (|h| h[LAYERS * 7 + 2] = -5e3, "heights: corner 7 (counted from 0), layers 3 and 2 of 4: -5000 m lies below"),
        (|h| h[LAYERS * 9 + 1] = FILL, "heights: corner 9 (counted from 0), layer 2 of 4: missing, but"),
        (|h| h.truncate(300 * LAYERS), "heights: 300 columns of 4 layers at Corner, expected 320 of 4 at Corner"),
    ];
    for (damage, words) in cases {
        let refused = on_ranks(3, |ranks| {
            let mut heights = good.clone();
            if ranks.rank() == 1 {
                damage(&mut heights);
            }
            let fields = fields(at_centers(&all, LAYERS), corners(&heights));
            refusal(Renderer::new(1).unwrap().render_over(ranks, &scene, &grid, &layers(), fields))
        });
        assert_same_refusal(&refused, ErrorKind::Layers, &format!("rank 1: {words}"));
    }
    // Of parts, on the rank that has the values.
    let (_, owner) = partitions(mesh, 2).swap_remove(0);
    let refused = Spread::new(mesh, 2, &owner).on_nodes(&[0, 0], |ranks, culled, grid, decomposition| {
        let (field, mut heights) = own_of(mesh, culled, &owner, ranks.rank());
        let first = |corner: &usize| owner[mesh.corner_cell[3 * corner] as usize] == ranks.rank() && corner % 11 != 4;
        let column = culled.corners.iter().position(first).unwrap();
        if ranks.rank() == 1 {
            heights[column * LAYERS + 3] = -7e3;
        }
        let fields = fields(at_centers(&field, LAYERS), corners(&heights));
        (column, refusal(render_decomposed(ranks, &scene, (grid, &decomposition.unwrap()), &layers(), fields)))
    });
    let (columns, refused): (Vec<usize>, Vec<_>) = refused.into_iter().unzip();
    let words = format!("rank 1: heights: corner {} (counted from 1), layers 4 and 3 of 4: -7000 m", columns[1] + 1);
    assert_same_refusal(&refused, ErrorKind::Layers, &words);
}

/// No rank waits for halos that another does not send, or reads columns of another length.
#[test]
fn ranks_that_have_heights_at_other_places_are_an_error() {
    let (mesh, grid) = icosahedral(2);
    let scene = scene(FAR, "", "");
    let (all, good) = (values(mesh, Location::Center), corner_heights(mesh));
    let centers = vec![0.0; mesh.cells() * LAYERS];
    let heights = |rank: usize| if rank == 1 { at_centers(&centers, LAYERS) } else { corners(&good) };
    let (_, owner) = partitions(mesh, 3).swap_remove(1);
    let spread = Spread::new(mesh, 3, &owner);
    let tiles = on_ranks(3, |ranks| {
        let fields = fields(at_centers(&all, LAYERS), heights(ranks.rank()));
        refusal(Renderer::new(1).unwrap().render_over(ranks, &scene, &grid, &layers(), fields))
    });
    let start = "rank 1: has heights at centres, but heights of 4 layers of 64 bits at corners on rank 0";
    assert_same_refusal(&tiles, ErrorKind::Mpi, start);
    for node_of in [&[0, 0, 0], &[0, 1, 0]] {
        let parts = spread.on_nodes(node_of, |ranks, culled, grid, decomposition| {
            let kept = columns_of(&all, &culled.cells, LAYERS);
            let centers = vec![0.0; culled.cells.len() * LAYERS];
            let good = columns_of(&good, &culled.corners, LAYERS);
            let heights = if ranks.rank() == 1 { at_centers(&centers, LAYERS) } else { corners(&good) };
            let fields = fields(at_centers(&kept, LAYERS), heights);
            refusal(render_decomposed(ranks, &scene, (grid, &decomposition.unwrap()), &layers(), fields))
        });
        let start = "rank 1: has heights at centres, but heights at corners on rank 0";
        assert_same_refusal(&parts, ErrorKind::Mpi, start);
    }
}
