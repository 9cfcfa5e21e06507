//! Meshes with holes: they are closed, and drawn as the whole mesh is drawn where their cells' values are missing.
//!
//! That whole mesh is an oracle with no void triangle in it: a frustum with a missing value adds nothing.

use glam::DVec3;
use icoray::{ComputedField, ErrorKind, Grid, IcosahedralMesh, Location, Renderer, Scene, Stretch, Traversal};
use std::collections::HashSet;
use std::f64::consts::TAU;
use std::ops::ControlFlow;

use crate::common::*;
use crate::culled::{Culled, Hole, Mark, Style, directions, holes, towards};

const LAYERS: usize = HEIGHT_M.len();
const STYLES: [(Style, Mark, i32); 4] = [
    (Style::Corners, Mark::BeforeFirst, 1),
    (Style::Triangles, Mark::BeforeFirst, 0),
    (Style::Corners, Mark::BehindLast, 0),
    (Style::Triangles, Mark::MinusOne, 1),
];

fn shown(camera: &str, rest: &str) -> Scene {
    let keys = "antialias = false\nexaggeration = 60\ntolerance = 1e-4\nimage = { width = 48, height = 40 }";
    scene(camera, HAZE, &format!("{keys}\n{rest}"))
}

const POLE: &str = "lon = 25\nlat = 89.999\ndistance = 1.4\nfov = 90";

/// Every side leads to a triangle that leads back, whose vertices are the same two.
pub fn assert_closed(grid: &Grid, name: &str) {
    let all = 0..(grid.triangles() + grid.void_triangles()) as u32;
    let all = all.filter(|&t| grid.is_triangle(t) || grid.is_void(t));
    let mut sides = 0;
    for t in all.clone() {
        let v = grid.triangle(t);
        for k in 0..3 {
            let other = grid.across(t, k);
            assert!(grid.is_triangle(other) || grid.is_void(other), "{name}: {t} leads to {other}");
            assert!((0..3).any(|j| grid.across(other, j) == t), "{name}: {other} does not lead back to {t}");
            let ends = [v[(k + 1) % 3], v[(k + 2) % 3]];
            let w = grid.triangle(other);
            let runs_back = (0..3).any(|i| [w[(i + 1) % 3], w[i]] == ends);
            assert!(runs_back, "{name}: side {k} of {t} and {other}");
            sides += 1;
        }
        let [a, b, c] = v.map(|cell| grid.direction(cell));
        assert!(a.dot(b.cross(c)) > -1e-15, "{name}: {t} is turned round");
    }
    for cell in 0..grid.cells() as u32 {
        let mut around: Vec<u32> = grid.triangles_around(cell).collect();
        let mut expected: Vec<u32> = grid.corners_of(cell).filter(|corner| grid.is_triangle(*corner)).collect();
        around.sort_unstable();
        expected.sort_unstable();
        assert_eq!(around, expected, "{name}: cell {cell}");
    }
    // Every vertex that is used has one ring of triangles: V - E + F = 2.
    let used: HashSet<u32> = all.flat_map(|t| grid.triangle(t)).collect();
    assert_eq!(used.len() as i64 - sides / 2 + sides / 3, 2, "{name}");
}

fn each_hole(level: u32, mut f: impl FnMut(&IcosahedralMesh, &Hole, &Culled)) {
    let mesh = IcosahedralMesh::new(level).unwrap();
    for (i, hole) in holes(&mesh).iter().enumerate() {
        for k in 0..2 {
            let (style, mark, base) = STYLES[(2 * i + k + i / 2) % 4];
            f(&mesh, hole, &Culled::new(&mesh, &hole.1, style, mark, base));
        }
    }
}

#[test]
fn holes_of_all_kinds_are_closed() {
    for level in [0, 1, 2, 3, 4] {
        each_hole(level, |mesh, (name, stays), culled| {
            if culled.cells.is_empty() {
                return;
            }
            let name = format!("{name}, level {level}");
            let grid = culled.grid();
            assert_closed(&grid, &name);
            assert_eq!(grid.cells(), culled.cells.len(), "{name}");
            assert_eq!(grid.triangles(), culled.corners.len(), "{name}");
            let whole = mesh.corner_cell.chunks_exact(3).filter(|row| row.iter().all(|&c| stays[c as usize]));
            let there = (0..grid.triangles() as u32).filter(|&t| grid.is_triangle(t));
            assert_eq!(there.count(), whole.count(), "{name}");
            assert_eq!(grid.void_triangles() > 0, stays.contains(&false), "{name}");
        });
    }
}

