//! Checks bounds and tolerances of runs.

use super::measure::Measured;
use super::sweep::{EXACT, EXACT_F64};
use std::fmt::Write as _;

/// Whether all bounds of a scene hold, and the report.
pub fn bounds_report(scene: &str, lit: bool, runs: &[Measured]) -> (bool, String) {
    let mut text = String::new();
    let mut bounds_hold = true;
    for series in [EXACT_F64, EXACT] {
        let runs: Vec<&Measured> = runs.iter().filter(|m| m.run.series == series).collect();
        let checked: Vec<_> = runs.iter().filter_map(|m| m.bound.map(|b| (*m, b))).collect();
        let broken: Vec<_> = checked.iter().filter(|(_, b)| b.violations > 0).collect();
        let over: Vec<_> = runs.iter().filter(|m| m.run.parameter.is_some_and(|t| m.distance.max > t)).collect();
        let kind = if lit || series == EXACT { "estimate" } else { "bound" };
        let _ = writeln!(
            text,
            "{scene}, {series}: {kind} held on every pixel at {} of {} tolerances; tolerance met at {} of {}",
            checked.len() - broken.len(),
            runs.len(),
            runs.len() - over.len(),
            runs.len(),
        );
        bounds_hold &= broken.is_empty() && checked.len() == runs.len();
        for (m, bound) in broken {
            let _ = writeln!(
                text,
                "    broken at {}: {} pixels, error up to {:.2e}, up to {:.2} times the {kind}",
                m.run.label(),
                bound.violations,
                m.distance.max,
                bound.worst
            );
        }
        for m in over {
            let _ = writeln!(text, "    not met at {}: error up to {:.2e}", m.run.label(), m.distance.max);
        }
    }
    (bounds_hold, text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::sweep::ladders;
    use icoray_reference::comparison::{BoundCheck, Comparison};

    fn measured(rung: usize, max: f64, violations: usize) -> Measured {
        let bound = BoundCheck { max: 1.0, median: 1.0, violations, worst: 1.5, ratio: None };
        Measured {
            run: ladders(0.1, false, true)[0][rung],
            seconds: vec![1.0],
            whole_s: 1.0,
            samples: 1,
            distance: Comparison { rmse: max, max, pixel_errors: Vec::new() },
            bound: Some(bound),
        }
    }

    #[test]
    fn broken_bounds_and_missed_tolerances_are_told() {
        let (bounds_hold, text) = bounds_report("s", false, &[measured(0, 1e-2, 0), measured(1, 1e-2, 0)]);
        assert!(bounds_hold && text.contains("s, exact: estimate held on every pixel at 2 of 2"), "{text}");
        let (bounds_hold, text) = bounds_report("s", false, &[measured(0, 0.2, 7), measured(1, 1e-3, 0)]);
        assert!(!bounds_hold);
        assert!(text.contains("held on every pixel at 1 of 2 tolerances; tolerance met at 1 of 2"), "{text}");
        assert!(text.contains("broken at exact 1.000e-1: 7 pixels") && text.contains("1.50 times"), "{text}");
        assert!(text.contains("not met at exact 1.000e-1: error up to 2.00e-1"), "{text}");
    }
}
