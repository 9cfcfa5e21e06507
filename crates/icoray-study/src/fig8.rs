//! The paper's Figure 8: close-ups by interpolation in wedges, in tetrahedra, and by mean value coordinates, beside the
//! default method and the oracle; the amplified difference from the oracle beneath each, once at equal step and once at
//! equal time.

use crate::closeup::{AtStep, View};
use crate::compare::{Comparison, median};
use crate::csv_file::CsvFile;
use crate::methods::{Job, Method, Picture};
use crate::montage::{Montage, Tile, amplified};
use crate::oracle::Oracle;
use crate::scenes::{Stage, StudyScene, data_directory};
use crate::{make_directory, progress, say};
use icoray::{Renderer, Result};
use std::io::Write;
use std::path::PathBuf;

/// What to draw.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Scenes, with commas between.
    #[arg(long, value_delimiter = ',', default_values_t = ["low_thin".to_owned(), "jw_vorticity".to_owned()])]
    pub scenes: Vec<String>,
    /// The equal step in planet radii.
    #[arg(long, default_value_t = 1e-3, value_parser = crate::step)]
    pub step: f64,
    /// Factor on differences.
    #[arg(long, default_value_t = 20.0)]
    pub amplify: f64,
    /// Size, threads and repeats.
    #[command(flatten)]
    pub view: View,
    /// Directory of montages and table.
    #[arg(long, default_value = "out/fig8")]
    pub out: PathBuf,
}

/// Runs that look for the step of an equal time, and how near that must come.
const SEARCH: usize = 8;
const NEAR: f64 = 0.05;

const METHODS: [(&str, AtStep); 3] = [
    ("wedges", |step| Method::Uniform { step }),
    ("tetrahedra", |step| Method::Tetrahedra { step }),
    ("mean value", |step| Method::MeanValue { step }),
];

const COLUMNS: [&str; 7] = ["scene", "equal", "method", "parameter", "seconds", "rmse", "max_error"];

/// One picture with what is said of it.
struct Shot {
    method: &'static str,
    parameter: String,
    seconds: f64,
    pixels: Vec<[f32; 4]>,
    distance: Comparison,
}

impl Shot {
    fn row(&self, scene: &str, equal: &str) -> [String; COLUMNS.len()] {
        [
            scene.to_owned(),
            equal.to_owned(),
            self.method.to_owned(),
            self.parameter.clone(),
            format!("{:.6e}", self.seconds),
            format!("{:.6e}", self.distance.rmse),
            format!("{:.6e}", self.distance.max),
        ]
    }

    fn line(&self, equal: &str) -> String {
        format!(
            "  equal {equal}: {:<10} {:<16} {:>8.3} s, RMSE {:.2e}, maximum {:.2e}",
            self.method, self.parameter, self.seconds, self.distance.rmse, self.distance.max
        )
    }

    fn tiles(&self, truth: &[[f64; 4]], amplify: f64) -> [Tile; 2] {
        let label = format!(
            "{}\n{}, {:.3} s\nRMSE {:.1e}, max {:.1e}",
            self.method, self.parameter, self.seconds, self.distance.rmse, self.distance.max
        );
        let difference = amplified(&self.pixels, truth, amplify);
        [
            Tile { pixels: self.pixels.clone(), label },
            Tile { pixels: difference, label: format!("difference x{amplify}") },
        ]
    }
}

/// Draws a montage per scene, writes `fig8.csv`, and prints its rows.
///
/// # Errors
/// Whatever the library says, and [`ErrorKind::Io`](icoray::ErrorKind::Io) when a result cannot be written.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let scenes = options.view.scenes(&options.scenes, 256)?;
    make_directory(&options.out)?;
    let data = data_directory(options.view.data.as_deref());
    let all_threads = Renderer::new(0)?;
    let mut table = CsvFile::create(options.out.join("fig8.csv"), &COLUMNS)?;
    for scene in &scenes {
        let Some(world) = scene.world.load(options.view.detail(), &data)? else {
            say(out, &format!("{} skipped: no file in {}", scene.name, data.display()))?;
            continue;
        };
        let shots = world.with(&all_threads, |stage| montage(options, stage, scene, &all_threads))?;
        say(out, &scene.name)?;
        for (equal, shot) in shots {
            table.row(&shot.row(&scene.name, equal))?;
            say(out, &shot.line(equal))?;
        }
    }
    say(out, &format!("montages and table in {}", options.out.display()))
}

