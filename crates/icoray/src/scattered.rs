//! Pixels at any places of a picture, which are traced again in tiles of their list.

use crate::raster::{SamplePoint, Tile};
use icoray_kernel::Counts;

/// Some pixels of a picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ScatteredPixels {
    /// Width of the picture.
    width: u32,
    /// Their numbers in the picture, rising.
    numbers: Vec<u32>,
    /// Number of pixels of a tile.
    per_tile: usize,
}

impl ScatteredPixels {
    /// The pixels with these numbers, in rising order, of a picture `width` pixels wide.
    pub fn new(width: u32, numbers: Vec<u32>, per_tile: usize) -> Self {
        ScatteredPixels { width, numbers, per_tile }
    }

    /// Their numbers in the picture, rising.
    pub fn numbers(&self) -> &[u32] {
        &self.numbers
    }

    /// Number of tiles.
    pub fn tiles(&self) -> u32 {
        self.numbers.len().div_ceil(self.per_tile) as u32
    }

    /// The pixels of a tile.
    pub fn of_tile(&self, tile: u32) -> &[u32] {
        let start = tile as usize * self.per_tile;
        &self.numbers[start..(start + self.per_tile).min(self.numbers.len())]
    }

    /// Column and row of a pixel.
    pub fn place(&self, number: u32) -> [u32; 2] {
        [number % self.width, number / self.width]
    }

    /// Emits the sample points of a pixel, the first of which begins a row.
    pub fn emit(offsets: impl Iterator<Item = [f64; 2]>, [x, y]: [u32; 2], emit: &mut dyn FnMut(SamplePoint)) {
        let middle = SamplePoint::middle(x, y, true);
        for (number, offset) in offsets.enumerate() {
            let at = [0, 1].map(|axis| middle.at[axis] + offset[axis]);
            emit(SamplePoint { at, begins_row: number == 0 });
        }
    }

    /// The tiles in order, and the sum of their rays' counts.
    ///
    /// # Panics
    /// If a tile is missing or occurs twice.
    pub fn in_order<'t>(&self, tiles: &'t [Tile]) -> (Vec<&'t Tile>, Counts) {
        let mut found = vec![None; self.tiles() as usize];
        let mut counts = Counts::default();
        for tile in tiles {
            counts += tile.counts;
            let before = found[tile.number as usize].replace(tile);
            assert!(before.is_none(), "tile {} came twice", tile.number);
        }
        let found = found.into_iter().map(|tile| tile.expect("a tile is missing"));
        (found.collect(), counts)
    }
}
