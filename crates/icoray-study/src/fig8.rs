//! The paper's Figure 8: close-ups by interpolation in wedges, in tetrahedra, and by mean value coordinates, the
//! default method and the oracle, with amplified differences from the oracle, at equal step and at equal time.

use crate::closeup::{INTERPOLATIONS, Interpolation, View};
use crate::montage::{Montage, Tile, amplified};
use crate::results::{Table, number, progress, say};
use crate::scenes::{PreparedDataset, StudyScene};
use icoray::{Renderer, Result};
use icoray_reference::comparison::Comparison;
use icoray_reference::job::Job;
use icoray_reference::methods::{Method, Picture, Sampling};
use icoray_reference::oracle;
use std::io::Write;
use std::path::PathBuf;

/// What to draw.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Scenes, with commas between.
    #[arg(long, value_delimiter = ',', default_values_t = ["low_thin".to_owned(), "jw_vorticity".to_owned()])]
    pub scenes: Vec<String>,
    /// The equal step in planet radii.
    #[arg(long, default_value_t = 1e-3, value_parser = crate::closeup::parse_step)]
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

/// Maximum number of runs that search the step of equal time, and the relative tolerance.
const SEARCH: usize = 8;
const NEAR: f64 = 0.05;

const COLUMNS: &str = "scene,equal,method,parameter,seconds,rmse,max_error";
const PRINTED: &str = "equal,method,parameter,seconds,rmse,max_error";

/// A picture with its time and error.
struct TimedPicture {
    method: &'static str,
    parameter: String,
    seconds: f64,
    pixels: Vec<[f32; 4]>,
    distance: Comparison,
}

impl TimedPicture {
    fn row(&self, scene: &str, equal: &str) -> [String; 7] {
        let [seconds, rmse, max] = [self.seconds, self.distance.rmse, self.distance.max].map(number);
        [scene, equal, self.method, &self.parameter, &seconds, &rmse, &max].map(str::to_owned)
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
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let scenes = options.view.scenes(&options.scenes, 256)?;
    let all_threads = Renderer::new(0)?;
    let mut table = Table::create(options.out.join("fig8.csv"), COLUMNS, PRINTED)?;
    options.view.each(&scenes, &all_threads, out, |scene, prepared, out| {
        let pictures = montage(options, prepared, scene, &all_threads)?;
        say!(out, "{}\n{}", scene.name, table.heading())?;
        for (equal, picture) in pictures {
            say!(out, "{}", table.row(&picture.row(&scene.name, equal))?)?;
        }
        Ok(())
    })?;
    say!(out, "montages and table in {}", options.out.display())
}

/// Renders all pictures of a scene and writes the montage; returns them with what is equal.
fn montage(
    options: &Options,
    prepared: &PreparedDataset,
    scene: &StudyScene,
    all_threads: &Renderer,
) -> Result<Vec<(&'static str, TimedPicture)>> {
    let job = prepared.job(&scene.scene);
    let renderer = Renderer::new(options.view.threads)?;
    let timer = PictureTimer { job, renderer: &renderer, repeats: options.view.repeats };
    let bar = progress(2 + 2 * INTERPOLATIONS.len(), &scene.name);
    bar.set_message("oracle");
    let truth = oracle::picture(&job, all_threads)?;
    bar.inc(1);
    let tolerance = scene.scene.tolerance;
    bar.set_message("exact");
    let exact = timer.picture("exact", Method::Exact { tolerance }, format!("tol. {tolerance:e}"), &truth)?;
    bar.inc(1);
    let (mut step_row, mut time_row) = (Vec::new(), Vec::new());
    let coarsest = prepared.thickness(&scene.scene)?;
    for Interpolation { name, sampling, .. } in INTERPOLATIONS {
        bar.set_message(format!("{name}, equal step"));
        let parameter = |step: f64| format!("step {step:.2e}");
        step_row.push(timer.picture(name, sampling.at(options.step), parameter(options.step), &truth)?);
        bar.inc(1);
        bar.set_message(format!("{name}, equal time"));
        let step = timer.step_of_time(sampling, exact.seconds, [options.step, coarsest])?;
        time_row.push(timer.picture(name, sampling.at(step), parameter(step), &truth)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    lay_out(options, scene, &truth, &exact, [("step", &step_row), ("time", &time_row)])?;
    let rows = step_row.into_iter().map(|s| ("step", s)).chain(time_row.into_iter().map(|s| ("time", s)));
    Ok(std::iter::once(("time", exact)).chain(rows).collect())
}

/// Writes the montage: rows of oracle, default method and other methods, with the differences below.
fn lay_out(
    options: &Options,
    scene: &StudyScene,
    truth: &[[f64; 4]],
    exact: &TimedPicture,
    rows: [(&str, &Vec<TimedPicture>); 2],
) -> Result<()> {
    let mut montage = Montage::new(scene.scene.width, scene.scene.height);
    for (equal, row) in rows {
        let oracle = Tile {
            pixels: truth.iter().map(|p| p.map(|c| c as f32)).collect(),
            label: format!("oracle\n{}\nat equal {equal}", scene.name),
        };
        let (mut above, mut below) = (vec![oracle], vec![blank(scene)]);
        for picture in std::iter::once(exact).chain(row) {
            let [picture, difference] = picture.tiles(truth, options.amplify);
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

/// Renders and times pictures.
struct PictureTimer<'a> {
    job: Job<'a>,
    renderer: &'a Renderer,
    repeats: usize,
}

impl PictureTimer<'_> {
    fn picture(
        &self,
        name: &'static str,
        method: Method,
        parameter: String,
        truth: &[[f64; 4]],
    ) -> Result<TimedPicture> {
        let Picture { pixels, seconds, .. } = method.timed(&self.job, self.renderer, self.repeats)?;
        let distance = Comparison::new(&pixels, truth);
        Ok(TimedPicture { method: name, parameter, seconds, pixels, distance })
    }

    /// The step at which `sampling` takes about `goal` seconds; `steps` are the initial and the coarsest one.
    fn step_of_time(&self, sampling: Sampling, goal: f64, steps: [f64; 2]) -> Result<f64> {
        let [mut step, coarsest] = steps;
        for _ in 0..SEARCH {
            let seconds = sampling.at(step).render(&self.job, self.renderer)?.seconds;
            let ratio = seconds / goal;
            if (ratio - 1.0).abs() <= NEAR {
                break;
            }
            step = (step * ratio.clamp(0.125, 8.0)).min(coarsest);
        }
        Ok(step)
    }
}
