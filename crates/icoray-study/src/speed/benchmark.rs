//! Frames of one grid.

use super::options::{Case, Light, Options, Setting, Size};
use crate::peak::PeakMemory;
use crate::results::{io_error, timed};
use icoray::{
    Counts, Field, Fields, Frame, FrameReport, Grid, IcosahedralMesh, Location, Plan, Renderer, Result, Savings, Scene,
};
use icoray_reference::sphere::{Sphere, multi_scale};
use std::time::Instant;

/// A frame's report, and its seconds from end to end.
struct TimedFrame {
    seconds: f64,
    report: FrameReport,
}

/// Bytes that a frame takes beyond the model's arrays and the checked grid, its picture included.
#[derive(Debug, Clone, Copy)]
pub(super) struct Memory {
    pub size: Size,
    pub light: Light,
    /// At the peak.
    pub measured: u64,
    /// By the plan.
    pub planned: u64,
}

/// A grid with a field, and the renderers.
pub(super) struct Benchmark<'o> {
    options: &'o Options,
    size: Size,
    pub sphere: Sphere,
    /// Heights of the layers over each cell, if they are native, level-fastest.
    heights: Vec<f64>,
    pub setup: Setup,
    renderers: Vec<Renderer>,
    walkers: Vec<Renderer>,
    /// A renderer without empty-space skipping.
    reader: Renderer,
    /// Memory of first frames.
    pub memory: Vec<Memory>,
}

/// Frames of one scene on one number of threads.
pub(super) struct Row {
    pub size: Size,
    pub cells: usize,
    pub setting: Setting,
    /// Seconds of all frames from end to end, rising.
    pub seconds: Vec<f64>,
    /// The report of the fastest frame.
    pub report: FrameReport,
    /// Frusta that rays crossed, with the skipped ones.
    pub crossed: u64,
    /// Bytes that rays read.
    pub bytes: u64,
    pub field_bytes: usize,
}

impl Row {
    pub fn least_s(&self) -> f64 {
        self.seconds[0]
    }

    pub fn median_s(&self) -> f64 {
        self.seconds[self.seconds.len() / 2]
    }

    /// Pieces and frusta that rays in packets left to scalar code, in percent of the frusta that were read.
    pub fn scalar_percent(&self) -> f64 {
        100.0 * self.report.counts.scalar_pieces as f64 / self.report.counts.frusta.max(1) as f64
    }

    /// Frusta per second in rays, crossed and read.
    pub fn rates(&self) -> [f64; 2] {
        [self.crossed, self.report.counts.frusta].map(|frusta| frusta as f64 / self.report.timing.render_s)
    }
}

impl<'o> Benchmark<'o> {
    pub fn new(size: Size, options: &'o Options) -> Result<Self> {
        let max = options.threads.iter().copied().max().unwrap_or(0);
        let reader = Renderer::new(max)?.with_savings(Savings { empty_space: false, ..Savings::ALL });
        let sphere = reader.run(|| Sphere::new(size.level, size.layers, [1.0, 1.15], multi_scale))?;
        let renderers = options.renderers()?;
        let times = if options.bare { 1 } else { options.frames };
        let setup = Setup::of(size.level, &sphere.mesh, &renderers, times)?;
        let walkers = options.renderers()?.into_iter().map(Renderer::without_integrals).collect();
        let memory = Vec::new();
        let heights = if options.is_native() { sphere.terrain() } else { Vec::new() };
        let mut benchmark = Benchmark { options, size, sphere, heights, setup, renderers, walkers, reader, memory };
        if !options.bare {
            let memory = options.lights.iter().map(|light| benchmark.memory_of(*light));
            benchmark.memory = memory.collect::<Result<_>>()?;
        }
        Ok(benchmark)
    }

    /// Memory of the first frame, with the transfer function "lobes".
    fn memory_of(&self, light: Light) -> Result<Memory> {
        let lobes = Case::all().find(|case| case.name == "lobes").expect("there is such a transfer function");
        let scene = Setting { case: lobes, light, tolerance: 1e-3 }.scene(self.options)?;
        let (grid, field) = (self.sphere.grid()?, self.sphere.field()?);
        let renderer = Renderer::new(self.reader.threads())?;
        let plan = Plan::new(&scene, &grid, &self.sphere.layers, &field)?;
        let planned = renderer.run(|| plan.memory(&scene, &grid));
        let peak = PeakMemory::start()?;
        self.draw(&renderer, &scene, &grid)?;
        let (size, planned) = (self.size, planned.total() - planned.grid);
        Ok(Memory { size, light, measured: peak.bytes()?, planned })
    }

    /// A row for each number of threads, with alternating frames.
    pub fn rows(&self, grid: &Grid, setting: &Setting) -> Result<Vec<Row>> {
        let renderers = self.of(setting);
        let scene = setting.scene(self.options)?;
        let mut drawn: Vec<Vec<TimedFrame>> = renderers.iter().map(|_| Vec::new()).collect();
        let mut last = None;
        for _ in 0..self.options.frames.max(1) {
            for (renderer, drawn) in renderers.iter().zip(&mut drawn) {
                let (seconds, frame) = self.draw(renderer, &scene, grid)?;
                drawn.push(TimedFrame { seconds, report: frame.report.clone() });
                last = Some(frame);
            }
        }
        let mut crossed = 0;
        if let (true, Some(frame)) = (setting.case.integrates, last) {
            self.keep(setting, &frame)?;
            crossed = self.crossed(setting, grid)?;
        }
        Ok(drawn.into_iter().map(|drawn| self.row(setting, grid, crossed, drawn)).collect())
    }

