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

/// Options of the figure.
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

struct TimedPicture {
    /// Quantity that is equal to that of others: "step", or "time".
    equal: &'static str,
    method: &'static str,
    parameter: String,
    seconds: f64,
    pixels: Vec<[f32; 4]>,
    distance: Comparison,
}

impl TimedPicture {
    fn row(&self, scene: &str) -> [String; 7] {
        let [seconds, rmse, max] = [self.seconds, self.distance.rmse, self.distance.max].map(number);
        [scene, self.equal, self.method, &self.parameter, &seconds, &rmse, &max].map(str::to_owned)
    }

    fn tiles(&self, truth: &[[f64; 4]], amplify: f64) -> [Tile; 2] {
        let Comparison { rmse, max, .. } = self.distance;
        let label =
            format!("{}\n{}, {:.3} s\nRMSE {rmse:.1e}, max {max:.1e}", self.method, self.parameter, self.seconds);
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
        let truth = oracle::picture(&prepared.job(&scene.scene), &all_threads)?;
        let pictures = pictures(options, prepared, scene, &truth)?;
        montage(options, scene, &truth, &pictures)?;
        say!(out, "{}\n{}", scene.name, table.heading())?;
        pictures.iter().try_for_each(|picture| say!(out, "{}", table.row(&picture.row(&scene.name))?))
    })?;
    say!(out, "montages and table in {}", options.out.display())
}

/// Renders a scene by the default method, and by the others at the same step and in the same time.
fn pictures(
    options: &Options,
    prepared: &PreparedDataset,
    scene: &StudyScene,
    truth: &[[f64; 4]],
) -> Result<Vec<TimedPicture>> {
    let renderer = Renderer::new(options.view.threads)?;
    let job = prepared.job(&scene.scene);
    let timer = PictureTimer { job, renderer: &renderer, repeats: options.view.repeats, truth };
    let bar = progress(1 + 2 * INTERPOLATIONS.len(), &scene.name);
    let tolerance = scene.scene.tolerance;
    bar.set_message("exact");
    let exact = timer.picture("time", "exact", Method::Exact { tolerance }, format!("tol. {tolerance:e}"))?;
    bar.inc(1);
    let exact_s = exact.seconds;
    let mut pictures = vec![exact];
    let coarsest = prepared.thickness(&scene.scene)?;
    for equal in ["step", "time"] {
        for Interpolation { name, sampling, .. } in INTERPOLATIONS {
            bar.set_message(format!("{name}, equal {equal}"));
            let step = match equal {
                "step" => options.step,
                _ => timer.step_of_time(sampling, exact_s, [options.step, coarsest])?,
            };
            pictures.push(timer.picture(equal, name, sampling.at(step), format!("step {step:.2e}"))?);
            bar.inc(1);
        }
    }
    Ok(pictures)
}

/// Writes the montage: rows of oracle, default method and other methods, with the differences below.
fn montage(options: &Options, scene: &StudyScene, truth: &[[f64; 4]], pictures: &[TimedPicture]) -> Result<()> {
    let mut montage = Montage::new(scene.scene.width, scene.scene.height);
    for equal in ["step", "time"] {
        let oracle = Tile {
            pixels: truth.iter().map(|p| p.map(|c| c as f32)).collect(),
            label: format!("oracle\n{}\nat equal {equal}", scene.name),
        };
        let blank = Tile { pixels: vec![[1.0; 4]; truth.len()], label: String::new() };
        let (mut above, mut below) = (vec![oracle], vec![blank]);
        for picture in pictures.iter().filter(|picture| picture.equal == equal || picture.method == "exact") {
            let [picture, difference] = picture.tiles(truth, options.amplify);
            above.push(picture);
            below.push(difference);
        }
        montage.push(above);
        montage.push(below);
    }
    montage.write(&options.out.join(format!("fig8_{}.png", scene.name)))
}

struct PictureTimer<'a> {
    job: Job<'a>,
    renderer: &'a Renderer,
    repeats: usize,
    truth: &'a [[f64; 4]],
}

impl PictureTimer<'_> {
    fn picture(
        &self,
        equal: &'static str,
        name: &'static str,
        method: Method,
        parameter: String,
    ) -> Result<TimedPicture> {
        let Picture { pixels, seconds, .. } = method.timed(&self.job, self.renderer, self.repeats)?;
        let distance = Comparison::new(&pixels, self.truth);
        Ok(TimedPicture { equal, method: name, parameter, seconds, pixels, distance })
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
