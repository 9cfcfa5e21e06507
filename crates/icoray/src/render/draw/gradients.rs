//! Gradients of the lit fields of a frame, and normals of its layers. A rank computes those that its rays need, and keeps
//! them between frames; ranks that read the same fields in a node's memory compute them together, each those of some
//! cells.

use super::node_work::NodeWork;
use super::scene_builder::{BuiltScene, SceneBuilder};
use crate::plan::lit_fields;
use crate::ranks::{NodeMemory, Ranks};
use crate::render::context::FrameContext;
use crate::render::frame_cache::{GradientKey, OccupancyKey};
use crate::render::prepare::check_memory;
use icoray_grid::gradient::{self, GradientOptions, Gradients, PartialGradients, PreparedSample};
use icoray_grid::occupancy::OccupancyMask;
use icoray_grid::samples::Samples;
use icoray_grid::visible_cells::VisibleCells;
use icoray_grid::{Error, ErrorKind, Reals, Result};
use icoray_kernel::general::Levels;
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;

/// A field whose gradients are computed.
struct LitField<'p> {
    /// Its number.
    number: usize,
    key: &'p GradientKey,
    /// The blocks in which they are computed; all if there are none.
    visible: Option<&'p OccupancyMask<'p>>,
    /// The cells of which they are computed; all if there are none.
    seen: Option<VisibleCells>,
}

impl SceneBuilder<'_, '_> {
    fn is_single(&self) -> bool {
        self.terrain.key.is_none() && self.context.plan.allows_single_gradients(self.context.scene)
    }

    fn is_packed(&self, partial: bool) -> bool {
        partial && self.savings.packing && self.is_single()
    }

    /// The key of the gradients of a field with these cuts.
    pub(super) fn gradient_key(&self, number: usize, cuts: &[f64], visible: Option<&OccupancyKey>) -> GradientKey {
        let FrameContext { plan, grid, .. } = *self.context;
        // Ranks exchange gradients, so all divide by the same range.
        let low = cuts.first().copied().unwrap_or(0.0);
        let width = cuts.last().map_or(0.0, |high| high - low);
        let width = if width > 0.0 { width } else { low.abs().max(1.0) };
        let has_blocks = self.partial_gradients && self.savings.gradients;
        GradientKey {
            source: self.context.fields[number].source(grid),
            falling: plan.falling,
            range: [low, low + width],
            radius: plan.radius.clone(),
            packed: self.is_packed(self.partial_gradients),
            single: self.is_single(),
            occupancy: visible.filter(|_| has_blocks).cloned(),
            heights: self.terrain.key.clone(),
        }
    }

    /// The gradients that are cached for `key`, and the further ones that the picture needs.
    pub(super) fn gradients(
        &self,
        number: usize,
        key: &GradientKey,
        visible: &OccupancyMask,
    ) -> Result<PartialGradients<'static>> {
        let lit = self.lit_field(number, key, visible);
        match self.context.fields[number].field().samples() {
            Reals::F32(data) => self.own_gradients(data, &lit),
            Reals::F64(data) => self.own_gradients(data, &lit),
        }
    }

    fn lit_field<'p>(&self, number: usize, key: &'p GradientKey, visible: &'p OccupancyMask<'p>) -> LitField<'p> {
        let FrameContext { scene, plan, grid, part, .. } = *self.context;
        LitField {
            number,
            key,
            visible: key.occupancy.is_some().then_some(visible),
            seen: (part.is_none() && self.savings.gradients).then(|| plan.visible_cells(scene, grid)),
        }
    }

    fn own_gradients<S: PreparedSample>(&self, data: &[S], lit: &LitField) -> Result<PartialGradients<'static>> {
        let FrameContext { plan, grid, cache, .. } = *self.context;
        let known = cache.gradients.take(lit.key);
        match &self.terrain.levels {
            Levels::Native(_) => known.or_else(|memory| {
                let memory = memory.map_or_else(Gradients::none, PartialGradients::into_values);
                Ok(self.gradients_over(data, lit, 0..grid.cells(), memory)?.into())
            }),
            Levels::Concentric(_) => {
                let known = known.unwrap_or_else(|memory| memory.unwrap_or_else(PartialGradients::none).of_none());
                known.with_cells(grid, &plan.radius, &self.samples(data, lit), lit.options())
            }
        }
    }

    /// The gradients over some cells.
    fn gradients_over<S: PreparedSample>(
        &self,
        data: &[S],
        lit: &LitField,
        cells: Range<usize>,
        memory: Gradients<'static>,
    ) -> Result<Gradients<'static>> {
        let (FrameContext { plan, grid, .. }, samples) = (self.context, self.samples(data, lit));
        match &self.terrain.levels {
            Levels::Native(heights) => gradient::native::gradients(grid, heights, &samples, cells, memory),
            Levels::Concentric(_) => gradient::gradients(grid, &plan.radius, &samples, cells, lit.options(), memory),
        }
    }

    fn samples<'d, S: PreparedSample>(&self, data: &'d [S], lit: &LitField) -> Samples<'d, S> {
        Samples::new(data, &self.context.fields[lit.number].field(), self.context.plan.falling, lit.key.range)
    }
}

impl LitField<'_> {
    fn options(&self) -> GradientOptions<'_> {
        let GradientKey { packed, single, .. } = *self.key;
        GradientOptions { visible: self.visible, seen: self.seen.as_ref(), packed, single }
    }
}

/// Gradients and normals in memory that the ranks of a node share.
pub(super) struct NodeGradients(NodeMemory);

