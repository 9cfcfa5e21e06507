//! Grids that are spread over ranks: the picture that is put together of their fragments is that of the whole grid.

use icoray::{
    DistributedGrid, ErrorKind, Fields, Frame, FrameReport, Grid, Ground, IcosahedralMesh, Level, Lines, Location,
    Pattern, Rendered, Renderer, Savings, Scene, Shape,
};
use icoray_test_support::{count, is_long};
use itertools::iproduct;

use crate::common::*;
use crate::culled::{Culled, Mark, Style, holes};
use crate::spread::{Rows, Spread, partitions, without_holes};

const LAYERS: usize = HEIGHT_M.len();

/// What ranks of a node each draw of their rows.
fn draw(spread: &Spread, mesh: &IcosahedralMesh, scene: &Scene, location: Location) -> (Frame, Vec<FrameReport>) {
    let nodes: Vec<usize> = (0..spread.parts.len()).collect();
    draw_on(&nodes, spread, scene, location, &waves(mesh, location, LAYERS))
}

/// What ranks of these nodes draw of values of the whole mesh.
fn draw_on(
    nodes: &[usize],
    spread: &Spread,
    scene: &Scene,
    location: Location,
    values: &[f64],
) -> (Frame, Vec<FrameReport>) {
    spread.draw(nodes, scene, &earth_layers(), |rank| {
        let Rows { rows, global, .. } =
            if location == Location::Center { &spread.cells[rank] } else { &spread.corners[rank] };
        // Columns without a number are no cells.
        let value = |column: usize, layer: usize| match global[column] {
            0 => f64::NAN,
            _ => values[rows[column] * LAYERS + layer],
        };
        let shape = Shape::level_fastest(rows.len(), LAYERS);
        vec![vec![("f", Array::new(shape, true, location, None, value))]]
    })
}

fn whole(mesh: &IcosahedralMesh, scene: &Scene, location: Location) -> Frame {
    let grid = Grid::new(mesh.tables()).unwrap();
    let values = waves(mesh, location, LAYERS);
    let field = level_fastest(&values, LAYERS, location);
    Renderer::new(2).unwrap().render(scene, &grid, &earth_layers(), &field).unwrap()
}

/// A scene in which `rest` has further keys and, behind a bar, further tables.
fn scene(camera: &str, precision: &str, rest: &str) -> Scene {
    let keys = format!(
        "antialias = false\nexaggeration = 60\nprecision = \"{precision}\"\nimage = {{ width = 64, height = 56 }}\n{rest}"
    );
    let scene = crate::common::scene(camera, HAZE, &keys);
    // Ends of rays and rules of integration depend on what lies in front, within the tolerance.
    let tolerance = if precision == "f64" { 1e-9 } else { 1e-6 };
    if rest.contains("tolerance") { scene } else { Scene { tolerance, ..scene } }
}

const HOLLOW: &str = "core = \"transparent\"\nbackground = \"transparent\"";

const LIMITS: [(&str, f32); 2] = [("f64", 1e-6), ("f32", 1e-5)];

#[test]
fn parts_make_the_picture_of_the_whole() {
    let mesh = IcosahedralMesh::new(4).unwrap();
    let lit = &format!("|{LIT}");
    let paper = "method = \"paper\"";
    let (centers, corners) = (Location::Center, Location::Corner);
    let scenes = [
        (FAR, HOLLOW, centers),
        (NEAR, "core = \"#804020\"", centers),
        (IN_SHELL, HOLLOW, centers),
        (FAR, lit, centers),
        (NEAR, paper, centers),
        (FAR, lit, corners),
    ];
    let mut worst = [0.0f32; 2];
    for (i, (camera, rest, location)) in scenes.into_iter().enumerate() {
        for (j, (precision, limit)) in LIMITS.into_iter().enumerate() {
            let scene = scene(camera, precision, rest);
            let expected = whole(&mesh, &scene, location);
            for ranks in [1, 2, 3, 4, 5, 8] {
                let two = (0..mesh.cells()).map(|cell| if cell < 1200 { 1 } else { 3 }).collect();
                let partitions = match ranks {
                    5 => vec![("ranks without cells", two)],
                    _ => partitions(&mesh, ranks),
                };
                for (k, (name, owner)) in partitions.iter().enumerate() {
                    // In the long run each combination of two of them at least.
                    let is_left_out = (i + j + k + ranks) % count(6, 2) != 0 && (ranks != 5 || i != 3);
                    if is_left_out && (ranks > 2 || !is_long()) {
                        continue;
                    }
                    let spread = Spread::new(&mesh, ranks, owner);
                    let (frame, reports) = draw(&spread, &mesh, &scene, location);
                    let off = difference(&frame, &expected);
                    assert!(off <= limit, "{ranks} ranks, {name}, scene {i}, {precision}: {off:e}");
                    worst[j] = worst[j].max(off);
                    let report = &frame.report;
                    assert_eq!(report.value_range, expected.report.value_range, "{name}");
                    assert_eq!(report.missing_values, 0);
                    assert_eq!(report.counts.rays, expected.report.counts.rays);
                    assert_eq!(report.counts.fragment_bytes > 0, ranks > 1);
                    assert_eq!(reports.len(), ranks);
                    assert!(reports.iter().all(|r| r.counts == report.counts && r.ranks.count == ranks));
                }
            }
        }
    }
    println!("largest differences: f64 {:.1e}, f32 {:.1e}", worst[0], worst[1]);
}

