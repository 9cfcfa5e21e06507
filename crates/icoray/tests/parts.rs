//! Grids that are spread over ranks: the picture that is put together of their fragments is that of the whole grid.

use glam::DVec3;
use icoray::ranks::{LocalTeam, local_team};
use icoray::{
    Field, Frame, FrameReport, Grid, GridTables, IcosahedralMesh, Layers, Location, LonLat, Owned, Part,
    PartCells, Ranks, Rendered, Renderer, Scene, Shape,
};
use std::thread;

mod culled;
use culled::{Culled, Mark, Style, towards};

const LAYERS: usize = 4;
const HEIGHT_M: [f64; LAYERS] = [0.0, 5e3, 12e3, 20e3];

/// A mesh of which each cell has an owner.
struct Spread {
    parts: Vec<Culled>,
    /// Of each part, which cells are its own.
    owned: Vec<Vec<i32>>,
    /// Of each part, the number of each cell in the whole mesh, from 1.
    global: Vec<Vec<i64>>,
}

impl Spread {
    fn new(mesh: &IcosahedralMesh, ranks: usize, owner: &[usize]) -> Self {
        let part = |rank: usize| {
            let mut stays: Vec<bool> = owner.iter().map(|owner| *owner == rank).collect();
            for row in mesh.corner_cell.chunks_exact(3) {
                if row.iter().any(|cell| owner[*cell as usize] == rank) {
                    row.iter().for_each(|cell| stays[*cell as usize] = true);
                }
            }
            let style = [Style::Corners, Style::Triangles][rank % 2];
            Culled::new(mesh, &stays, style, [Mark::BeforeFirst, Mark::BehindLast][rank % 2], 1)
        };
        let parts: Vec<Culled> = (0..ranks).map(part).collect();
        let owned = parts.iter().enumerate();
        let owned = owned.map(|(rank, p)| p.cells.iter().map(|c| i32::from(owner[*c] == rank)).collect());
        let global = parts.iter().map(|p| p.cells.iter().map(|c| *c as i64 + 1).collect());
        Spread { owned: owned.collect(), global: global.collect(), parts }
    }

    /// What `work` makes of each rank's grid and part.
    fn each<R: Send>(
        &self,
        work: impl Fn(&mut Ranks, &Culled, Result<Part, icoray::Error>) -> R + Sync,
    ) -> Vec<R> {
        let teams = local_team(self.parts.len());
        thread::scope(|scope| {
            let rank = |(rank, team): (usize, LocalTeam)| {
                let work = &work;
                scope.spawn(move || {
                    let mut ranks = Ranks::new(Box::new(team));
                    let culled = &self.parts[rank];
                    let grid = culled.grid();
                    let cells = PartCells {
                        global: self.global[rank].as_slice().into(),
                        owned: Owned::Marked(&self.owned[rank]),
                    };
                    let part = Part::new(&mut ranks, &grid, &cells);
                    work(&mut ranks, culled, part)
                })
            };
            let threads: Vec<_> = teams.into_iter().enumerate().map(rank).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        })
    }

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

fn directions(lon_rad: &[f64], lat_rad: &[f64]) -> Vec<DVec3> {
    lon_rad.iter().zip(lat_rad).map(|(lon, lat)| towards(lon.to_degrees(), lat.to_degrees())).collect()
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
        "field = \"f\"\nexaggeration = 60\nprecision = \"{precision}\"\n{tolerance}\n{rest}\n[image]\nwidth = 64\nheight = 56\n\
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

/// A number below `most` for a cell (SplitMix64's mixing).
fn chance(cell: usize, most: usize) -> usize {
    let z = (cell as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as usize % most
}

/// Partitions with their names: who owns each cell.
fn partitions(mesh: &IcosahedralMesh, ranks: usize) -> Vec<(&'static str, Vec<usize>)> {
    let at = directions(&mesh.lon_center_rad, &mesh.lat_center_rad);
    // Patches around some places, as graph partitioners make them.
    let seeds: Vec<DVec3> = (0..ranks).map(|rank| at[chance(rank, at.len())]).collect();
    let nearest = |p: &DVec3| {
        let closer = |a: &usize, b: &usize| seeds[*a].dot(*p).total_cmp(&seeds[*b].dot(*p));
        (0..ranks).max_by(closer).unwrap()
    };
    let count = at.len();
    vec![
        ("contiguous rows", (0..count).map(|cell| cell * ranks / count).collect()),
        ("patches", at.iter().map(nearest).collect()),
        ("random cells", (0..count).map(|cell| chance(cell, ranks)).collect()),
        (
            "a single cell",
            (0..count)
                .map(|cell| if cell == 77 { ranks - 1 } else { cell % (ranks - 1).max(1) / 2 })
                .collect(),
        ),
    ]
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
                    // Each combination of two of them at least.
                    if ranks > 2 && (i + j + k + ranks) % 2 == 1 {
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