/// Takes all shots of a scene and lays them out; returns them with what is equal.
fn montage(
    options: &Options,
    stage: &Stage,
    scene: &StudyScene,
    all_threads: &Renderer,
) -> Result<Vec<(&'static str, Shot)>> {
    let job = stage.job(&scene.scene);
    let renderer = Renderer::new(options.view.threads)?;
    let camera = Camera { job, renderer: &renderer, repeats: options.view.repeats.max(1) };
    let bar = progress(2 + 2 * METHODS.len(), &scene.name);
    bar.set_message("oracle");
    let truth = Oracle::new(&job)?.picture(all_threads);
    bar.inc(1);
    let tolerance = scene.scene.tolerance;
    bar.set_message("exact");
    let exact = camera.shot("exact", Method::Exact { tolerance }, format!("tol. {tolerance:e}"), &truth)?;
    bar.inc(1);
    let (mut step_row, mut time_row) = (Vec::new(), Vec::new());
    let coarsest = stage.thickness(&scene.scene)?;
    for (name, method) in METHODS {
        bar.set_message(format!("{name}, equal step"));
        step_row.push(camera.shot(
            name,
            method(options.step),
            format!("step {:.2e}", options.step),
            &truth,
        )?);
        bar.inc(1);
        bar.set_message(format!("{name}, equal time"));
        let step = camera.step_of_time(method, exact.seconds, [options.step, coarsest])?;
        time_row.push(camera.shot(name, method(step), format!("step {step:.2e}"), &truth)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    lay_out(options, scene, &truth, &exact, [("step", &step_row), ("time", &time_row)])?;
    let rows = step_row.into_iter().map(|s| ("step", s)).chain(time_row.into_iter().map(|s| ("time", s)));
    Ok(std::iter::once(("time", exact)).chain(rows).collect())
}

/// Writes the montage: for each row of shots the oracle, the default method and the row, and the differences below.
fn lay_out(
    options: &Options,
    scene: &StudyScene,
    truth: &[[f64; 4]],
    exact: &Shot,
    rows: [(&str, &Vec<Shot>); 2],
) -> Result<()> {
    let mut montage = Montage::new(scene.scene.width, scene.scene.height);
    for (equal, row) in rows {
        let oracle = Tile {
            pixels: truth.iter().map(|p| p.map(|c| c as f32)).collect(),
            label: format!("oracle\n{}\nat equal {equal}", scene.name),
        };
        let (mut above, mut below) = (vec![oracle], vec![blank(scene)]);
        for shot in std::iter::once(exact).chain(row) {
            let [picture, difference] = shot.tiles(truth, options.amplify);
            above.push(picture);
            below.push(difference);
        }
        montage.push(above);
        montage.push(below);
    }
    montage.write(&options.out.join(format!("fig8_{}.png", scene.name)))
}

/// An empty tile below the oracle.
fn blank(scene: &StudyScene) -> Tile {
    let pixels = vec![[1.0; 4]; (scene.scene.width * scene.scene.height) as usize];
    Tile { pixels, label: String::new() }
}

/// Takes shots.
struct Camera<'a> {
    job: Job<'a>,
    renderer: &'a Renderer,
    repeats: usize,
}

impl Camera<'_> {
    fn shot(
        &self,
        name: &'static str,
        method: Method,
        parameter: String,
        truth: &[[f64; 4]],
    ) -> Result<Shot> {
        let picture: Picture = method.render(&self.job, self.renderer)?;
        let mut seconds = vec![picture.seconds];
        for _ in 1..self.repeats {
            seconds.push(method.render(&self.job, self.renderer)?.seconds);
        }
        let distance = Comparison::new(&picture.pixels, truth);
        Ok(Shot { method: name, parameter, seconds: median(seconds), pixels: picture.pixels, distance })
    }

    /// The step at which `method` takes about `goal` seconds, no coarser than the second of `steps`; the first is where the
    /// search begins.
    fn step_of_time(&self, method: AtStep, goal: f64, steps: [f64; 2]) -> Result<f64> {
        let [mut step, coarsest] = steps;
        for _ in 0..SEARCH {
            let seconds = method(step).render(&self.job, self.renderer)?.seconds;
            let off = seconds / goal;
            if (off - 1.0).abs() <= NEAR {
                break;
            }
            step = (step * off.clamp(0.125, 8.0)).min(coarsest);
        }
        Ok(step)
    }
}
