//! One picture, on both.

use super::cost::Cost;
use super::{Setting, Stage};
use crate::compare::Comparison;
use crate::scenes::multi_scale::Opacity;
use icoray::{Frame, Renderer, Result, Scene};
use std::time::Instant;

/// A picture's seconds.
#[derive(Debug, Clone)]
pub(super) struct Row {
    pub setting: Setting,
    pub transfer: &'static str,
    /// On the GPU, or why not.
    pub gpu: std::result::Result<OnGpu, String>,
    /// Seconds on the CPU from end to end.
    pub cpu_s: f64,
}

/// A picture on the GPU.
#[derive(Debug, Clone)]
pub(super) struct OnGpu {
    /// Seconds in rays by the device's clock; without one from the first ray to the last pixel.
    pub device_s: f64,
    /// Whether that is the device's clock.
    pub is_timed: bool,
    pub prepare_s: f64,
    pub upload_s: f64,
    pub bytes_uploaded: u64,
    /// Seconds from asking for the picture to having it.
    pub end_s: f64,
    pub columns: u64,
    pub frusta: u64,
    pub cost: Cost,
    /// How far it is from the CPU's picture, root-mean-square and at most.
    pub rmse: f64,
    /// See above.
    pub max: f64,
}

impl OnGpu {
    /// Frusta per second on the device.
    pub fn rate(&self) -> f64 {
        self.frusta as f64 / self.device_s
    }

    /// Bytes per second that were uploaded.
    pub fn upload(&self) -> f64 {
        self.bytes_uploaded as f64 / self.upload_s
    }
}

impl Stage<'_> {
    pub fn row(&self, setting: &Setting, transfer: &'static str, opacity: Opacity) -> Result<Row> {
        let scene = setting.scene(opacity)?;
        let drawn = self.best(&scene)?;
        let (truth, cpu_s) = self.draw(&self.cpu, &scene, 0)?;
        let gpu = drawn.map(|(frame, end_s)| on_gpu(&frame, end_s, &truth, setting.is_lit));
        Ok(Row { setting: *setting, transfer, gpu, cpu_s })
    }

    /// The fastest frame of the GPU with its seconds from end to end, or why there is none.
    fn best(&self, scene: &Scene) -> Result<std::result::Result<(Frame, f64), String>> {
        // The first frame compiles the shader and uploads the grid.
        let (first, _) = self.draw(&self.gpu, scene, 0)?;
        if let Some(reason) = first.report.left_to_cpu {
            return Ok(Err(reason));
        }
        let mut best = self.draw(&self.gpu, scene, 1)?;
        for i in 1..self.frames {
            let next = self.draw(&self.gpu, scene, i + 1)?;
            if seconds(&next.0) < seconds(&best.0) {
                best = next;
            }
        }
        let reason = best.0.report.left_to_cpu.clone();
        Ok(reason.map_or(Ok(best), Err))
    }

    fn draw(&self, renderer: &Renderer, scene: &Scene, frame: usize) -> Result<(Frame, f64)> {
        let start = Instant::now();
        let frame = renderer.render(scene, self.grid, self.layers, &self.fields[frame % 2])?;
        Ok((frame, start.elapsed().as_secs_f64()))
    }
}

/// Seconds in rays.
fn seconds(frame: &Frame) -> f64 {
    let report = &frame.report;
    report.device_s.unwrap_or(report.render_s - report.upload_s)
}

fn on_gpu(frame: &Frame, end_s: f64, truth: &Frame, is_lit: bool) -> OnGpu {
    let report = &frame.report;
    let truth: Vec<[f64; 4]> = truth.pixels.iter().map(|pixel| pixel.map(f64::from)).collect();
    let Comparison { rmse, max, .. } = Comparison::new(&frame.pixels, &truth);
    OnGpu {
        device_s: seconds(frame),
        is_timed: report.device_s.is_some(),
        prepare_s: report.prepare_s,
        upload_s: report.upload_s,
        bytes_uploaded: report.bytes_uploaded,
        end_s,
        columns: report.counts.columns,
        frusta: report.counts.frusta,
        cost: Cost::of(report, frame.pixels.len() as u64, is_lit),
        rmse,
        max,
    }
}
