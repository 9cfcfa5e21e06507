//! Grids that are spread over ranks: the picture that is put together of their fragments is that of the whole grid.

use glam::DVec3;
use icoray::ranks::{LocalTeam, local_team};
use icoray::{
    ErrorKind, Field, Frame, FrameReport, Grid, Ground, IcosahedralMesh, Layers, Level, Lines, Location,
    Part, Pattern, Ranks, Rendered, Renderer, Scene, Shape,
};
use icoray_test_support::{count, is_long};
use std::thread;

use crate::culled::{Culled, Mark, Style, holes};
use crate::spread::{NOBODY, Spread, directions, partitions};

const LAYERS: usize = 4;
const HEIGHT_M: [f64; LAYERS] = [0.0, 5e3, 12e3, 20e3];

impl Spread {
    /// Draws the scene; `change` may change a rank's values.
    fn draw(
        &self,
        mesh: &IcosahedralMesh,
        scene: &Scene,
        location: Location,
        change: impl Fn(usize, &mut [f64]) + Sync,
    ) -> (Frame, Vec<FrameReport>) {
        let all = values(mesh, location);
        let drawn = self.each(|ranks, culled, part| {
            let part = part.unwrap();
            let grid = culled.grid();
            let rows = if location == Location::Center { &culled.cells } else { &culled.corners };
            let mut values: Vec<f64> =
                rows.iter().flat_map(|row| all[row * LAYERS..(row + 1) * LAYERS].to_vec()).collect();
            change(ranks.rank(), &mut values);
            let shape = Shape::level_fastest(rows.len(), LAYERS);
            let field = Field::new(values.as_slice().into(), shape, location, None).unwrap();
            let renderer = Renderer::new(1).unwrap();
            renderer.render_over(ranks, scene, &grid, Some(&part), &layers(), &field).unwrap()
        });
        let (mut frame, mut reports) = (None, Vec::new());
        for drawn in drawn {
            match drawn {
                Rendered::Here(here) => {
                    reports.push(here.report.clone());
                    assert!(frame.replace(here).is_none());
                }
                Rendered::AtRoot(report) => reports.push(report),
            }
        }
        (frame.unwrap(), reports)
    }
}

fn layers() -> Layers {
    Layers::from_heights(&HEIGHT_M, 6371e3).unwrap()
}

fn values(mesh: &IcosahedralMesh, location: Location) -> Vec<f64> {
    let at = match location {
        Location::Center => directions(&mesh.lon_center_rad, &mesh.lat_center_rad),
        Location::Corner => directions(&mesh.lon_corner_rad, &mesh.lat_corner_rad),
    };
    let value = |p: DVec3, layer: usize| (3.0 * p.x).sin() * (4.0 * p.y).cos() + p.z + 0.3 * layer as f64;
    at.into_iter().flat_map(|p| (0..LAYERS).map(move |layer| value(p, layer))).collect()
}

fn whole(mesh: &IcosahedralMesh, scene: &Scene, location: Location) -> Frame {
    let grid = Grid::new(mesh.tables()).unwrap();
    let values = values(mesh, location);
    let shape = Shape::level_fastest(values.len() / LAYERS, LAYERS);
    let field = Field::new(values.as_slice().into(), shape, location, None).unwrap();
    Renderer::new(2).unwrap().render(scene, &grid, &layers(), &field).unwrap()
}

/// A scene in which `rest` has further keys and, behind a bar, further tables.
fn scene(camera: &str, precision: &str, rest: &str) -> Scene {
    let (rest, light) = rest.split_once('|').unwrap_or((rest, ""));
    // Ends of rays and rules of integration depend on what lies in front, within the tolerance.
    let tolerance = if precision == "f64" { 1e-9 } else { 1e-6 };
    let tolerance =
        if rest.contains("tolerance") { String::new() } else { format!("tolerance = {tolerance}") };
    Scene::parse(&format!(
        "field = \"f\"\nantialias = false\nexaggeration = 60\nprecision = \"{precision}\"\n{tolerance}\n{rest}\n[image]\nwidth = 64\nheight = 56\n\
         [camera]\n{camera}\n[transfer]\nmap = \"viridis\"\nrange = [-1.5, 2.5]\n\
         opacity = [[-1.5, 0.5], [0, 0.05], [0.4, 0.8], [2.5, 0.3]]\n{light}\n"
    ))
    .unwrap()
}

