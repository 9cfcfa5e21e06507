//! Traces pixels over the thread pool, in tiles of a raster, which may have only each k-th pixel and is then filled in.

use icoray_grid::array::MapInline;
use icoray_kernel::Counts;
use icoray_kernel::signature::BoundarySignature;
use rayon::prelude::*;
use std::time::Instant;

/// Maximum side of a tile in traced pixels: small enough that 64 threads have about equal work in a picture of 512 x
/// 512.
const TILE: u32 = 16;

/// A pixel and its error bound.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Pixel {
    pub color: [f32; 4],
    pub error: f32,
    /// The surfaces that its ray met, if the scene has several.
    pub surfaces: BoundarySignature,
}

/// A point of the picture through which a ray is traced.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SamplePoint {
    /// Pixels to the right and downwards from the picture's upper left corner.
    pub at: [f64; 2],
    /// Whether it is the first of its row in a tile.
    pub begins_row: bool,
}

impl SamplePoint {
    /// The middle of a pixel.
    pub fn middle(x: u32, y: u32, begins_row: bool) -> Self {
        SamplePoint { at: [x, y].map_inline(|at| f64::from(at) + 0.5), begins_row }
    }
}

/// Rays in tiles, numbered from 0: equal for all devices, threads and ranks.
pub(crate) trait Tiling: Sync {
    fn tiles(&self) -> u32;

    fn pixels_of(&self, tile: u32) -> usize;

    fn rays_per_pixel(&self) -> usize;

    /// Calls `emit` with the sample points of a tile, pixel by pixel.
    fn sample_points(&self, tile: u32, emit: &mut dyn FnMut(SamplePoint));

    /// A tile's pixels, computed from the results of its rays.
    fn resolve(&self, rays: Vec<Pixel>) -> Vec<Pixel>;

    /// The raster of these tiles, if they are a raster's.
    fn raster(&self) -> Option<Raster>;
}

/// Traces tiles, dealt to threads one by one, when the iterator is run: `draw` returns the results of rays at a tile's
/// sample points.
///
/// Tiles are left untraced once `is_stopped` is true. Each tile starts its own search: pictures depend on no thread or
/// rank.
pub(crate) fn trace<'a>(
    tiling: &'a dyn Tiling,
    tiles: &'a [u32],
    is_stopped: impl Fn() -> bool + Sync + Send + 'a,
    draw: impl Fn(&[SamplePoint], &mut Counts) -> Vec<Pixel> + Sync + Send + 'a,
) -> impl ParallelIterator<Item = Tile> + 'a {
    let trace = move |number: &u32| {
        if is_stopped() {
            return Tile::untraced(tiling, *number);
        }
        let start = Instant::now();
        let mut counts = Counts::default();
        let rays = draw(&sample_points(tiling, *number), &mut counts);
        Tile::resolved(tiling, *number, rays, start, counts)
    };
    tiles.par_iter().with_max_len(1).map(trace)
}

/// The sample points of a tile, pixel by pixel.
pub(crate) fn sample_points(tiling: &dyn Tiling, tile: u32) -> Vec<SamplePoint> {
    let mut places = Vec::with_capacity(tiling.pixels_of(tile) * tiling.rays_per_pixel());
    tiling.sample_points(tile, &mut |place| places.push(place));
    places
}

/// A rectangle of traced pixels.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tile {
    /// Its index among the raster's tiles.
    pub number: u32,
    /// Seconds of tracing on one thread.
    pub seconds: f64,
    pub counts: Counts,
    /// Its pixels, row by row.
    pub pixels: Vec<Pixel>,
}

impl Tile {
    /// The tile of `tiling` with the results of its rays, whose tracing began at `start`.
    pub fn resolved(tiling: &dyn Tiling, number: u32, rays: Vec<Pixel>, start: Instant, counts: Counts) -> Self {
        Tile { number, seconds: start.elapsed().as_secs_f64(), counts, pixels: tiling.resolve(rays) }
    }

