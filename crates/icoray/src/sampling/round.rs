//! A round of samples: more rays for some pixels.

use super::pattern::Pattern;
use crate::edges::mean;
use crate::raster::{Pixel, Raster, SamplePoint, Tiling};
use crate::scattered::ScatteredPixels;
use std::ops::Range;

/// Approximate number of rays of a tile: as many as one of a raster.
const TILE_RAYS: usize = 256;

/// Some of the samples of some pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct SampleRound {
    pub pixels: ScatteredPixels,
    /// The samples of each pixel.
    pub samples: Range<u32>,
}

impl SampleRound {
    /// These samples of the pixels with these numbers in the picture of a raster.
    pub fn new(raster: Raster, numbers: Vec<u32>, samples: Range<u32>) -> Self {
        let per_tile = TILE_RAYS.div_ceil(samples.len());
        SampleRound { pixels: ScatteredPixels::new(raster.width, numbers, per_tile), samples }
    }
}

impl Tiling for SampleRound {
    fn tiles(&self) -> u32 {
        self.pixels.tiles()
    }

    fn pixels_of(&self, tile: u32) -> usize {
        self.pixels.of_tile(tile).len()
    }

    fn rays_per_pixel(&self) -> usize {
        self.samples.len()
    }

    fn sample_points(&self, tile: u32, emit: &mut dyn FnMut(SamplePoint)) {
        for number in self.pixels.of_tile(tile) {
            let place = self.pixels.place(*number);
            let pattern = Pattern::of(place);
            ScatteredPixels::emit(self.samples.clone().map(|sample| pattern.place(sample)), place, emit);
        }
    }

    fn resolve(&self, rays: Vec<Pixel>) -> Vec<Pixel> {
        rays.chunks_exact(self.samples.len()).map(mean).collect()
    }

    fn raster(&self) -> Option<Raster> {
        None
    }
}
