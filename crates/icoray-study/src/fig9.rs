//! The paper's Figure 9: frame rate against the sampling step for interpolation in wedges, in tetrahedra and by mean
//! value coordinates, in the views of Figure 8.

use crate::closeup::{INTERPOLATIONS, Interpolation, View};
use crate::plot::{Chart, Line};
use crate::results::{Table, progress, say};
use crate::scenes::StudyScene;
use icoray::{Renderer, Result};
use icoray_reference::comparison::median;
use icoray_reference::job::Job;
use icoray_reference::methods::Method;
use std::io::Write;
use std::path::PathBuf;

/// Options of the measurement.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Scenes, with commas between.
    #[arg(long, value_delimiter = ',', default_values_t = ["high_lobes".to_owned(), "jw_vorticity".to_owned()])]
    pub scenes: Vec<String>,
    /// Steps in planet radii, with commas between.
    #[arg(long, value_delimiter = ',', default_values_t = [1e-2, 5e-3, 2e-3, 1e-3, 5e-4], value_parser = crate::closeup::parse_step)]
    pub steps: Vec<f64>,
    /// Size, threads and repeats.
    #[command(flatten)]
    pub view: View,
    /// Directory of table and plots.
    #[arg(long, default_value = "out/fig9")]
    pub out: PathBuf,
}

const COLUMNS: &str = "scene,method,step,seconds_median,frames_per_s,samples,ns_per_sample";

/// One method at one step.
struct Rate {
    method: usize,
    step: f64,
    seconds: Vec<f64>,
    samples: u64,
}

impl Rate {
    fn median_s(&self) -> f64 {
        median(self.seconds.clone())
    }

    fn frames_per_s(&self) -> f64 {
        1.0 / self.median_s()
    }

    fn row(&self, scene: &str) -> [String; 7] {
        [
            scene.to_owned(),
            INTERPOLATIONS[self.method].name.to_owned(),
            format!("{:e}", self.step),
            format!("{:.6e}", self.median_s()),
            format!("{:.6e}", self.frames_per_s()),
            self.samples.to_string(),
            format!("{:.3}", 1e9 * self.median_s() / self.samples.max(1) as f64),
        ]
    }
}

/// Measures, writes `fig9.csv` and a chart per scene, and prints both.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let scenes = options.view.scenes(&options.scenes, 160)?;
    let renderer = Renderer::new(options.view.threads)?;
    let mut table = Table::create(options.out.join("fig9.csv"), COLUMNS, "")?;
    options.view.each(&scenes, &renderer, out, |scene, prepared, out| {
        let job = prepared.job(&scene.scene);
        let rates = rates(options, &job, &scene.name, &renderer)?;
        let exact = Method::Exact { tolerance: scene.scene.tolerance };
        let exact_s = exact.timed(&job, &renderer, options.view.repeats)?.seconds;
        for rate in &rates {
            table.row(&rate.row(&scene.name))?;
        }
        chart(scene, &rates, exact_s).write(&options.out.join(format!("fig9_{}.svg", scene.name)))?;
        print(scene, &rates, exact_s, out)
    })?;
    say!(out, "table and plots in {}", options.out.display())
}

/// Measures every method at every step, in rounds, so that noise affects all alike.
fn rates(options: &Options, job: &Job, name: &str, renderer: &Renderer) -> Result<Vec<Rate>> {
    let mut rates: Vec<Rate> = (0..INTERPOLATIONS.len())
        .flat_map(|method| options.steps.iter().map(move |step| (method, *step)))
        .map(|(method, step)| Rate { method, step, seconds: Vec::new(), samples: 0 })
        .collect();
    let repeats = options.view.repeats.max(1);
    let bar = progress(rates.len() * repeats, name);
    for _ in 0..repeats {
        for rate in &mut rates {
            let Interpolation { name, sampling, .. } = INTERPOLATIONS[rate.method];
            bar.set_message(format!("{name} {:e}", rate.step));
            let picture = sampling.at(rate.step).render(job, renderer)?;
            rate.seconds.push(picture.seconds);
            rate.samples = picture.samples;
            bar.inc(1);
        }
    }
    Ok(rates)
}

fn chart(scene: &StudyScene, rates: &[Rate], exact_s: f64) -> Chart {
    let steps = rates.iter().map(|r| r.step);
    let ends = [steps.clone().fold(f64::INFINITY, f64::min), steps.fold(0.0, f64::max)];
    let mut lines = vec![Line {
        name: format!("exact, tolerance {:e}", scene.scene.tolerance),
        style: 0,
        points: ends.map(|step| (step, 1.0 / exact_s)).to_vec(),
    }];
    for (number, Interpolation { name, style, .. }) in INTERPOLATIONS.iter().enumerate() {
        let of = rates.iter().filter(|r| r.method == number);
        let points = of.map(|r| (r.step, r.frames_per_s())).collect();
        lines.push(Line { name: (*name).to_owned(), style: *style, points });
    }
    Chart {
        title: format!("{}, close-up, {} × {} pixels", scene.name, scene.scene.width, scene.scene.height),
        x: "step / planet radius".to_owned(),
        y: "frames per second".to_owned(),
        lines,
    }
}

fn print(scene: &StudyScene, rates: &[Rate], exact_s: f64, out: &mut dyn Write) -> Result<()> {
    say!(out, "{}: frames per second by step in planet radii", scene.name)?;
    let of = |method: usize| rates.iter().filter(move |r| r.method == method);
    let heads: Vec<String> = of(0).map(|r| format!("{:>9.0e}", r.step)).collect();
    say!(out, "{:>12} {}", "", heads.join(" "))?;
    for (number, Interpolation { name, .. }) in INTERPOLATIONS.iter().enumerate() {
        let cells: Vec<String> = of(number).map(|r| format!("{:>9.3}", r.frames_per_s())).collect();
        let gains: Vec<f64> = of(0).zip(of(number)).map(|(w, r)| w.frames_per_s() / r.frames_per_s() - 1.0).collect();
        let gain = 100.0 * gains.iter().sum::<f64>() / gains.len().max(1) as f64;
        let words = if number == 0 { String::new() } else { format!("  wedges gain {gain:.0} % on average") };
        say!(out, "{name:>12} {}{words}", cells.join(" "))?;
    }
    say!(out, "{:>12} {:>9.3} at tolerance {:e}, no step", "exact", 1.0 / exact_s, scene.scene.tolerance)
}
