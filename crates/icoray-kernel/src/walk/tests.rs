//! No ray is lost, none loops: random rays and rays aimed at everything that could go wrong.

use super::*;
use icoray_grid::{GridTables, IcosahedralMesh, LonLat};
use icoray_test_support::{Random, count};
use rayon::prelude::*;

#[path = "../../../icoray/tests/suite/culled/mod.rs"]
pub mod culled;

const OUTER: f64 = 1.1;

/// Walks one ray and returns the first fault of its columns, if any.
fn walk(grid: &Grid, eye: DVec3, dir: DVec3, hint: u32) -> Result<usize, String> {
    let Some(line) = RayLine::new(eye, dir, OUTER) else { return Ok(0) };
    let mut walk = Walk::new(grid, line, hint);
    let (mut columns, mut t, mut rho) = (0, line.start, None);
    let mut last_triangle = u32::MAX;
    loop {
        let is_void = walk.is_void();
        let Some(column) = walk.next_column() else { break };
        columns += 1;
        let wrong = |what: &str| Err(format!("column {columns}: {what}: {column:?} of {line:?}"));
        if columns > grid.triangles() + grid.void_triangles() {
            return wrong("more columns than triangles");
        }
        if !is_void && column.cells.iter().any(|&cell| cell as usize >= grid.cells()) {
            return wrong("a synthetic point is taken for a cell");
        }
        if column.entry.t != t || column.exit.t < t {
            return wrong("a gap or a step back");
        }
        if rho.is_some_and(|rho| rho != column.entry.rho) {
            return wrong("a jump in height");
        }
        if walk.triangle() == last_triangle && columns > 1 && walk.from.is_some() {
            return wrong("the same triangle twice");
        }
        last_triangle = walk.triangle();
        for end in [&column.entry, &column.exit] {
            let [b, c] = end.weight;
            let weights = [1.0 - b - c, b, c];
            if !weights.iter().all(|w| (-1e-9..=1.0 + 1e-9).contains(w)) {
                return wrong("weights outside the triangle");
            }
            let on: DVec3 = (0..3).map(|k| weights[k] * grid.direction(column.cells[k])).sum();
            let off = (end.rho * on).distance(line.position(end.t));
            if !(off < 1e-11 && end.rho >= 0.0) {
                return wrong(&format!("{off:e} off the ray"));
            }
        }
        (t, rho) = (column.exit.t, Some(column.exit.rho));
    }
    if t != line.end {
        return Err(format!("lost at {t} of {line:?}"));
    }
    Ok(columns)
}

fn must_walk(grid: &Grid, eye: DVec3, dir: DVec3, hint: u32) -> usize {
    walk(grid, eye, dir, hint).unwrap_or_else(|e| panic!("eye {eye:?}, dir {dir:?}, hint {hint}: {e}"))
}

/// A mesh whose cells were moved about by up to a third of their spacing, with coordinates of 32 bits and turned rows.
fn uneven(level: u32) -> IcosahedralMesh {
    let mut mesh = IcosahedralMesh::new(level).unwrap();
    let spacing = 1.1 / f64::from(1u32 << level);
    let mut random = Random::new(7);
    for cell in 0..mesh.cells() {
        let at = icoray_grid::grid::unit_vector(mesh.lon_center_rad[cell], mesh.lat_center_rad[cell]);
        let moved = (at + DVec3::from_array(random.direction()) * spacing * 0.33).normalize();
        mesh.lon_center_rad[cell] = f64::from(moved.y.atan2(moved.x) as f32);
        mesh.lat_center_rad[cell] = f64::from(moved.z.asin() as f32);
    }
    for row in mesh.corner_cell.chunks_exact_mut(3).step_by(3) {
        row.swap(0, 2);
    }
    mesh
}

/// An eye, from the centre out to 1e4 radii, and an aim around the shell; many of the rays graze it.
fn ends(random: &mut Random, ray: u64) -> [DVec3; 2] {
    let far = [0.3, 1.0, 1.05, 1.5, 3.0, 1e4][(ray % 6) as usize];
    let eye = DVec3::from_array(random.direction()) * far * random.unit().max(0.01);
    let aim = DVec3::from_array(random.direction()) * OUTER;
    [eye, aim * if ray.is_multiple_of(5) { 0.999_999 } else { random.unit() }]
}

