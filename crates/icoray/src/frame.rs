//! A rendered picture with what it cost.

pub use crate::kernel::ray::Counts;
use crate::output::Stamp;

/// What a frame cost and what it met.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrameReport {
    /// Seconds before the first ray: value range, averages of corner fields, gradients.
    pub prepare_s: f64,
    /// Seconds in the rays.
    pub render_s: f64,
    /// Seconds of encoding and disk.
    pub write_s: f64,
    /// Rays, columns, frusta.
    pub counts: Counts,
    /// Least and greatest value of the field, `None` when all are missing.
    pub value_range: Option<[f64; 2]>,
    /// Values that are NaN, infinite or the fill value.
    pub missing_values: u64,
    /// Bytes that were derived from the field: averages of corner fields, gradients.
    pub derived_bytes: usize,
    /// What the plan left out, in words.
    pub left_out: Vec<String>,
}

/// A picture: premultiplied linear RGBA, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width · height` pixels, premultiplied linear RGBA.
    pub pixels: Vec<[f32; 4]>,
    /// Name of the field that is shown.
    pub field: String,
    /// Camera and transfer range in words.
    pub notes: Vec<(&'static str, String)>,
    /// When the frame was; set when it is written.
    pub stamp: Stamp,
    /// What it cost.
    pub report: FrameReport,
}

impl Frame {
    /// Keys and texts that a picture file carries: step, time, field, range, camera, version.
    pub fn describe(&self) -> Vec<(String, String)> {
        let range = self
            .report
            .value_range
            .map_or_else(|| "no values".into(), |[low, high]| format!("{low} to {high}"));
        let mut lines = vec![
            ("Software".into(), format!("icoray {}", env!("CARGO_PKG_VERSION"))),
            ("step".into(), self.stamp.step.to_string()),
            ("time_s".into(), self.stamp.time_s.to_string()),
            ("field".into(), self.field.clone()),
            ("field range".into(), range),
        ];
        lines.extend(self.stamp.date.iter().map(|date| ("date".into(), date.clone())));
        lines.extend(self.notes.iter().map(|(key, text)| ((*key).to_string(), text.clone())));
        lines
    }
}