const FAR: &str = "lon = 20\nlat = 35\ndistance = 3.2\nfov = 45";
const NEAR: &str = "lon = -100\nlat = -60\ndistance = 1.9\nfov = 60";
/// Inside the shell, which ends at 1.19 radii.
const INSIDE: &str = "lon = 26\nlat = 33\ndistance = 1.1\nfov = 110";
const HOLLOW: &str = "core = \"transparent\"\nbackground = \"transparent\"";
const LIT: &str = "|[light]\nkind = \"headlight\"";

fn difference(one: &Frame, other: &Frame) -> f32 {
    let channels = one.pixels.iter().flatten().zip(other.pixels.iter().flatten());
    channels.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

const LIMITS: [(&str, f32); 2] = [("f64", 1e-6), ("f32", 1e-5)];

#[test]
fn parts_make_the_picture_of_the_whole() {
    let mesh = IcosahedralMesh::new(4).unwrap();
    let scenes = [
        (FAR, HOLLOW),
        (NEAR, "core = \"#804020\""),
        (INSIDE, HOLLOW),
        (FAR, LIT),
        (NEAR, "method = \"paper\""),
    ];
    let mut worst = [0.0f32; 2];
    for (i, (camera, rest)) in scenes.iter().enumerate() {
        for (j, (precision, limit)) in LIMITS.into_iter().enumerate() {
            let scene = scene(camera, precision, rest);
            let expected = whole(&mesh, &scene, Location::Center);
            for ranks in [1, 2, 3, 4, 8] {
                for (k, (name, owner)) in partitions(&mesh, ranks).iter().enumerate() {
                    // In the long run each combination of two of them at least.
                    let is_left_out = (i + j + k + ranks) % count(6, 2) != 0;
                    if is_left_out && (ranks > 2 || !is_long()) {
                        continue;
                    }
                    let spread = Spread::new(&mesh, ranks, owner);
                    let (frame, reports) = spread.draw(&mesh, &scene, Location::Center, |_, _| ());
                    let off = difference(&frame, &expected);
                    assert!(off <= limit, "{ranks} ranks, {name}, scene {i}, {precision}: {off:e}");
                    worst[j] = worst[j].max(off);
                    let report = &frame.report;
                    assert_eq!(report.value_range, expected.report.value_range, "{name}");
                    assert_eq!(report.missing_values, 0);
                    assert_eq!(report.counts.rays, expected.report.counts.rays);
                    assert_eq!(report.counts.fragment_bytes > 0, ranks > 1);
                    assert!(reports.iter().all(|r| r.counts == report.counts && r.ranks == ranks));
                }
            }
        }
    }
    println!("largest differences: f64 {:.1e}, f32 {:.1e}", worst[0], worst[1]);
}

/// The scene with land, sea and lines on its core.
fn with_ground(mut scene: Scene) -> Scene {
    scene.scenery.ground = Ground { land: Some([0.1, 0.6, 0.1]), ocean: Some([0.0, 0.1, 0.7]) };
    let graticule = Pattern::Graticule { spacing_deg: 5.0 };
    scene.scenery.lines = [graticule, Pattern::Coast]
        .map(|pattern| Lines {
            pattern,
            on: Level::Ground,
            color: [1.0, 0.9, 0.8],
            width_px: 1.5,
            opacity: 0.7,
            region: None,
        })
        .into();
    scene
}

/// The mesh's own holes, beside those that each rank's part has: land in an ocean, with the core showing.
#[test]
fn holes_of_the_whole_are_holes_of_its_parts() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let scenes = [
        scene(FAR, "f64", "core = \"#804020\""),
        scene(INSIDE, "f64", HOLLOW),
        scene(NEAR, "f64", &format!("core = \"#804020\"{LIT}")),
        with_ground(scene(NEAR, "f64", &format!("core = \"#804020\"{LIT}"))),
    ];
    let (mut worst, mut drawn) = (0.0f32, 0);
    for (i, (name, stays)) in holes(&mesh).iter().enumerate() {
        let culled = Culled::new(&mesh, stays, Style::Corners, Mark::BeforeFirst, 1);
        let all = values(&mesh, Location::Center);
        let kept: Vec<f64> =
            culled.cells.iter().flat_map(|&c| all[c * LAYERS..(c + 1) * LAYERS].to_vec()).collect();
        let shape = Shape::level_fastest(culled.cells.len(), LAYERS);
        let field = Field::new(kept.as_slice().into(), shape, Location::Center, None).unwrap();
        for (k, scene) in scenes.iter().enumerate().filter(|(k, _)| is_long() || (i + k) % 4 == 0) {
            let whole = Renderer::new(2).unwrap().render(scene, &culled.grid(), &layers(), &field).unwrap();
            let ranks = 2 + (i + k) % 3;
            let (partition, mut owner) = partitions(&mesh, ranks).swap_remove((i + k) % 3);
            (owner.iter_mut().zip(stays))
                .filter(|(_, stays)| !**stays)
                .for_each(|(owner, _)| *owner = NOBODY);
            let spread = Spread::new(&mesh, ranks, &owner);
            let (frame, _) = spread.draw(&mesh, scene, Location::Center, |_, _| ());
            let off = difference(&frame, &whole);
            assert!(off <= 1e-6, "{name}, {partition} on {ranks} ranks, scene {k}: {off:e}");
            worst = worst.max(off);
            drawn += frame.report.counts.fragments;
        }
    }
    println!("largest difference {worst:.1e}, {drawn} fragments");
    assert!(drawn > count(20_000, 100_000), "{drawn}");
}

