//! The methods with their parameters: runs all on one scene, in rounds, and compares them with the oracle.

use super::Options;
use crate::results::number;
use icoray::{Precision, Renderer, Result, Scene};
use icoray_progress::Bar;
use icoray_reference::comparison::{BoundCheck, Comparison, median};
use icoray_reference::job::Job;
use icoray_reference::methods::{Method, Picture, Sampling};
use std::time::Instant;

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

    pub fn row(&self, scene: &str) -> [String; 13] {
        let optional = |v: Option<f64>| v.map_or_else(String::new, number);
        [
            scene.to_owned(),
            self.run.series.to_owned(),
            optional(self.run.parameter),
            number(self.median_s()),
            number(self.least_s()),
            self.seconds.len().to_string(),
            number(self.distance.rmse),
            number(self.distance.max),
            self.samples.to_string(),
            optional(self.bound.map(|b| b.max)),
            optional(self.bound.map(|b| b.median)),
            self.bound.map_or_else(String::new, |b| b.violations.to_string()),
            optional(self.bound.and_then(|b| b.ratio)),
        ]
    }
}

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

/// The least multiple of a scene's first run that [`Options::longest`] stands for.
const FIRST_RUNS: f64 = 3.0;

/// Runs the ladders on a scene against `truth`: all runs once, then all again, so that noise affects all alike.
pub fn measure(
    job: &Job,
    truth: &[[f64; 4]],
    ladders: &[Vec<Run>],
    options: &Options,
    renderer: &Renderer,
    bar: &Bar,
) -> Result<Vec<Measured>> {
    let mut all: Vec<Measured> = Vec::new();
    let mut longest_s = options.longest;
    for ladder in ladders {
        for run in ladder {
            bar.set_message(run.label());
            let start = Instant::now();
            let Picture { pixels, seconds, samples, bound } = render(job, run, renderer)?;
            let whole_s = start.elapsed().as_secs_f64();
            let mut distance = Comparison::new(&pixels, truth);
            let pixel_errors = std::mem::take(&mut distance.pixel_errors);
            let bound = bound.map(|bound| BoundCheck::new(&bound, &pixel_errors));
            if all.is_empty() {
                longest_s = longest_s.max(FIRST_RUNS * seconds);
            }
            all.push(Measured { run: *run, seconds: vec![seconds], whole_s, samples, distance, bound });
            bar.inc(1);
            if seconds > longest_s && !matches!(run.method, Method::Exact { .. }) {
                break;
            }
        }
    }
    let again = all.iter().filter(|m| m.whole_s <= longest_s).count();
    bar.set_length((all.len() + again * options.repeats.saturating_sub(1)) as u64);
    for _ in 1..options.repeats {
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
    let job = Job { scene: &scene, ..*job };
    match run.level {
        0 => run.method.render(&job, renderer),
        level => run.method.render(&job, &Renderer::new(renderer.threads())?.on_level(level)),
    }
}

pub const COLUMNS: &str = "scene,method,parameter,seconds_median,-seconds_min,-repeats,rmse,max_error,samples,\
    bound_max,-bound_median,violations,bound_ratio";

/// The default method's name in tables and plots.
pub const EXACT: &str = "exact";
/// The same in double precision.
pub const EXACT_F64: &str = "exact f64";
/// The default method on coarser grids.
pub const LEVELS: &str = "levels";

/// One method at one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    /// The line of a plot that it is a point of.
    pub series: &'static str,
    pub method: Method,
    pub precision: Precision,
    /// Tolerance, step in planet radii or level; `None` where there is none.
    pub parameter: Option<f64>,
    /// The level of detail; 0 is the grid itself.
    pub level: u32,
}

impl Run {
    pub fn label(&self) -> String {
        match self.parameter {
            Some(parameter) => format!("{} {parameter:.3e}", self.series),
            None => self.series.to_owned(),
        }
    }
}

/// The runs on a scene, a ladder for each series, from coarse to fine: steps from a 16th of the shell's `thickness` on
/// halved, tolerances divided by 10, and for an unlit scene the levels of a grid of `cells`. Those of a lit scene are
/// the first of all.
pub fn ladders(thickness: f64, cells: usize, lit: bool, quick: bool) -> Vec<Vec<Run>> {
    /// Tolerance on levels, whose own errors are larger.
    const ON_LEVELS: f64 = 1e-3;
    /// Least number of cells of a level of [`Renderer::on_level`].
    const LEAST_CELLS: usize = 100;
    let rungs = if quick { 3 } else { 7 };
    let exact = |series, precision| -> Vec<Run> {
        let run = |i: i32| {
            let tolerance = 10f64.powi(-1 - i);
            Run { series, method: Method::Exact { tolerance }, precision, parameter: Some(tolerance), level: 0 }
        };
        (0..rungs).map(run).collect()
    };
    let steps = |sampling: Sampling| -> Vec<Run> {
        let run = |i: i32| {
            let step = thickness / 16.0 * 0.5f64.powi(i);
            let (method, precision) = (sampling.at(step), Precision::default());
            Run { series: sampling.name(), method, precision, parameter: Some(step), level: 0 }
        };
        (0..rungs).map(run).collect()
    };
    let on_level = |level: u32| Run {
        series: LEVELS,
        method: Method::Exact { tolerance: ON_LEVELS },
        precision: Precision::F32,
        parameter: Some(level.into()),
        level,
    };
    let precision = Precision::default();
    let paper = Run { series: "paper", method: Method::Paper, precision, parameter: None, level: 0 };
    let mut ladders = vec![exact(EXACT, Precision::F32), exact(EXACT_F64, Precision::F64), vec![paper]];
    let all = Sampling::all(if quick { 64 } else { 256 });
    ladders.extend(all.into_iter().filter(|sampling| !lit || *sampling == Sampling::Uniform).map(steps));
    // A level has a quarter of the cells of the one before, the first a sixteenth.
    let levels: Vec<Run> = (1..).take_while(|level| cells >> (2 * level + 2) >= LEAST_CELLS).map(on_level).collect();
    if !lit && !levels.is_empty() {
        ladders.push(levels);
    }
    ladders
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_series_has_a_ladder_and_lit_scenes_have_four() {
        let names = |lit| ladders(0.16, 10_242, lit, false).iter().map(|ladder| ladder[0].series).collect::<Vec<_>>();
        assert_eq!(names(true), [EXACT, EXACT_F64, "paper", "uniform"]);
        assert_eq!((names(false).len(), &names(false)[..4]), (10, &names(true)[..]));
        let unlit = ladders(0.16, 10_242, false, false);
        let exact = &unlit[0];
        assert!((exact[6].parameter.unwrap() - 1e-7).abs() < 1e-20);
        let uniform = &unlit[3];
        assert_eq!((uniform.len(), uniform[0].parameter, uniform[1].parameter), (7, Some(0.01), Some(0.005)));
        let levels: Vec<u32> = unlit[9].iter().map(|run| run.level).collect();
        assert_eq!(levels, [1, 2]);
    }
}
