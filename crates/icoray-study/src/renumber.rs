//! New numbers for a mesh's cells and corners: along a space-filling curve, as models do for their caches.

use icoray::IcosahedralMesh;
use icoray_reference::shading::direction;

/// Renumbers cells and corners so that those near to each other have close numbers. Edges keep their numbers.
pub(crate) fn along_curve(mesh: &mut IcosahedralMesh) {
    let cells = order(&mesh.lon_center_rad, &mesh.lat_center_rad);
    let corners = order(&mesh.lon_corner_rad, &mesh.lat_corner_rad);
    for column in [&mut mesh.lon_center_rad, &mut mesh.lat_center_rad] {
        *column = rows(column, 1, &cells).collect();
    }
    for column in [&mut mesh.lon_corner_rad, &mut mesh.lat_corner_rad] {
        *column = rows(column, 1, &corners).collect();
    }
    mesh.cell_corner = rows(&mesh.cell_corner, 6, &cells).collect();
    mesh.corner_cell = rows(&mesh.corner_cell, 3, &corners).collect();
    mesh.corner_edge = rows(&mesh.corner_edge, 3, &corners).collect();
    let (new_cell, new_corner) = (numbers(&cells), numbers(&corners));
    mesh.corner_cell.iter_mut().for_each(|cell| *cell = new_cell[*cell as usize]);
    mesh.cell_corner.iter_mut().for_each(|corner| *corner = new_corner[*corner as usize]);
    mesh.edge_corner.iter_mut().for_each(|corner| *corner = new_corner[*corner as usize]);
}

/// The places in the order of Morton's curve through space.
fn order(lon_rad: &[f64], lat_rad: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..lon_rad.len()).collect();
    order.sort_by_cached_key(|k| morton(lon_rad[*k], lat_rad[*k]));
    order
}

/// Morton code of a direction in the cube around the sphere, with 16 bits per axis.
pub(crate) fn morton(lon_rad: f64, lat_rad: f64) -> u64 {
    let at = direction(lon_rad, lat_rad).to_array().map(|x| ((x + 1.0) * 32767.5) as u64);
    let bits = (0..48).map(|bit| (at[bit % 3] >> (bit / 3) & 1) << bit);
    bits.sum()
}

/// The position of each row in `order`.
fn numbers(order: &[usize]) -> Vec<i32> {
    let mut numbers = vec![0; order.len()];
    (0..).zip(order).for_each(|(number, &row)| numbers[row] = number);
    numbers
}

/// The entries of rows of `width`.
pub(crate) fn rows<'a, V: Copy>(table: &'a [V], width: usize, kept: &'a [usize]) -> impl Iterator<Item = V> + 'a {
    kept.iter().flat_map(move |&row| table[row * width..(row + 1) * width].iter().copied())
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
