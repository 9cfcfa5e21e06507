//! Options of `icoray render` and `icoray plan` that select files, scene and times.

use crate::gpu;
use crate::input::{self, Input, LayerOption};
use crate::overrides::Overrides;
use crate::scene_options::SceneOptions;
use icoray::{Renderer, Result, Script};
use icoray_dataset::{Dataset, TimeSelection};
use icoray_progress::Progress;
use std::path::Path;

/// The files, scene and times to draw.
#[derive(clap::Args)]
pub struct Selection {
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub scene_options: SceneOptions,
    #[command(flatten)]
    pub overrides: Overrides,
    /// Time by number from 0, negative from the last (-1); by date (2003-01-01T06; 2003-01 is a whole month); by a
    /// range of either, without its end (0..10, 2003-01..2003-03, -5..); or "all". Of ranges and all times those
    /// are drawn that are the views' turn (every, at_steps, at_times, when), the number of a time being its step;
    /// others are drawn by all views [default: -1]
    #[arg(long, value_name = "TIME|A..B|all", allow_hyphen_values = true)]
    pub time: Option<TimeSelection>,
    #[command(flatten)]
    pub layer_option: LayerOption,
    /// Number of threads; 0 is as many as there are cores to use
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
}

pub struct Opened {
    pub renderer: Renderer,
    pub file: Dataset,
    /// Numbers of the selected times, and whether they were selected as a series.
    pub times: Vec<usize>,
    pub is_series: bool,
    /// The text of the scene file, if given; it is that of a script.
    pub given: Option<String>,
}

impl Selection {
    /// Reads the scene file, if given, and opens the model's files; `None` if the scene has no keys.
    pub fn open(&self, progress: &Progress) -> Result<Option<Opened>> {
        let scene = self.scene_options.scene.as_deref();
        let given = scene.map(input::scene_text).transpose()?;
        if let (Some(text), Some(path)) = (&given, scene)
            && Script::parse_optional(text).map_err(|e| e.within(path.display()))?.is_none()
        {
            return Ok(None);
        }
        progress.stage(format!("reading {}", self.input.files[0].display()));
        let renderer = gpu::renderer(self.threads)?.with_progress(progress.tiles());
        let file = self.input.open()?;
        let time = self.time.as_ref().unwrap_or(&TimeSelection::LAST);
        let times = time.of(file.times()).map_err(|e| e.within(format!("--time {time}")))?;
        let is_series = time.is_series();
        Ok(Some(Opened { renderer, file, times, is_series, given }))
    }

    /// The message for a scene without keys.
    pub fn nothing(&self) -> String {
        let scene = self.scene_options.scene.as_deref().unwrap_or(Path::new(""));
        format!("note      nothing is drawn: {} has no keys", scene.display())
    }
}
