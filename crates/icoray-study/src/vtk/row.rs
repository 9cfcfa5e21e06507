//! A renderer's row of the table.

use super::Options;
use crate::compare::Comparison;

pub(super) const OURS: &str = "icoray";

/// What a renderer took for a picture, and how far that is from the right one.
#[derive(Debug, Clone)]
pub(super) struct Row {
    pub level: u32,
    pub transfer: &'static str,
    pub renderer: String,
    pub seconds: Seconds,
    /// Most bytes at any time beyond the model's arrays.
    pub memory: u64,
    /// What icoray says that it derived of grid and field, which is all that grows with them; nobody else says so.
    pub derived: Option<u64>,
    pub wedges: u64,
    pub far: Comparison,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Seconds {
    /// Until rays can start.
    pub prepare: f64,
    /// Of the first frame, which VTK's sorts and splits in.
    pub first: f64,
    /// Of a later one, of the same values and of others.
    pub frame: f64,
    /// See above.
    pub step: f64,
}

impl Seconds {
    pub fn all(&self) -> [f64; 4] {
        [self.prepare, self.first, self.frame, self.step]
    }
}

pub(super) const HEAD: [&str; 2] = [
    "| n | transfer | renderer | prepare s | first frame s | frame s | frame of new values s | memory MiB | RMSE | max |",
    "|---|---|---|---|---|---|---|---|---|---|",
];

pub(super) const COLUMNS: [&str; 12] = [
    "level",
    "layers",
    "transfer",
    "renderer",
    "prepare_s",
    "first_frame_s",
    "frame_s",
    "step_frame_s",
    "memory_bytes",
    "wedges",
    "rmse",
    "max_error",
];

impl Row {
    pub fn line(&self) -> String {
        let seconds = self.seconds.all().map(|s| format!("{s:.3}")).join(" | ");
        format!(
            "| {} | {} | {} | {seconds} | {:.1} | {:.1e} | {:.3} |",
            self.level,
            self.transfer,
            self.renderer,
            self.memory as f64 / f64::from(1 << 20),
            self.far.rmse,
            self.far.max,
        )
    }

    pub fn cells(&self, options: &Options) -> Vec<String> {
        let mut cells = vec![self.level.to_string(), options.layers.to_string()];
        cells.extend([self.transfer.to_owned(), self.renderer.clone()]);
        cells.extend(self.seconds.all().map(|s| format!("{s:.6}")));
        cells.extend([self.memory, self.wedges].map(|n| n.to_string()));
        cells.extend([self.far.rmse, self.far.max].map(|d| format!("{d:.6e}")));
        cells
    }
}