    /// A tile of an abandoned frame.
    fn untraced(tiling: &dyn Tiling, number: u32) -> Self {
        let pixels = vec![Pixel::default(); tiling.pixels_of(number)];
        Tile { number, seconds: 0.0, counts: Counts::default(), pixels }
    }
}

/// All tiles of `tiling`, which come in any order, by number, and the sum of their counts.
///
/// # Panics
/// If a tile is missing or occurs twice.
pub(crate) fn in_order<'t>(tiling: &dyn Tiling, tiles: &'t [Tile]) -> (Vec<&'t Tile>, Counts) {
    let mut found = vec![None; tiling.tiles() as usize];
    let mut counts = Counts::default();
    for tile in tiles {
        assert!(found[tile.number as usize].replace(tile).is_none(), "tile {} came twice", tile.number);
        counts += tile.counts;
    }
    (found.into_iter().map(|tile| tile.expect("a tile is missing")).collect(), counts)
}

/// The pixels of a picture that are traced: each `step`-th in both directions, and the last of each row and column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Raster {
    pub width: u32,
    pub height: u32,
    /// Distance between traced pixels.
    pub step: u32,
}

impl Raster {
    /// Traced columns and rows.
    fn nodes(&self) -> [u32; 2] {
        [self.width, self.height].map(|side| (side - 1).div_ceil(self.step) + 1)
    }

    /// Fraction of the picture's pixels that are traced.
    pub fn part(&self) -> f64 {
        let [across, down] = self.nodes().map(f64::from);
        across * down / (f64::from(self.width) * f64::from(self.height))
    }

    /// A tile's side in traced pixels. A coarse raster has enough tiles for all threads too.
    fn side(&self) -> u32 {
        let [across, down] = self.nodes();
        (across.max(down) / 8).clamp(2, TILE)
    }

    /// Tiles in a row.
    pub fn tiles_across(&self) -> u32 {
        self.nodes()[0].div_ceil(self.side())
    }

    /// A tile's traced pixels.
    pub fn rect(&self, tile: u32) -> Rect {
        let (side, tiles_across) = (self.side(), self.tiles_across());
        let [across, down] = self.nodes();
        let (left, top) = (tile % tiles_across * side, tile / tiles_across * side);
        Rect { left, top, width: side.min(across - left), height: side.min(down - top) }
    }

    /// The picture of all tiles, which are in any order, with the pixels between filled in: rows from the top. The
    /// error of a pixel between is an estimate ([`Self::is_traced`]).
    ///
    /// # Panics
    /// If a tile is missing or occurs twice.
    pub fn assemble(&self, tiles: &[Tile]) -> (Vec<Pixel>, Counts) {
        let [across, down] = self.nodes().map(|n| n as usize);
        let (tiles, counts) = in_order(self, tiles);
        // Pages of memory are much of the time, so that threads share their first use.
        let mut nodes: Vec<Pixel> = (0..across * down).into_par_iter().map(|_| Pixel::default()).collect();
        let side = self.side() as usize;
        let rows = tiles.par_chunks(self.tiles_across() as usize).zip(nodes.par_chunks_mut(across * side));
        rows.for_each(|(tiles, nodes)| {
            for (x0, tile) in (0..across).step_by(side).zip(tiles) {
                let lines = tile.pixels.chunks_exact(side.min(across - x0));
                for (line, nodes) in lines.zip(nodes.chunks_exact_mut(across)) {
                    nodes[x0..x0 + line.len()].copy_from_slice(line);
                }
            }
        });
        if self.step == 1 { (nodes, counts) } else { (self.fill(&nodes), counts) }
    }

    /// Traces all tiles and assembles the picture.
    #[cfg(test)]
    pub fn draw(&self, draw: impl Fn(&[SamplePoint], &mut Counts) -> Vec<Pixel> + Sync + Send) -> (Vec<Pixel>, Counts) {
        let all: Vec<u32> = (0..self.tiles()).collect();
        self.assemble(&trace(self, &all, || false, draw).collect::<Vec<_>>())
    }