/// The ranks of a node share what their renderers all compute, and in the form that all of them read.
#[test]
fn ranks_may_have_renderers_of_different_savings() {
    let mesh = IcosahedralMesh::new(4).unwrap();
    let scene = scene(FAR, "f32", &format!("tolerance = 1e-3|{LIT}"));
    let (expected, values) = (whole(&mesh, &scene, Location::Center), waves(&mesh, Location::Center, LAYERS));
    let (_, owner) = partitions(&mesh, 3).swap_remove(1);
    let (spread, layers) = (Spread::new(&mesh, 3, &owner), earth_layers());
    let odd = [Savings { packing: false, ..Savings::ALL }, Savings { ends: true, ..Savings::NONE }];
    for (nodes, odd) in iproduct!([[0, 0, 0], [0, 0, 1], [0, 1, 1]], odd) {
        let drawn = spread.on_nodes(&nodes, |ranks, _, grid, decomposition| {
            let savings = if ranks.rank() == 1 { odd } else { Savings::ALL };
            let renderer = Renderer::new(1).unwrap().with_savings(savings);
            let data = DistributedGrid { grid, decomposition: Some(&decomposition.unwrap()), layers: &layers };
            let rows = &spread.cells[ranks.rank()].rows;
            let own: Vec<f64> = rows.iter().flat_map(|row| &values[row * LAYERS..][..LAYERS]).copied().collect();
            let field = level_fastest(&own, LAYERS, Location::Center);
            renderer.render_decomposed(ranks, &scene, data, Fields::new([("f", field)])).unwrap()
        });
        let off = difference(&picture(drawn).0, &expected);
        assert!(off <= 1e-3, "{nodes:?}, {odd:?}: {off:e}");
    }
}

/// All of one node is visible, where no mask is needed, and little of the other.
#[test]
fn nodes_may_differ_in_what_is_visible() {
    let mesh = IcosahedralMesh::new(4).unwrap();
    let transfer = "map = \"viridis\"\nrange = [-1, 1]\nopacity = [[-1, 0.5], [-0.2, 0], [1, 0]]";
    let scene = crate::common::scene(FAR, transfer, "antialias = false\nexaggeration = 60\ntolerance = 1e-4");
    // The north and its halo are visible, the south hardly.
    let (lon, lat) = (&mesh.lon_center_rad, &mesh.lat_center_rad);
    let owner: Vec<usize> =
        lon.iter().zip(lat).map(|(lon, lat)| usize::from(lon.sin() > 0.0) + if *lat > 0.0 { 0 } else { 2 }).collect();
    let value = |i: usize| if lat[i / LAYERS] > -0.3 { -0.5 } else { 0.5 - (i % 97) as f64 / 100.0 };
    let values: Vec<f64> = (0..mesh.cells() * LAYERS).map(value).collect();
    let grid = Grid::new(mesh.tables()).unwrap();
    let field = level_fastest(&values, LAYERS, Location::Center);
    let expected = Renderer::new(1).unwrap().render(&scene, &grid, &earth_layers(), &field).unwrap();
    let spread = Spread::new(&mesh, 4, &owner);
    let (frame, _) = draw_on(&[0, 0, 1, 1], &spread, &scene, Location::Center, &values);
    let off = difference(&frame, &expected);
    assert!(off <= 2e-4, "{off:e}");
}

