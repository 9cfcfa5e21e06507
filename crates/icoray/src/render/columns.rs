//! Renders fields whose columns are distributed over ranks: each node gathers whole fields and draws from them.

use super::RenderInputs;
use super::Rendered;
use super::draw;
use super::renderer::Renderer;
use crate::fields::Fields;
use crate::plan::CELL_CORNER;
use crate::ranks::{Decomposition, DistributedGrid, GatherInputs, NodeFields, Ranks};
use icoray_grid::{Grid, Layers, Result};
use icoray_scene::Scene;
use std::time::Instant;

impl Renderer {
    /// Renders `scene` together with the other ranks, as [`Self::render_over`] does if all have the same data.
    /// Collective. With [`Decomposition::Columns`] `fields`, and heights if the scene needs them, have the columns of
    /// this rank, of which only own ones are read; the picture is bitwise that of one process with the whole fields.
    /// Without, they are whole fields over a whole grid.
    ///
    /// # Errors
    /// As [`Self::render_over`]; [`ErrorKind::Field`](icoray_grid::ErrorKind::Field) if a field or heights have other
    /// columns than this rank.
    pub fn render_decomposed<'f>(
        &self,
        ranks: &mut Ranks,
        scene: &Scene,
        data: DistributedGrid,
        fields: impl Into<Fields<'f>>,
    ) -> Result<Rendered> {
        let DistributedGrid { grid, decomposition, layers } = data;
        let (start, fields) = (Instant::now(), fields.into());
        let Some(Decomposition::Columns(columns)) = decomposition else {
            let given = RenderInputs { scene, grid, part: None, mates: None, layers, fields: &fields };
            return self.in_context(start, ranks, &given, draw::draw);
        };
        let derivation_inputs = scene.derivation_inputs().collect();
        let inputs = GatherInputs { threads: &self.threads, grid, layers, derivation_inputs };
        let gathered = columns.gather(ranks, &inputs, || fields.needed_by(scene))?;
        let mut rendered = self.render_gathered(start, ranks, scene, grid, layers, &gathered);
        if let Ok(rendered) = &mut rendered {
            let report = rendered.report_mut();
            (report.bytes_copied, report.timing.copy_s) = (gathered.bytes_copied, gathered.copy_s);
            report.timing.prepare_s -= gathered.copy_s;
        }
        gathered.leave(ranks);
        rendered
    }

    /// Renders `scene` from fields that nodes have gathered, as a frame that began at `start`. Collective.
    pub(crate) fn render_gathered(
        &self,
        start: Instant,
        ranks: &mut Ranks,
        scene: &Scene,
        grid: &Grid,
        layers: &Layers,
        gathered: &NodeFields,
    ) -> Result<Rendered> {
        let needed = gathered.fields().and_then(|fields| fields.needed_by(scene));
        let fields = ranks.collective(needed)?;
        if let (Some(error), Some(_)) = (&gathered.heights_error, fields.heights()) {
            return Err(error.clone());
        }
        let (grid, part, mates) = (gathered.grid(grid), gathered.part(), gathered.mates.as_ref());
        let given = RenderInputs { scene, grid, part, mates, layers, fields: &fields };
        let mut rendered = self.in_context(start, ranks, &given, draw::draw)?;
        let report = rendered.report_mut();
        report.bytes_derived += gathered.table_bytes() + gathered.bytes_averaged as usize;
        if gathered.are_averaged(&fields) {
            report.left_out.retain(|what| what != CELL_CORNER);
        }
        report.ranks.sharing =
            report.ranks.sharing.map(|sharing| sharing.of_gathered(gathered.grid.is_some(), gathered.is_refused()));
        Ok(rendered)
    }
}
