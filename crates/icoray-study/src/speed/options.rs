//! The options of `icoray-study speed`, and the scenes that they select.

use crate::scenes::multi_scale::{self, Opacity};
use crate::scenes::select;
use icoray::{Renderer, Result, Scene};
use std::path::PathBuf;

/// Options of the measurement.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Bisections of the icosahedron x layers; 5x61,7x26,8x99 by default: 8x99 is the paper's largest grid.
    #[arg(long, value_delimiter = ',', value_parser = size)]
    pub sizes: Vec<Size>,
    /// One small grid and small pictures.
    #[arg(long)]
    pub quick: bool,
    /// Width and height of the pictures; 512 by default.
    #[arg(long)]
    pub pixels: Option<u32>,
    /// Numbers of threads.
    #[arg(long, value_delimiter = ',', value_parser = count, default_values_t = [1, 2])]
    pub threads: Vec<usize>,
    /// Transfer functions; `walk` is none: rays walk and interpolate, and nothing is integrated.
    #[arg(long, value_delimiter = ',', default_values_t = ["dense", "lobes", "thin", "opaque", "walk"].map(String::from))]
    pub transfers: Vec<String>,
    /// With light or without.
    #[arg(long, value_delimiter = ',', value_enum, default_values_t = [Light::Unlit, Light::Lit])]
    pub lights: Vec<Light>,
    /// Tolerances.
    #[arg(long, value_delimiter = ',', default_values_t = [1e-3, 1e-2])]
    pub tolerance: Vec<f64>,
    /// Frames of each; the least and the median are reported.
    #[arg(long, default_value_t = 3)]
    pub frames: usize,
    /// Integration method: exact or paper.
    #[arg(long, default_value = "exact")]
    pub method: String,
    /// Precision: f32 or f64.
    #[arg(long, default_value = "f32")]
    pub precision: String,
    /// The layers' heights: mean, or native over mountains.
    #[arg(long, default_value = "mean")]
    pub heights: String,
    /// The core is hollow instead of opaque: rays pass through to the far side.
    #[arg(long)]
    pub hollow: bool,
    /// Grid on which instructions are counted, by perf or valgrind.
    #[arg(long, value_parser = size, default_value = "4x31")]
    pub counted: Size,
    /// Do not count instructions.
    #[arg(long)]
    pub uncounted: bool,
    /// Another build of this program: renders frames of both in turn, and prints their seconds, instructions and ratios
    /// instead.
    #[arg(long, value_name = "PROGRAM")]
    pub against: Option<PathBuf>,
    /// Draw and do nothing else, for a counter of instructions.
    #[arg(long, hide = true)]
    pub bare: bool,
    /// With `--bare`: draws each frame when it has read a line, and prints its seconds.
    #[arg(long, hide = true)]
    pub paced: bool,
    /// Directory of speed.csv, speed.md and pictures.
    #[arg(long, default_value = "out/speed")]
    pub out: PathBuf,
    /// A file in which the tables take the place of those between its lines `<!-- icoray-study speed -->` and `<!--
    /// end -->`.
    #[arg(long)]
    pub readme: Option<PathBuf>,
}

/// A grid's bisections and layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Bisections of the icosahedron.
    pub level: u32,
    pub layers: usize,
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.level, self.layers)
    }
}

pub(crate) fn size(text: &str) -> std::result::Result<Size, String> {
    let parsed = text.split_once('x').and_then(|(level, layers)| {
        let (level, layers) = (level.parse().ok()?, layers.parse().ok()?);
        (level <= icoray::MAX_LEVEL && layers >= 2).then_some(Size { level, layers })
    });
    parsed.ok_or_else(|| format!("{text:?}, expected bisections and layers, such as 8x99"))
}

pub(crate) fn count(text: &str) -> std::result::Result<usize, String> {
    let count = text.parse().ok().filter(|count| (1..=1024).contains(count));
    count.ok_or_else(|| "expected 1 to 1024 threads".to_owned())
}

impl Options {
    pub(super) fn sizes(&self) -> Vec<Size> {
        match (self.sizes.is_empty(), self.quick) {
            (false, _) => self.sizes.clone(),
            (true, true) => vec![self.counted],
            (true, false) => [(5, 61), (7, 26), (8, 99)].map(|(level, layers)| Size { level, layers }).into(),
        }
    }

    pub(super) fn pixels(&self) -> u32 {
        self.pixels.unwrap_or(if self.quick { 128 } else { 512 })
    }

    pub(super) fn is_native(&self) -> bool {
        self.heights == "native"
    }

    pub(super) fn renderers(&self) -> Result<Vec<Renderer>> {
        self.threads.iter().map(|threads| Renderer::new(*threads)).collect()
    }

    /// The settings of each grid. The traversal alone has one, as it depends on neither light nor tolerance.
    pub(super) fn settings(&self) -> Result<Vec<Setting>> {
        let cases = select(Case::all().collect(), &self.transfers, |case| case.name)?;
        let mut settings = Vec::new();
        for &light in &self.lights {
            for &tolerance in &self.tolerance {
                let of = |&case: &Case| Setting { case, light, tolerance };
                settings.extend(cases.iter().filter(|case| case.integrates).map(of));
            }
        }
        let walk = cases.iter().find(|case| !case.integrates);
        settings.extend(walk.map(|&case| Setting { case, light: Light::Unlit, tolerance: 1e-3 }));
        Ok(settings)
    }
}

/// Whether a scene is lit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Light {
    /// Emission and absorption only.
    Unlit,
    /// By a headlight.
    Lit,
}

impl std::fmt::Display for Light {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(if *self == Light::Lit { "lit" } else { "unlit" })
    }
}

/// Numbers of cores in words.
pub(super) fn cores(threads: &[usize]) -> String {
    let numbers: Vec<_> = threads.iter().map(ToString::to_string).collect();
    format!("{} {}", numbers.join(", "), if threads == [1] { "core" } else { "cores" })
}

/// A transfer function, or none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Case {
    pub name: &'static str,
    opacity: Opacity,
    /// Whether frusta are integrated; else rays only traverse and interpolate.
    pub integrates: bool,
}

impl Case {
    pub fn all() -> impl Iterator<Item = Case> {
        let transfer = |(name, opacity)| Case { name, opacity, integrates: true };
        let walk = Case { name: "walk", opacity: |_| 0.5, integrates: false };
        multi_scale::TRANSFERS.into_iter().map(transfer).chain([walk])
    }
}

/// A scene of each grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setting {
    pub case: Case,
    pub light: Light,
    pub tolerance: f64,
}

impl Setting {
    /// Transfer function, light and tolerance.
    pub fn name(&self) -> String {
        format!("{} {} {:e}", self.case.name, self.light, self.tolerance)
    }

    pub fn scene(&self, options: &Options) -> Result<Scene> {
        let Options { method, precision, heights, .. } = options;
        let method = if self.case.integrates { method } else { "exact" };
        let rest = format!(
            "method = \"{method}\"\nprecision = \"{precision}\"\nheights = \"{heights}\"\ntolerance = {:e}",
            self.tolerance
        );
        let rest = if options.hollow { format!("core = \"transparent\"\n{rest}") } else { rest };
        let light = if self.light == Light::Lit { multi_scale::HEADLIGHT } else { "" };
        let mut scene = multi_scale::scene(options.pixels(), self.case.opacity, &rest, light)?;
        if !self.case.integrates {
            // One span, which contains all values.
            let knots = &mut scene.volumes[0].transfer.knots;
            *knots = vec![knots[0], knots[knots.len() - 1]];
        }
        Ok(scene)
    }
}
