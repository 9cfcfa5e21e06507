//! The table of runs, as CSV and as printed lines.

use super::measure::Measured;

/// The columns of the file.
pub(super) const COLUMNS: &str = "scene,method,parameter,seconds_median,seconds_min,repeats,rmse,max_error,samples,bound_max,\
    bound_median,violations,bound_ratio";

/// A run as a row of the file.
pub(super) fn row(scene: &str, m: &Measured) -> [String; 13] {
    let number = |v: f64| format!("{v:.6e}");
    let optional = |v: Option<f64>| v.map_or_else(String::new, number);
    [
        scene.to_owned(),
        m.run.series.to_owned(),
        optional(m.run.parameter),
        number(m.median_s()),
        number(m.least_s()),
        m.seconds.len().to_string(),
        number(m.distance.rmse),
        number(m.distance.max),
        m.samples.to_string(),
        optional(m.bound.map(|b| b.max)),
        optional(m.bound.map(|b| b.median)),
        m.bound.map_or_else(String::new, |b| b.violations.to_string()),
        optional(m.bound.and_then(|b| b.ratio)),
    ]
}

/// The head of the printed lines.
pub(super) const HEADING: &str = "scene              method                          parameter  median s      RMSE   maximum     \
    samples     bound violations  ratio";

/// A run as a printed line.
pub(super) fn line(scene: &str, m: &Measured) -> String {
    let text = |v: Option<String>| v.unwrap_or_else(|| "-".to_owned());
    format!(
        "{:<18} {:<31} {:>9} {:>9.4} {:>9.2e} {:>9.2e} {:>11} {:>9} {:>10} {:>6}",
        scene,
        m.run.series,
        text(m.run.parameter.map(|p| format!("{p:.2e}"))),
        m.median_s(),
        m.distance.rmse,
        m.distance.max,
        m.samples,
        text(m.bound.map(|b| format!("{:.2e}", b.max))),
        text(m.bound.map(|b| b.violations.to_string())),
        text(m.bound.and_then(|b| b.ratio).map(|r| format!("{r:.1}"))),
    )
}
