//! Which methods run, over which parameters.

use icoray::Precision;
use icoray_reference::methods::Method;

/// The default method's name in tables and plots.
pub const EXACT: &str = "exact";
/// The same in double precision.
pub const EXACT_F64: &str = "exact f64";

/// All series, in the order of their colours.
pub const SERIES: [&str; 9] = [
    EXACT,
    EXACT_F64,
    "paper",
    "uniform",
    "pre-integrated",
    "pre-integrated, no attenuation",
    "constant",
    "tetrahedra",
    "mean value",
];

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
/// halved, tolerances divided by 10. Only three methods can light a scene.
pub fn ladders(thickness: f64, lit: bool, quick: bool) -> Vec<Vec<Run>> {
    let rungs = if quick { 3 } else { 7 };
    let exact = |series, precision| -> Vec<Run> {
        let run = |i: i32| {
            let tolerance = 10f64.powi(-1 - i);
            Run { series, method: Method::Exact { tolerance }, precision, parameter: Some(tolerance) }
        };
        (0..rungs).map(run).collect()
    };
    let steps = |series, method: &dyn Fn(f64) -> Method| -> Vec<Run> {
        let run = |i: i32| {
            let step = thickness / 16.0 * 0.5f64.powi(i);
            Run { series, method: method(step), precision: Precision::default(), parameter: Some(step) }
        };
        (0..rungs).map(run).collect()
    };
    let paper = Run { series: "paper", method: Method::Paper, precision: Precision::default(), parameter: None };
    let mut ladders = vec![
        exact(EXACT, Precision::F32),
        exact(EXACT_F64, Precision::F64),
        vec![paper],
        steps("uniform", &|step| Method::Uniform { step }),
    ];
    if !lit {
        // Values along each side of the table.
        let table = if quick { 64 } else { 256 };
        let pre_integrated = |attenuated| move |step| Method::PreIntegrated { step, table, attenuated };
        ladders.extend([
            steps("pre-integrated", &pre_integrated(true)),
            steps("pre-integrated, no attenuation", &pre_integrated(false)),
            steps("constant", &|step| Method::Constant { step }),
            steps("tetrahedra", &|step| Method::Tetrahedra { step }),
            steps("mean value", &|step| Method::MeanValue { step }),
        ]);
    }
    ladders
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_series_has_a_ladder_and_lit_scenes_have_four() {
        let names = |lit| ladders(0.16, lit, false).iter().map(|ladder| ladder[0].series).collect::<Vec<_>>();
        assert_eq!(names(false), SERIES);
        assert_eq!(names(true), SERIES[..4]);
        let exact = &ladders(0.16, false, false)[0];
        assert!((exact[6].parameter.unwrap() - 1e-7).abs() < 1e-20);
        let uniform = &ladders(0.16, false, false)[3];
        assert_eq!((uniform.len(), uniform[0].parameter, uniform[1].parameter), (7, Some(0.01), Some(0.005)));
    }
}