/// Five degrees of a fine mesh, and all but them.
#[test]
fn small_caps_are_closed() {
    let mesh = IcosahedralMesh::new(6).unwrap();
    let at = directions(&mesh.lon_center_rad, &mesh.lat_center_rad);
    for center in [towards(7.0, 46.0), DVec3::Z, DVec3::NEG_Z, DVec3::X] {
        let inside: Vec<bool> = at.iter().map(|p| p.angle_between(center) < 5f64.to_radians()).collect();
        let outside: Vec<bool> = inside.iter().map(|i| !i).collect();
        for (style, mark, base) in STYLES {
            for stays in [&inside, &outside] {
                let culled = Culled::new(&mesh, stays, style, mark, base);
                assert_closed(&culled.grid(), &format!("{center} {style:?}"));
            }
        }
    }
}

/// The same picture as of the whole mesh with no values at the cells that are missing. An opaque core is made of
/// facets, which differ between a hole and data: there pixels are the same whose rays meet no triangle that is missing.
#[test]
fn a_hole_looks_like_missing_values() {
    let (renderer, layers) = (Renderer::new(2).unwrap(), earth_layers());
    let hollow = |camera, rest| shown(camera, &format!("core = \"transparent\"\nprecision = {rest}"));
    let scenes = [
        (hollow(FAR, "\"f64\""), 0.0),
        (hollow(NEAR, "\"f64\"\nmethod = \"paper\""), 0.0),
        (hollow(POLE, "\"f32\""), 0.0),
        (hollow(IN_SHELL, "\"f64\""), 0.0),
        // Gradients beside a hole are summed in another order.
        (hollow(FAR, "\"f64\"|[light]\nkind = \"headlight\""), 1e-6),
        (shown(FAR, "precision = \"f64\""), 0.0),
        (shown(NEAR, ""), 0.0),
        (shown(POLE, ""), 0.0),
        (shown(IN_SHELL, "precision = \"f64\""), 0.0),
    ];
    let radius: Vec<f64> = HEIGHT_M.iter().map(|h| 1.0 + 60.0 * h / 6371e3).collect();
    let (mut drawn, mut same, mut meeting) = (0, 0, 0);
    each_hole(3, |mesh, (name, stays), culled| {
        let whole = Grid::new(mesh.tables()).unwrap();
        let mut all = waves(mesh, Location::Center, LAYERS);
        let kept = columns_of(&all, &culled.cells, LAYERS);
        for (values, _) in all.chunks_exact_mut(LAYERS).zip(stays).filter(|(_, stays)| !**stays) {
            values.fill(f64::NAN);
        }
        let grid = culled.grid();
        let (field, masked) = (at_centers(&kept, LAYERS), at_centers(&all, LAYERS));
        let traversal = Traversal::new(&whole, &radius).unwrap();
        let meets_hole = |(eye, dir): (DVec3, DVec3)| {
            let mut meets = false;
            traversal.ray(eye, dir, &mut 0, |stretch| {
                if let Stretch::Frustum(f) = stretch {
                    meets |= f.cells.iter().any(|&cell| !stays[cell as usize]);
                }
                ControlFlow::Continue(())
            });
            meets
        };
        for (i, (scene, allowed)) in scenes.iter().enumerate() {
            let one = renderer.render(scene, &grid, &layers, &field).unwrap();
            let other = renderer.render(scene, &whole, &layers, &masked).unwrap();
            assert_eq!(one.report.value_range, other.report.value_range, "{name}, scene {i}");
            assert_eq!(one.report.missing_values, 0, "{name}");
            drawn += one.pixels.iter().filter(|pixel| pixel[3] > 0.0).count();
            for (pixel, ray) in rays(scene).enumerate() {
                if scene.core.is_some() && meets_hole(ray) {
                    meeting += 1;
                    continue;
                }
                same += usize::from(scene.core.is_some());
                let off = pixel_difference(&one, &other, pixel);
                assert!(off <= *allowed, "{name}, scene {i}: {off:e} at pixel {pixel}");
            }
        }
    });
    assert!(drawn > 30_000, "{drawn} pixels with something in them");
    assert!(same > 50_000 && meeting > 20_000, "{same} {meeting}");
}

