//! Values of both grids at random places, interpolated by their definition, against the deviations.

use super::*;
use crate::{CoarseGrid, IcosahedralMesh, Location, LonLat, OwnedGrid, OwnedTables};
use icoray_test_support::Random;

const RADIUS: [f64; 5] = [1.0, 1.02, 1.05, 1.06, 1.1];

/// Value of a column's layers at a place: gap and value, or `None` outside of the shell or of the mesh. Layers are
/// `lift` times as high.
fn value_at(grid: &Grid, lift: f64, place: DVec3, value: impl Fn(u32, usize) -> f64) -> Option<(u32, usize, f64)> {
    let cells = |t: u32| grid.triangle(t).map(|cell| grid.direction(cell));
    let weights = |t: u32| {
        let [a, b, c] = cells(t);
        [b.cross(c).dot(place), c.cross(a).dot(place), a.cross(b).dot(place)]
    };
    let holds = |t: &u32| grid.is_triangle(*t) && weights(*t).iter().all(|weight| *weight >= 0.0);
    let triangle = (0..grid.triangles() as u32).find(holds)?;
    let ([a, b, c], weights) = (cells(triangle), weights(triangle));
    let normal = (b - a).cross(c - a);
    let height = place.dot(normal) / (a.dot(normal) * lift);
    let gap = RADIUS.windows(2).position(|pair| pair[0] <= height && height <= pair[1])?;
    let part = (height - RADIUS[gap]) / (RADIUS[gap + 1] - RADIUS[gap]);
    let sum: f64 = weights.iter().sum();
    let at = |layer: usize| {
        let numbers = grid.triangle(triangle);
        numbers.iter().zip(weights).map(|(cell, weight)| value(*cell, layer) * weight / sum).sum::<f64>()
    };
    Some((triangle, gap, (1.0 - part) * at(gap) + part * at(gap + 1)))
}

/// Compares a smooth field with some noise at random places; returns the greatest part of a deviation that was seen.
fn compare(fine: &Grid, twice: bool) -> f64 {
    let mut coarse = CoarseGrid::new(fine).unwrap();
    if twice {
        coarse = CoarseGrid::new(coarse.grid()).unwrap().over(coarse.cells());
    }
    assert!(4 * coarse.grid().cells() < 3 * fine.cells(), "{} of {}", coarse.grid().cells(), fine.cells());
    for (number, cell) in coarse.cells().iter().enumerate() {
        assert_eq!(coarse.grid().direction(number as u32), fine.direction(*cell));
    }
    let over = CellsOver::new(fine, coarse.grid());
    let mut random = Random::new(7);
    let mut values = Vec::new();
    for cell in 0..fine.cells() as u32 {
        let [x, y, z] = fine.direction(cell).to_array();
        values.extend((0..RADIUS.len()).map(|layer| (3.0 * x + layer as f64).sin() * y + z + 0.1 * random.unit()));
    }
    let field = Field::level_fastest(&values, RADIUS.len(), Location::Center).unwrap();
    let pair = GridPair { fine, field, radius: &RADIUS, coarse: coarse.grid(), cells: coarse.cells(), over: &over };
    let mut finder = GapFinder::new(pair);
    let (mut most, mut seen) = (0.0f64, 0);
    for _ in 0..1_500 {
        let place = DVec3::from_array(random.direction()) * (1.0 + 0.1 * random.unit());
        let on_fine = value_at(fine, 1.0, place, |cell, layer| field.value(cell as usize, layer));
        let of_coarse = |cell: u32, layer| field.value(coarse.cells()[cell as usize] as usize, layer);
        let on_coarse = value_at(coarse.grid(), pair.lift(), place, of_coarse);
        let (Some((_, _, value)), Some((triangle, gap, other))) = (on_fine, on_coarse) else { continue };
        let GapRange { low, high, deviation } = finder.gaps(triangle).nth(gap).unwrap();
        let off = (value - other).abs();
        assert!(off <= deviation, "{off}, expected at most {deviation} at {place}");
        assert!((low..=high).contains(&other), "{other}, expected {low} to {high}");
        (most, seen) = (most.max(off / deviation), seen + 1);
    }
    assert!(seen > 300, "{seen} places");
    most
}

