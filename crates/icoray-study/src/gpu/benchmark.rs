//! Renders one picture on GPU and CPU.

use crate::results::timed;
use crate::scenes::multi_scale::{self, Opacity};
use icoray::{Error, ErrorKind, Field, Frame, FrameReport, Grid, Layers, Renderer, Result, Scene};
use icoray_gpu::Peaks;
use icoray_reference::comparison::Comparison;
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

/// A picture of the GPU.
pub(super) struct Row {
    pub setting: Setting,
    pub transfer: &'static str,
    pub report: FrameReport,
    /// Seconds from end to end, and those of the CPU's picture.
    pub end_s: f64,
    pub cpu_s: f64,
    pub cost: Cost,
    /// Difference from the CPU's picture.
    pub difference: Comparison,
}

impl Row {
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
        let (end_s, frame) = self.best(&scene)?;
        let (cpu_s, truth) = self.draw(&self.cpu, &scene, 0)?;
        let cost = Cost::of(&frame.report, frame.pixels.len() as u64, setting.is_lit);
        let difference = Comparison::new(&frame.pixels, &truth.pixels);
        Ok(Row { setting: *setting, transfer, report: frame.report, end_s, cpu_s, cost, difference })
    }

    /// The GPU's fastest frame with its seconds from end to end.
    fn best(&self, scene: &Scene) -> Result<(f64, Frame)> {
        let draw = |frame: usize| {
            let drawn = self.draw(&self.gpu, scene, frame)?;
            let Some(reason) = &drawn.1.report.device.left_to_cpu else { return Ok(drawn) };
            let context = format!("{} x {} pixels are left to the CPU: {reason}", scene.width, scene.height);
            Err(Error::new(ErrorKind::Unsupported, context))
        };
        // The first frame compiles the shader and uploads the grid.
        draw(0)?;
        let mut best = draw(1)?;
        for i in 1..self.frames {
            let next = draw(i + 1)?;
            if device_s(&next.1.report) < device_s(&best.1.report) {
                best = next;
            }
        }
        Ok(best)
    }

    fn draw(&self, renderer: &Renderer, scene: &Scene, frame: usize) -> Result<(f64, Frame)> {
        timed(renderer, scene, self.grid, self.layers, &self.fields[frame % 2])
    }
}

fn device_s(report: &FrameReport) -> f64 {
    report.device.device_s.unwrap_or(report.timing.render_s - report.device.upload_s)
}

/// Orientation, neighbour, cells of the next triangle, its new vertex' direction; values of three cells at the ray's
/// first layer.
const COLUMN_BYTES: u64 = 4 + 4 + 12 + 24 + 12;
/// Values of three cells at the next layer.
const FRUSTUM_BYTES: u64 = 12;
/// Gradients of three vertices, wherever values are read.
const GRADIENT_BYTES: u64 = 36;
/// Output of a pixel's ray.
const PIXEL_BYTES: u64 = 44;

/// In double-float, where a sum is 20 operations, a product 24 and a quotient 110: the new vertex seen from the ray's
/// plane 336, the side crossed 258, whether the ray ends 68, distance 134, height 246; in f32 the first chord 45.
const COLUMN_FLOPS: u64 = 336 + 258 + 68 + 134 + 246 + 45;
/// The next layer, chord and segment 45; its span 9; knots, error bounds and rounding 33; terms of the integral 40;
/// absorption, bound and integral of a thin piece 81; light over light 16. Clear frusta end after 54.
const FRUSTUM_FLOPS: u64 = 45 + 9 + 33 + 40 + 81 + 16;

/// Cost of a frame on a device: bytes that its rays read and write, and operations in f32.
///
/// Counted by hand in `shaders/kernel`, along the usual path of rays, and multiplied by the numbers of columns and
/// frusta. All reads count, including those that caches serve. Data that all rays share (layers, transfer function) do
/// not count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cost {
    pub bytes: f64,
    /// Of unlit rays: operations of lighting are not counted.
    pub flops: f64,
}

impl Cost {
    pub fn of(report: &FrameReport, pixels: u64, is_lit: bool) -> Self {
        let counts = &report.counts;
        let gradients = if is_lit { GRADIENT_BYTES } else { 0 };
        let bytes = counts.columns * (COLUMN_BYTES + gradients)
            + counts.frusta * (FRUSTUM_BYTES + gradients)
            + pixels * PIXEL_BYTES;
        let flops = counts.columns * COLUMN_FLOPS + counts.frusta * FRUSTUM_FLOPS;
        Cost { bytes: bytes as f64, flops: flops as f64 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray::Counts;

    #[test]
    fn rays_pay_for_columns_frusta_and_light() {
        let of = |columns, frusta, pixels, is_lit| {
            let counts = Counts { columns, frusta, ..Counts::default() };
            Cost::of(&FrameReport { counts, ..FrameReport::default() }, pixels, is_lit)
        };
        assert_eq!(of(1, 0, 0, false), Cost { bytes: 56.0, flops: 1087.0 });
        assert_eq!(of(0, 1, 0, false), Cost { bytes: 12.0, flops: 224.0 });
        assert_eq!(of(0, 1, 0, true), Cost { bytes: 48.0, flops: 224.0 });
        assert_eq!(of(2, 3, 5, false).bytes, 112.0 + 36.0 + 220.0);
    }
}
