//! Log lines about pictures with errors above the tolerance, with many cells in a pixel, and with colours off the values,
//! one of each per view, and about fields without values, one per field.

use crate::log::{Level, Log};
use icoray_core::output::Stamp;
use icoray_core::{ErrorSummary, FrameReport};
use std::collections::BTreeSet;

/// The lines that were logged: what each is about, and the name of its view or field.
#[derive(Debug, Default)]
pub(super) struct ErrorWarnings(BTreeSet<(&'static str, String)>);

/// Number of remembered lines, after which they are forgotten: bounds the memory where a host invents names.
const MAX_LINES: usize = 1000;

impl ErrorWarnings {
    /// Whether this line was not logged before.
    fn is_new(&mut self, what: &'static str, name: &str) -> bool {
        let line = (what, name.to_owned());
        if self.0.len() == MAX_LINES && !self.0.contains(&line) {
            self.0.clear();
        }
        self.0.insert(line)
    }

    /// Logs a warning for the first picture of a view that has pixels with an error above the tolerance, and a hint for
    /// the first that shows many cells in a pixel by one ray, or colours and isosurfaces off the values; a warning for
    /// the first of a field without values.
    pub fn log_frame(&mut self, view: &str, stamp: &Stamp, report: &FrameReport, log: &Log) {
        let step = stamp.step;
        let of = if view.is_empty() { String::new() } else { format!(", view {view:?}") };
        if let Some(hint) = report.sampling.hint().filter(|_| self.is_new("samples", view)) {
            log.say(Level::Info, &format!("step {step}{of}: {hint}"));
        }
        if !report.off_values.is_empty() && self.is_new("off values", view) {
            log.say(Level::Info, &format!("step {step}{of}: {}", report.off_values.join("; ")));
        }
        for field in report.without_values.iter().filter(|field| self.is_new("without values", field)) {
            let line = format!(
                "step {step}{of}: field {field:?} has no values: all are NaN, infinite or its fill value, and nothing of \
                 it is drawn"
            );
            log.say(Level::Warn, &line);
        }
        let ErrorSummary { pixels_over_tolerance: count, max, certainty, .. } = report.error;
        if count == 0 || !self.is_new("tolerance", view) {
            return;
        }
        let (pixels, tolerance) = (if count == 1 { "pixel has" } else { "pixels have" }, report.quality.tolerance);
        let line = format!(
            "step {step}{of}: {count} {pixels} an error above the tolerance {tolerance:e}, at most {max:.1e} \
             ({certainty}); later pictures: pixels_over_tolerance in report.csv"
        );
        log.say(Level::Warn, &line);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::tests::keep_line;
    use icoray_core::{CellsPerPixel, Quality, SamplingReport};

    /// The lines for frames of these steps, views and reports.
    fn logged(level: Level, frames: impl IntoIterator<Item = (i64, &'static str, FrameReport)>) -> Vec<(i32, String)> {
        let mut lines: Vec<(i32, String)> = Vec::new();
        let log = Log::new(Some(keep_line), (&raw mut lines).cast(), level as i32);
        let mut errors = ErrorWarnings::default();
        for (step, view, report) in frames {
            errors.log_frame(view, &Stamp { step, time_s: 0.0, date: None }, &report, &log);
        }
        lines
    }

    #[test]
    fn errors_above_the_tolerance_are_reported_once_for_each_view() {
        let report = |pixels_over_tolerance| FrameReport {
            error: ErrorSummary { max: 1.6e-3, pixels_over_tolerance, ..ErrorSummary::default() },
            quality: Quality { tolerance: 1e-3, ..Quality::default() },
            ..FrameReport::default()
        };
        let frames = [(1, "", 0), (2, "", 7), (3, "", 9), (4, "north", 1), (5, "north", 3), (6, "b", 0)];
        let lines = logged(Level::Warn, frames.map(|(step, view, over)| (step, view, report(over))));
        let warn = Level::Warn as i32;
        let more = "at most 1.6e-3 (estimate); later pictures: pixels_over_tolerance in report.csv";
        let expected = [
            (warn, format!("step 2: 7 pixels have an error above the tolerance 1e-3, {more}")),
            (warn, format!("step 4, view \"north\": 1 pixel has an error above the tolerance 1e-3, {more}")),
        ];
        assert_eq!(lines, expected);
    }

    #[test]
    fn samples_and_colours_are_hinted_at_once_for_each_view() {
        let report = |samples, mean| FrameReport {
            sampling: SamplingReport {
                samples,
                cells_per_pixel: CellsPerPixel { max: 2.0 * mean, mean },
                ..SamplingReport::default()
            },
            ..FrameReport::default()
        };
        let off_values = vec!["q is 1 to 2: it has no isosurface of 3".to_owned()];
        let off = FrameReport { off_values, ..FrameReport::default() };
        let frames = [
            (1, "", report(1, 2.0)),
            (2, "", report(4, 20.0)),
            (3, "", report(1, 20.0)),
            (4, "", report(1, 20.0)),
            (5, "b", report(1, 20.0)),
            (6, "b", off.clone()),
            (7, "b", off),
        ];
        let lines = logged(Level::Info, frames);
        let info = Level::Info as i32;
        assert_eq!(lines.len(), 3, "{lines:?}");
        assert_eq!(lines[2], (info, "step 6, view \"b\": q is 1 to 2: it has no isosurface of 3".to_owned()));
        assert!(lines[0].0 == info && lines[0].1.starts_with("step 3: 20 cells fall into a pixel"), "{lines:?}");
        assert!(lines[1].1.starts_with("step 5, view \"b\": 20 cells"), "{lines:?}");
    }
}