/// Copies of halo cells, of which NICAM has several for a cell.
#[test]
fn columns_that_are_no_cells_are_not_read() {
    let mesh = IcosahedralMesh::new(4).unwrap();
    let scene = scene(FAR, "f64", HOLLOW);
    let (_, owner) = partitions(&mesh, 3).swap_remove(1);
    let mut spread = Spread::new(&mesh, 3, &owner);
    // Tables of these parts mark what is missing by 0, those of the others by the number behind the last.
    for rank in [0, 2] {
        let (part, cells) = (&mut spread.parts[rank], &mut spread.cells[rank]);
        for cell in (0..cells.rows.len()).filter(|cell| cells.owned[*cell] == 0).collect::<Vec<_>>() {
            (0..2).for_each(|axis| part.lon_lat[axis].push(part.lon_lat[axis][cell]));
            part.cell_corner.extend([0; 6]);
            cells.rows.push(cells.rows[cell]);
            cells.owned.push(0);
            cells.global.push(0);
        }
    }
    let (frame, _) = draw(&spread, &mesh, &scene, Location::Center);
    let expected = whole(&mesh, &scene, Location::Center);
    assert!(difference(&frame, &expected) <= LIMITS[0].1);
    assert_eq!((frame.report.value_range, frame.report.missing_values), (expected.report.value_range, 0));
}

/// The scene with land, sea and lines on its core.
fn with_ground(mut scene: Scene) -> Scene {
    scene.scenery.ground = Ground { land: Some([0.1, 0.6, 0.1]), ocean: Some([0.0, 0.1, 0.7]) };
    let lines = |pattern| {
        let (color, width_px, opacity) = ([1.0, 0.9, 0.8], 1.5, 0.7);
        Lines { pattern, on: Level::Ground, color, width_px, opacity, region: None }
    };
    scene.scenery.lines = [Pattern::Graticule { spacing_deg: 5.0 }, Pattern::Coast].map(lines).into();
    scene
}

/// The mesh's own holes, beside those that each rank's part has: land in an ocean, with the core showing.
#[test]
fn holes_of_the_whole_are_holes_of_its_parts() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let lit = scene(NEAR, "f64", &format!("core = \"#804020\"|{LIT}"));
    let scenes =
        [scene(FAR, "f64", "core = \"#804020\""), scene(IN_SHELL, "f64", HOLLOW), lit.clone(), with_ground(lit)];
    let (mut worst, mut drawn) = (0.0f32, 0);
    for (i, (name, stays)) in holes(&mesh).iter().enumerate() {
        let culled = Culled::new(&mesh, stays, Style::Corners, Mark::BeforeFirst, 1);
        let kept = columns_of(&waves(&mesh, Location::Center, LAYERS), &culled.cells, LAYERS);
        let field = at_centers(&kept, LAYERS);
        for (k, scene) in scenes.iter().enumerate().filter(|(k, _)| is_long() || (i + k) % 4 == 0) {
            let whole = Renderer::new(2).unwrap().render(scene, &culled.grid(), &earth_layers(), &field).unwrap();
            let ranks = 2 + (i + k) % 3;
            let (partition, owner) = partitions(&mesh, ranks).swap_remove((i + k) % 3);
            let spread = Spread::new(&mesh, ranks, &without_holes(owner, stays));
            let (frame, _) = draw(&spread, &mesh, scene, Location::Center);
            let off = difference(&frame, &whole);
            assert!(off <= 1e-6, "{name}, {partition} on {ranks} ranks, scene {k}: {off:e}");
            worst = worst.max(off);
            drawn += frame.report.counts.fragments;
        }
    }
    println!("largest difference {worst:.1e}, {drawn} fragments");
    assert!(drawn > count(20_000, 100_000), "{drawn}");
}

/// At the usual tolerance parts and whole are both within their errors of the exact picture.
#[test]
fn parts_are_within_their_errors_of_the_exact_picture() {
    let mesh = IcosahedralMesh::new(4).unwrap();
    for (precision, rest) in [("f64", HOLLOW), ("f32", "core = \"#804020\"")] {
        let exact = whole(&mesh, &scene(NEAR, "f64", &format!("{rest}\ntolerance = 1e-7")), Location::Center);
        for tolerance in [1e-2, 1e-3] {
            let scene = scene(NEAR, precision, &format!("{rest}\ntolerance = {tolerance}"));
            for (name, owner) in partitions(&mesh, 4) {
                let (frame, _) = draw(&Spread::new(&mesh, 4, &owner), &mesh, &scene, Location::Center);
                let most = frame.report.error.max;
                assert!(most > 0.0 && most <= 1.1 * tolerance + 1e-5, "{name}: {most:e}");
                for i in 0..frame.pixels.len() {
                    let off = pixel_difference(&frame, &exact, i);
                    let error = frame.error[i] + exact.error[i];
                    assert!(off <= error, "{name}, {precision}, {tolerance}, pixel {i}: {off:e} > {error:e}");
                }
            }
        }
    }
}

