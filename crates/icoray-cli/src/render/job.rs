//! What the pictures of one run share, and one of them.

use super::press::Said;
use super::target::Target;
use crate::gpu;
use crate::input::{self, Wanted};
use icoray::output::Stamp;
use icoray::{Frame, Grid, Layers, Location, Ranks, Rendered, Renderer, Result, Scene};
use icoray_netcdf::{FieldInfo, LayerHeights, ModelFile};
use std::time::Instant;

/// All that the pictures of one run share.
pub struct Job<'a> {
    pub scene: &'a Scene,
    pub file: &'a ModelFile,
    pub info: &'a FieldInfo,
    pub wanted: &'a Wanted,
    pub grid: &'a Grid<'a>,
    pub layers: &'a Layers,
    pub renderer: &'a Renderer,
    pub target: &'a Target,
    /// What is said of every picture, in its file too.
    pub notes: &'a [String],
    /// Seconds until the first picture was begun.
    pub open_s: f64,
}

/// When record `time` was. Files give a date; seconds since the start are not made of it, since that would need the
/// run's calendar.
pub fn stamp(file: &ModelFile, time: usize) -> Stamp {
    Stamp { step: time as i64, time_s: 0.0, date: file.times()[time].clone() }
}

/// What is not drawn as the file has it.
pub fn notes(info: &FieldInfo, layers: &Layers, grid: &Grid, heights: &LayerHeights) -> Vec<String> {
    let mut notes = Vec::new();
    if info.location == Location::Corner {
        let bytes = grid.cells() * layers.count() * info.precision.bytes();
        notes.push(format!(
            "{} lives on corners: averaged to cell centres (derived, {bytes} bytes)",
            info.name
        ));
    }
    if let Some(deviation_m) = heights.deviation_m.filter(|deviation| *deviation > 0.0) {
        notes.push(format!(
            "concentric mean heights are rendered; columns deviate by up to {deviation_m:.1} m"
        ));
    }
    if heights.is_of_pressure {
        let name = &heights.variable;
        notes.push(format!("{name} gives pressures: rendered at the heights of the standard atmosphere"));
    }
    notes
}

impl Job<'_> {
    /// Draws record `time`, together with the other ranks. At rank 0 the frame, when it is, and what is to be said of it.
    pub fn picture(&self, time: usize, ranks: &mut Ranks) -> Result<Option<(Frame, Stamp, Said)>> {
        let start = Instant::now();
        let owned = ranks.together(self.wanted.read(self.file, self.info, time))?;
        let read_s = start.elapsed().as_secs_f64();
        let field = owned.field()?;
        let rendered = self.renderer.render_over(ranks, self.scene, self.grid, None, self.layers, &field)?;
        let Rendered::Here(mut frame) = rendered else { return Ok(None) };
        frame.description = self.info.description.clone();
        frame.notes.extend(self.notes.iter().map(|note| ("note", note.clone())));
        let stamp = stamp(self.file, time);
        let said = self.said(&frame, &stamp, read_s)?;
        Ok(Some((frame, stamp, said)))
    }

    fn said(&self, frame: &Frame, stamp: &Stamp, read_s: f64) -> Result<Said> {
        let date = stamp.date.as_deref().unwrap_or("no date");
        let path = self.target.path(&self.scene.output, stamp, &self.scene.field)?;
        let (info, report, counts) = (self.info, &frame.report, &frame.report.counts);
        let layers = self.layers.count();
        let before = format!(
            "picture   {} ({} x {})\n\
             field     {} at {}, {layers} layers, time {} ({date})\n\
             range     {}, {} missing\n\
             rays      {}, {} columns, {} frusta ({} void)\n\
             error     {}\n\
             quality   {}\n\
             seconds   open {:.3}, read {read_s:.3}, prepare {:.3}, render {:.3}, write ",
            path.display(),
            frame.width,
            frame.height,
            info.name,
            input::place(info.location),
            stamp.step,
            input::range(report.value_range, info.description.units.as_deref()),
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