/// A field at corners: each cell has the mean over those of its corners that are in the table.
#[test]
fn corners_that_are_there_are_averaged() {
    each_hole(2, |mesh, (name, _), culled| {
        let grid = culled.grid();
        let at = |corner: usize| (1.7 * corner as f64).sin();
        let there: Vec<f64> = culled.corners.iter().map(|&corner| at(corner)).collect();
        if there.is_empty() {
            return;
        }
        let centers = ComputedField::average(&grid, &level_fastest(&there, 1, Location::Corner)).unwrap();
        for (i, &cell) in culled.cells.iter().enumerate() {
            let names = |corner: &&usize| mesh.corner_cell[3 * **corner..][..3].contains(&(cell as i32));
            let around: Vec<f64> = culled.corners.iter().filter(names).map(|&corner| at(corner)).collect();
            let mean = around.iter().sum::<f64>() / around.len() as f64;
            let found = centers.field().value(i, 0);
            let fine = if around.is_empty() { found.is_nan() } else { (found - mean).abs() < 1e-12 };
            assert!(fine, "{name}, cell {cell}: {found}, expected {mean}");
        }
    });
}

/// The core under a hole is as round as the core under data.
#[test]
fn the_core_shows_through_holes() {
    let renderer = Renderer::new(2).unwrap();
    let layers = earth_layers();
    let scene = shown(FAR, "core = \"#ff0000\"\nprecision = \"f64\"");
    each_hole(3, |_, (name, _), culled| {
        let grid = culled.grid();
        let clear = vec![f64::NAN; grid.cells() * LAYERS];
        let frame = renderer.render(&scene, &grid, &layers, &at_centers(&clear, LAYERS)).unwrap();
        for ((eye, dir), pixel) in rays(&scene).zip(&frame.pixels) {
            let closest = (eye - eye.dot(dir) * dir).length();
            // Facets of a mesh of this level dip 0.9 % below their sphere in their middle.
            if closest < 0.99 {
                assert!(pixel[0] > 0.99, "{name}: no core {closest} from the centre: {pixel:?}");
            } else if closest > 1.0 {
                assert_eq!(pixel[0], 0.0, "{name}: core {closest} from the centre");
            }
        }
    });
}

/// A hole is one by all tables: what only looks like one is refused, with the rows that disagree.
#[test]
fn holes_are_no_excuse() {
    type Damage = fn(&mut Culled, usize, usize);
    let cases: &[(&str, Damage, &[&str])] = &[
        // `t` is a triangle beside the hole, `rim` its side there as an edge.
        ("the rim's corner names a stranger", |m, _, rim| beyond(m, rim)[0] = 3, &["cells in common", "expected 2"]),
        (
            "one more cell is marked",
            |m, t, _| m.corner_cell[3 * t + 1] = -1,
            &["corner_cell[", "and [", "-1", "expected 2"],
        ),
        (
            "a triangle's edge is marked",
            |m, t, _| m.corner_edge[3 * t] = -1,
            &["corner_edge[", "][0] (MPAS edgesOnVertex, ICON edge_of_cell): -1", "expected 0 to"],
        ),
        (
            "the rim's edge forgets its triangle",
            |m, t, rim| mark(&mut m.edge_corner[2 * rim..][..2], |end| end == t as i32),
            &["edge_corner[", "-1", "expected two corners"],
        ),
        (
            "an inner edge ends at nothing for one of its triangles",
            |m, t, _| {
                let inner = inner_edge(m, t);
                mark(&mut m.edge_corner[2 * inner..][..2], |end| end != t as i32);
            },
            &["edge_corner[", "-1", "expected two corners"],
        ),
        (
            "a cell forgets a corner",
            |m, t, _| {
                let cell = m.corner_cell[3 * t] as usize;
                mark(&mut m.cell_corner[6 * cell..][..6], |corner| corner == t as i32);
            },
            &["cell_corner[", "different corners", "expected the"],
        ),
        (
            "a number that is no mark",
            |m, _, rim| *beyond(m, rim).iter_mut().find(|cell| **cell < 0).unwrap() = -7,
            &["corner_cell[", ": -7, expected 0 to"],
        ),
    ];
    let mesh = IcosahedralMesh::new(3).unwrap();
    let stays: Vec<bool> = (0..mesh.cells()).map(|cell| cell % 50 != 20).collect();
    let right = Culled::new(&mesh, &stays, Style::Corners, Mark::MinusOne, 0);
    let is_there = |t: &usize| right.corner_cell[3 * t..3 * t + 3].iter().all(|&cell| cell >= 0);
    let rim_of = |t: usize| {
        let edges = right.corner_edge[3 * t..3 * t + 3].iter().map(|&edge| edge as usize);
        edges.into_iter().find(|&edge| right.edge_corner[2 * edge..][..2].iter().any(|&c| !is_there(&(c as usize))))
    };
    let triangles = 0..right.corners.len();
    let (t, rim) = triangles.filter(is_there).find_map(|t| Some((t, rim_of(t)?))).unwrap();
    right.grid();
    for (name, damage, words) in cases {
        let mut damaged = right.clone();
        damage(&mut damaged, t, rim);
        assert_grid_error(Grid::new(damaged.tables()), words, name);
    }
}