#[test]
fn corners_are_averaged_over_all_that_a_cell_has() {
    let mesh = IcosahedralMesh::new(4).unwrap();
    for (i, (precision, limit)) in LIMITS.into_iter().enumerate() {
        let scene = scene(FAR, precision, LIT);
        let expected = whole(&mesh, &scene, Location::Corner);
        // One for each precision, or all in the long run.
        let partitions = partitions(&mesh, 3).into_iter().skip(count(i, 0)).take(count(1, usize::MAX));
        for (name, owner) in partitions {
            let (frame, _) = Spread::new(&mesh, 3, &owner).draw(&mesh, &scene, Location::Corner, |_, _| ());
            let off = difference(&frame, &expected);
            assert!(off <= limit, "{name}, {precision}: {off:e}");
        }
    }
}

/// At the usual tolerance parts and whole are both within their errors of the exact picture.
#[test]
fn parts_are_as_near_to_the_exact_picture_as_they_say() {
    let mesh = IcosahedralMesh::new(4).unwrap();
    for (precision, rest) in [("f64", HOLLOW), ("f32", "core = \"#804020\"")] {
        let exact =
            whole(&mesh, &scene(NEAR, "f64", &format!("{rest}\ntolerance = 1e-10")), Location::Center);
        for tolerance in [1e-2, 1e-3] {
            let scene = scene(NEAR, precision, &format!("{rest}\ntolerance = {tolerance}"));
            for (name, owner) in partitions(&mesh, 4) {
                let (frame, _) =
                    Spread::new(&mesh, 4, &owner).draw(&mesh, &scene, Location::Center, |_, _| ());
                let most = frame.report.error.max;
                assert!(most > 0.0 && most <= 1.1 * tolerance + 1e-5, "{name}: {most:e}");
                for (i, (pixel, expected)) in frame.pixels.iter().zip(&exact.pixels).enumerate() {
                    let off = pixel.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                    let error = frame.error[i] + exact.error[i];
                    assert!(off <= error, "{name}, {precision}, {tolerance}, pixel {i}: {off:e} > {error:e}");
                }
            }
        }
    }
}

