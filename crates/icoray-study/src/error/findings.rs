//! Findings of the runs on a scene: errors beyond the reported ones, and methods that are faster than the default one.

use super::measure::{EXACT, EXACT_F64, LEVELS, MEASURES, Measure, Measured};
use std::fmt::Write as _;

#[derive(Debug, Clone)]
pub struct Finding {
    pub is_true: bool,
    pub text: String,
}

/// Whether the errors of a scene's pixels are at most the reported ones.
pub fn reported_errors(scene: &str, is_lit: bool, runs: &[Measured]) -> Finding {
    let mut finding = Finding { is_true: true, text: String::new() };
    for series in [EXACT_F64, EXACT] {
        let runs: Vec<&Measured> = runs.iter().filter(|m| m.run.series == series).collect();
        let checked: Vec<_> = runs.iter().filter_map(|m| m.bound.map(|b| (*m, b))).collect();
        let broken: Vec<_> = checked.iter().filter(|(_, b)| b.violations > 0).collect();
        let above: Vec<_> = runs.iter().filter(|m| m.run.parameter.is_some_and(|t| m.distance.max > t)).collect();
        let kind = if is_lit || series == EXACT { "estimate" } else { "bound" };
        let _ = writeln!(
            finding.text,
            "{scene}, {series}: {kind} met by every pixel at {} of {} tolerances; tolerance met at {} of {}",
            checked.len() - broken.len(),
            runs.len(),
            runs.len() - above.len(),
            runs.len(),
        );
        finding.is_true &= broken.is_empty() && checked.len() == runs.len();
        for (m, bound) in broken {
            let _ = writeln!(
                finding.text,
                "    broken at {}: {} pixels, error up to {:.2e}, up to {:.2} times the {kind}",
                m.run.label(),
                bound.violations,
                m.distance.max,
                bound.worst
            );
        }
        for m in above {
            let _ = writeln!(finding.text, "    not met at {}: error up to {:.2e}", m.run.label(), m.distance.max);
        }
    }
    finding
}

/// For each measure of error, whether for each run of another method a run of the default one is neither slower nor
/// worse.
pub fn fastest(scene: &str, runs: &[Measured]) -> Vec<Finding> {
    let exact = || runs.iter().filter(|m| m.run.series == EXACT);
    let others = || runs.iter().filter(|m| ![EXACT, EXACT_F64, LEVELS].contains(&m.run.series));
    let of_measure = |Measure { title, error, .. }: &Measure| {
        let best = |m: &Measured| {
            let as_good = exact().filter(|run| error(run) <= error(m));
            as_good.map(Measured::median_s).min_by(f64::total_cmp)
        };
        let faster: Vec<_> = others().filter(|m| best(m).is_none_or(|seconds| seconds > m.median_s())).collect();
        let count = others().count();
        let is_true = faster.is_empty();
        let mut text = format!("{scene}, {title}: at {} of {count} points\n", count - faster.len());
        for m in faster {
            let exact = best(m).map_or_else(|| "no run".to_owned(), |seconds| format!("{seconds:.4} s"));
            let (label, error, seconds) = (m.run.label(), error(m), m.median_s());
            let _ = writeln!(text, "    not at {label}: {error:.2e} in {seconds:.4} s; exact has {exact} for that");
        }
        Finding { is_true, text }
    };
    MEASURES.iter().map(of_measure).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::measure::ladders;
    use icoray_reference::comparison::{BoundCheck, Comparison};

    /// A run of one of the ladders.
    fn measured(ladder: usize, rung: usize, seconds: f64, max: f64, violations: usize) -> Measured {
        let bound = BoundCheck { max: 1.0, median: 1.0, median_error: 0.0, violations, worst: 1.5, ratio: None };
        Measured {
            run: ladders(0.1, 10_242, false, true)[ladder][rung],
            seconds: vec![seconds],
            whole_s: seconds,
            samples: 1,
            distance: Comparison { rmse: max, max, pixel_errors: Vec::new() },
            bound: Some(bound),
        }
    }

    #[test]
    fn broken_bounds_and_missed_tolerances_are_reported() {
        let good = [measured(0, 0, 1.0, 1e-2, 0), measured(0, 1, 1.0, 1e-2, 0)];
        let Finding { is_true, text } = reported_errors("s", false, &good);
        assert!(is_true && text.contains("s, exact: estimate met by every pixel at 2 of 2"), "{text}");
        let bad = [measured(0, 0, 1.0, 0.2, 7), measured(0, 1, 1.0, 1e-3, 0)];
        let Finding { is_true, text } = reported_errors("s", false, &bad);
        assert!(!is_true);
        assert!(text.contains("met by every pixel at 1 of 2 tolerances; tolerance met at 1 of 2"), "{text}");
        assert!(text.contains("broken at exact 1.000e-1: 7 pixels") && text.contains("1.50 times"), "{text}");
        assert!(text.contains("not met at exact 1.000e-1: error up to 2.00e-1"), "{text}");
    }

    #[test]
    fn runs_that_no_exact_run_beats_are_listed() {
        let mut runs = vec![measured(0, 0, 1.0, 1e-2, 0), measured(0, 1, 4.0, 1e-4, 0)];
        runs.extend([measured(3, 0, 1.0, 1e-2, 0), measured(3, 1, 5.0, 1e-4, 0)]);
        let [rmse, max] = &fastest("s", &runs)[..] else { panic!("two measures") };
        assert!(rmse.is_true && max.is_true && max.text.ends_with(": at 2 of 2 points\n"), "{max:?}");
        runs.extend([measured(3, 0, 3.0, 1e-3, 0), measured(3, 1, 9.0, 1e-5, 0)]);
        let Finding { is_true, text } = &fastest("s", &runs)[0];
        assert!(!is_true && text.starts_with("s, RMSE against the oracle: at 2 of 4 points\n"), "{text}");
        assert!(text.contains("1.00e-3 in 3.0000 s; exact has 4.0000 s for that"), "{text}");
        assert!(text.contains("1.00e-5 in 9.0000 s; exact has no run for that"), "{text}");
    }
}
