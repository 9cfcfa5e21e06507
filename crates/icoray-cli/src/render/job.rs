//! Rendering of one picture, and its summary.

use super::target::{PictureSummary, Target};
use crate::{gpu, input};
use icoray::output::Stamp;
use icoray::{Backend, Field, Frame, Ranks, Result, Shot};
use icoray_dataset::{Drawing, Key, NativeHeightCache, SceneField};
use std::collections::BTreeMap;

/// Data that all pictures of a run share.
pub struct Job<'a> {
    pub drawing: Drawing<'a>,
    pub target: &'a Target,
    /// Seconds from the start to the first picture.
    pub open_s: f64,
    /// Whether summaries have all lines.
    pub is_verbose: bool,
}

impl Job<'_> {
    /// Renders a shot with the other ranks. Returns frame and summary at rank 0; `read_s` are the seconds of reading.
    pub fn picture(
        &self,
        shot: &Shot,
        stamp: &Stamp,
        fields: &BTreeMap<Key, Field>,
        heights: &NativeHeightCache,
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
        let path = self.target.path(&scene.output, stamp, scene.field())?;
        let report = &frame.report;
        let fields = self.drawing.scene_fields.of(scene)?;
        let units = fields.first().and_then(|first| first.info.description.units.as_deref());
        let mut text = format!(
            "picture   {} ({} x {})\nfield     {}\nrange     {}, {} missing",
            path.display(),
            frame.width,
            frame.height,
            in_words(&fields, stamp),
            input::range(report.value_range, units),
            report.missing_values,
        );
        text.extend(report.off_values.iter().map(|note| format!("\nnote      {note}")));
        text.extend(report.sampling.hint().map(|hint| format!("\nhint      {hint}")));
        let (device, left_to_cpu) = (report.device.name.as_deref(), report.device.left_to_cpu.as_deref());
        if self.is_verbose || report.error.pixels_over_tolerance > 0 {
            text += &format!("\nerror     {}", report.error);
        }
        if self.is_verbose || left_to_cpu.is_some() && scene.backend == Backend::Gpu {
            text += &format!("\ndrawn on  {}", gpu::drawn_on(device, left_to_cpu));
        }
        let details = self.is_verbose.then(|| self.details(shot, frame, read_s)).transpose()?;
        Ok(PictureSummary { text, details })
    }

    /// The other lines of a summary, before and after the seconds of writing.
    fn details(&self, shot: &Shot, frame: &Frame, read_s: f64) -> Result<[String; 2]> {
        let (report, counts) = (&frame.report, &frame.report.counts);
        let heights = self.drawing.scene_fields.native(&shot.scene)?;
        let heights = heights.map_or_else(String::new, |native| format!("heights   {}\n", native.description));
        let view = if shot.name.is_empty() { String::new() } else { format!("view      {}\n", shot.name) };
        let before = format!(
            "{view}{heights}\
             rays      {}, {} columns, {} frusta ({} void)\n\
             quality   {}\n\
             sampling  {}; cells per pixel {}\n\
             seconds   open {:.3}, read {read_s:.3}, prepare {:.3}, render {:.3}, write ",
            counts.rays,
            counts.columns,
            counts.frusta,
            counts.void_frusta,
            report.quality,
            report.sampling,
            report.sampling.cells_per_pixel,
            self.open_s,
            report.timing.prepare_s,
            report.timing.render_s,
        );
        let threads = report.threads;
        let ranks = if report.ranks.count > 1 {
            format!("{} ranks of {threads} threads", report.ranks.count)
        } else {
            format!("{threads} threads")
        };
        Ok([before, format!(" ({ranks})\nleft out  {}", report.left_out.join("; "))])
    }
}

/// The fields of a picture and its time.
fn in_words(fields: &[SceneField], stamp: &Stamp) -> String {
    let field = |SceneField { info, range }: &SceneField| {
        let layers = if info.is_2d() { "2D".into() } else { format!("{} layers", range.len()) };
        format!("{} at {}, {layers}", info.name, input::place(info))
    };
    let fields: Vec<String> = fields.iter().map(field).collect();
    format!("{}, time {} ({})", fields.join("; "), stamp.step, stamp.date.as_deref().unwrap_or("no date"))
}
