//! Pixels at any places of a picture, which are traced again with several rays each, in tiles of their list.

use crate::edges::{self, weighted_mean};
use crate::raster::{Pixel, Raster, SamplePoint, Tile, Tiling, in_order};
use crate::sampling::Pattern;
use icoray_kernel::Counts;
use std::ops::Range;

/// Approximate number of rays of a tile: as many as one of a raster.
const TILE_RAYS: usize = 256;

/// The rays of a pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum PixelRays {
    /// Those of a pixel with the edge of a surface in it.
    Edge,
    /// Some of its samples.
    Samples(Range<u32>),
}

impl PixelRays {
    fn count(&self) -> usize {
        match self {
            PixelRays::Edge => edges::RAYS,
            PixelRays::Samples(samples) => samples.len(),
        }
    }

    /// Their places to the right of and below the middle of the pixel in this column and row, in pixels.
    fn places(&self, pixel: [u32; 2]) -> Vec<[f64; 2]> {
        match self {
            PixelRays::Edge => edges::PATTERN.map(|place| place.map(|sixteenths| f64::from(sixteenths) / 16.0)).into(),
            PixelRays::Samples(samples) => {
                let pattern = Pattern::of(pixel);
                samples.clone().map(|sample| pattern.place(sample)).collect()
            }
        }
    }
}

/// Some pixels of a picture, each of which shows the mean of its rays.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ScatteredPixels {
    /// Width of the picture.
    width: u32,
    /// Their numbers in the picture, rising.
    numbers: Vec<u32>,
    rays: PixelRays,
}

impl ScatteredPixels {
    /// The pixels with these numbers, in rising order, in the picture of a raster.
    pub fn new(raster: Raster, numbers: Vec<u32>, rays: PixelRays) -> Self {
        ScatteredPixels { width: raster.width, numbers, rays }
    }

    pub fn numbers(&self) -> &[u32] {
        &self.numbers
    }

    fn of_tile(&self, tile: u32) -> &[u32] {
        let per_tile = TILE_RAYS.div_ceil(self.rays.count());
        let start = tile as usize * per_tile;
        &self.numbers[start..(start + per_tile).min(self.numbers.len())]
    }

    /// The pixels of all tiles in order, and the sum of their rays' counts.
    ///
    /// # Panics
    /// If a tile is missing or occurs twice.
    pub fn in_order<'t>(&self, tiles: &'t [Tile]) -> (Vec<&'t Pixel>, Counts) {
        let (tiles, counts) = in_order(self, tiles);
        (tiles.into_iter().flat_map(|tile| &tile.pixels).collect(), counts)
    }
}

impl Tiling for ScatteredPixels {
    fn tiles(&self) -> u32 {
        self.numbers.len().div_ceil(TILE_RAYS.div_ceil(self.rays.count())) as u32
    }

    fn pixels_of(&self, tile: u32) -> usize {
        self.of_tile(tile).len()
    }

    fn rays_per_pixel(&self) -> usize {
        self.rays.count()
    }

    /// The first ray of each pixel begins a row.
    fn sample_points(&self, tile: u32, emit: &mut dyn FnMut(SamplePoint)) {
        for number in self.of_tile(tile) {
            let [x, y] = [number % self.width, number / self.width];
            let middle = SamplePoint::middle(x, y, true);
            for (number, place) in self.rays.places([x, y]).into_iter().enumerate() {
                let at = [0, 1].map(|axis| middle.at[axis] + place[axis]);
                emit(SamplePoint { at, begins_row: number == 0 });
            }
        }
    }

    fn resolve(&self, rays: Vec<Pixel>) -> Vec<Pixel> {
        let mean = |rays: &[Pixel]| weighted_mean(rays.iter().map(|ray| (ray, 1.0)));
        rays.chunks_exact(self.rays.count()).map(mean).collect()
    }

    fn raster(&self) -> Option<Raster> {
        None
    }
}
