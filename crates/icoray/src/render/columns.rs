//! A picture of columns that are spread over ranks: each node puts the field together, and draws as if it had been given so.

use super::{Given, Rendered, Renderer};
use crate::error::{Error, Result};
use crate::field::Field;
use crate::grid::{Grid, Reals};
use crate::layers::Layers;
use crate::ranks::{Columns, Ranks};
use crate::scene::Scene;
use std::time::Instant;

impl Renderer {
    /// Renders `scene` together with the other ranks, as [`Self::render_over`] does where all have the same data: each rank
    /// gives the whole `grid`, and `field` has the columns that `columns` says, of which those of its own are read.
    /// Collective. The picture is bitwise that of one process with the whole field.
    ///
    /// # Errors
    /// As [`Self::render_over`]; [`ErrorKind::Field`](crate::ErrorKind::Field) where a field lies at corners.
    pub fn render_columns(
        &self,
        ranks: &mut Ranks,
        scene: &Scene,
        grid: &Grid,
        columns: &Columns,
        layers: &Layers,
        field: &Field,
    ) -> Result<Rendered> {
        let start = Instant::now();
        let bytes = ranks.attempt(|| {
            let named = |e: Error| e.within(format!("{:?}", scene.field));
            columns.bytes_for(grid, field).map_err(named)
        });
        // Else they would write over each other's.
        let bytes = ranks.of_one_mind(bytes, |_| {
            let bits = if matches!(field.samples(), Reals::F32(_)) { 32 } else { 64 };
            let values = format!("{} layers of {bits} bits", field.shape().layers);
            vec![("has a field of", values), ("has missing values marked by", format!("{:?}", field.fill()))]
        })?;
        let mut node = ranks.take_node(bytes)?;
        let gathered = columns.gather(ranks, &mut node, field);
        let whole = gathered.and_then(|copied| Ok((copied, columns.whole(&node, field)?)));
        let rendered = ranks.together(whole).and_then(|(copied, field)| {
            let copy_s = start.elapsed().as_secs_f64();
            let given = Given { grid, part: None, layers, fields: &(&field).into() };
            let mut rendered = self.render_since(start, ranks, scene, &given)?;
            let report = rendered.report_mut();
            (report.bytes_copied, report.copy_s) = (copied, copy_s);
            report.prepare_s -= copy_s;
            report.sharing = report.sharing.map(|sharing| sharing.of_gathered(node.is_refused));
            Ok(rendered)
        });
        ranks.keep_node(node);
        rendered
    }
}
