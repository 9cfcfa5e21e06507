//! Renders one picture on GPU and CPU.

use super::cost::Cost;
use crate::scenes::multi_scale::{self, Opacity};
use icoray::{Field, Frame, FrameReport, Grid, Layers, Renderer, Result, Scene};
use icoray_gpu::Peaks;
use icoray_reference::comparison::Comparison;
use std::time::Instant;

/// The pictures of one size, light and tolerance, one for each transfer function.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setting {
    pub size: (u32, u32),
    pub is_lit: bool,
    pub tolerance: f64,
}

impl Setting {
    pub fn scene(&self, opacity: Opacity) -> Result<Scene> {
        let light = if self.is_lit { multi_scale::HEADLIGHT } else { "" };
        let (width, height) = self.size;
        let rest = format!("tolerance = {:e}", self.tolerance);
        Ok(Scene { width, height, ..multi_scale::scene(width, opacity, &rest, light)? })
    }

    pub fn light(&self) -> &'static str {
        if self.is_lit { "lit" } else { "unlit" }
    }
}

/// Model and renderers of all pictures.
pub(super) struct Benchmark<'a> {
    pub grid: &'a Grid<'a>,
    pub layers: &'a Layers,
    /// Two fields that differ in the last bit of a value. Frames alternate between them, so that each uploads its
    /// field.
    pub fields: [Field<'a>; 2],
    pub gpu: Renderer,
    pub cpu: Renderer,
    pub frames: usize,
    pub peaks: Peaks,
}

/// Measurements of a picture.
#[derive(Debug, Clone)]
pub(super) struct Row {
    pub setting: Setting,
    pub transfer: &'static str,
    /// Measurements on the GPU, or the reason why it did not render.
    pub gpu: std::result::Result<OnGpu, String>,
    /// Seconds on the CPU from end to end.
    pub cpu_s: f64,
}

/// A picture on the GPU.
#[derive(Debug, Clone)]
pub(super) struct OnGpu {
    pub report: FrameReport,
    /// Seconds from end to end.
    pub end_s: f64,
    pub cost: Cost,
    /// Difference from the CPU's picture.
    pub difference: Comparison,
}

impl OnGpu {
    /// Seconds in rays by the device's clock, or else from the first ray to the last pixel.
    pub fn device_s(&self) -> f64 {
        device_s(&self.report)
    }

    /// Frusta per second on the device.
    pub fn rate(&self) -> f64 {
        self.report.counts.frusta as f64 / self.device_s()
    }

    /// Bytes per second that were uploaded.
    pub fn upload(&self) -> f64 {
        self.report.device.bytes_uploaded as f64 / self.report.device.upload_s
    }
}

impl Benchmark<'_> {
    pub fn row(&self, setting: &Setting, transfer: &'static str, opacity: Opacity) -> Result<Row> {
        let scene = setting.scene(opacity)?;
        let drawn = self.best(&scene)?;
        let (truth, cpu_s) = self.draw(&self.cpu, &scene, 0)?;
        let gpu = drawn.map(|(frame, end_s)| OnGpu {
            end_s,
            cost: Cost::of(&frame.report, frame.pixels.len() as u64, setting.is_lit),
            difference: Comparison::new(&frame.pixels, &truth.pixels),
            report: frame.report,
        });
        Ok(Row { setting: *setting, transfer, gpu, cpu_s })
    }

    /// The GPU's fastest frame with its seconds from end to end, or the reason why there is none.
    fn best(&self, scene: &Scene) -> Result<std::result::Result<(Frame, f64), String>> {
        // The first frame compiles the shader and uploads the grid.
        let (first, _) = self.draw(&self.gpu, scene, 0)?;
        if let Some(reason) = first.report.device.left_to_cpu {
            return Ok(Err(reason));
        }
        let mut best = self.draw(&self.gpu, scene, 1)?;
        for i in 1..self.frames {
            let next = self.draw(&self.gpu, scene, i + 1)?;
            if device_s(&next.0.report) < device_s(&best.0.report) {
                best = next;
            }
        }
        let reason = best.0.report.device.left_to_cpu.clone();
        Ok(reason.map_or(Ok(best), Err))
    }

    fn draw(&self, renderer: &Renderer, scene: &Scene, frame: usize) -> Result<(Frame, f64)> {
        let start = Instant::now();
        let frame = renderer.render(scene, self.grid, self.layers, &self.fields[frame % 2])?;
        Ok((frame, start.elapsed().as_secs_f64()))
    }
}

fn device_s(report: &FrameReport) -> f64 {
    report.device.device_s.unwrap_or(report.timing.render_s - report.device.upload_s)
}
