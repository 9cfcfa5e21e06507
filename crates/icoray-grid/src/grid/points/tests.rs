use super::*;
use crate::{ErrorKind, Grid, IcosahedralMesh};
use icoray_test_support::Random;
use std::collections::HashSet;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn made(points: &[[f64; 2]]) -> Result<OwnedTables> {
    let [lon, lat] = [0, 1].map(|k| points.iter().map(|point| point[k]).collect::<Vec<f64>>());
    OwnedTables::of_points(LonLat::of(&lon, &lat))
}

fn scattered(count: usize, seed: u64) -> Vec<[f64; 2]> {
    let mut random = Random::new(seed);
    (0..count).map(|_| [TAU * random.unit(), (2.0 * random.unit() - 1.0).asin()]).collect()
}

/// Rows and columns `step` apart from a corner, radians.
fn patch([lon, lat]: [f64; 2], [columns, rows]: [usize; 2], step: f64) -> Vec<[f64; 2]> {
    (0..columns * rows).map(|i| [lon + step * (i % columns) as f64, lat + step * (i / columns) as f64]).collect()
}

fn void_triangles(tables: &OwnedTables) -> usize {
    Grid::new(tables.tables()).unwrap().void_triangles()
}

/// The cells that are vertices.
fn vertices(tables: &OwnedTables) -> HashSet<i32> {
    tables.corner_cell.iter().copied().collect()
}

#[test]
fn points_of_a_mesh_in_any_order_give_its_triangles() {
    let mesh = IcosahedralMesh::new(4).unwrap();
    let mut random = Random::new(3);
    let mut order: Vec<usize> = (0..mesh.cells()).collect();
    (1..order.len()).rev().for_each(|i| order.swap(i, random.below(i + 1)));
    // Longitudes from -π to π and from 0 to 2π.
    let lon = |cell: usize| mesh.lon_center_rad[cell].rem_euclid(TAU) - if cell.is_multiple_of(2) { TAU } else { 0.0 };
    let points: Vec<[f64; 2]> = order.iter().map(|cell| [lon(*cell), mesh.lat_center_rad[*cell]]).collect();
    let tables = made(&points).unwrap();
    let sorted = |row: &[i32], cell: &dyn Fn(i32) -> i32| {
        let mut row = [row[0], row[1], row[2]].map(cell);
        row.sort_unstable();
        row
    };
    let found = tables.corner_cell.chunks_exact(3).map(|row| sorted(row, &|cell| order[cell as usize] as i32));
    let expected = mesh.corner_cell.chunks_exact(3).map(|row| sorted(row, &|cell| cell));
    assert_eq!(found.collect::<HashSet<_>>(), expected.collect::<HashSet<_>>());
    assert_eq!((void_triangles(&tables), tables.corner_cell.len()), (0, mesh.corner_cell.len()));
}

/// On lines of symmetry four points lie on one circle exactly.
#[test]
fn points_on_one_circle_in_any_order_give_the_same_triangles() {
    let side = |i: usize| [-0.75, -0.25, 0.25, 0.75][i % 4];
    let on_cube = (0..96).map(|i| {
        let mut point = [side(i), side(i / 4), 1.0 - 2.0 * (i / 16 % 2) as f64];
        point.rotate_left(i / 32);
        [point[1].atan2(point[0]), point[2].atan2(point[0].hypot(point[1]))]
    });
    let points: Vec<[f64; 2]> = on_cube.collect();
    let triangles = |order: &[usize]| -> HashSet<[usize; 3]> {
        let tables = made(&order.iter().map(|i| points[*i]).collect::<Vec<_>>()).unwrap();
        let of_row = |row: &[i32; 3]| {
            let mut row = row.map(|cell| order[cell as usize]);
            row.sort_unstable();
            row
        };
        tables.corner_cell.as_chunks().0.iter().map(of_row).collect()
    };
    let mut order: Vec<usize> = (0..points.len()).collect();
    let expected = triangles(&order);
    assert_eq!(expected.len(), 2 * (points.len() - 2));
    let mut random = Random::new(12);
    for _ in 0..20 {
        (1..order.len()).rev().for_each(|i| order.swap(i, random.below(i + 1)));
        assert_eq!(triangles(&order), expected);
    }
}

