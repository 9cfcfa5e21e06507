//! A rendered picture with its cost.

use icoray_grid::{Description, printable};
use icoray_scene::name::Stamp;
use icoray_scene::{Coloring, Scene};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

pub mod figures;
mod frame_report;
mod legend;
mod sampling;

use figures::{FIGURES, Figure, Scope, Value};
pub use frame_report::{DeviceReport, FrameReport, RanksReport, Sharing, Timing};
pub use legend::Legend;
pub use sampling::{CellsPerPixel, SamplingError, SamplingReport};

/// Reliability of a frame's errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Certainty {
    /// A bound, derived from the integrand; rounding in f64, which is orders smaller, is estimated. Unlit scenes in f64
    /// with `method = "exact"`.
    Bound,
    /// An estimate that is intended to be no less than the error, without proof: light, f32 rounding,
    /// `method = "paper"`.
    #[default]
    Estimate,
}

impl fmt::Display for Certainty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Certainty::Bound => "bound",
            Certainty::Estimate => "estimate",
        })
    }
}

/// Summary of a frame's errors: of the largest error over the channels of each pixel, premultiplied linear 0 to 1.
///
/// The error is that of the integral along the pixel's ray, against the exact integral of the same interpolant; it does
/// not include the error of flat triangles and linear interpolation between cells. The error of a pixel that was not
/// traced ([`Quality::pixel_step`](icoray_scene::Quality::pixel_step)) is unknown: it is given as 1, or the brightest
/// value that the scene may show.
///
/// Mean and percentile are over the pixels whose error is above 0: exact empty space around the planet does not improve
/// them. All are 0 if no pixel has an error.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ErrorSummary {
    /// Largest over the picture.
    pub max: f64,
    /// Mean over the pixels whose error is above 0.
    pub mean: f64,
    /// 99.9th percentile over these pixels: no more than one in a thousand has a larger error.
    pub p999: f64,
    /// Number of pixels whose error is above the tolerance.
    pub pixels_over_tolerance: u64,
    /// Bound or estimate.
    pub certainty: Certainty,
}

impl ErrorSummary {
    /// Summarises `error`, one per pixel, of a picture drawn to `tolerance`. A NaN error counts as infinite.
    pub fn of(error: &[f32], certainty: Certainty, tolerance: f64) -> Self {
        let known = error.iter().map(|e| if e.is_nan() { f32::INFINITY } else { *e });
        let mut error: Vec<f32> = known.filter(|e| *e > 0.0).collect();
        let count = error.len();
        if count == 0 {
            return ErrorSummary { certainty, ..ErrorSummary::default() };
        }
        let sum: f64 = error.iter().map(|e| f64::from(*e)).sum();
        let pixels_over_tolerance = error.iter().filter(|e| **e > tolerance as f32).count() as u64;
        // The least error that at most one in a thousand errors exceeds; counting down needs no rounding.
        let (_, p999, above) = error.select_nth_unstable_by(count - 1 - count / 1000, f32::total_cmp);
        let max = above.iter().fold(*p999, |max, e| max.max(*e));
        ErrorSummary {
            max: f64::from(max),
            mean: sum / count as f64,
            p999: f64::from(*p999),
            pixels_over_tolerance,
            certainty,
        }
    }
}

impl fmt::Display for ErrorSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [max, mean, p999] = [self.max, self.mean, self.p999].map(two_digits_up);
        write!(f, "at most {max}, mean {mean}, 99.9% below {p999} ({})", self.certainty)?;
        match self.pixels_over_tolerance {
            0 => Ok(()),
            1 => f.write_str("; above the tolerance in 1 pixel"),
            pixels => write!(f, "; above the tolerance in {pixels} pixels"),
        }
    }
}

/// A number from 0 to two digits, rounded up except for the rounding of a float: a printed bound remains one.
pub(crate) fn two_digits_up(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let text = format!("{value:.1e}");
    if text.parse().is_ok_and(|shown: f64| shown >= value * (1.0 - f64::from(f32::EPSILON))) {
        return text;
    }
    let half_a_digit = 0.5 * 10f64.powf(value.log10().floor() - 1.0);
    format!("{:.1e}", value + 1.001 * half_a_digit)
}

/// The range of values of a colour map.
#[derive(Debug, Clone, PartialEq)]
pub struct Colors {
    /// Name of the coloured field.
    pub field: String,
    /// First and last value.
    pub range: [f64; 2],
    /// The map, its scale, and the source of the range.
    pub how: String,
}

impl fmt::Display for Colors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Colors { field, range: [low, high], how } = self;
        write!(f, "{field}: {how}, {low} to {high}")
    }
}

