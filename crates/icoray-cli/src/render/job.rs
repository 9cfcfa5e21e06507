//! What the pictures of one run share, and one of them.

use super::due::Inputs;
use super::press::Said;
use super::subject::Subjects;
use super::target::Target;
use crate::gpu;
use crate::input;
use icoray::output::Stamp;
use icoray::{Frame, Grid, Ranks, Rendered, Renderer, Result, Shot};

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
    /// Draws a shot, together with the other ranks. At rank 0 the frame, and what is to be said of it; `read_s` is the
    /// seconds that reading took.
    pub fn picture(
        &self,
        shot: &Shot,
        stamp: &Stamp,
        inputs: &Inputs,
        read_s: f64,
        ranks: &mut Ranks,
    ) -> Result<Option<(Frame, Said)>> {
        let scene = &shot.scene;
        let layers = self.subjects.layers(scene);
        let rendered = self.renderer.render_over(ranks, scene, self.grid, None, layers, inputs.of(scene))?;
        let Rendered::Here(mut frame) = rendered else { return Ok(None) };
        for info in self.subjects.infos(scene)? {
            if info.name == scene.field {
                frame.description = info.description.clone();
            } else {
                frame.descriptions.push((info.name.clone(), info.description.clone()));
            }
        }
        frame.notes.extend(self.subjects.notes(scene).map(|note| ("note", note.clone())));
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
        let (infos, layers) = (self.subjects.infos(scene)?, self.subjects.count(scene));
        let view = if shot.name.is_empty() { String::new() } else { format!("view      {}\n", shot.name) };
        let fields: Vec<String> = infos
            .iter()
            .map(|info| {
                let (name, place) = (&info.name, input::place(info.location));
                format!("field     {name} at {place}, {layers} layers, time {} ({date})\n", stamp.step)
            })
            .collect();
        let units = infos.first().and_then(|info| info.description.units.as_deref());
        let before = format!(
            "picture   {} ({} x {})\n\
             {view}{}\
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