/// Data that every rank has can be drawn by fragments too, where the scene asks for it; parts cannot be drawn by tiles.
#[test]
fn scenes_may_request_fragments_but_no_impossible_scheme() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let asked = |ranks: &str| scene(FAR, "f64", &format!("ranks = \"{ranks}\""));
    let expected = whole(&mesh, &asked("auto"), Location::Center);
    let all = waves(&mesh, Location::Center, LAYERS);
    for (scheme, sentence) in [
        ("fragments", "fragments: requested; every rank has the whole grid"),
        ("auto", "tiles: every rank has the whole grid"),
    ] {
        let drawn = on_ranks(3, |ranks| {
            let (grid, field) = (Grid::new(mesh.tables()).unwrap(), at_centers(&all, LAYERS));
            let renderer = Renderer::new(1).unwrap();
            renderer.render_over(ranks, &asked(scheme), &grid, &earth_layers(), &field).unwrap()
        });
        let Rendered::Here(frame) = &drawn[0] else { panic!("rank 0 has the picture") };
        assert_eq!(frame.report.ranks.sharing.unwrap().to_string(), sentence);
        assert_eq!(frame.report.counts.fragments > 0, scheme == "fragments");
        assert!(difference(frame, &expected) <= 1e-6);
    }
    let (_, owner) = partitions(&mesh, 2).swap_remove(0);
    let spread = Spread::new(&mesh, 2, &owner);
    let refused = spread.render(&[0, 1], &asked("tiles"), &earth_layers(), |rank| {
        let shape = Shape::level_fastest(spread.cells[rank].rows.len(), LAYERS);
        vec![vec![("f", Array::new(shape, true, Location::Center, None, |_, _| 0.0))]]
    });
    let refused: Vec<_> = refused.into_iter().map(refusal).collect();
    let start = "rank 0: key ranks: \"tiles\", but each node has a part";
    assert_same_refusal(&refused, ErrorKind::Scene, start);
}

/// A part that does not fit is the same error on all ranks, with the cell and the ranks.
#[test]
fn parts_that_do_not_fit_are_refused_on_all_ranks() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let (_, owner) = partitions(&mesh, 3).swap_remove(0);
    type Damage = fn(&mut Spread, &IcosahedralMesh);
    // Two owners or none; a number twice or too low; too few numbers and too many marks; a halo that was cut off.
    let cases: [(Damage, &[&str]); 8] = [
        (|s, _| s.cells[1].owned.fill(1), &["is owned by ranks", "expected one owner"]),
        (|s, _| s.cells[2].owned.fill(0), &["is in the halo of rank", "but owned by no rank"]),
        (|s, _| s.cells[1].global[5] = s.cells[1].global[9], &["rank 1: cell_global rows 6 and 10: both "]),
        (|s, _| s.cells[2].global[7] = -1, &["rank 2: cell_global row 8: -1, expected 1 or more"]),
        (
            |s, _| s.cells[2].global[7] = 0,
            &["rank 2: cell_global row 8: 0, expected a number, as a triangle has this cell"],
        ),
        (|s, _| s.cells[0].global.truncate(9), &["rank 0: cell_global: ", "one per cell"]),
        (|s, _| s.cells[0].owned.push(1), &["rank 0: is_owned: ", "one per cell"]),
        (
            |s, mesh| {
                let mut own = vec![false; mesh.cells()];
                let Rows { rows, owned, .. } = &s.cells[0];
                rows.iter().zip(owned).for_each(|(cell, is_own)| own[*cell] = *is_own == 1);
                s.parts[0] = Culled::new(mesh, &own, Style::Corners, Mark::BeforeFirst, 1);
                s.cells[0] = Rows::new(s.parts[0].cells.clone(), |cell| cell as i64 + 1, |_| true);
            },
            &["rank 0: own cell ", "a halo at least one cell wide"],
        ),
    ];
    for (damage, words) in cases {
        let mut spread = Spread::new(&mesh, 3, &owner);
        damage(&mut spread, &mesh);
        let refusals = spread.each(|_, _, _, decomposition| refusal(decomposition));
        assert_same_refusal(&refusals, ErrorKind::Grid, "");
        assert!(words.iter().all(|word| refusals[0].1.contains(word)), "{words:?}: {}", refusals[0].1);
    }
}

/// A budget that nothing keeps: all ranks leave out as much as may be, each hears of the same quality.
#[test]
fn ranks_with_parts_keep_a_time_budget_together() {
    let mesh = IcosahedralMesh::new(4).unwrap();
    let mut scene = scene(NEAR, "f64", &format!("|{LIT}"));
    scene.time_budget_ms = Some(1e-3);
    let (_, owner) = partitions(&mesh, 3).swap_remove(1);
    let (frame, reports) = draw(&Spread::new(&mesh, 3, &owner), &mesh, &scene, Location::Center);
    let quality = frame.report.quality;
    assert!(quality.pixel_step == 32 && quality.tolerance >= 1e-2, "{quality}");
    assert!(reports.iter().all(|report| report.quality == quality));
    assert_eq!(frame.pixels.len(), 64 * 56);
}