impl Colors {
    /// The ranges of each colour map of a scene, described as in the scene `asked` and with the ranges of the scene
    /// `drawn`; equal colourings are listed once.
    pub fn of(asked: &Scene, drawn: &Scene) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for (asked, drawn) in asked.paintings().into_iter().zip(drawn.paintings()) {
            if let (Some(how), Some(range)) = (asked.coloring, drawn.coloring.and_then(Coloring::fixed)) {
                let colors = Colors { field: asked.field.to_owned(), range, how: how.describe() };
                if !all.contains(&colors) {
                    all.push(colors);
                }
            }
        }
        all
    }
}

/// A picture: premultiplied linear RGBA, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width · height` pixels, premultiplied linear RGBA.
    pub pixels: Vec<[f32; 4]>,
    /// For each pixel, the error of its channels against the exact integral; see [`ErrorSummary`].
    pub error: Vec<f32>,
    /// For each pixel, the estimated error of the mean of its rays against the mean over its area, or of a pixel that
    /// was not traced against its ray, see [`SamplingError`]. Empty if each pixel has one ray.
    pub sampling_error: Vec<f32>,
    /// Name of the displayed field.
    pub field: String,
    /// Descriptions of the scene's fields, by name; set by the caller.
    pub descriptions: BTreeMap<String, Description>,
    /// Labels to be written into the picture.
    pub legend: Option<Box<Legend>>,
    /// Camera and transfer range in words.
    pub notes: Vec<(&'static str, String)>,
    /// Step and time of the frame; set when it is written.
    pub stamp: Stamp,
    /// Cost and statistics of the frame.
    pub report: FrameReport,
}

impl Frame {
    /// The figures of the frame with their values: those of this scope and of narrower ones.
    pub fn figures(&self, scope: Scope) -> impl Iterator<Item = (&'static Figure, Value)> {
        let figures = FIGURES.iter().filter(move |figure| figure.scope >= scope);
        figures.map(|figure| (figure, figure.of(&self.stamp, &self.report)))
    }