/// Marks entries as missing.
fn mark(entries: &mut [i32], is_lost: impl Fn(i32) -> bool) {
    entries.iter_mut().filter(|entry| is_lost(**entry)).for_each(|entry| *entry = -1);
}

/// The cells of the corner at the end of a rim edge that is no triangle.
fn beyond(m: &mut Culled, rim: usize) -> &mut [i32] {
    let ends = &m.edge_corner[2 * rim..2 * rim + 2];
    let row = ends.iter().map(|&c| 3 * c as usize).find(|&c| m.corner_cell[c..c + 3].contains(&-1)).unwrap();
    &mut m.corner_cell[row..row + 3]
}

/// An edge of the triangle that another triangle has too.
fn inner_edge(m: &Culled, t: usize) -> usize {
    let is_whole = |c: i32| !m.corner_cell[3 * c as usize..][..3].contains(&-1);
    let edges = m.corner_edge[3 * t..3 * t + 3].iter().map(|&edge| edge as usize);
    edges.into_iter().find(|&edge| m.edge_corner[2 * edge..][..2].iter().all(|&c| is_whole(c))).unwrap()
}

/// Two patches that lie over each other agree with all tables, and cannot be closed.
#[test]
fn patches_that_overlap_are_refused() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let at = directions(&mesh.lon_center_rad, &mesh.lat_center_rad);
    let near = |p: &DVec3, lon: f64| p.angle_between(towards(lon, 10.0)) < 0.4;
    let stays: Vec<bool> = at.iter().map(|p| near(p, 0.0) || near(p, 90.0)).collect();
    let mut culled = Culled::new(&mesh, &stays, Style::Triangles, Mark::MinusOne, 0);
    culled.grid();
    for (shift, inside) in [(TAU / 4.0, "in each other's place"), (1.4, "all"), (1.1, "half"), (0.85, "a little")] {
        let mut moved = culled.clone();
        for (lon, &cell) in moved.lon_lat[0].iter_mut().zip(&culled.cells) {
            if near(&at[cell], 90.0) {
                *lon -= shift;
            }
        }
        let error = Grid::new(moved.tables()).expect_err(inside);
        assert_eq!(error.kind(), ErrorKind::Grid, "{inside}: {error}");
        let message = error.to_string();
        let names = message.contains("overlap") && message.contains("corner_cell[");
        assert!(names || message.contains("center["), "{inside}: {message}");
    }
    // One within the other, rims apart.
    let stays: Vec<bool> = at.iter().map(|p| near(p, 0.0) || p.angle_between(towards(90.0, 10.0)) < 0.15).collect();
    let mut nested = Culled::new(&mesh, &stays, Style::Corners, Mark::BeforeFirst, 1);
    for (lon, &cell) in nested.lon_lat[0].iter_mut().zip(&nested.cells) {
        *lon -= if near(&at[cell], 90.0) { 1.53 } else { 0.0 };
    }
    let message = Grid::new(nested.tables()).unwrap_err().to_string();
    assert!(message.contains("corner_cell(:, ") && message.contains("overlap"), "{message}");
    // Both turned together lie apart.
    culled.lon_lat[0].iter_mut().for_each(|lon| *lon -= 0.3);
    culled.grid();
}