/// Ten million rays in the long run.
#[test]
fn random_rays_are_walked_to_their_end() {
    let [uneven, fine] = [uneven(3), IcosahedralMesh::new(5).unwrap()];
    let [uneven, fine] = [&uneven, &fine].map(|mesh| Grid::new(mesh.tables()).unwrap());
    let rays: u64 = count(200_000, 10_000_000);
    const BLOCK: u64 = 10_000;
    let columns: usize = (0..rays / BLOCK)
        .into_par_iter()
        .map(|block| {
            let grid = if block % 8 == 0 { &fine } else { &uneven };
            let mut columns = 0;
            for ray in 0..BLOCK {
                let mut random = Random::new(block * BLOCK + ray);
                let [eye, aim] = ends(&mut random, ray);
                let hint = (random.unit() * grid.triangles() as f64) as u32;
                // Hints near the start, as the renderer has them, for most; anywhere for the rest.
                let hint = if ray % 16 == 0 { hint } else { locate(grid, 0, (eye + aim * 1e-9).normalize()) };
                columns += must_walk(grid, eye, (aim - eye).normalize(), hint);
            }
            columns
        })
        .sum();
    assert!(columns > rays as usize, "only {columns} columns: the rays missed");
}

/// Rays through the centre, from an eye above each vertex: all triangles around the vertex lie behind the ray.
#[test]
fn rays_from_above_vertices_through_the_centre_reach_the_far_side() {
    for level in 0..4 {
        let mesh = uneven(level);
        let grid = Grid::new(mesh.tables()).unwrap();
        for cell in 0..grid.cells() as u32 {
            for far in [1.05, 1.3, 1.5, 2.7, 11.0, 300.0] {
                let eye = grid.direction(cell) * far;
                must_walk(&grid, eye, -eye.normalize(), 0);
                must_walk(&grid, eye, -grid.direction(cell), 0);
            }
        }
    }
}

/// A million rays in the long run. Over holes of all kinds, from inside the shell above them too, into and out of data,
/// to and from void triangles.
#[test]
fn random_rays_are_walked_over_holes() {
    let each: u64 = count(2_000, 40_000);
    let meshes = [uneven(3), IcosahedralMesh::new(4).unwrap()];
    let meshes = meshes.iter().flat_map(|mesh| culled::holes(mesh).into_iter().map(move |hole| (hole, mesh)));
    let mut rays = 0;
    for ((name, stays), mesh) in meshes {
        let culled = culled::Culled::new(mesh, &stays, culled::Style::Corners, culled::Mark::BeforeFirst, 1);
        let grid = culled.grid();
        let all = grid.triangles() + grid.void_triangles();
        let walked: usize = (0..each)
            .into_par_iter()
            .map(|ray| {
                let mut random = Random::new(ray);
                let [eye, aim] = ends(&mut random, ray);
                let hint = (random.unit() * all as f64) as u32;
                walk(&grid, eye, (aim - eye).normalize(), hint).unwrap_or_else(|e| panic!("{name}, ray {ray}: {e}"))
            })
            .sum();
        assert!(walked > each as usize, "{name}: only {walked} columns");
        // At every vertex, synthetic ones and those of the rim too, and along every side.
        let there = (0..all as u32).filter(|&t| grid.is_triangle(t) || grid.is_void(t));
        there.collect::<Vec<_>>().par_iter().for_each(|&t| {
            let [a, b, c] = grid.triangle(t).map(|cell| grid.direction(cell));
            let eyes = [DVec3::new(2.0, 0.3, 0.1), (a + b + c) * 0.34, b * 1.05];
            for (eye, aim) in eyes.into_iter().flat_map(|eye| [a, (a + b) * 0.5, c].map(|aim| (eye, aim))) {
                if let Some(dir) = (aim - eye).try_normalize() {
                    must_walk(&grid, eye, dir, t);
                }
            }
            must_walk(&grid, a * 1.02, (b - a).normalize(), t);
        });
        rays += each;
    }
    assert!(rays > count(50_000, 1_000_000), "{rays}");
}