/// No circumcircle contains another point: the definition, without the code of the triangulation.
#[test]
fn circumcircles_are_empty() {
    for (seed, share) in [(5, 1.0), (6, 0.2)] {
        let points: Vec<[f64; 2]> = scattered(600, seed).into_iter().map(|[lon, lat]| [share * lon, lat]).collect();
        let tables = made(&points).unwrap();
        let at = |cell: usize| check::unit_vector(points[cell][0], points[cell][1]);
        assert!(tables.corner_cell.len() > 3 * 1000, "{}", tables.corner_cell.len());
        for (corner, row) in tables.corner_cell.chunks_exact(3).enumerate() {
            let middle = check::unit_vector(tables.corner[0][corner], tables.corner[1][corner]);
            let radius = middle.distance(at(row[0] as usize));
            let nearest = (0..points.len()).map(|cell| middle.distance(at(cell))).fold(f64::INFINITY, f64::min);
            assert!((nearest - radius).abs() < 1e-12, "triangle {corner}: {nearest} within {radius}");
        }
        assert_eq!(vertices(&tables).len(), points.len());
        Grid::new(tables.tables()).unwrap();
    }
}

/// The poles stand there once for each meridian, and the first meridian twice.
#[test]
fn points_in_one_place_are_one_vertex() {
    let (columns, rows) = (201, 101);
    let point = |i: usize| [TAU * (i % columns) as f64 / 200.0, PI * (i / columns) as f64 / 100.0 - FRAC_PI_2];
    let points: Vec<[f64; 2]> = (0..columns * rows).map(point).collect();
    let tables = made(&points).unwrap();
    let vertices = vertices(&tables);
    // Each pole has 200 triangles, and is left out.
    assert_eq!(vertices.len(), 200 * 99);
    let first_of_both = |row: i32| vertices.contains(&(201 * row)) && !vertices.contains(&(201 * row + 200));
    assert!((1..100).all(first_of_both));
    assert_eq!((tables.corner_cell.len() / 3, void_triangles(&tables)), (2 * (vertices.len() - 2), 0));
    assert!(tables.connectivity.cell_corner_row < 32, "{}", tables.connectivity.cell_corner_row);
    // In single precision the meridians differ a little.
    let rounded: Vec<[f64; 2]> = points.iter().map(|point| point.map(|angle| f64::from(angle as f32))).collect();
    assert_eq!(self::vertices(&made(&rounded).unwrap()), vertices);
}

#[test]
fn regions_stay_regions() {
    let [west, east] = [-0.3, 0.3].map(|lon| patch([lon, 0.5], [20, 15], 0.01));
    let tables = made(&[west, east].concat()).unwrap();
    assert_eq!(tables.corner_cell.len() / 3, 2 * 2 * 19 * 14);
    assert!(tables.corner_cell.chunks_exact(3).all(|row| row.iter().all(|cell| (*cell < 300) == (row[0] < 300))));
    assert!(void_triangles(&tables) > 100);
    // Half of a sphere, and more: the ocean around a continent.
    let points = scattered(4000, 8);
    for (lowest, highest) in [(0.0, FRAC_PI_2), (-0.9, FRAC_PI_2), (-0.4, 0.4)] {
        let region: Vec<[f64; 2]> = points.iter().copied().filter(|[_, lat]| (lowest..highest).contains(lat)).collect();
        let tables = made(&region).unwrap();
        let far = (lowest - 0.2)..(highest + 0.2);
        assert!(tables.corner[1].iter().all(|lat| far.contains(lat)), "{lowest} to {highest}");
        assert_eq!(vertices(&tables).len(), region.len());
        assert!(void_triangles(&tables) > 10);
    }
}

#[test]
fn the_triangles_do_not_depend_on_threads() {
    let points = [scattered(3000, 9), patch([0.0, 0.0], [30, 30], 1e-3)].concat();
    let on = |threads| crate::threads::Threads::new(threads).unwrap().run(|| made(&points).unwrap().corner_cell);
    assert_eq!(on(1), on(3));
}

#[test]
fn points_that_make_no_mesh_are_named() {
    let mut points = scattered(50, 10);
    let message = |points: &[[f64; 2]]| {
        let error = made(points).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Grid);
        error.to_string()
    };
    points[7][1] = f64::NAN;
    assert!(message(&points).contains("center[7]"), "{}", message(&points));
    points[7] = [20.0, 45.0];
    assert!(message(&points).contains("these look like degrees"));
    let equator: Vec<[f64; 2]> = (0..90).map(|i| [0.05 * f64::from(i), 0.0]).collect();
    let inclined = |[lon, _]: &[f64; 2]| [(0.6 * lon.sin()).atan2(lon.cos()), (0.8 * lon.sin()).asin()];
    let inclined: Vec<[f64; 2]> = equator.iter().map(inclined).collect();
    for few in [&points[..0], &points[..2], &equator, &inclined] {
        assert!(message(few).contains(&format!("the {} points span no area", few.len())), "{}", message(few));
    }
    let places = LonLat::of(&[0.0, 1.0], &[0.0]);
    let error = OwnedTables::of_points(places).unwrap_err().to_string();
    assert!(error.contains("2 longitudes and 1 latitudes"), "{error}");
}