impl NodeGradients {
    /// Memory for the gradients of lit fields and the normals of layers, which `builder` then leaves out; `None` if there
    /// are none, or a node has no memory to share. Collective.
    pub fn allocate(builder: &mut SceneBuilder, node: NodeWork, ranks: &mut Ranks) -> Result<Option<Self>> {
        let context = builder.context;
        if !builder.summary.is_lit() {
            return Ok(None);
        }
        let packed = builder.is_packed(node.partial_gradients);
        let gradients = lit_fields(context.scene).len() * context.plan.radius.len() * size_of_gradient(packed);
        let normals = builder.terrain.normal_keys(&builder.surface_layers(), true).len() * NORMAL;
        let memory = ranks.take_node(node.max_cells * (gradients + normals))?;
        if memory.is_refused {
            // Each rank takes memory of its own for all of them.
            let processes = ranks.node_size();
            ranks.collective_work(|| check_memory(context, processes, 1))?;
            return Ok(None);
        }
        builder.leave_out_gradients(node.partial_gradients);
        Ok(Some(NodeGradients(memory)))
    }

    /// Computes what the scene of `builder` lacks, each rank that of its turns, and that of halo cells at their owners.
    /// Collective.
    pub fn compute(
        &mut self,
        builder: &SceneBuilder,
        node: NodeWork,
        ranks: &mut Ranks,
        built: &BuiltScene,
    ) -> Result<()> {
        let FrameContext { renderer, grid, fields, part, .. } = *builder.context;
        let (NodeGradients(memory), places) = (self, places(built));
        memory.write(ranks, |put| {
            renderer.run(|| {
                for Place { of, start, width } in &places {
                    let (turns, at) = (node.turns(grid.cells()).par_bridge(), |cell: usize| start + cell * width);
                    match *of {
                        Vectors::Gradients(number, key) => {
                            let lit = builder.lit_field(number, key, &built.scene.visible);
                            let of_turn = |memory: &mut Option<_>, cells: Range<usize>| {
                                let at = at(cells.start);
                                let rows = memory.take().unwrap_or_else(Gradients::none);
                                let rows = match fields[number].field().samples() {
                                    Reals::F32(data) => builder.gradients_over(data, &lit, cells, rows)?,
                                    Reals::F64(data) => builder.gradients_over(data, &lit, cells, rows)?,
                                };
                                put(at, rows.bytes());
                                *memory = Some(rows);
                                Ok(())
                            };
                            turns.try_for_each_init(|| None, of_turn)?;
                        }
                        Vectors::Normals(_, layer) => turns.for_each(|cells| {
                            let at = at(cells.start);
                            let normals = builder.terrain.normals(grid, layer, cells, Vec::new());
                            put(at, bytemuck::cast_slice(&normals));
                        }),
                    }
                }
                Ok(())
            })
        })?;
        let Some(part) = part else { return Ok(()) };
        places.iter().try_for_each(|place| part.fill_shared_halo(ranks, memory, (place.start, place.width)))
    }

    /// Gives the scene these gradients and normals.
    pub fn lend<'n>(&'n self, built: &mut BuiltScene<'n>) -> Result<()> {
        let unaligned = || Error::new(ErrorKind::Internal, "gradients in the node's memory are not aligned");
        let (mut gradients, mut normals) = (Vec::new(), Vec::new());
        for Place { of, start, width } in places(built) {
            let bytes = &self.0.bytes()[start..start + built.scene.grid.cells() * width];
            match of {
                Vectors::Gradients(number, key) => {
                    gradients.push((number, Gradients::of_bytes(bytes, key.packed).ok_or_else(unaligned)?));
                }
                Vectors::Normals(number, _) => {
                    normals.push((number, bytemuck::try_cast_slice(bytes).map_err(|_| unaligned())?));
                }
            }
        }
        gradients.into_iter().for_each(|(number, of)| built.scene.sources[number].gradients = of.into());
        normals.into_iter().for_each(|(number, of)| built.scene.normals[number].1 = Cow::Borrowed(of));
        Ok(())
    }

    /// Returns the memory for the next frame.
    pub fn leave(self, ranks: &mut Ranks) {
        ranks.keep_node(self.0);
    }
}

/// Gradients of a field, by its number, or normals of a layer, with their number in the scene.
enum Vectors<'b> {
    Gradients(usize, &'b GradientKey),
    Normals(usize, usize),
}

/// Where the vectors of all cells are: bytes before them, and bytes of a cell.
struct Place<'b> {
    of: Vectors<'b>,
    start: usize,
    width: usize,
}

/// The places of the gradients of each lit field, and of the normals of each layer.
fn places<'b>(built: &'b BuiltScene) -> Vec<Place<'b>> {
    let layers = built.scene.levels.count();
    let lit = built.gradient_keys.iter().enumerate().filter_map(|(number, key)| {
        let key = key.as_ref()?;
        Some((Vectors::Gradients(number, key), layers * size_of_gradient(key.packed)))
    });
    let normals = built.normal_keys.iter().enumerate();
    let normals = normals.map(|(number, key)| (Vectors::Normals(number, key.layer[0]), NORMAL));
    let mut start = 0;
    let place = |(of, width)| {
        let place = Place { of, start, width };
        start += built.scene.grid.cells() * width;
        place
    };
    lit.chain(normals).map(place).collect()
}

/// Bytes of a normal.
const NORMAL: usize = size_of::<[f32; 3]>();

fn size_of_gradient(packed: bool) -> usize {
    if packed { size_of::<u64>() } else { size_of::<[f32; 3]>() }
}
