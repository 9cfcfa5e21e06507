//! Rendering of one picture, and its summary.

use super::output_queue::PictureSummary;
use super::target::Target;
use crate::gpu;
use crate::input;
use icoray::output::Stamp;
use icoray::{Field, Frame, Ranks, Result, Shot};
use icoray_dataset::{Drawing, Key, NativeHeightCache, SceneField};
use std::collections::BTreeMap;

/// Data that all pictures of a run share.
pub struct Job<'a> {
    pub drawing: Drawing<'a>,
    pub target: &'a Target,
    /// Seconds from the start to the first picture.
    pub open_s: f64,
}

impl Job<'_> {
    /// Renders a shot with the other ranks. Returns frame and summary at rank 0; `read_s` are the seconds of reading.
    pub fn picture(
        &self,
        shot: &Shot,
        stamp: &Stamp,
        (fields, heights): (&BTreeMap<Key, Field>, &NativeHeightCache),
        read_s: f64,
        ranks: &mut Ranks,
    ) -> Result<Option<(Frame, PictureSummary)>> {
        let Some(mut frame) = self.drawing.frame(&shot.scene, fields, heights, ranks)? else { return Ok(None) };
        if !shot.name.is_empty() {
            frame.notes.push(("view", shot.name.clone()));
        }
        let summary = self.summary(shot, &frame, stamp, read_s)?;
        Ok(Some((frame, summary)))
    }

    fn summary(&self, shot: &Shot, frame: &Frame, stamp: &Stamp, read_s: f64) -> Result<PictureSummary> {
        let scene = &shot.scene;
        let date = stamp.date.as_deref().unwrap_or("no date");
        let path = self.target.path(&scene.output, stamp, scene.field())?;
        let (report, counts) = (&frame.report, &frame.report.counts);
        let scene_fields = self.drawing.scene_fields.of(scene)?;
        let heights = self.drawing.scene_fields.native(scene)?;
        let heights = heights.map_or_else(String::new, |native| format!("heights   {}\n", native.description));
        let view = if shot.name.is_empty() { String::new() } else { format!("view      {}\n", shot.name) };
        let fields: Vec<String> = scene_fields
            .iter()
            .map(|SceneField { info, range }| {
                let (name, place) = (&info.name, input::place(info.location));
                let layers = if info.is_2d() { "2D".into() } else { format!("{} layers", range.len()) };
                format!("field     {name} at {place}, {layers}, time {} ({date})\n", stamp.step)
            })
            .collect();
        let units = scene_fields.first().and_then(|first| first.info.description.units.as_deref());
        let hint = report.sampling.hint().map_or_else(String::new, |hint| format!("\nhint      {hint}"));
        let before = format!(
            "picture   {} ({} x {})\n\
             {view}{}{heights}\
             range     {}, {} missing\n\
             rays      {}, {} columns, {} frusta ({} void)\n\
             error     {}\n\
             quality   {}\n\
             sampling  {}; cells per pixel {}{hint}\n\
             seconds   open {:.3}, read {read_s:.3}, prepare {:.3}, render {:.3}, write ",
            path.display(),
            frame.width,
            frame.height,
            fields.concat(),
            input::range(report.value_range, units),
            report.missing_values,
            counts.rays,
            counts.columns,
            counts.frusta,
            counts.void_frusta,
            report.error,
            report.quality,
            report.sampling,
            report.sampling.cells_per_pixel,
            self.open_s,
            report.timing.prepare_s,
            report.timing.render_s,
        );
        let drawn_on = gpu::drawn_on(report.device.name.as_deref(), report.device.left_to_cpu.as_deref());
        let (threads, left_out) = (report.threads, report.left_out.join("; "));
        let ranks = if report.ranks.count > 1 {
            format!("{} ranks of {threads} threads", report.ranks.count)
        } else {
            format!("{threads} threads")
        };
        let after = format!(" ({ranks})\ndrawn on  {drawn_on}\nleft out  {left_out}");
        Ok(PictureSummary(before, after))
    }
}
