//! What the pictures of one run share, and one of them.

use super::due::Key;
use super::own_heights::OwnHeights;
use super::press::Said;
use super::subject::{Subject, Subjects};
use super::target::Target;
use crate::gpu;
use crate::input;
use icoray::output::Stamp;
use icoray::{Field, Fields, Frame, Grid, Ranks, Rendered, Renderer, Result, Shot};
use std::collections::BTreeMap;

/// All that the pictures of one run share.
pub struct Job<'a> {
    pub subjects: &'a Subjects<'a>,
    pub grid: &'a Grid<'a>,
    pub renderer: &'a Renderer,
    pub target: &'a Target,
    /// Seconds until the first picture was begun.
    pub open_s: f64,
}

impl Job<'_> {
    /// Draws a shot of fields and heights that were read, together with the other ranks. At rank 0 the frame, and what is to be
    /// said of it; `read_s` is the seconds that reading took.
    pub fn picture(
        &self,
        shot: &Shot,
        stamp: &Stamp,
        (fields, heights): (&BTreeMap<Key, Field>, &OwnHeights),
        read_s: f64,
        ranks: &mut Ranks,
    ) -> Result<Option<(Frame, Said)>> {
        let scene = &shot.scene;
        let subjects = self.subjects.of(scene)?;
        let needed = subjects.iter().filter_map(|s| Some((s.info.name.as_str(), *fields.get(&s.key())?)));
        let needed = Fields::new(needed);
        let needed = match heights.of(self.subjects, scene)? {
            Some(heights) => needed.with_heights(heights),
            None => needed,
        };
        let layers = self.subjects.layers(scene)?;
        let rendered = self.renderer.render_over(ranks, scene, self.grid, None, layers, needed)?;
        let Rendered::Here(mut frame) = rendered else { return Ok(None) };
        for Subject { info, .. } in &subjects {
            if info.name == scene.field {
                frame.description = info.description.clone();
            } else {
                frame.descriptions.push((info.name.clone(), info.description.clone()));
            }
        }
        frame.notes.extend(self.subjects.notes(scene)?.into_iter().map(|note| ("note", note)));
        if let Some(native) = self.subjects.native(scene)? {
            frame.notes.push(("heights", native.description.clone()));
        }
        if !shot.name.is_empty() {
            frame.notes.push(("view", shot.name.clone()));
        }
        let said = self.said(shot, &frame, stamp, read_s)?;
        Ok(Some((frame, said)))
    }

    fn said(&self, shot: &Shot, frame: &Frame, stamp: &Stamp, read_s: f64) -> Result<Said> {
        let scene = &shot.scene;
        let date = stamp.date.as_deref().unwrap_or("no date");
        let path = self.target.path(&scene.output, stamp, &scene.field)?;
        let (report, counts) = (&frame.report, &frame.report.counts);
        let subjects = self.subjects.of(scene)?;
        let heights = self.subjects.native(scene)?;
        let heights =
            heights.map_or_else(String::new, |native| format!("heights   {}\n", native.description));
        let view = if shot.name.is_empty() { String::new() } else { format!("view      {}\n", shot.name) };
        let fields: Vec<String> = subjects
            .iter()
            .map(|Subject { info, range }| {
                let (name, place) = (&info.name, input::place(info.location));
                let layers = if info.is_2d() { "2D".into() } else { format!("{} layers", range.len()) };
                format!("field     {name} at {place}, {layers}, time {} ({date})\n", stamp.step)
            })
            .collect();
        let units = subjects.first().and_then(|first| first.info.description.units.as_deref());
        let before = format!(
            "picture   {} ({} x {})\n\
             {view}{}{heights}\
             range     {}, {} missing\n\
             rays      {}, {} columns, {} frusta ({} void)\n\
             error     {}\n\
             quality   {}\n\
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
            self.open_s,
            report.prepare_s,
            report.render_s,
        );
        let drawn_on = gpu::drawn_on(report.device.as_deref(), report.left_to_cpu.as_deref());
        let (threads, left_out) = (report.threads, report.left_out.join("; "));
        let ranks = if report.ranks > 1 {
            format!("{} ranks of {threads} threads", report.ranks)
        } else {
            format!("{threads} threads")
        };
        let after = format!(" ({ranks})\ndrawn on  {drawn_on}\nleft out  {left_out}");
        Ok(Said(before, after))
    }
}
