//! The renderer: draws scenes on a thread pool of its own, and on a device if there is one.

use crate::derive;
use crate::fields::Fields;
use crate::plan::Plan;
use crate::ranges::FieldValues;
use crate::ranks::{CountedColumns, HAS_WHOLE, NodeRanks, Part, Ranks};
use icoray_grid::{Error, ErrorKind, Field, Grid, Layers, Result};
use icoray_output::{Frame, FrameReport, Sharing};
use icoray_scene::{Scene, Scheme};
use std::time::Instant;

mod columns;
mod context;
mod device;
mod draw;
mod frame_cache;
#[cfg(test)]
mod ground_tests;
mod lazy;
mod levels;
mod parts;
mod picture;
mod prepare;
mod prepared_field;
mod probe;
mod renderer;
mod round;
mod samples;
mod statistics;
mod work;

pub use probe::{Contribution, Probe, ProbePoint, ScenePart};
pub use renderer::Renderer;
pub use statistics::Histogram;

use context::FrameContext;
use prepared_field::PreparedField;

/// A rank's result of a finished picture.
#[derive(Debug, Clone, PartialEq)]
pub enum Rendered {
    /// The picture, on rank 0.
    Here(Frame),
    /// The picture's report; the pixels are at rank 0. Errors, counts and the gathering are those of the whole picture;
    /// seconds, threads and tiles are this rank's.
    AtRoot(FrameReport),
}

impl Rendered {
    pub(crate) fn report_mut(&mut self) -> &mut FrameReport {
        match self {
            Rendered::Here(frame) => &mut frame.report,
            Rendered::AtRoot(report) => report,
        }
    }
}

/// A scene and the data that it shows.
#[derive(Clone, Copy)]
pub(crate) struct RenderInputs<'f> {
    pub scene: &'f Scene,
    pub grid: &'f Grid<'f>,
    /// The rank's part of the grid; `None` is the whole grid.
    pub part: Option<&'f Part<'f>>,
    /// The ranks of this node, if they read the same fields in its memory.
    pub mates: Option<&'f NodeRanks>,
    pub layers: &'f Layers,
    pub fields: &'f Fields<'f>,
}

impl<'f> RenderInputs<'f> {
    /// The columns that count on this rank.
    pub fn counted(&self) -> CountedColumns<'f> {
        CountedColumns::new(self.part, self.mates)
    }
}

