//! Runs all methods on one scene, in rounds, and compares them with the oracle.

use super::sweep::Run;
use icoray::{Renderer, Result, Scene};
use icoray_progress::Bar;
use icoray_reference::comparison::{BoundCheck, Comparison, median};
use icoray_reference::job::Job;
use icoray_reference::methods::{Method, Picture};
use std::time::Instant;

/// Time and error of a run.
#[derive(Debug, Clone)]
pub struct Measured {
    pub run: Run,
    /// Seconds of each repeat.
    pub seconds: Vec<f64>,
    /// Seconds of the first run with its set-up.
    pub whole_s: f64,
    /// Samples taken, or frusta integrated.
    pub samples: u64,
    /// Error against the oracle; its `pixel_errors` are emptied.
    pub distance: Comparison,
    /// The bound, where the method has one.
    pub bound: Option<BoundCheck>,
}

impl Measured {
    pub fn median_s(&self) -> f64 {
        median(self.seconds.clone())
    }

    pub fn least_s(&self) -> f64 {
        self.seconds.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

/// A measure of error.
pub struct Measure {
    /// In the names of files.
    pub name: &'static str,
    pub title: &'static str,
    pub error: fn(&Measured) -> f64,
}

pub const MEASURES: [Measure; 2] = [
    Measure { name: "rmse", title: "RMSE against the oracle", error: |m| m.distance.rmse },
    Measure { name: "max", title: "largest error against the oracle", error: |m| m.distance.max },
];

/// Limits of repeats and times.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Times that each run is repeated.
    pub repeats: usize,
    /// Runs that take longer are not repeated, and no smaller step of their series is tried; at least a multiple of
    /// the scene's first run.
    pub longest_s: f64,
}

/// That multiple.
const FIRST_RUNS: f64 = 3.0;

/// Runs the ladders on a scene against `truth`: all runs once, then all again, so that noise affects all alike.
pub fn measure(
    job: &Job,
    truth: &[[f64; 4]],
    ladders: &[Vec<Run>],
    effort: Effort,
    renderer: &Renderer,
    bar: &Bar,
) -> Result<Vec<Measured>> {
    let mut all: Vec<Measured> = Vec::new();
    let mut longest_s = effort.longest_s;
    for ladder in ladders {
        for run in ladder {
            bar.set_message(run.label());
            let start = Instant::now();
            let picture = render(job, run, renderer)?;
            let measured = first(*run, picture, start.elapsed().as_secs_f64(), truth);
            let seconds = measured.seconds[0];
            if all.is_empty() {
                longest_s = longest_s.max(FIRST_RUNS * seconds);
            }
            all.push(measured);
            bar.inc(1);
            if seconds > longest_s && !matches!(run.method, Method::Exact { .. }) {
                break;
            }
        }
    }
    let again = all.iter().filter(|m| m.whole_s <= longest_s).count();
    bar.set_length((all.len() + again * effort.repeats.saturating_sub(1)) as u64);
    for _ in 1..effort.repeats {
        for measured in all.iter_mut().filter(|m| m.whole_s <= longest_s) {
            bar.set_message(measured.run.label());
            measured.seconds.push(render(job, &measured.run, renderer)?.seconds);
            bar.inc(1);
        }
    }
    Ok(all)
}

fn render(job: &Job, run: &Run, renderer: &Renderer) -> Result<Picture> {
    let scene = Scene { precision: run.precision, ..job.scene.clone() };
    run.method.render(&Job { scene: &scene, ..*job }, renderer)
}

fn first(run: Run, picture: Picture, whole_s: f64, truth: &[[f64; 4]]) -> Measured {
    let mut distance = Comparison::new(&picture.pixels, truth);
    let pixel_errors = std::mem::take(&mut distance.pixel_errors);
    Measured {
        run,
        seconds: vec![picture.seconds],
        whole_s,
        samples: picture.samples,
        distance,
        bound: picture.bound.map(|bound| BoundCheck::new(&bound, &pixel_errors)),
    }
}
