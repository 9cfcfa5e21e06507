//! A grid in one block of bytes, in memory that the ranks of a node share: one rank makes and writes it, all read it in
//! place.

use super::hole_filling::HoleFilling;
use super::{Grid, GridTables, Indices, LonLat, OwnedGrid};
use crate::block;
use crate::error::Result;
use crate::macrocells::Macrocells;
use std::sync::{Arc, OnceLock};

/// Arrays of a block, by their numbers there.
mod array {
    pub const NUMBERS: usize = 0;
    pub const CENTER_LON: usize = 1;
    pub const CENTER_LAT: usize = 2;
    pub const CORNER_LON: usize = 3;
    pub const CORNER_LAT: usize = 4;
    pub const CORNER_CELL: usize = 5;
    pub const CELL_CORNER: usize = 6;
    pub const CELL_CORNER_COUNT: usize = 7;
    pub const CELL_NUMBER: usize = 8;
    pub const DIRECTION: usize = 9;
    pub const ORIENTATION: usize = 10;
    pub const BEYOND: usize = 11;
    pub const VOID: usize = 12;
    pub const RIM: usize = 13;
    pub const HALF_EDGE: usize = 14;
    pub const MACROCELLS: [usize; 2] = [15, 16];
    pub const COUNT: usize = 17;
}

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
        let mut arrays: [&[u8]; array::COUNT] = [&[]; array::COUNT];
        arrays[array::NUMBERS] = bytemuck::cast_slice(&numbers);
        arrays[array::CENTER_LON] = bytemuck::cast_slice(&tables.center[0]);
        arrays[array::CENTER_LAT] = bytemuck::cast_slice(&tables.center[1]);
        arrays[array::CORNER_LON] = bytemuck::cast_slice(&tables.corner[0]);
        arrays[array::CORNER_LAT] = bytemuck::cast_slice(&tables.corner[1]);
        arrays[array::CORNER_CELL] = bytemuck::cast_slice(&tables.corner_cell);
        arrays[array::CELL_CORNER] = bytemuck::cast_slice(&of.cell_corner);
        arrays[array::CELL_CORNER_COUNT] = bytemuck::cast_slice(&of.cell_corner_count);
        arrays[array::CELL_NUMBER] = bytemuck::cast_slice(&tables.cell_number);
        arrays[array::DIRECTION] = bytemuck::cast_slice(&grid.direction);
        arrays[array::ORIENTATION] = bytemuck::cast_slice(&grid.orientations);
        arrays[array::BEYOND] = bytemuck::cast_slice(&grid.beyond);
        arrays[array::VOID] = bytemuck::cast_slice(&grid.hole_filling.void);
        arrays[array::RIM] = bytemuck::cast_slice(&grid.hole_filling.rim);
        arrays[array::HALF_EDGE] = bytemuck::cast_slice(grid.half_edges());
        for (number, of) in array::MACROCELLS.into_iter().zip(grid.macrocells().arrays()) {
            arrays[number] = bytemuck::cast_slice(of);
        }
        Ok(write(&arrays))
    }
}

impl<'a> Grid<'a> {
    /// The grid of a block that [`OwnedGrid::with_arrays`] wrote, read in place. Its tables of edges are empty.
    ///
    /// # Errors
    /// [`ErrorKind::Internal`](crate::ErrorKind::Internal) if arrays are missing.
    pub fn of_block(block: &'a [u8]) -> Result<Self> {
        let indices = |number: usize| block::array::<i32>(block, number);
        let angles = |number: usize| block::array::<f64>(block, number);
        let numbers: &[u64] = block::array(block, array::NUMBERS)?;
        let [start, cell_corner_row, lowest_facet, longest_side] = [0, 1, 2, 3].map(|k| numbers[k]);
        let [lowest_facet, longest_side] = [lowest_facet, longest_side].map(f64::from_bits);
        let [of_triangle, triangle_in] = array::MACROCELLS.map(|number| block::array::<u32>(block, number));
        let macrocells = Macrocells::of_arrays(lowest_facet, of_triangle?.into(), triangle_in?.into());
        let hole_filling = HoleFilling {
            void: block::array(block, array::VOID)?.into(),
            rim: block::array(block, array::RIM)?.into(),
        };
        Ok(Grid {
            tables: GridTables {
                index_base: 0,
                center: LonLat::of(angles(array::CENTER_LON)?, angles(array::CENTER_LAT)?),
                corner: LonLat::of(angles(array::CORNER_LON)?, angles(array::CORNER_LAT)?),
                cell_corner: indices(array::CELL_CORNER)?.into(),
                cell_corner_row: cell_corner_row as usize,
                cell_corner_count: Some(indices(array::CELL_CORNER_COUNT)?.into()),
                corner_cell: indices(array::CORNER_CELL)?.into(),
                corner_edge: EMPTY,
                edge_corner: EMPTY,
            },
            direction: block::array(block, array::DIRECTION)?.into(),
            orientations: block::array(block, array::ORIENTATION)?.into(),
            beyond: block::array(block, array::BEYOND)?.into(),
            hole_filling,
            start: start as u32,
            cell_number: block::array(block, array::CELL_NUMBER)?,
            lowest_facet: lowest_facet.into(),
            longest_side: longest_side.into(),
            half_edges: OnceLock::new(),
            macrocells: OnceLock::new(),
            shared: Some((block::array(block, array::HALF_EDGE)?, macrocells)),
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
