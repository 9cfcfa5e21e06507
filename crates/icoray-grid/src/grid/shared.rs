//! A grid in one block of bytes, in memory that the ranks of a node share: one rank makes and writes it, all read it in
//! place.

use super::{Grid, GridTables, Indices, LonLat, OwnedGrid};
use crate::block;
use crate::error::Result;
use crate::macrocells::Macrocells;
use bytemuck::Pod;
use std::sync::{Arc, OnceLock};

/// A table that the block does not have.
const EMPTY: Indices<'static> = Indices::I32(&[]);

impl OwnedGrid {
    /// Number of arrays of a grid in a block; others may follow.
    pub const ARRAYS: usize = 10;

    /// Calls `write` with the arrays of a block that [`Grid::of_block`] reads: latitudes and corners of cells, positions of
    /// corners, and all that derives from the tables, macrocells included, which are made for it. Rows of cells with
    /// fewer corners repeat one of them.
    pub fn with_arrays<R>(&self, write: impl FnOnce([&[u8]; Self::ARRAYS]) -> R) -> R {
        let (grid, tables) = (self.grid(), self.tables());
        let numbers = [
            grid.cells() as u64,
            grid.triangles() as u64,
            tables.connectivity.cell_corner_row as u64,
            u64::from(grid.start),
            grid.lowest_facet().to_bits(),
            grid.longest_side().to_bits(),
            grid.number_base as u64,
        ];
        let [of_triangle, triangle_in] = grid.macrocells().arrays();
        write([
            bytemuck::cast_slice(&numbers),
            bytemuck::cast_slice(&tables.center[1]),
            bytemuck::cast_slice(&tables.corner[0]),
            bytemuck::cast_slice(&tables.corner[1]),
            bytemuck::cast_slice(&tables.connectivity.cell_corner),
            bytemuck::cast_slice(&grid.direction),
            bytemuck::cast_slice(&grid.half_edges),
            bytemuck::cast_slice(&tables.cell_number),
            bytemuck::cast_slice(of_triangle),
            bytemuck::cast_slice(triangle_in),
        ])
    }
}

/// The arrays of a block, one after the other.
struct Arrays<'a> {
    block: &'a [u8],
    next: usize,
}

impl<'a> Arrays<'a> {
    fn read<T: Pod>(&mut self) -> Result<&'a [T]> {
        self.next += 1;
        block::array(self.block, self.next - 1)
    }
}

impl<'a> Grid<'a> {
    /// The grid of a block that [`OwnedGrid::with_arrays`] wrote, read in place. Of its tables only the latitudes and
    /// the corners of cells, and the positions of corners, are not empty.
    ///
    /// # Errors
    /// [`ErrorKind::Internal`](crate::ErrorKind::Internal) if arrays are missing.
    pub fn of_block(block: &'a [u8]) -> Result<Self> {
        let mut arrays = Arrays { block, next: 0 };
        let numbers: &[u64] = arrays.read()?;
        let [lowest_facet, longest_side] = [numbers[4], numbers[5]].map(f64::from_bits);
        // Fields are evaluated in the order in which they stand here, which is that of the arrays.
        Ok(Grid {
            tables: GridTables {
                index_base: 0,
                center: LonLat::of(&[], arrays.read()?),
                corner: LonLat::of(arrays.read()?, arrays.read()?),
                cell_corner: Indices::I32(arrays.read()?),
                cell_corner_row: numbers[2] as usize,
                cell_corner_count: None,
                corner_cell: EMPTY,
                corner_edge: EMPTY,
                edge_corner: EMPTY,
            },
            counts: [numbers[0] as usize, numbers[1] as usize],
            direction: arrays.read()?.into(),
            half_edges: arrays.read()?.into(),
            start: numbers[3] as u32,
            cell_number: arrays.read()?,
            number_base: numbers[6] as i64,
            lowest_facet: lowest_facet.into(),
            longest_side: longest_side.into(),
            macrocells: OnceLock::new(),
            shared_macrocells: Some(Macrocells::of_arrays(lowest_facet, arrays.read()?.into(), arrays.read()?.into())),
            table_hashes: OnceLock::new(),
            life: Arc::default(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OwnedTables;
    use std::f64::consts::PI;

    /// A region, whose mesh is closed by void triangles: all that a ray reads is that of the grid itself.
    #[test]
    fn a_grid_in_a_block_is_the_grid() {
        let points = |scale: f64| (0..400).map(move |i| scale * f64::from(i % 20) + 1e-3 * f64::from(i * i % 7));
        let (lon, lat): (Vec<f64>, Vec<f64>) =
            (points(0.02).collect(), (0..400).map(|i| 0.02 * f64::from(i / 20)).collect());
        let tables = OwnedTables::of_points(LonLat::of(&lon, &lat)).unwrap();
        let owned = OwnedGrid::new(tables).unwrap();
        let bytes = owned.with_arrays(|arrays| block::length(&arrays));
        let mut words = vec![0u64; bytes.div_ceil(8)];
        let memory: &mut [u8] = bytemuck::cast_slice_mut(&mut words);
        let put = |at: usize, bytes: &[u8]| memory[at..at + bytes.len()].copy_from_slice(bytes);
        owned.with_arrays(|arrays| block::write(&arrays, put));
        let (whole, read) = (owned.grid(), Grid::of_block(bytemuck::cast_slice(&words)).unwrap());
        assert!(read.void_triangles() > 0 && read.longest_side() < PI / 50.0);
        assert_eq!(read.half_edges(), whole.half_edges());
        assert_eq!(read.macrocells().arrays(), whole.macrocells().arrays());
        assert_eq!(read.macrocells().map, whole.macrocells().map);
        assert_eq!(read.directions(), whole.directions());
        let [here, there] = [&read, whole].map(|grid| grid.tables());
        assert_eq!(here.center.lat_rad.get(7), there.center.lat_rad.get(7));
        assert_eq!(here.corner.lon_rad.get(7), there.corner.lon_rad.get(7));
        assert_eq!([read.cells(), read.triangles()], [whole.cells(), whole.triangles()]);
        assert_eq!(read.void_triangles(), whole.void_triangles());
        assert_eq!((read.lowest_facet(), read.longest_side()), (whole.lowest_facet(), whole.longest_side()));
        assert_eq!((read.derived_bytes(), read.describe_holes()), (whole.derived_bytes(), whole.describe_holes()));
        for cell in 0..whole.cells() as u32 {
            assert!(read.triangles_around(cell).eq(whole.triangles_around(cell)) && read.fans(cell).count() > 0);
        }
        assert!(Grid::of_block(bytemuck::cast_slice(&words[..40])).is_err());
    }
}
