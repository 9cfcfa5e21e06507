//! The visible blocks of a frame's volumes and isosurfaces: found by a rank alone and kept between frames, or by the
//! ranks of a node together, in memory that they share.

use super::node_work::NodeWork;
use super::scene_builder::SceneBuilder;
use crate::plan::{Blocks, MAX_CLEAR, OccupancyTest, SeenBlocks, clear_values};
use crate::ranks::{NodeMemory, PutBytes, Ranks};
use crate::render::context::FrameContext;
use crate::render::frame_cache::OccupancyKey;
use icoray_grid::gradient::PreparedSample;
use icoray_grid::occupancy::OccupancyMask;
use icoray_grid::samples::Samples;
use icoray_grid::{Reals, Result};
use icoray_kernel::general::{Isosurface, Medium};
use icoray_kernel::transfer::{KernelKnot, Spans};
use rayon::prelude::*;
use std::ops::Range;

/// A field that is visible where a transfer function of these knots is not clear.
pub(super) struct SeenField {
    source: usize,
    knots: Vec<KernelKnot>,
}

impl<'f> SceneBuilder<'_, 'f> {
    /// Occupancy of each volume and isosurface, with its key; without a key, all or nothing.
    pub(super) fn visible(
        &self,
        media: &[Medium],
        isosurfaces: &[Isosurface],
    ) -> (Vec<OccupancyKey>, Vec<OccupancyMask<'f>>) {
        let FrameContext { plan, grid, deviations, cache, .. } = *self.context;
        let layers = plan.radius.len();
        if let Some(deviations) = deviations {
            let leaps = self.leaps();
            let source = self.context.fields[0].source(grid);
            let key = OccupancyKey { source, falling: plan.falling, clear: Vec::new(), leaps };
            let visible = cache.visible.take(&key).unwrap_or_else(|_| {
                let visible = deviations.visible(grid, layers);
                if leaps { visible.with_macrocells(grid, layers) } else { visible }
            });
            return (vec![key], vec![visible]);
        }
        if !self.savings.empty_space {
            return (Vec::new(), vec![OccupancyMask::default().full(layers)]);
        }
        let seen = self.seen_fields(media, isosurfaces);
        if seen.is_empty() {
            return (Vec::new(), vec![OccupancyMask::none(grid.triangles(), layers)]);
        }
        let blocks = self.blocks(seen.len());
        let all =
            seen.iter().enumerate().map(|(number, seen)| match self.context.fields[seen.source].field().samples() {
                Reals::F32(data) => self.visible_of(&self.occupancy_test(data, seen, blocks), seen, number),
                Reals::F64(data) => self.visible_of(&self.occupancy_test(data, seen, blocks), seen, number),
            });
        all.unzip()
    }

    fn visible_of<S: PreparedSample>(
        &self,
        test: &OccupancyTest<S>,
        seen: &SeenField,
        number: usize,
    ) -> (OccupancyKey, OccupancyMask<'f>) {
        let FrameContext { plan, grid, cache, .. } = *self.context;
        let source = self.context.fields[seen.source].source(grid);
        let clear = test.clear.iter().map(|range| range.map(|value| value.wide().to_bits())).collect();
        let key = OccupancyKey { source, falling: plan.falling, clear, leaps: test.blocks.leaps };
        let visible = match self.node_occupancy {
            Some(shared) => shared.mask(number, test.blocks),
            None => cache.visible.take(&key).unwrap_or_else(|memory| test.visible(memory.unwrap_or_default())),
        };
        (key, visible)
    }

    /// What is seen: volumes, then isosurfaces.
    fn seen_fields(&self, media: &[Medium], isosurfaces: &[Isosurface]) -> Vec<SeenField> {
        let of_media = media.iter().map(|medium| {
            let knots = medium.extinction.knots().to_vec();
            SeenField { source: medium.extinction.source, knots }
        });
        let of_surfaces = isosurfaces.iter().map(|surface| {
            let knots = spike(surface.value, self.range(surface.source).unwrap_or([0.0; 2]));
            SeenField { source: surface.source, knots }
        });
        of_media.chain(of_surfaces).collect()
    }

    /// The blocks in which this number of fields is seen. Macrocells of several masks are those of the joined one.
    fn blocks(&self, fields: usize) -> Blocks<'f> {
        let FrameContext { plan, grid, .. } = *self.context;
        Blocks { grid, layers: plan.radius.len(), leaps: self.leaps() && fields == 1 }
    }

    fn occupancy_test<'d, S: PreparedSample>(
        &self,
        data: &'d [S],
        seen: &SeenField,
        blocks: Blocks<'d>,
    ) -> OccupancyTest<'d, S> {
        let (range, whole) = (self.range(seen.source), Spans::<f64>::new(&seen.knots));
        let field = self.context.fields[seen.source].field();
        let samples = Samples::new(data, &field, self.context.plan.falling, whole.range());
        // Values that equal a knot in the precision of the rays.
        let clear = match self.vectors() {
            Some(_) => clear_values(&Spans::<f32>::new(&seen.knots), &samples, range),
            None => clear_values(&whole, &samples, range),
        };
        OccupancyTest { blocks, samples, clear }
    }
}