#[test]
fn rays_aimed_at_vertices_edges_poles_and_the_axis_are_walked_to_their_end() {
    let mesh = IcosahedralMesh::new(2).unwrap();
    let grid = Grid::new(mesh.tables()).unwrap();
    let cells = 0..grid.cells() as u32;
    let mut targets: Vec<DVec3> = cells.map(|c| grid.direction(c)).collect();
    for t in 0..grid.triangles() as u32 {
        let v = grid.triangle(t).map(|c| grid.direction(c));
        targets.extend((0..3).map(|k| 0.5 * (v[k] + v[(k + 1) % 3])));
        targets.push((v[0] + v[1] + v[2]) / 3.0);
    }
    targets.extend([DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::ZERO]);
    let mut eyes: Vec<DVec3> = targets.iter().step_by(17).flat_map(|p| [*p * 0.5, *p, *p * OUTER, *p * 3.0]).collect();
    eyes.extend([DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::Y].map(|p| p * 2.5));
    eyes.extend([DVec3::ZERO, DVec3::new(1e-300, 0.0, 0.0), DVec3::new(0.0, 1e-17, 1e-16)]);
    let walked: usize = eyes
        .par_iter()
        .map(|eye| {
            let mut walked = 0;
            for target in &targets {
                let Some(dir) = (*target - *eye).try_normalize() else { continue };
                walked += usize::from(must_walk(&grid, *eye, dir, 0) > 0);
                walked += usize::from(must_walk(&grid, *eye, -dir, 319) > 0);
            }
            walked
        })
        .sum();
    assert!(walked > eyes.len() * targets.len() / 2, "{walked}");
}

#[test]
fn rays_in_the_planes_of_edges_and_grazing_rays_are_walked_to_their_end() {
    let mesh = IcosahedralMesh::new(2).unwrap();
    let grid = Grid::new(mesh.tables()).unwrap();
    let mut grazing = 0;
    for t in 0..grid.triangles() as u32 {
        let v = grid.triangle(t).map(|c| grid.direction(c));
        for k in 0..3 {
            let (a, b) = (v[k], v[(k + 1) % 3]);
            // Along an edge, on its own great circle, at several depths.
            for depth in [0.2, 0.95, 1.0, 1.02] {
                must_walk(&grid, a * depth, (b * depth - a * depth).normalize(), t);
                must_walk(&grid, (a * 2.0 - b) * depth, (b - a).normalize(), t);
            }
            // Touching the outer sphere from just inside it, over a vertex and over the middle of an edge.
            for over in [a, (a + b).normalize()] {
                let along = over.cross(b - a).normalize();
                for below in [1e-2, 1e-6, 1e-10, 1e-13, 1e-15] {
                    let eye = over * OUTER * (1.0 - below) - along * 4.0;
                    grazing += must_walk(&grid, eye, along, t);
                }
            }
        }
    }
    assert!(grazing > 1000, "{grazing}");
}

/// Every column's exit is the next one's entry, in place as well as in height.
#[test]
fn columns_join_without_a_gap() {
    let mesh = IcosahedralMesh::new(2).unwrap();
    let grid = Grid::new(mesh.tables()).unwrap();
    let line = RayLine::new(DVec3::new(3.0, 0.2, 0.1), DVec3::NEG_X, OUTER).unwrap();
    let mut walk = Walk::new(&grid, line, 0);
    let mut columns = Vec::new();
    while let Some(column) = walk.next_column() {
        columns.push(column);
    }
    let place = |column: &Column, end: &ColumnEnd| -> DVec3 {
        let [b, c] = end.weight;
        let weights = [1.0 - b - c, b, c];
        (0..3).map(|k| weights[k] * grid.direction(column.cells[k])).sum()
    };
    for pair in columns.windows(2) {
        assert!(place(&pair[0], &pair[0].exit).distance(place(&pair[1], &pair[1].entry)) < 1e-15);
    }
    assert!(columns.len() > 8);
}
