//! A renderer's row of the table.

use super::options::Options;
use icoray_reference::comparison::Comparison;

pub(super) const OURS: &str = "icoray";

/// Cost and error of a renderer's picture.
#[derive(Debug, Clone)]
pub(super) struct Row {
    pub level: u32,
    pub transfer: &'static str,
    pub renderer: String,
    pub seconds: Seconds,
    /// Peak bytes beyond the model's arrays.
    pub memory: u64,
    /// Bytes that icoray derived from grid and field, which is all memory that grows with these; unknown for other
    /// renderers.
    pub derived: Option<u64>,
    pub wedges: u64,
    pub comparison: Comparison,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Seconds {
    /// Preparation before the first ray.
    pub prepare: f64,
    /// The first frame, in which VTK sorts and splits cells.
    pub first: f64,
    /// A later frame of the same values, and one of new values.
    pub frame: f64,
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

pub(super) const COLUMNS: &str = "level,layers,transfer,renderer,prepare_s,first_frame_s,frame_s,step_frame_s,\
    memory_bytes,wedges,rmse,max_error";

impl Row {
    pub fn line(&self) -> String {
        let seconds = self.seconds.all().map(|s| format!("{s:.3}")).join(" | ");
        format!(
            "| {} | {} | {} | {seconds} | {:.1} | {:.1e} | {:.3} |",
            self.level,
            self.transfer,
            self.renderer,
            self.memory as f64 / f64::from(1 << 20),
            self.comparison.rmse,
            self.comparison.max,
        )
    }

    pub fn cells(&self, options: &Options) -> Vec<String> {
        let mut cells = vec![self.level.to_string(), options.layers.to_string()];
        cells.extend([self.transfer.to_owned(), self.renderer.clone()]);
        cells.extend(self.seconds.all().map(|s| format!("{s:.6}")));
        cells.extend([self.memory, self.wedges].map(|n| n.to_string()));
        cells.extend([self.comparison.rmse, self.comparison.max].map(|d| format!("{d:.6e}")));
        cells
    }
}
