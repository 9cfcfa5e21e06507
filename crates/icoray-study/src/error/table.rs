//! The table of runs.

use super::measure::Measured;
use crate::results::number;

/// The columns of the file.
pub(super) const COLUMNS: &str = "scene,method,parameter,seconds_median,seconds_min,repeats,rmse,max_error,samples,bound_max,\
    bound_median,violations,bound_ratio";

/// Those that are printed.
pub(super) const PRINTED: &str = "scene,method,parameter,seconds_median,rmse,max_error,samples,bound_max,violations,\
    bound_ratio";

/// A run as a row.
pub(super) fn row(scene: &str, m: &Measured) -> [String; 13] {
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