#[test]
fn values_deviate_no_more_than_the_bound() {
    let mesh = IcosahedralMesh::new(4).unwrap();
    let fine = Grid::new(mesh.tables()).unwrap();
    let coarse = CoarseGrid::new(&fine).unwrap();
    assert_eq!(coarse.grid().cells(), IcosahedralMesh::new(3).unwrap().cells(), "the mesh that was bisected");
    for twice in [false, true] {
        let most = compare(&fine, twice);
        assert!(most > 0.4, "a bound {most} of which is reached is too large");
    }
}

/// The mesh of the points of a bisected icosahedron that random steps move by up to this length.
fn moved_points(length: f64, stays: impl Fn(DVec3) -> bool) -> OwnedGrid {
    let mesh = IcosahedralMesh::new(4).unwrap();
    let fine = Grid::new(mesh.tables()).unwrap();
    let mut random = Random::new(11);
    let all =
        (0..fine.cells() as u32).map(|cell| fine.direction(cell) + length * DVec3::from_array(random.direction()));
    let angles =
        all.map(DVec3::normalize).filter(|place| stays(*place)).map(|place| (place.y.atan2(place.x), place.z.asin()));
    let (lon, lat): (Vec<f64>, Vec<f64>) = angles.unzip();
    OwnedGrid::new(OwnedTables::of_points(LonLat::of(&lon, &lat)).unwrap()).unwrap()
}

#[test]
fn irregular_meshes_and_regions_have_levels() {
    compare(moved_points(0.02, |_| true).grid(), false);
    let region = moved_points(0.01, |place| place.x > 0.2);
    assert!(region.grid().void_triangles() > 0);
    compare(region.grid(), false);
    // Scattered points, of whose triangles some are slivers.
    let scattered = moved_points(0.5, |_| true);
    assert!(CoarseGrid::new(scattered.grid()).unwrap().grid().cells() > 300);
}

/// Deviations beside missing values are infinite, and there are none where all are missing.
#[test]
fn missing_values_are_no_values() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let fine = Grid::new(mesh.tables()).unwrap();
    let coarse = CoarseGrid::new(&fine).unwrap();
    let over = CellsOver::new(&fine, coarse.grid());
    // The coarser grid has none of the single cells with values.
    let is_single = |cell: u32| cell as usize > coarse.grid().cells() && cell.is_multiple_of(60);
    let value = |cell: u32| if fine.direction(cell).z > 0.2 && !is_single(cell) { f64::NAN } else { 1.0 };
    let values: Vec<f64> = (0..fine.cells() as u32).flat_map(|cell| [value(cell); RADIUS.len()]).collect();
    let field = Field::level_fastest(&values, RADIUS.len(), Location::Center).unwrap();
    let pair =
        GridPair { fine: &fine, field, radius: &RADIUS, coarse: coarse.grid(), cells: coarse.cells(), over: &over };
    let mut finder = GapFinder::new(pair);
    let mut kinds = [0; 3];
    for triangle in 0..coarse.grid().triangles() as u32 {
        let missing = over.of(triangle).iter().filter(|cell| value(**cell).is_nan()).count();
        for GapRange { low, high, deviation } in finder.gaps(triangle) {
            let kind = match missing {
                0 => {
                    assert_eq!((low, high), (1.0, 1.0));
                    assert!(deviation < 1e-12, "{deviation}");
                    0
                }
                all if all == over.of(triangle).len() => {
                    assert!(low > high, "{low} to {high}");
                    1
                }
                _ => {
                    assert_eq!([low, high, deviation], [f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY]);
                    2
                }
            };
            kinds[kind] += 1;
        }
    }
    assert!(kinds.iter().all(|kind| *kind > 20), "{kinds:?}");
}