    /// Whether the pixel with this number in the picture is traced.
    pub fn is_traced(&self, number: u32) -> bool {
        let is_node = |at: u32, side: u32| at.is_multiple_of(self.step) || at + 1 == side;
        is_node(number % self.width, self.width) && is_node(number / self.width, self.height)
    }

    /// All pixels, bilinear between traced ones. The error of a pixel between is estimated as the difference of a
    /// traced pixel around it from its neighbours on all sides, in addition to their own errors. The estimate misses
    /// details between traced pixels.
    fn fill(&self, nodes: &[Pixel]) -> Vec<Pixel> {
        let [across, down] = self.nodes().map(|n| n as usize);
        let range = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
        let spread = |node: usize| {
            let rows = range(node / across, down);
            let around =
                rows.flat_map(|row| range(node % across, across).map(move |column| &nodes[row * across + column]));
            let (error, low, high) =
                around.fold((0.0f32, [f32::MAX; 4], [f32::MIN; 4]), |(error, low, high), pixel| {
                    let color = pixel.color;
                    let bound =
                        |of: fn(f32, f32) -> f32, so_far: [f32; 4]| std::array::from_fn(|k| of(so_far[k], color[k]));
                    (error.max(pixel.error), bound(f32::min, low), bound(f32::max, high))
                });
            error + (0..4).fold(0.0, |most, k| f32::max(most, high[k] - low[k]))
        };
        let spread: Vec<f32> = (0..nodes.len()).into_par_iter().map(spread).collect();
        let step = self.step as usize;
        let (width, height) = (self.width as usize, self.height as usize);
        // The traced pixels before and behind a pixel, and its position between them.
        let between = |at: usize, side: usize| {
            let node = at / step;
            let (low, high) = (node * step, (node * step + step).min(side - 1));
            match (at - low, high - low) {
                (0, _) => (node, node, 0.0),
                (past, whole) if past == whole => (node + 1, node + 1, 0.0),
                (past, whole) => (node, node + 1, past as f32 / whole as f32),
            }
        };
        let mut picture = vec![Pixel::default(); width * height];
        picture.par_chunks_exact_mut(width).enumerate().for_each(|(y, row)| {
            let (up, down, v) = between(y, height);
            for (x, pixel) in row.iter_mut().enumerate() {
                let (left, right, u) = between(x, width);
                let around = [(up, left), (up, right), (down, left), (down, right)].map(|(y, x)| y * across + x);
                *pixel = nodes[around[0]];
                if around[0] != around[3] {
                    pixel.color = mean(&around.map(|node| nodes[node].color), u, v);
                    pixel.error = around.iter().fold(0.0, |most, node| most.max(spread[*node]));
                }
            }
        });
        picture
    }
}

/// A rectangle of traced pixels: from the first to before the last in each direction, counted in steps of
/// [`Quality::pixel_step`](icoray_scene::Quality::pixel_step) pixels. The last one of a picture's row or column may
/// come after a shorter step: node `i` of a side is its pixel `min(i · step, side - 1)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rect {
    /// First column.
    pub left: u32,
    /// First row.
    pub top: u32,
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

impl Rect {
    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }
}

impl Tiling for Raster {
    fn tiles(&self) -> u32 {
        self.tiles_across() * self.nodes()[1].div_ceil(self.side())
    }

    fn pixels_of(&self, tile: u32) -> usize {
        self.rect(tile).pixels()
    }

    fn rays_per_pixel(&self) -> usize {
        1
    }

    fn sample_points(&self, tile: u32, emit: &mut dyn FnMut(SamplePoint)) {
        let pixel = |node: u32, side: u32| (node * self.step).min(side - 1);
        let Rect { left, top, width, height } = self.rect(tile);
        for y in top..top + height {
            for x in left..left + width {
                emit(SamplePoint::middle(pixel(x, self.width), pixel(y, self.height), x == left));
            }
        }
    }

