//! One grid, and frames of it.

use super::case::{Case, Light, Setting};
use super::setup::Setup;
use super::{Options, Size, cost};
use crate::io_error;
use crate::peak::Peak;
use crate::sphere::{self, Sphere};
use icoray::{Counts, Frame, FrameReport, Grid, Renderer, Result, Savings, Scene};
use std::time::Instant;

/// Seconds and reports of frames.
type Drawn = Vec<(f64, FrameReport)>;

/// A grid with a field, and who draws them.
pub(super) struct Stage<'o> {
    options: &'o Options,
    size: Size,
    pub sphere: Sphere,
    pub setup: Setup,
    renderers: Vec<Renderer>,
    walkers: Vec<Renderer>,
    /// Reads everything.
    reader: Renderer,
    /// The most memory that a frame takes beyond the model's arrays and the grid, its picture included.
    pub memory: Vec<(Light, u64)>,
}

/// Frames of one scene on one number of threads.
#[derive(Debug, Clone)]
pub(super) struct Row {
    pub size: Size,
    pub cells: usize,
    pub setting: Setting,
    pub threads: usize,
    /// Of all frames from asking to having, rising.
    pub seconds: Vec<f64>,
    /// Of the fastest frame, before the first ray and in the rays.
    pub prepare_s: f64,
    /// See above.
    pub render_s: f64,
    pub counts: Counts,
    /// Frusta that rays crossed, those that they leapt over as well.
    pub crossed: u64,
    /// Bytes that rays read.
    pub bytes: u64,
    /// Bytes of a field, and what is derived of it for a frame.
    pub field_bytes: usize,
    /// See above.
    pub derived_bytes: usize,
}

impl Row {
    pub fn least_s(&self) -> f64 {
        self.seconds[0]
    }

    pub fn median_s(&self) -> f64 {
        self.seconds[self.seconds.len() / 2]
    }

    /// Frusta per second in rays, crossed and read.
    pub fn rates(&self) -> [f64; 2] {
        [self.crossed, self.counts.frusta].map(|frusta| frusta as f64 / self.render_s)
    }
}

impl<'o> Stage<'o> {
    pub fn new(size: Size, options: &'o Options) -> Result<Self> {
        let most = options.threads.iter().copied().max().unwrap_or(0);
        let reader = Renderer::new(most)?.with_savings(Savings { leaps: false, ..Savings::ALL });
        let sphere = reader.run(|| Sphere::new(size.level, size.layers, [1.0, 1.15], sphere::multi_scale))?;
        let renderers = options.renderers()?;
        let times = if options.bare { 1 } else { options.frames };
        let setup = Setup::of(size.level, &sphere.mesh, &renderers, times)?;
        let walkers = options.renderers()?.into_iter().map(Renderer::without_integrals).collect();
        let memory = Vec::new();
        let mut stage = Stage { options, size, sphere, setup, renderers, walkers, reader, memory };
        if !options.bare {
            let of = |light: &Light| Ok((*light, stage.memory_of(*light)?));
            stage.memory = options.lights.iter().map(of).collect::<Result<_>>()?;
        }
        Ok(stage)
    }

    /// What the first frame takes of a transfer function that is nowhere dense and nowhere clear for long.
    fn memory_of(&self, light: Light) -> Result<u64> {
        let lobes = Case::all().find(|case| case.name == "lobes");
        let scene =
            lobes.map(|case| Setting { case, light, tolerance: 1e-3 }.scene(self.options)).transpose()?;
        let grid = self.sphere.grid()?;
        let renderer = Renderer::new(self.reader.threads())?;
        let peak = Peak::start()?;
        scene.map(|scene| self.draw(&renderer, &scene, &grid)).transpose()?;
        peak.bytes()
    }

    /// A row for each number of threads, their frames drawn in turn.
    pub fn rows(&self, grid: &Grid, setting: &Setting) -> Result<Vec<Row>> {
        let renderers = self.of(setting);
        let scene = setting.scene(self.options)?;
        let mut drawn: Vec<Drawn> = renderers.iter().map(|_| Vec::new()).collect();
        let mut last = None;
        for _ in 0..self.options.frames.max(1) {
            for (renderer, drawn) in renderers.iter().zip(&mut drawn) {
                let (seconds, frame) = self.draw(renderer, &scene, grid)?;
                drawn.push((seconds, frame.report.clone()));
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

    /// Draws so many frames, and gives the frusta of the last one.
    pub fn frusta(&self, setting: &Setting, frames: usize) -> Result<u64> {
        let (scene, grid) = (setting.scene(self.options)?, self.sphere.grid()?);
        let mut frusta = 0;
        for _ in 0..frames {
            let (_, frame) = self.draw(&self.of(setting)[0], &scene, &grid)?;
            frusta = frame.report.counts.frusta;
        }
        Ok(frusta)
    }

    /// The renderers, one for each number of threads.
    fn of(&self, setting: &Setting) -> &[Renderer] {
        if setting.case.integrates { &self.renderers } else { &self.walkers }
    }

    fn draw(&self, renderer: &Renderer, scene: &Scene, grid: &Grid) -> Result<(f64, Frame)> {
        // A new one, that nothing is known of.
        let field = self.sphere.field()?;
        let start = Instant::now();
        let frame = renderer.render(scene, grid, &self.sphere.layers, &field)?;
        Ok((start.elapsed().as_secs_f64(), frame))
    }

    /// Frusta that the scene's rays would read if they leapt over none.
    fn crossed(&self, setting: &Setting, grid: &Grid) -> Result<u64> {
        let scene = Setting { light: Light::Unlit, ..*setting }.scene(self.options)?;
        Ok(self.draw(&self.reader, &scene, grid)?.1.report.counts.frusta)
    }

    fn row(&self, setting: &Setting, grid: &Grid, crossed: u64, mut drawn: Drawn) -> Row {
        drawn.sort_by(|a, b| a.0.total_cmp(&b.0));
        let report = &drawn[0].1;
        let counts = report.counts;
        Row {
            size: self.size,
            cells: grid.cells(),
            setting: *setting,
            threads: report.threads,
            seconds: drawn.iter().map(|drawn| drawn.0).collect(),
            prepare_s: report.prepare_s,
            render_s: report.render_s,
            counts,
            crossed: crossed.max(counts.frusta),
            bytes: cost::bytes(&counts, crossed > counts.frusta, setting.light == Light::Lit),
            field_bytes: size_of_val(self.sphere.values.as_slice()),
            derived_bytes: report.derived_bytes,
        }
    }

    fn keep(&self, setting: &Setting, frame: &Frame) -> Result<()> {
        let name =
            format!("{}_{}_{}_{:e}.png", self.size, setting.case.name, setting.light, setting.tolerance);
        let path = self.options.out.join(name);
        icoray::output::write_picture(&path, frame).map(drop).map_err(|e| io_error(&path, e))
    }
}
