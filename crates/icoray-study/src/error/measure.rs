//! Runs all methods on one scene, in turn, and compares them with the oracle.

use super::sweep::Run;
use crate::compare::{BoundCheck, Comparison, median};
use crate::methods::{Job, Method, Picture};
use icoray::{Renderer, Result, Scene};
use icoray_progress::Bar;
use std::time::Instant;

/// What a run cost and how far it was off.
#[derive(Debug, Clone)]
pub struct Measured {
    /// What ran.
    pub run: Run,
    /// Seconds of each repeat.
    pub seconds: Vec<f64>,
    /// Seconds of the first run with all set-up.
    pub whole_s: f64,
    /// Samples taken, or frusta integrated.
    pub samples: u64,
    /// Distance from the oracle; its `far` is emptied.
    pub distance: Comparison,
    /// The bound, where the method has one.
    pub bound: Option<BoundCheck>,
}

impl Measured {
    /// Median of the repeats.
    pub fn median_s(&self) -> f64 {
        median(self.seconds.clone())
    }

    /// The fastest repeat.
    pub fn least_s(&self) -> f64 {
        self.seconds.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

/// How often and how long.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Times that each run is repeated.
    pub repeats: usize,
    /// Seconds after which a run, with its set-up, is not repeated, and in the rays no smaller step of its series is tried;
    /// but never less than a few times what the scene's first run takes, so that there is something to compare it with.
    pub longest_s: f64,
}

/// That many times.
const FIRST_RUNS: f64 = 3.0;

/// Runs the ladders on a scene against `truth`: all runs once, then all again, so that noise hits all alike.
///
/// # Errors
/// Whatever a method says.
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
    let far = std::mem::take(&mut distance.far);
    Measured {
        run,
        seconds: vec![picture.seconds],
        whole_s,
        samples: picture.samples,
        distance,
        bound: picture.bound.map(|bound| BoundCheck::new(&bound, &far)),
    }
}
