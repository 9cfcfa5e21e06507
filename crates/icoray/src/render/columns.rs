//! A picture of columns that are spread over ranks: each node puts the fields together, and draws as if it had been given
//! so.

use super::{Given, Rendered, Renderer};
use crate::error::Result;
use crate::fields::Fields;
use crate::grid::Grid;
use crate::layers::Layers;
use crate::ranks::{Columns, Placed, Ranks};
use crate::scene::Scene;
use std::time::Instant;

impl Renderer {
    /// Renders `scene` together with the other ranks, as [`Self::render_over`] does where all have the same data: each rank
    /// gives the whole `grid`, and `fields`, and heights where the scene needs them, have the columns that `columns` says,
    /// of which those of its own are read. Collective. The picture is bitwise that of one process with the whole fields.
    ///
    /// # Errors
    /// As [`Self::render_over`]; [`ErrorKind::Field`](crate::ErrorKind::Field) where a field lies at corners.
    pub fn render_columns<'f>(
        &self,
        ranks: &mut Ranks,
        scene: &Scene,
        grid: &Grid,
        columns: &Columns,
        layers: &Layers,
        fields: impl Into<Fields<'f>>,
    ) -> Result<Rendered> {
        let start = Instant::now();
        let fields = fields.into();
        let places = ranks.attempt(|| columns.places(grid, &fields.needed_by(scene)?));
        let (places, bytes) =
            ranks.of_one_mind(places, |(places, _)| places.iter().flat_map(Placed::facts).collect())?;
        let mut node = ranks.take_node(bytes)?;
        let mut gathered = Ok(0);
        for place in &places {
            // Where one has failed the others wait for this rank all the same.
            let copied = columns.gather(ranks, &mut node, place);
            gathered = gathered.and_then(|sum| Ok(sum + copied?));
        }
        let wholes = gathered.and_then(|copied| Ok((copied, columns.wholes(&node, &places)?)));
        let rendered = ranks.together(wholes).and_then(|(copied, fields)| {
            let copy_s = start.elapsed().as_secs_f64();
            let given = Given { grid, part: None, layers, fields: &fields };
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