/// The limits above would see a seam: a single halo value that is stale, light whose gradients at the rim are a part's own.
#[test]
fn a_stale_halo_is_seen() {
    let mesh = IcosahedralMesh::new(4).unwrap();
    let scene = scene(FAR, "f64", HOLLOW);
    let expected = whole(&mesh, &scene, Location::Center);
    let (_, owner) = partitions(&mesh, 3).swap_remove(1);
    let spread = Spread::new(&mesh, 3, &owner);
    let eye = DVec3::from_array(scene.camera.eye());
    let at = directions(&mesh.lon_center_rad, &mesh.lat_center_rad);
    let halo = |rank: usize| {
        let cells = spread.parts[rank].cells.iter().zip(&spread.owned[rank]).enumerate();
        let halo = cells.filter(|(_, (_, owned))| **owned == 0);
        let nearest = halo.max_by(|a, b| at[*a.1.0].dot(eye).total_cmp(&at[*b.1.0].dot(eye)));
        nearest.unwrap().0
    };
    // On each rank the halo cell that the camera sees best; which triangles there are its own depends on numbers.
    let seen = (0..3).map(|stale| {
        let (frame, _) = spread.draw(&mesh, &scene, Location::Center, |rank, values| {
            if rank == stale {
                values[halo(rank) * LAYERS..][..LAYERS].iter_mut().for_each(|value| *value += 0.3);
            }
        });
        difference(&frame, &expected)
    });
    let seen: Vec<f32> = seen.collect();
    assert!(seen.iter().any(|off| *off > 1e-3), "{seen:?}");
}

#[test]
fn ranks_without_cells_and_one_rank_alone_have_parts_too() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let scene = scene(FAR, "f64", LIT);
    let expected = whole(&mesh, &scene, Location::Center);
    let owner: Vec<usize> = (0..mesh.cells()).map(|cell| if cell < 300 { 1 } else { 3 }).collect();
    let (frame, reports) = Spread::new(&mesh, 5, &owner).draw(&mesh, &scene, Location::Center, |_, _| ());
    assert!(difference(&frame, &expected) <= 1e-6);
    assert_eq!(reports.len(), 5);
    let grid = Grid::new(mesh.tables()).unwrap();
    let mut alone = Ranks::alone();
    let part = Part::of_whole(&mut alone, &grid).unwrap();
    assert_eq!((part.cells(), part.ranks()), (mesh.cells() as u64, 1));
    assert!((part.covered() - 1.0).abs() < 1e-12, "{}", part.covered());
    let all = values(&mesh, Location::Center);
    let shape = Shape::level_fastest(mesh.cells(), LAYERS);
    let field = Field::new(all.as_slice().into(), shape, Location::Center, None).unwrap();
    let renderer = Renderer::new(2).unwrap();
    let drawn = renderer.render_over(&mut alone, &scene, &grid, Some(&part), &layers(), &field).unwrap();
    let Rendered::Here(frame) = drawn else { panic!("alone is rank 0") };
    assert!(difference(&frame, &expected) <= 1e-6);
}

/// Data that every rank has can be drawn by fragments too, where the scene asks for it; parts cannot be drawn by tiles.
#[test]
fn a_scene_may_ask_for_fragments_but_not_for_what_cannot_be() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let asked = |ranks: &str| scene(FAR, "f64", &format!("ranks = \"{ranks}\""));
    let expected = whole(&mesh, &asked("auto"), Location::Center);
    let all = values(&mesh, Location::Center);
    for (scheme, sentence) in [
        ("fragments", "fragments: asked for; every rank has the whole grid"),
        ("auto", "tiles: every rank has the whole grid"),
    ] {
        let drawn = thread::scope(|scope| {
            let rank = |team: LocalTeam| {
                let (mesh, all, scene) = (&mesh, &all, asked(scheme));
                scope.spawn(move || {
                    let grid = Grid::new(mesh.tables()).unwrap();
                    let shape = Shape::level_fastest(mesh.cells(), LAYERS);
                    let field = Field::new(all.as_slice().into(), shape, Location::Center, None).unwrap();
                    let mut ranks = Ranks::new(Box::new(team));
                    Renderer::new(1)
                        .unwrap()
                        .render_over(&mut ranks, &scene, &grid, None, &layers(), &field)
                        .unwrap()
                })
            };
            let threads: Vec<_> = local_team(3).into_iter().map(rank).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).next()
        });
        let Some(Rendered::Here(frame)) = drawn else { panic!("rank 0 has the picture") };
        assert_eq!(frame.report.sharing.unwrap().to_string(), sentence);
        assert_eq!(frame.report.counts.fragments > 0, scheme == "fragments");
        assert!(difference(&frame, &expected) <= 1e-6);
    }
    let (_, owner) = partitions(&mesh, 2).swap_remove(0);
    let refused = Spread::new(&mesh, 2, &owner).each(|ranks, culled, part| {
        let all = vec![0.0; culled.cells.len() * LAYERS];
        let shape = Shape::level_fastest(culled.cells.len(), LAYERS);
        let field = Field::new(all.as_slice().into(), shape, Location::Center, None).unwrap();
        let (part, grid) = (part.unwrap(), culled.grid());
        let renderer = Renderer::new(1).unwrap();
        let error =
            renderer.render_over(ranks, &asked("tiles"), &grid, Some(&part), &layers(), &field).unwrap_err();
        (error.kind(), error.context().to_string())
    });
    for (kind, context) in refused {
        assert_eq!(kind, ErrorKind::Scene);
        assert!(context.starts_with("rank 0: key ranks: \"tiles\", but each rank has a part"), "{context}");
    }
}