/// A transfer function that is clear except near `value`, for a field of this range.
fn spike(value: f64, [low, high]: [f64; 2]) -> Vec<KernelKnot> {
    let near = if high > low { 1e-6 * (high - low) } else { value.abs().max(1.0) };
    let knot = |value: f64, extinction: f64| KernelKnot { value, color: [0.0; 3], extinction };
    vec![knot(value - near, 0.0), knot(value, 1.0), knot(value + near, 0.0)]
}

/// Visible blocks in memory that the ranks of a node share.
pub(super) struct NodeOccupancy {
    /// For each field that is seen a word per triangle.
    memory: NodeMemory,
    triangles: usize,
    /// For each of them the number of its visible blocks; `None` if all are.
    seen: Vec<Option<SeenBlocks>>,
}

impl NodeOccupancy {
    /// Finds the visible blocks of the frame of `builder`, each rank those of its turns; `None` if it needs none or a
    /// node has no memory to share. Collective.
    pub fn find(builder: &SceneBuilder, node: NodeWork, ranks: &mut Ranks) -> Result<Option<Self>> {
        let FrameContext { renderer, grid, fields, .. } = *builder.context;
        let mut parts = builder.clone();
        let (media, isosurfaces) = (parts.media(), parts.isosurfaces());
        let all = builder.seen_fields(&media, &isosurfaces);
        if all.is_empty() || !node.finds_blocks {
            return Ok(None);
        }
        let blocks = builder.blocks(all.len());
        let (cells, triangles, word) = (grid.cells(), grid.triangles(), size_of::<u32>());
        let mut columns = ranks.take_node(all.len() * MAX_CLEAR * word * node.max_cells)?;
        let mut memory = ranks.take_node(all.len() * word * node.max_triangles)?;
        if columns.is_refused || memory.is_refused {
            return Ok(None);
        }
        let mut ranges = Vec::with_capacity(all.len());
        let place_of = |number: usize| number * MAX_CLEAR * word * cells;
        columns.write(ranks, |put| {
            renderer.run(|| {
                for (number, seen) in all.iter().enumerate() {
                    let put = &|at: usize, bytes: &[u8]| put(place_of(number) + at, bytes);
                    ranges.push(match fields[seen.source].field().samples() {
                        Reals::F32(data) => put_columns(&builder.occupancy_test(data, seen, blocks), node, put),
                        Reals::F64(data) => put_columns(&builder.occupancy_test(data, seen, blocks), node, put),
                    });
                }
            });
            Ok(())
        })?;
        let mut seen = vec![SeenBlocks::default(); all.len()];
        memory.write(ranks, |put| {
            renderer.run(|| {
                for (number, ranges) in ranges.iter().enumerate().filter(|(_, ranges)| **ranges > 0) {
                    let columns = bytemuck::cast_slice(&columns.bytes()[place_of(number)..][..cells * ranges * word]);
                    let of_turn = |words: &mut Vec<u32>, turn: Range<usize>| {
                        words.resize(turn.len(), 0);
                        let seen = blocks.find(*ranges, columns, turn.start, words);
                        put((number * triangles + turn.start) * word, bytemuck::cast_slice(words));
                        seen
                    };
                    let of_turns = node.turns(triangles).par_bridge().map_init(Vec::new, of_turn);
                    seen[number] = of_turns.reduce(SeenBlocks::default, SeenBlocks::and);
                }
            });
            Ok(())
        })?;
        ranks.keep_node(columns);
        let sums = |mut a: Vec<SeenBlocks>, b: Vec<SeenBlocks>| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a = a.and(b));
            a
        };
        let seen = node.sum(ranks, &seen, sums)?;
        let seen = seen.into_iter().zip(ranges).map(|(seen, ranges)| (ranges > 0).then_some(seen)).collect();
        Ok(Some(NodeOccupancy { memory, triangles, seen }))
    }

    /// The mask of the field that is seen with this number.
    fn mask(&self, number: usize, blocks: Blocks) -> OccupancyMask<'_> {
        let words: &[u32] = match self.seen[number] {
            Some(_) => &bytemuck::cast_slice(self.memory.bytes())[number * self.triangles..][..self.triangles],
            None => &[],
        };
        let mask = OccupancyMask { blocks: words.into(), ..OccupancyMask::default().full(blocks.layers) };
        self.seen[number].iter().fold(mask, |mask, seen| blocks.mask(mask, *seen))
    }

    /// Returns the memory for the next frame.
    pub fn leave(self, ranks: &mut Ranks) {
        ranks.keep_node(self.memory);
    }
}

/// Puts the words of the cells of this rank's turns, and returns their number for each cell.
fn put_columns<S: PreparedSample>(test: &OccupancyTest<S>, node: NodeWork, put: PutBytes) -> usize {
    let clear = test.frequent();
    if !clear.is_empty() {
        let turns = node.turns(test.blocks.grid.cells()).par_bridge();
        turns.for_each_init(Vec::new, |words, turn| {
            words.resize(clear.len() * turn.len(), 0u32);
            test.find_columns(&clear, turn.start, words);
            put(clear.len() * turn.start * size_of::<u32>(), bytemuck::cast_slice(words));
        });
    }
    clear.len()
}
