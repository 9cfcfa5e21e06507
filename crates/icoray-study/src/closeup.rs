//! Close-up views for the paper's Figures 8 and 9.

use crate::results::say;
use crate::scenes::{self, Dataset, PreparedDataset, StudyScene, data_directory, select};
use icoray::{Camera, Error, ErrorKind, Renderer, Result};
use icoray_reference::methods::Sampling;
use std::io::Write;
use std::path::PathBuf;

/// An interpolation of the figures.
pub(crate) struct Interpolation {
    pub name: &'static str,
    /// Colour and marker in charts.
    pub style: usize,
    pub sampling: Sampling,
}

pub(crate) const INTERPOLATIONS: [Interpolation; 3] = [
    Interpolation { name: "wedges", style: 3, sampling: Sampling::Uniform },
    Interpolation { name: "tetrahedra", style: 7, sampling: Sampling::Tetrahedra },
    Interpolation { name: "mean value", style: 8, sampling: Sampling::MeanValue },
];

/// Which close-up views, how large, and by how many threads.
#[derive(Debug, Clone, clap::Args)]
pub struct View {
    /// Width of the pictures in pixels.
    #[arg(long)]
    pub size: Option<u32>,
    /// Threads of the timed runs; the oracle takes all.
    #[arg(long, default_value_t = 1)]
    pub threads: usize,
    /// Times that each run is repeated; the median counts.
    #[arg(long, default_value_t = 3)]
    pub repeats: usize,
    /// Small pictures of small grids, for a trial run.
    #[arg(long)]
    pub quick: bool,
    /// Directory of the data files; else that of ICORAY_TEST_DATA, else ../shared/data.
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
}

impl View {
    /// The scenes of these names with close-up cameras.
    pub(crate) fn scenes(&self, names: &[String], width: u32) -> Result<Vec<StudyScene>> {
        let width = self.size.unwrap_or(if self.quick { 32 } else { width });
        let mut scenes = select(scenes::all(width)?, names, |scene| &scene.name)?;
        for scene in &mut scenes {
            scene.scene.camera = camera(scene)?;
        }
        Ok(scenes)
    }

    /// Loads the dataset of each scene and hands both to `draw`; prints which scenes have no file.
    pub(crate) fn each(
        &self,
        scenes: &[StudyScene],
        renderer: &Renderer,
        out: &mut dyn Write,
        mut draw: impl FnMut(&StudyScene, &PreparedDataset, &mut dyn Write) -> Result<()>,
    ) -> Result<()> {
        let data = data_directory(self.data.as_deref());
        for scene in scenes {
            let drawn = scene.dataset.with(self.quick, &data, renderer, |prepared| draw(scene, prepared, out))?;
            if drawn.is_none() {
                say!(out, "{} skipped: no file in {}", scene.name, data.display())?;
            }
        }
        Ok(())
    }
}

/// A close-up camera: at the wave of the real fields, near the limb of the synthetic ones.
fn camera(scene: &StudyScene) -> Result<Camera> {
    let (eye, target, fov) = match scene.dataset {
        Dataset::Vorticity | Dataset::Theta => ([-1.908, -0.406, 1.219], [-0.62, -0.16, 0.80], 14.0),
        _ => ([1.65, 0.95, 0.55], [0.7, 0.5, 0.74], 20.0),
    };
    Camera::look_at(eye, target, [0.0, 0.0, 1.0], fov)
        .ok_or_else(|| Error::new(ErrorKind::Scene, "the close-up's camera is not one"))
}

/// Parses a step of the command line, in planet radii.
pub(crate) fn parse_step(text: &str) -> std::result::Result<f64, String> {
    let step = text.parse().ok().filter(|s| (1e-6..=1.0).contains(s));
    step.ok_or_else(|| "expected a number of planet radii from 1e-6 to 1".to_owned())
}