impl Renderer {
    /// Renders `scene` from its fields, or from one field.
    ///
    /// # Errors
    /// As [`Plan::new`], and [`ErrorKind::Scene`](icoray_grid::ErrorKind::Scene) if the scene shows a field that is
    /// missing.
    pub fn render<'f>(
        &self,
        scene: &Scene,
        grid: &Grid,
        layers: &Layers,
        fields: impl Into<Fields<'f>>,
    ) -> Result<Frame> {
        match self.render_over(&mut Ranks::alone(), scene, grid, layers, fields)? {
            Rendered::Here(frame) => Ok(frame),
            Rendered::AtRoot(_) => unreachable!("who draws alone is rank 0"),
        }
    }

    /// Renders `scene` together with the other ranks; the picture is at rank 0. Collective: all ranks pass the same
    /// scene and layers, and copies of the same grid and fields; [`Self::render_decomposed`] renders distributed ones.
    ///
    /// Each rank draws some tiles, and the picture is bitwise that of [`Self::render`], or, where the scene requests
    /// fragments, agrees with the exact integral within its errors. [`Sharing`](icoray_output::Sharing) lists the
    /// schemes that a scene can request.
    ///
    /// Within a time budget rank 0 picks the quality; with fragments it is the cheapest that any rank picks.
    ///
    /// # Errors
    /// Equal on all ranks: as [`Plan::new`] on any of them, [`ErrorKind::Internal`](icoray_grid::ErrorKind::Internal)
    /// if one of several panicked, and [`ErrorKind::Mpi`](icoray_grid::ErrorKind::Mpi) if their data differ or the
    /// transport fails.
    pub fn render_over<'f>(
        &self,
        ranks: &mut Ranks,
        scene: &Scene,
        grid: &Grid,
        layers: &Layers,
        fields: impl Into<Fields<'f>>,
    ) -> Result<Rendered> {
        let given = RenderInputs { scene, grid, part: None, mates: None, layers, fields: &fields.into() };
        self.in_context(Instant::now(), ranks, &given, draw::draw)
    }

    /// Prepares a frame's plan, fields and heights, with the derived ones, and keeps what the next frame may reuse
    /// after `draw`. Collective.
    fn in_context<R>(
        &self,
        start: Instant,
        ranks: &mut Ranks,
        given: &RenderInputs,
        draw: impl FnOnce(&FrameContext, &mut Ranks) -> Result<R>,
    ) -> Result<R> {
        let RenderInputs { scene, grid, part, mates, layers, fields } = *given;
        let needed = ranks.attempt(|| fields.needed_by(scene));
        let fields = &ranks.collective(needed)?;
        let given = &RenderInputs { fields, ..*given };
        let made = derive::make(ranks, &self.derived, &self.threads, given, self.memory_limit)?;
        let given = &RenderInputs { fields: &made.fields(fields), ..*given };
        let (mut plan, sharing) = self.agree_on_plan(ranks, given)?;
        let share_of_whole = match part {
            None if sharing.scheme == Scheme::Fragments => Some(Part::of_whole(ranks, grid)?),
            _ => None,
        };
        let has_whole = part.is_none();
        let part = part.or(share_of_whole.as_ref());
        let given = &RenderInputs { part, ..*given };
        let prepared = self.prepare_fields(ranks, given, has_whole)?;
        let heights = self.prepare_heights(ranks, given)?;
        if prepared.iter().chain(&heights).any(PreparedField::is_average) {
            plan.mark_corners_read();
        }
        let shown: Vec<(&str, Field)> = prepared.iter().map(|field| (field.name(), field.field())).collect();
        let values = |name: &str| {
            let (_, field) = shown.iter().find(|(known, _)| *known == name).unwrap_or(&shown[0]);
            FieldValues { threads: &self.threads, field, counted: given.counted() }
        };
        let settled = self.ranges.resolve(ranks, scene, &values)?;
        if let Some(settled) = &settled {
            settled.check_values()?;
        }
        let bytes_of_fields: usize = prepared.iter().chain(&heights).map(PreparedField::bytes).sum();
        let (scene, node_rank) = (settled.as_ref().unwrap_or(scene), ranks.node_rank());
        let context = FrameContext {
            renderer: self,
            // On one of the renderer's threads, so that threads that a driver starts do not descend from the host's.
            device: self.run(|| self.device_for(scene, node_rank)),
            asked: given.scene,
            scene,
            plan: &plan,
            grid,
            part,
            mates,
            has_whole,
            sharing,
            layers,
            heights: heights.as_ref(),
            fields: &prepared,
            deviations: None,
            cache: &self.frame_cache,
            bytes_derived: bytes_of_fields + made.bytes(),
            start,
        };
        let drawn = draw(&context, ranks)?;
        prepared.into_iter().chain(heights).for_each(|field| field.keep(ranks, &self.frame_cache, grid));
        self.derived.keep(ranks, made);
        Ok(drawn)
    }

    /// The plan of a frame, and the distribution of its picture over ranks: equal on all. Collective.
    fn agree_on_plan(&self, ranks: &mut Ranks, given: &RenderInputs) -> Result<(Plan, Sharing)> {
        let RenderInputs { scene, grid, part, layers, fields, .. } = *given;
        let plan = ranks.attempt(|| {
            if part.is_none() && grid.cells() == 0 {
                return Err(Error::new(ErrorKind::Grid, "0 cells, expected at least 1"));
            }
            Ok((Plan::new(scene, grid, layers, fields.get(scene.field())?)?, Plan::sharing(scene, part.is_some())?))
        });
        ranks.agree_all(plan, |(plan, sharing)| {
            let place = if plan.from_corners { "corners" } else { "centres" };
            let (count, exaggeration) = (plan.radius.len(), scene.exaggeration);
            let described = format!("{}, {count} of the field, exaggeration {exaggeration}", layers.describe());
            let mut facts = vec![
                ("draws", sharing.to_string()),
                ("has layers", described),
                ("has a field at", place.into()),
                ("has a scene with backend", format!("{:?}", scene.backend)),
            ];
            if part.is_none() {
                let tables = self.run(|| grid.table_hashes());
                facts
                    .extend(tables.iter().map(|(name, hash)| (HAS_WHOLE, format!("table {name} of hash {hash:016x}"))));
            }
            facts
        })
    }
}
