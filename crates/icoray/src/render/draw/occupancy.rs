//! The visible blocks of a frame's volumes and isosurfaces: found by a rank alone and kept between frames, or by the
//! ranks of a node together, in memory that they share.

use super::node_work::NodeWork;
use super::scene_builder::SceneBuilder;
use crate::plan::{Blocks, FieldColumns, FieldTest, MAX_CLEAR, OccupancyTest, SeenBlocks, clear_values};
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
    /// The blocks that any volume or isosurface needs, with their key; without a key, all or nothing.
    pub(super) fn visible(
        &self,
        media: &[Medium],
        isosurfaces: &[Isosurface],
    ) -> (Option<OccupancyKey>, OccupancyMask<'f>) {
        let FrameContext { plan, grid, deviations, cache, .. } = *self.context;
        let (blocks, seen) = (self.blocks(), self.seen_fields(media, isosurfaces));
        let key = |fields| OccupancyKey { fields, falling: plan.falling, leaps: blocks.leaps };
        if let Some(deviations) = deviations {
            let key = key(vec![(self.context.fields[0].source(grid), Vec::new())]);
            let visible = cache.visible.take(&key).unwrap_or_else(|_| {
                let visible = deviations.visible(grid, blocks.layers);
                if blocks.leaps { visible.with_macrocells(grid, blocks.layers) } else { visible }
            });
            return (Some(key), visible);
        }
        if !self.savings.empty_space {
            return (None, OccupancyMask::default().full(blocks.layers));
        }
        if seen.is_empty() {
            return (None, OccupancyMask::none(grid.triangles(), blocks.layers));
        }
        let tests = self.occupancy_tests(&seen);
        let sources = seen.iter().map(|seen| self.context.fields[seen.source].source(grid));
        let key = key(sources.zip(tests.iter().map(|test| test.clear_bits())).collect());
        let visible = match self.node_occupancy {
            Some(shared) => shared.mask(blocks),
            None => cache.visible.take(&key).unwrap_or_else(|memory| blocks.visible(tests, memory.unwrap_or_default())),
        };
        (Some(key), visible)
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

    fn blocks(&self) -> Blocks<'f> {
        let FrameContext { plan, grid, .. } = *self.context;
        Blocks { grid, layers: plan.radius.len(), leaps: self.leaps() }
    }

    fn occupancy_tests(&self, seen: &[SeenField]) -> Vec<Box<dyn OccupancyTest + '_>> {
        let test = |seen: &SeenField| match self.context.fields[seen.source].field().samples() {
            Reals::F32(data) => Box::new(self.field_test(data, seen)) as Box<dyn OccupancyTest>,
            Reals::F64(data) => Box::new(self.field_test(data, seen)),
        };
        seen.iter().map(test).collect()
    }

    fn field_test<'d, S: PreparedSample>(&'d self, data: &'d [S], seen: &SeenField) -> FieldTest<'d, S> {
        let (range, whole) = (self.range(seen.source), Spans::<f64>::new(&seen.knots));
        let field = self.context.fields[seen.source].field();
        let samples = Samples::new(data, &field, self.context.plan.falling, whole.range());
        // Values that equal a knot in the precision of the rays.
        let clear = match self.vectors() {
            Some(_) => clear_values(&Spans::<f32>::new(&seen.knots), &samples, range),
            None => clear_values(&whole, &samples, range),
        };
        FieldTest { blocks: self.blocks(), samples, clear }
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
    /// A word per triangle.
    memory: NodeMemory,
    triangles: usize,
    /// The number of visible blocks; `None` if all are.
    seen: Option<SeenBlocks>,
}

impl NodeOccupancy {
    /// Finds the visible blocks of the frame of `builder`, each rank those of its turns; `None` if it needs none or a
    /// node has no memory to share. Collective.
    pub fn find(builder: &SceneBuilder, node: NodeWork, ranks: &mut Ranks) -> Result<Option<Self>> {
        let FrameContext { renderer, grid, .. } = *builder.context;
        let mut parts = builder.clone();
        let (media, isosurfaces) = (parts.media(), parts.isosurfaces());
        let mut tests = builder.occupancy_tests(&builder.seen_fields(&media, &isosurfaces));
        if tests.is_empty() || !node.finds_blocks {
            return Ok(None);
        }
        let (cells, triangles, word) = (grid.cells(), grid.triangles(), size_of::<u32>());
        let mut columns = ranks.take_node(tests.len() * MAX_CLEAR * word * node.max_cells)?;
        let mut memory = ranks.take_node(word * node.max_triangles)?;
        if columns.is_refused || memory.is_refused {
            return Ok(None);
        }
        let mut ranges = Vec::with_capacity(tests.len());
        let place_of = |number: usize| number * MAX_CLEAR * word * cells;
        columns.write(ranks, |put| {
            renderer.run(|| {
                for (number, test) in tests.iter_mut().enumerate() {
                    let put = &|at: usize, bytes: &[u8]| put(place_of(number) + at, bytes);
                    ranges.push(put_columns(&mut **test, cells, node, put));
                }
            });
            Ok(())
        })?;
        let blocks = builder.blocks();
        let (is_full, mut seen) = (ranges.contains(&0), SeenBlocks::default());
        memory.write(ranks, |put| {
            let field = |(number, ranges): (usize, &usize)| {
                let words = &columns.bytes()[place_of(number)..][..cells * ranges * word];
                FieldColumns { ranges: *ranges, words: bytemuck::cast_slice(words) }
            };
            let fields: Vec<_> = ranges.iter().enumerate().map(field).collect();
            let of_turn = |words: &mut Vec<u32>, turn: Range<usize>| {
                words.resize(turn.len(), 0);
                let seen = blocks.find(&fields, turn.start, words);
                put(turn.start * word, bytemuck::cast_slice(words));
                seen
            };
            if !is_full {
                let of_turns = || node.turns(triangles).par_bridge().map_init(Vec::new, of_turn);
                seen = renderer.run(|| of_turns().reduce(SeenBlocks::default, SeenBlocks::and));
            }
            Ok(())
        })?;
        ranks.keep_node(columns);
        // Also on nodes of which all is visible, as all ranks make the same calls.
        let seen = node.sum(ranks, &seen, SeenBlocks::and)?;
        Ok(Some(NodeOccupancy { memory, triangles, seen: (!is_full).then_some(seen) }))
    }

    fn mask(&self, blocks: Blocks) -> OccupancyMask<'_> {
        let all = OccupancyMask::default().full(blocks.layers);
        let Some(seen) = self.seen else { return all };
        let words: &[u32] = &bytemuck::cast_slice(self.memory.bytes())[..self.triangles];
        blocks.mask(OccupancyMask { blocks: words.into(), ..all }, seen)
    }

    /// Returns the memory for the next frame.
    pub fn leave(self, ranks: &mut Ranks) {
        ranks.keep_node(self.memory);
    }
}

/// Puts the words of the cells of this rank's turns, and returns their number for each cell.
fn put_columns(test: &mut dyn OccupancyTest, cells: usize, node: NodeWork, put: PutBytes) -> usize {
    let count = test.keep_frequent();
    if count > 0 {
        let (test, turns) = (&*test, node.turns(cells).par_bridge());
        turns.for_each_init(Vec::new, |words, turn| {
            words.resize(count * turn.len(), 0u32);
            test.find_columns(turn.start, words);
            put(count * turn.start * size_of::<u32>(), bytemuck::cast_slice(words));
        });
    }
    count
}