    /// The renderers, one for each number of threads.
    pub fn of(&self, setting: &Setting) -> &[Renderer] {
        if setting.case.integrates { &self.renderers } else { &self.walkers }
    }

    pub fn draw(&self, renderer: &Renderer, scene: &Scene, grid: &Grid) -> Result<(f64, Frame)> {
        // A new field, so that nothing derived from it is cached.
        let field = self.sphere.field()?;
        let mut fields = Fields::from(&field);
        if self.options.is_native() {
            fields = fields.with_heights(Field::level_fastest(&self.heights, self.size.layers, Location::Center)?);
        }
        timed(renderer, scene, grid, &self.sphere.layers, fields)
    }

    /// Number of frusta that the rays read without empty-space skipping.
    fn crossed(&self, setting: &Setting, grid: &Grid) -> Result<u64> {
        let scene = Setting { light: Light::Unlit, ..*setting }.scene(self.options)?;
        Ok(self.draw(&self.reader, &scene, grid)?.1.report.counts.frusta)
    }

    fn row(&self, setting: &Setting, grid: &Grid, crossed: u64, mut drawn: Vec<TimedFrame>) -> Row {
        drawn.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        let seconds = drawn.iter().map(|drawn| drawn.seconds).collect();
        let report = drawn.swap_remove(0).report;
        let counts = &report.counts;
        Row {
            size: self.size,
            cells: grid.cells(),
            setting: *setting,
            seconds,
            crossed: crossed.max(counts.frusta),
            bytes: bytes_read(counts, crossed > counts.frusta, if setting.light == Light::Lit { PACKED } else { 0 }),
            field_bytes: size_of_val(self.sphere.values.as_slice()),
            report,
        }
    }

    fn keep(&self, setting: &Setting, frame: &Frame) -> Result<()> {
        let name = format!("{}_{}_{}_{:e}.png", self.size, setting.case.name, setting.light, setting.tolerance);
        let path = self.options.out.join(name);
        icoray::output::write_picture(&path, frame).map(drop).map_err(|e| io_error(&path, e))
    }
}

#[derive(Debug, Clone)]
pub(super) struct Setup {
    pub level: u32,
    pub cells: usize,
    pub triangles: usize,
    /// The minimum for each number of threads.
    pub seconds: Vec<f64>,
    /// Memory of the grid beside the model's tables, as it reports.
    pub derived_bytes: usize,
}

impl Setup {
    pub fn of(level: u32, mesh: &IcosahedralMesh, renderers: &[Renderer], times: usize) -> Result<Self> {
        let mut seconds = vec![f64::INFINITY; renderers.len()];
        let mut derived_bytes = 0;
        for _ in 0..times.max(1) {
            for (renderer, min) in renderers.iter().zip(&mut seconds) {
                let start = Instant::now();
                let grid = renderer.run(|| Grid::new(mesh.tables()))?;
                *min = min.min(start.elapsed().as_secs_f64());
                derived_bytes = grid.derived_bytes();
            }
        }
        let (cells, triangles) = (mesh.cells(), mesh.tables().corners());
        Ok(Setup { level, cells, triangles, seconds, derived_bytes })
    }

    /// Seconds, one number of threads after the other.
    pub fn times(&self) -> String {
        let times: Vec<_> = self.seconds.iter().map(|min| format!("{min:.3}")).collect();
        times.join(", ")
    }
}

/// Of the next triangle: its number, its row of `corner_cell`, its new vertex' direction.
const COLUMN: u64 = 4 + 12 + 24;
/// Occupancy over a triangle, where there is empty space to skip.
const BLOCKS: u64 = 4;
/// Values of three cells on one layer, of 4 bytes.
const VALUES: u64 = 12;
/// A gradient at a vertex, packed.
pub(crate) const PACKED: u64 = 8;

/// Bytes that rays read of tables and field; `empty_space` if they skip it, with a gradient of so many bytes at each
/// vertex.
///
/// Counted by hand in the kernel and multiplied by the numbers of columns and frusta. All reads count, including those
/// that caches serve. Data that all rays share (layers, transfer function) and the preparation of frames do not count.
pub(crate) fn bytes_read(counts: &Counts, empty_space: bool, gradient: u64) -> u64 {
    let column = COLUMN + if empty_space { BLOCKS } else { 0 };
    // A frustum reads the layer behind it and the one ahead.
    let layers = 2 * counts.frusta;
    counts.columns * column + layers * (VALUES + 3 * gradient)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_frusta_blocks_and_light_are_paid_for() {
        let of = |columns, frusta, empty_space, gradient| {
            bytes_read(&Counts { columns, frusta, ..Counts::default() }, empty_space, gradient)
        };
        assert_eq!(of(3, 0, false, 0), 3 * 40);
        assert_eq!(of(3, 0, true, 0), 3 * 44);
        assert_eq!(of(3, 5, false, 0), 3 * 40 + 10 * 12);
        assert_eq!(of(3, 2, false, PACKED), 3 * 40 + 4 * 36);
    }
}