    /// Keys and texts of a picture file, without control characters: field, figures of the picture, notes such as the
    /// camera, and the version.
    pub fn describe(&self) -> Vec<(String, String)> {
        let mut lines = vec![
            ("Software".into(), format!("icoray {}", env!("CARGO_PKG_VERSION"))),
            ("field".into(), self.field.clone()),
        ];
        if let Some(Description { long_name, units }) = self.descriptions.get(&self.field) {
            lines.extend(long_name.iter().map(|name| ("long name".into(), name.clone())));
            lines.extend(units.iter().map(|units| ("units".into(), units.clone())));
        }
        let others = self.descriptions.iter().filter(|(name, _)| **name != self.field);
        let others = others.map(|(name, Description { long_name, units })| {
            let texts = [long_name, units].into_iter().flatten().map(String::as_str);
            format!("{name}: {}", texts.collect::<Vec<_>>().join(", "))
        });
        let others = others.collect::<Vec<_>>().join("; ");
        lines.extend((!others.is_empty()).then(|| ("other fields".into(), others)));
        let figures = self.figures(Scope::Picture).map(|(figure, value)| (figure.name.into(), value.to_string()));
        lines.extend(figures.filter(|(_, text)| !text.is_empty()));
        lines.extend(self.notes.iter().map(|(key, text)| ((*key).to_string(), text.clone())));
        lines.into_iter().map(|(key, text)| (key, printable(&text).into_owned())).collect()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use icoray_scene::Quality;

    /// A frame of two rows of three pixels with errors on the diagonal of the first two columns.
    pub(crate) fn frame() -> Frame {
        let error = vec![1e-3, 0.0, 0.0, 0.0, 2.5e-6, 0.0];
        let pixels = (0..6).map(|i| [0.01 * i as f32, 0.3, 1.0 / 3.0, 0.5]).collect();
        let summary = ErrorSummary::of(&error, Certainty::Bound, 2e-3);
        Frame {
            width: 3,
            height: 2,
            pixels,
            error,
            sampling_error: Vec::new(),
            field: "q".into(),
            descriptions: BTreeMap::new(),
            legend: None,
            notes: vec![("camera", "far away".into())],
            stamp: Stamp { step: 7, time_s: 60.0, date: None },
            report: FrameReport {
                error: summary,
                quality: Quality { tolerance: 2e-3, ..Quality::default() },
                ..FrameReport::default()
            },
        }
    }

    #[test]
    fn errors_are_summed_up_over_the_pixels_that_have_one() {
        let mut error = vec![0.0; 500];
        error.extend((1..=2000).rev().map(|i| i as f32));
        error.extend([0.0; 7]);
        let certainty = Certainty::Bound;
        let summary = ErrorSummary::of(&error, certainty, 1990.0);
        assert_eq!(
            summary,
            ErrorSummary { max: 2000.0, mean: 1000.5, p999: 1998.0, pixels_over_tolerance: 10, certainty }
        );
        assert!(summary.to_string().ends_with("(bound); above the tolerance in 10 pixels"), "{summary}");
        let few = ErrorSummary::of(&[0.0, 3.0, 1.0, 2.0], Certainty::Estimate, 3.0);
        assert_eq!(few.pixels_over_tolerance, 0);
        assert!(few.to_string().ends_with("(estimate)"), "{few}");
        assert_eq!((few.max, few.mean, few.p999, few.certainty), (3.0, 2.0, 3.0, Certainty::Estimate));
    }

    #[test]
    fn no_errors_sum_up_to_0_and_bad_ones_are_not_lost() {
        for none in [&[][..], &[0.0; 5]] {
            let summary = ErrorSummary::of(none, Certainty::Bound, 1e-3);
            assert_eq!(summary, ErrorSummary { certainty: Certainty::Bound, ..ErrorSummary::default() });
        }
        let bad = ErrorSummary::of(&[f32::NAN, 1e-3], Certainty::Bound, 1e-3);
        assert_eq!((bad.max, bad.pixels_over_tolerance), (f64::INFINITY, 1));
        assert!(bad.to_string().ends_with("above the tolerance in 1 pixel"), "{bad}");
    }

    #[test]
    fn printed_errors_are_never_below_the_true_ones() {
        for (value, text) in [
            (0.0, "0"),
            (1.2e-4, "1.2e-4"),
            (1.200_001e-4, "1.3e-4"),
            (1.29e-4, "1.3e-4"),
            (9.92e-7, "1.0e-6"),
            (9.96e-7, "1.0e-6"),
            (1e-5, "1.0e-5"),
            (f64::from(1e-3f32), "1.0e-3"),
            (0.5, "5.0e-1"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(two_digits_up(value), text);
        }
    }

    #[test]
    fn a_frame_states_the_range_of_each_colour_map() {
        let mut frame = frame();
        let text = |frame: &Frame, key: &str| {
            let texts = frame.describe();
            let mut found = texts.iter().filter(|(k, _)| k == key).map(|(_, text)| text.clone());
            let first = found.next();
            assert_eq!(found.next(), None, "{key} stands once");
            first
        };
        assert_eq!((text(&frame, "colors"), text(&frame, "other fields")), (None, None));
        let colors = |field: &str, high: f64| Colors { field: field.into(), range: [-1.0, high], how: "vik".into() };
        frame.report.colors = vec![colors("q", 2.0)];
        assert_eq!(text(&frame, "colors").unwrap(), "q: vik, -1 to 2");
        frame.report.colors.push(colors("w", 3.5));
        assert_eq!(text(&frame, "colors").unwrap(), "q: vik, -1 to 2; w: vik, -1 to 3.5");
        assert_eq!([text(&frame, "color_min").unwrap(), text(&frame, "color_max").unwrap()], ["-1", "2"]);
        let wind = Description { long_name: Some("wind".into()), units: Some("m s-1".into()) };
        frame.descriptions = [("w".into(), wind), ("v".into(), Description::default())].into();
        assert_eq!(text(&frame, "other fields").unwrap(), "v: ; w: wind, m s-1");
    }

    #[test]
    fn each_map_of_a_scene_is_reported_once() {
        let surface = |layer: u32, more: &str| {
            format!("[[surfaces]]\nlayer = {layer}\nfield = \"w\"\ntransfer = {{ range = [0, 4]{more} }}\n")
        };
        let scene = |range: &str| {
            let text = format!(
                "field = \"q\"\n[camera]\nlon = 0\nlat = 0\ndistance = 3\n[transfer]\nrange = {range}\n\
                 opacity = [[0, 0.5]]\n{}{}{}",
                surface(0, ""),
                surface(1, ""),
                surface(2, ", map = \"vik\"")
            );
            Scene::parse(&text).unwrap()
        };
        let asked = scene("{ percentile = [0, 100] }");
        let of = |field: &str, range, how: &str| Colors { field: field.into(), range, how: how.into() };
        let expected = [
            of("q", [2.0, 3.0], "viridis, linear, percentiles 0 to 100 of the first frame"),
            of("w", [0.0, 4.0], "viridis, linear, fixed"),
            of("w", [0.0, 4.0], "vik, linear, fixed"),
        ];
        let ranged = asked.over_each(|field, _| Ok((field == "q").then_some([2.0, 3.0]))).unwrap().unwrap();
        assert_eq!(Colors::of(&asked, &ranged), expected);
    }

    #[test]
    fn a_frame_states_its_error() {
        let texts = frame().describe();
        let text = |key: &str| texts.iter().find(|(k, _)| k == key).unwrap().1.clone();
        let max = f64::from(1e-3f32);
        assert_eq!([text("error_max"), text("error_is_bound")], [max.to_string(), "true".into()]);
        assert_eq!([text("tolerance"), text("lights"), text("camera")], ["0.002", "off", "far away"]);
        assert_eq!(frame().report.error.to_string(), "at most 1.0e-3, mean 5.1e-4, 99.9% below 1.0e-3 (bound)");
        assert!(texts.iter().all(|(key, text)| !text.is_empty() && key != "render_s"));
    }
}
