//! The methods that run, and their parameters.

use icoray::Precision;
use icoray_reference::methods::{Method, Sampling};

/// The default method's name in tables and plots.
pub const EXACT: &str = "exact";
/// The same in double precision.
pub const EXACT_F64: &str = "exact f64";

/// One method at one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    /// The line of a plot that it is a point of.
    pub series: &'static str,
    pub method: Method,
    pub precision: Precision,
    /// Tolerance or step in planet radii; `None` where there is neither.
    pub parameter: Option<f64>,
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
/// halved, tolerances divided by 10. Those of a lit scene are the first of all.
pub fn ladders(thickness: f64, lit: bool, quick: bool) -> Vec<Vec<Run>> {
    let rungs = if quick { 3 } else { 7 };
    let exact = |series, precision| -> Vec<Run> {
        let run = |i: i32| {
            let tolerance = 10f64.powi(-1 - i);
            Run { series, method: Method::Exact { tolerance }, precision, parameter: Some(tolerance) }
        };
        (0..rungs).map(run).collect()
    };
    let steps = |sampling: Sampling| -> Vec<Run> {
        let run = |i: i32| {
            let step = thickness / 16.0 * 0.5f64.powi(i);
            let (method, precision) = (sampling.at(step), Precision::default());
            Run { series: sampling.name(), method, precision, parameter: Some(step) }
        };
        (0..rungs).map(run).collect()
    };
    let paper = Run { series: "paper", method: Method::Paper, precision: Precision::default(), parameter: None };
    let mut ladders = vec![exact(EXACT, Precision::F32), exact(EXACT_F64, Precision::F64), vec![paper]];
    let all = Sampling::all(if quick { 64 } else { 256 });
    ladders.extend(all.into_iter().filter(|sampling| !lit || *sampling == Sampling::Uniform).map(steps));
    ladders
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_series_has_a_ladder_and_lit_scenes_have_four() {
        let names = |lit| ladders(0.16, lit, false).iter().map(|ladder| ladder[0].series).collect::<Vec<_>>();
        assert_eq!(names(true), [EXACT, EXACT_F64, "paper", "uniform"]);
        assert_eq!((names(false).len(), &names(false)[..4]), (9, &names(true)[..]));
        let exact = &ladders(0.16, false, false)[0];
        assert!((exact[6].parameter.unwrap() - 1e-7).abs() < 1e-20);
        let uniform = &ladders(0.16, false, false)[3];
        assert_eq!((uniform.len(), uniform[0].parameter, uniform[1].parameter), (7, Some(0.01), Some(0.005)));
    }
}