    fn resolve(&self, rays: Vec<Pixel>) -> Vec<Pixel> {
        rays
    }

    fn raster(&self) -> Option<Raster> {
        Some(*self)
    }
}

/// The bilinear mean of four colours; exact if all four are equal.
fn mean(around: &[[f32; 4]; 4], u: f32, v: f32) -> [f32; 4] {
    let between = |a: f32, b: f32, at: f32| a + (b - a) * at;
    let [up_left, up_right, down_left, down_right] = around;
    std::array::from_fn(|k| {
        let [up, down] = [(up_left, up_right), (down_left, down_right)].map(|(a, b)| between(a[k], b[k], u));
        between(up, down, v)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture that is bilinear in x and y, so that filling it in is exact.
    fn pixels(places: &[SamplePoint], counts: &mut Counts) -> Vec<Pixel> {
        counts.rays += places.len() as u64;
        let pixel = |p: &SamplePoint| {
            let [x, y] = p.at.map(|at| (at - 0.5) as f32);
            Pixel { color: [x, y, 2.0, 0.5], error: 0.25, ..Pixel::default() }
        };
        places.iter().map(pixel).collect()
    }

    #[test]
    fn every_pixel_is_traced_once_and_lies_where_it_belongs() {
        for (width, height) in [(1, 1), (33, 7), (64, 32), (100, 65)] {
            let (picture, counts) = Raster { width, height, step: 1 }.draw(pixels);
            assert_eq!((picture.len(), counts.rays), ((width * height) as usize, u64::from(width * height)));
            for (i, p) in (0u32..).zip(&picture) {
                assert_eq!(p.color[..2], [(i % width) as f32, (i / width) as f32]);
            }
        }
    }

    #[test]
    fn pixels_between_traced_ones_are_their_bilinear_mean() {
        for (width, height, step) in [(1, 1, 4), (9, 9, 4), (10, 3, 4), (70, 41, 3), (5, 200, 16)] {
            let raster = Raster { width, height, step };
            let (picture, counts) = raster.draw(pixels);
            assert!((raster.part() * f64::from(width * height) - counts.rays as f64).abs() < 1e-6);
            for (i, p) in (0u32..).zip(&picture) {
                let exact = [(i % width) as f32, (i / width) as f32, 2.0, 0.5];
                assert!(p.color.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-4), "{i} of {raster:?}: {p:?}");
                assert!(p.error >= 0.25 && p.error <= 0.25 + 2.0 * step as f32);
                assert!((p.error == 0.25) == (raster.is_traced(i) || width == 1), "{i} of {raster:?}: {}", p.error);
            }
        }
    }

    #[test]
    fn tiles_that_several_draw_make_the_same_picture() {
        for (width, height, step) in [(1, 1, 1), (97, 61, 1), (300, 200, 3), (64, 500, 7)] {
            let raster = Raster { width, height, step };
            let (whole, counts) = raster.draw(pixels);
            let of = |rank: u32| (0..raster.tiles()).rev().filter(|tile| tile % 3 == rank).collect::<Vec<_>>();
            let parts = [2, 0, 1].map(|rank| trace(&raster, &of(rank), || false, pixels).collect::<Vec<_>>());
            let tiles = parts.concat();
            assert!(tiles.iter().all(|tile| tile.pixels.len() == raster.pixels_of(tile.number)));
            assert_eq!(raster.assemble(&tiles), (whole, counts));
        }
    }

    #[test]
    #[should_panic(expected = "a tile is missing")]
    fn a_picture_with_a_tile_missing_is_none() {
        let raster = Raster { width: 97, height: 61, step: 1 };
        raster.assemble(&trace(&raster, &[0, 1], || false, pixels).collect::<Vec<_>>());
    }
}
