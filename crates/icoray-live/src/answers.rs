//! Answers about the data, for the page.

use icoray::Frame;
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Number of bins in an answer.
const BINS: usize = 128;
/// The percentiles in an answer.
const PERCENTILES: [u64; 5] = [1, 5, 50, 95, 99];

/// The distribution of a field's values.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Histogram {
    /// Name of the field.
    pub field: String,
    /// Its units.
    pub units: Option<String>,
    /// Least and greatest value; `None` if all are missing.
    pub range: Option<[f64; 2]>,
    /// Numbers of values in equal parts of the range.
    pub counts: Vec<u64>,
    /// Percentiles 1, 5, 50, 95 and 99, to a part in 8192 of the range; 0 if all values are missing.
    pub percentiles: BTreeMap<u64, f64>,
    /// Number of missing values.
    pub missing: u64,
}

impl Histogram {
    /// The number of bins in which values are counted, for percentiles.
    pub const FINE_BINS: usize = BINS * 64;

    /// The histogram of a field whose values were counted in [`Self::FINE_BINS`].
    pub fn new(field: &str, units: Option<String>, found: icoray::Histogram) -> Self {
        let icoray::Histogram { range, counts: fine, missing } = found;
        let mut counts = vec![0; BINS];
        for (bin, count) in fine.iter().enumerate() {
            counts[bin * BINS / fine.len()] += count;
        }
        let all: u64 = fine.iter().sum();
        let [low, high] = range.unwrap_or_default();
        let percentile = |hundredths: u64| {
            let mut below = 0;
            let bin = fine.iter().position(|count| {
                below += count;
                100 * below >= hundredths * all
            });
            let place = (bin.unwrap_or(0) as f64 + 0.5) / fine.len() as f64;
            (hundredths, low + place * (high - low))
        };
        let percentiles = PERCENTILES.map(percentile).into();
        Histogram { field: field.to_owned(), units, range, percentiles, counts, missing }
    }
}

/// A place that a ray shows, and the values along the ray.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// The renderer's probe.
    pub found: icoray::Probe,
    /// Units of its field.
    pub units: Option<String>,
    /// The error of the pixel in the last picture at rest; `None` if there is none.
    pub error: Option<f32>,
    /// The step of a running model whose data were probed.
    pub step: Option<i64>,
}

impl Probe {
    /// The result of a probe at a place of the picture `shown`, from 0 to 1 from the left and from the top.
    pub fn new(found: icoray::Probe, units: Option<String>, at: [f64; 2], shown: Option<&Frame>) -> Self {
        let error = shown.map(|frame| {
            let [x, y] = [(at[0], frame.width), (at[1], frame.height)]
                .map(|(at, size)| ((at * f64::from(size)) as usize).min(size as usize - 1));
            frame.error[y * frame.width as usize + x]
        });
        Probe { found, units, error, step: None }
    }

    /// The answer as JSON; missing values are null, as JSON has no NaN.
    pub(crate) fn answer(&self) -> Value {
        let Probe { found, units, error, step } = self;
        let contributions = found.contributions.iter().map(|one| {
            json!({
                "part": one.part.to_string(),
                "field": one.field,
                "weight": one.weight,
                "distance": one.distance,
                "height_m": one.height_m,
                "value": one.value,
            })
        });
        let of_column = |k: usize| found.column.iter().map(|row| row[k]).collect::<Vec<f64>>();
        json!({
            "hit": true,
            "lon": found.lon_lat_deg[0],
            "lat": found.lon_lat_deg[1],
            "height_m": found.height_m,
            "value": found.value,
            "units": units,
            "field": found.field,
            "error": error,
            "step": step,
            "alpha": found.alpha,
            "part": found.part.map(|part| part.to_string()),
            "contributions": contributions.collect::<Vec<_>>(),
            "along": found.along,
            "column": { "height_m": of_column(0), "values": of_column(1) },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray::{Field, Location, Ranks, Renderer};

    #[test]
    fn a_histogram_counts_each_value_once() {
        let mut values: Vec<f32> = (0..1000).map(|i| i as f32).collect();
        values[17] = f32::NAN;
        let field = Field::level_fastest(&values, 2, Location::Center).unwrap();
        let renderer = Renderer::new(1).unwrap();
        let found = renderer.histogram(&mut Ranks::alone(), &field, None, Histogram::FINE_BINS).unwrap();
        let histogram = Histogram::new("q", None, found);
        assert_eq!((histogram.range, histogram.missing), (Some([0.0, 999.0]), 1));
        assert_eq!(histogram.counts.iter().sum::<u64>(), 999);
        assert!(histogram.counts.iter().all(|count| (6..=9).contains(count)), "{:?}", histogram.counts);
        for (percent, expected) in [(1, 10.0), (50, 500.0), (99, 989.0)] {
            assert!((histogram.percentiles[&percent] - expected).abs() < 2.0, "{:?}", histogram.percentiles);
        }
        assert_eq!(serde_json::to_value(&histogram).unwrap()["percentiles"].as_object().unwrap().len(), 5);
    }

    #[test]
    fn missing_values_are_sent_as_null() {
        let point = icoray::ProbePoint { distance: 1.0, height_m: 2.0, value: f64::NAN, length: 3.0, weight: 0.5 };
        let found = icoray::Probe {
            part: Some(icoray::ScenePart::Volume(0)),
            field: "q".into(),
            lon_lat_deg: [1.0, 2.0],
            height_m: 3.0,
            value: None,
            alpha: 0.25,
            contributions: Vec::new(),
            along: vec![point],
            column: vec![[0.0, 7.5], [1e3, f64::NAN]],
        };
        let answer = Probe::new(found, None, [0.5; 2], None).answer();
        assert_eq!((&answer["value"], &answer["along"][0]["value"]), (&Value::Null, &Value::Null));
        assert_eq!(answer["column"], json!({ "height_m": [0.0, 1e3], "values": [7.5, null] }));
    }
}
