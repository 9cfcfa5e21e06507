//! What `icoray render` draws and `icoray plan` tells of: files, scene, times.

use crate::gpu;
use crate::input::{self, Input, Wanted};
use crate::look::Look;
use crate::suggested::{self, Suggested};
use crate::times::Times;
use icoray::{Grid, Renderer, Result, Scene, Script};
use icoray_netcdf::{FieldInfo, ModelFile};
use icoray_progress::Progress;
use std::path::Path;

/// What is drawn.
#[derive(clap::Args)]
pub struct Drawn {
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub look: Look,
    /// Time by number from 0, negative from the last (-1); by date (2003-01-01T06; 2003-01 is a whole month); by a range of
    /// either, without its end (0..10, 2003-01..2003-03, -5..); or "all". Of ranges and all times those are drawn that are
    /// the views' turn (every, at_steps, at_times, when), the number of a time being its step; others are drawn by all views
    /// [default: 0, or the last one where no --scene is given]
    #[arg(long, value_name = "TIME|A..B|all", allow_hyphen_values = true)]
    pub time: Option<Times>,
    #[command(flatten)]
    pub wanted: Wanted,
    /// Number of threads; 0 is as many as there are cores to use
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    #[command(flatten)]
    pub who: gpu::Who,
    /// Picture size in pixels, instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,
    /// Largest error allowed in a channel of a pixel, 0 to 1, instead of the scene's
    #[arg(long, value_name = "E", allow_hyphen_values = true, value_parser = tolerance)]
    pub tolerance: Option<f64>,
}

fn size(text: &str) -> std::result::Result<(u32, u32), String> {
    let side = |t: &str| t.parse().ok().filter(|s| (1..=16384).contains(s));
    let sides = text.split_once('x');
    sides
        .and_then(|(w, h)| Some((side(w)?, side(h)?)))
        .ok_or_else(|| "expected WxH with sides of 1 to 16384 pixels, such as 640x480".to_owned())
}

fn tolerance(text: &str) -> std::result::Result<f64, String> {
    let (low, high) = (Scene::TOLERANCE.start(), Scene::TOLERANCE.end());
    let tolerance = text.parse().ok().filter(|t| Scene::TOLERANCE.contains(t));
    tolerance.ok_or_else(|| format!("expected a number from {low:e} to {high}"))
}

/// What the command opens first.
pub struct Opened {
    pub renderer: Renderer,
    pub file: ModelFile,
    /// Which of the file's times are drawn, and whether they were asked for as a series.
    pub times: Vec<usize>,
    pub is_series: bool,
    /// The script of the scene file, where there is one.
    given: Option<Script>,
}

/// The scenes that are drawn.
pub struct Scenes<'f> {
    pub script: Script,
    /// The file's grid, where it was needed to suggest the scene.
    pub grid: Option<Grid<'f>>,
    /// The suggestion, where no scene was given.
    pub suggested: Option<Suggested>,
}

impl Drawn {
    /// Reads the scene file, where there is one, and opens the model's; `None` where the scene has no keys.
    pub fn open(&self, progress: &Progress) -> Result<Option<Opened>> {
        let given = match self.look.scene.as_deref().map(input::script).transpose()? {
            Some(None) => return Ok(None),
            given => given.flatten(),
        };
        progress.stage(format!("reading {}", self.input.file.display()));
        let renderer = gpu::renderer(self.threads)?.with_progress(progress.tiles());
        let file = self.input.open()?;
        let time = match &self.time {
            Some(time) => time,
            None if given.is_some() => &Times::FIRST,
            None => &Times::LAST,
        };
        let (times, is_series) = (time.of(file.times())?, time.is_series());
        Ok(Some(Opened { renderer, file, times, is_series, given }))
    }

    /// What is said where the scene has no keys.
    pub fn nothing(&self) -> String {
        let scene = self.look.scene.as_deref().unwrap_or(Path::new(""));
        format!("note      nothing is drawn: {} has no keys", scene.display())
    }
}

impl Opened {
    /// The scenes of the scene file, with what the command says instead; or a suggested one.
    pub fn scenes(&self, drawn: &Drawn, progress: &Progress) -> Result<Scenes<'_>> {
        let Some(mut script) = self.given.clone() else {
            let (suggested, grid) = Suggested::new(drawn, self, progress)?;
            let script = Script::parse(&suggested.text).map_err(|e| e.within("the suggested scene"))?;
            return Ok(Scenes { script, grid: Some(grid), suggested: Some(suggested) });
        };
        if script.lacks_field() {
            script.name_first_field(&suggested::first_field(&self.file)?.name);
        }
        script.show_as_surfaces(|name| self.file.field_info(name).is_ok_and(FieldInfo::is_2d));
        drawn.look.apply(&mut script)?;
        for scene in script.scenes_mut() {
            if let Some((width, height)) = drawn.size {
                (scene.width, scene.height) = (width, height);
            }
            if let Some(tolerance) = drawn.tolerance {
                scene.tolerance = tolerance;
            }
            drawn.who.apply(scene);
        }
        Ok(Scenes { script, grid: None, suggested: None })
    }
}
