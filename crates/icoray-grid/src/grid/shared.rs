//! A grid in one block of bytes, in memory that the ranks of a node share: one rank makes and writes it, all read it in
//! place.

use super::hole_filling::HoleFilling;
use super::{Grid, GridTables, Indices, LonLat, OwnedGrid};
use crate::block;
use crate::error::Result;
use crate::macrocells::Macrocells;
use bytemuck::Pod;
use std::sync::{Arc, OnceLock};

/// A table that the block does not have.
const EMPTY: Indices<'static> = Indices::I32(&[]);

impl OwnedGrid {
    /// Calls `write` with the arrays of a block that [`Grid::of_block`] reads: the tables, but for those of edges, in whose
    /// place the neighbours of triangles are, and all that derives from them, half-edges and macrocells included, which
    /// are made for it.
    ///
    /// # Errors
    /// [`ErrorKind::Memory`](crate::ErrorKind::Memory) if the half-edges do not fit.
    pub fn with_arrays<R>(&self, write: impl FnOnce(&[&[u8]]) -> R) -> Result<R> {
        let (grid, tables) = (self.grid(), self.tables());
        grid.make_half_edges()?;
        let of = &tables.connectivity;
        let numbers = [
            u64::from(grid.start),
            of.cell_corner_row as u64,
            grid.lowest_facet().to_bits(),
            grid.longest_side().to_bits(),
        ];
        let [of_triangle, triangle_in] = grid.macrocells().arrays();
        let arrays = [
            bytemuck::cast_slice(&numbers),
            bytemuck::cast_slice(&tables.center[0]),
            bytemuck::cast_slice(&tables.center[1]),
            bytemuck::cast_slice(&tables.corner[0]),
            bytemuck::cast_slice(&tables.corner[1]),
            bytemuck::cast_slice(&of.cell_corner),
            bytemuck::cast_slice(&of.cell_corner_count),
            bytemuck::cast_slice(&tables.corner_cell),
            bytemuck::cast_slice(&grid.direction),
            bytemuck::cast_slice(&grid.orientations),
            bytemuck::cast_slice(&grid.beyond),
            bytemuck::cast_slice(&grid.hole_filling.void),
            bytemuck::cast_slice(&grid.hole_filling.rim),
            bytemuck::cast_slice(&tables.cell_number),
            bytemuck::cast_slice(grid.half_edges()),
            bytemuck::cast_slice(of_triangle),
            bytemuck::cast_slice(triangle_in),
        ];
        Ok(write(&arrays))
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
    /// The grid of a block that [`OwnedGrid::with_arrays`] wrote, read in place. Its tables of edges are empty.
    ///
    /// # Errors
    /// [`ErrorKind::Internal`](crate::ErrorKind::Internal) if arrays are missing.
    pub fn of_block(block: &'a [u8]) -> Result<Self> {
        let mut arrays = Arrays { block, next: 0 };
        let numbers: &[u64] = arrays.read()?;
        let [lowest_facet, longest_side] = [numbers[2], numbers[3]].map(f64::from_bits);
        // Fields are evaluated in the order in which they stand here, which is that of the arrays.
        Ok(Grid {
            tables: GridTables {
                index_base: 0,
                center: LonLat::of(arrays.read()?, arrays.read()?),
                corner: LonLat::of(arrays.read()?, arrays.read()?),
                cell_corner: Indices::I32(arrays.read()?),
                cell_corner_row: numbers[1] as usize,
                cell_corner_count: Some(Indices::I32(arrays.read()?)),
                corner_cell: Indices::I32(arrays.read()?),
                corner_edge: EMPTY,
                edge_corner: EMPTY,
            },
            direction: arrays.read()?.into(),
            orientations: arrays.read()?.into(),
            beyond: arrays.read()?.into(),
            hole_filling: HoleFilling { void: arrays.read()?.into(), rim: arrays.read()?.into() },
            start: numbers[0] as u32,
            cell_number: arrays.read()?,
            lowest_facet: lowest_facet.into(),
            longest_side: longest_side.into(),
            half_edges: OnceLock::new(),
            macrocells: OnceLock::new(),
            shared: Some((
                arrays.read()?,
                Macrocells::of_arrays(lowest_facet, arrays.read()?.into(), arrays.read()?.into()),
            )),
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
        let bytes = owned.with_arrays(block::length).unwrap();
        let mut words = vec![0u64; bytes.div_ceil(8)];
        let memory: &mut [u8] = bytemuck::cast_slice_mut(&mut words);
        let put = |at: usize, bytes: &[u8]| memory[at..at + bytes.len()].copy_from_slice(bytes);
        owned.with_arrays(|arrays| block::write(arrays, put)).unwrap();
        let (whole, read) = (owned.grid(), Grid::of_block(bytemuck::cast_slice(&words)).unwrap());
        assert!(read.void_triangles() > 0 && read.longest_side() < PI / 50.0);
        let has = |hash: &&(&str, u64)| !["corner_edge", "edge_corner"].contains(&hash.0);
        assert!(read.table_hashes().iter().filter(has).eq(whole.table_hashes().iter().filter(has)));
        assert_eq!(read.half_edges(), whole.half_edges());
        assert_eq!(read.macrocells().arrays(), whole.macrocells().arrays());
        assert_eq!(read.macrocells().map, whole.macrocells().map);
        assert_eq!((read.directions(), read.orientations()), (whole.directions(), whole.orientations()));
        assert_eq!(read.void_triangles(), whole.void_triangles());
        assert_eq!((read.lowest_facet(), read.longest_side()), (whole.lowest_facet(), whole.longest_side()));
        assert_eq!((read.derived_bytes(), read.half_edge_bytes()), (whole.derived_bytes(), whole.half_edge_bytes()));
        for triangle in 0..(whole.triangles() + whole.void_triangles()) as u32 {
            assert_eq!(read.triangle(triangle), whole.triangle(triangle));
            assert!((0..3).all(|k| read.across(triangle, k) == whole.across(triangle, k)));
        }
        assert!(Grid::of_block(bytemuck::cast_slice(&words[..40])).is_err());
    }
}