/// Whatever does not fit is the same error on all ranks, with the cell and the ranks.
#[test]
fn parts_that_do_not_fit_are_refused_on_all_ranks() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let (_, owner) = partitions(&mesh, 3).swap_remove(0);
    type Damage = fn(&mut Spread);
    let cases: [(&str, Damage, &[&str]); 6] = [
        (
            "owned twice",
            |s| s.owned[1].iter_mut().for_each(|own| *own = 1),
            &["is owned by ranks", "expected one owner"],
        ),
        ("owned by none", |s| s.owned[2].fill(0), &["is in the halo of rank", "but owned by no rank"]),
        (
            "a number twice",
            |s| s.global[1][5] = s.global[1][9],
            &["rank 1: cell_global rows 6 and 10: both "],
        ),
        ("a number too low", |s| s.global[2][7] = 0, &["rank 2: cell_global row 8: 0, expected 1 or more"]),
        (
            "too few numbers",
            |s| {
                s.global[0].pop();
            },
            &["rank 0: cell_global: ", "one per cell"],
        ),
        ("too many marks", |s| s.owned[0].push(1), &["rank 0: is_owned: ", "one per cell"]),
    ];
    for (name, damage, words) in cases {
        let mut spread = Spread::new(&mesh, 3, &owner);
        damage(&mut spread);
        let found =
            spread.each(|_, _, part| part.map(|part| part.ranks()).map_err(|e| (e.kind(), e.to_string())));
        for found in &found {
            let (kind, sentence) = found.as_ref().expect_err(name);
            assert_eq!(*kind, ErrorKind::Grid, "{name}: {sentence}");
            assert!(words.iter().all(|word| sentence.contains(word)), "{name}: {sentence}");
        }
        assert!(found.windows(2).all(|pair| pair[0] == pair[1]), "{name}: {found:?}");
    }
}

/// An owner without all triangles of a cell, which another rank has: its halo was cut off.
#[test]
fn a_halo_that_is_too_narrow_is_refused() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let (_, owner) = partitions(&mesh, 2).swap_remove(0);
    let mut spread = Spread::new(&mesh, 2, &owner);
    let own: Vec<bool> = owner.iter().map(|owner| *owner == 0).collect();
    spread.parts[0] = Culled::new(&mesh, &own, Style::Corners, Mark::BeforeFirst, 1);
    spread.global[0] = spread.parts[0].cells.iter().map(|cell| *cell as i64 + 1).collect();
    spread.owned[0] = vec![1; spread.global[0].len()];
    for part in spread.each(|_, _, part| part.map(|part| part.ranks())) {
        let sentence = part.unwrap_err().to_string();
        assert!(
            sentence.contains("rank 0: own cell ") && sentence.contains("a halo at least one cell wide"),
            "{sentence}"
        );
    }
}

/// A budget that nothing keeps: all ranks leave out as much as may be, each hears of the same quality.
#[test]
fn ranks_with_parts_keep_a_time_budget_together() {
    let mesh = IcosahedralMesh::new(4).unwrap();
    let mut scene = scene(NEAR, "f64", LIT);
    scene.time_budget_ms = Some(1e-3);
    let (_, owner) = partitions(&mesh, 3).swap_remove(1);
    let (frame, reports) = Spread::new(&mesh, 3, &owner).draw(&mesh, &scene, Location::Center, |_, _| ());
    let quality = frame.report.quality;
    assert!(quality.pixel_step == 32 && quality.tolerance >= 1e-2, "{quality}");
    assert!(reports.iter().all(|report| report.quality == quality));
    assert_eq!(frame.pixels.len(), 64 * 56);
}
