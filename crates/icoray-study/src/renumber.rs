//! Numbers a mesh's cells and corners along a space-filling curve, as models do for their caches.

use crate::shading::direction;
use icoray::IcosahedralMesh;

/// Bits of a coordinate along the curve.
const BITS: u32 = 10;

/// Renumbers cells and corners so that those near to each other have close numbers. Edges keep their numbers.
pub(crate) fn along_curve(mesh: &mut IcosahedralMesh) {
    let cells = order(&mesh.lon_center_rad, &mesh.lat_center_rad);
    let corners = order(&mesh.lon_corner_rad, &mesh.lat_corner_rad);
    for column in [&mut mesh.lon_center_rad, &mut mesh.lat_center_rad] {
        *column = permuted::<_, 1>(column, &cells);
    }
    for column in [&mut mesh.lon_corner_rad, &mut mesh.lat_corner_rad] {
        *column = permuted::<_, 1>(column, &corners);
    }
    mesh.cell_corner = permuted::<_, 6>(&mesh.cell_corner, &cells);
    mesh.corner_cell = permuted::<_, 3>(&mesh.corner_cell, &corners);
    mesh.corner_edge = permuted::<_, 3>(&mesh.corner_edge, &corners);
    let (new_cell, new_corner) = (inverse(&cells), inverse(&corners));
    mesh.corner_cell.iter_mut().for_each(|cell| *cell = new_cell[*cell as usize]);
    mesh.cell_corner.iter_mut().for_each(|corner| *corner = new_corner[*corner as usize]);
    mesh.edge_corner.iter_mut().for_each(|corner| *corner = new_corner[*corner as usize]);
}

/// The places in the order of Morton's curve through space.
fn order(lon: &[f64], lat: &[f64]) -> Vec<usize> {
    let key = |k: usize| {
        let place = direction(lon[k], lat[k]).to_array();
        let [x, y, z] = place.map(|x| ((0.5 * (x + 1.0)) * f64::from((1 << BITS) - 1)) as u64);
        (0..BITS).fold(0, |key, bit| {
            let of = |x: u64, axis: u32| (x >> bit & 1) << (3 * bit + axis);
            key | of(x, 0) | of(y, 1) | of(z, 2)
        })
    };
    let mut order: Vec<usize> = (0..lon.len()).collect();
    order.sort_by_cached_key(|k| key(*k));
    order
}

/// Rows of `N` elements in a new order.
fn permuted<X: Copy, const N: usize>(rows: &[X], order: &[usize]) -> Vec<X> {
    let rows = rows.as_chunks::<N>().0;
    order.iter().flat_map(|row| rows[*row]).collect()
}

/// The new number of each old one.
fn inverse(order: &[usize]) -> Vec<i32> {
    let mut numbers = vec![0; order.len()];
    (0..).zip(order).for_each(|(new, old)| numbers[*old] = new);
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray::Grid;

    /// The renumbered mesh is the same grid, and its neighbours are closer to each other in memory.
    #[test]
    fn a_renumbered_mesh_is_a_grid_of_close_neighbours() {
        let mesh = IcosahedralMesh::new(5).unwrap();
        let mut renumbered = mesh.clone();
        along_curve(&mut renumbered);
        let distance = |mesh: &IcosahedralMesh| {
            let grid = Grid::new(mesh.tables()).unwrap();
            let sides = (0..grid.triangles() as u32).map(|triangle| {
                let [a, b, c] = grid.triangle(triangle);
                u64::from(a.abs_diff(b) + b.abs_diff(c) + c.abs_diff(a))
            });
            sides.sum::<u64>()
        };
        assert!(distance(&renumbered) < distance(&mesh) / 2);
    }
}
