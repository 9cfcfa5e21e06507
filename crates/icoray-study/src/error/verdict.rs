//! Is the default method's curve of error against time the lowest?

use std::fmt::Write as _;

/// A run as a point of a plot.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    pub label: String,
    pub seconds: f64,
    pub error: f64,
}

/// Position of another method's point relative to the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Standing {
    /// A run of the curve is neither slower nor worse.
    Dominated,
    /// The curve, interpolated between its runs, is lower or equal at the point's time.
    AboveCurve,
    /// The curve has this larger error at the point's time.
    BelowCurve(f64),
    /// No run of the curve is as fast as the point; this is its fastest.
    FasterThanCurve(f64),
}

/// The curve's lower envelope: by time, each run better than all faster ones.
pub fn envelope(curve: &[Point]) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> = curve.iter().map(|p| (p.seconds, p.error)).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut best = f64::INFINITY;
    points.retain(|p| {
        p.1 < best && {
            best = p.1;
            true
        }
    });
    points
}

/// The envelope's error at a time: straight between its points on logarithmic axes, level after the last. `None` before
/// the first.
pub fn error_at(envelope: &[(f64, f64)], seconds: f64) -> Option<f64> {
    let after = envelope.partition_point(|p| p.0 <= seconds);
    let (t0, e0) = *envelope.get(after.checked_sub(1)?)?;
    let Some(&(t1, e1)) = envelope.get(after) else { return Some(e0) };
    if e1 <= 0.0 || t0 <= 0.0 {
        return Some(e0);
    }
    Some(e0 * (e1 / e0).powf((seconds / t0).ln() / (t1 / t0).ln()))
}

/// How each of `others` lies to the curve.
pub fn judge(curve: &[Point], others: &[Point]) -> Vec<Standing> {
    let envelope = envelope(curve);
    let standing = |p: &Point| {
        if envelope.iter().any(|(t, e)| *t <= p.seconds && *e <= p.error) {
            return Standing::Dominated;
        }
        match error_at(&envelope, p.seconds) {
            Some(error) if error <= p.error => Standing::AboveCurve,
            Some(error) => Standing::BelowCurve(error),
            None => Standing::FasterThanCurve(envelope.first().map_or(f64::INFINITY, |p| p.0)),
        }
    };
    others.iter().map(standing).collect()
}

/// The verdict on one scene by one measure of error, in words; and whether the curve is lower everywhere.
pub fn verdict_report(scene: &str, measure: &str, curve: &[Point], others: &[Point]) -> (bool, String) {
    let standings = judge(curve, others);
    let count = |wanted: fn(&Standing) -> bool| standings.iter().filter(|s| wanted(s)).count();
    let (dominated, under) = (count(|s| *s == Standing::Dominated), count(|s| *s == Standing::AboveCurve));
    let fast = count(|s| matches!(s, Standing::FasterThanCurve(_)));
    let above = others.len() - dominated - under - fast;
    let all = above + fast == 0;
    let mut text = format!(
        "{scene}, {measure}: {} lower or equal at {} of {} points of other methods \
         ({dominated} by a run no slower and no worse, {under} between runs); {above} lower at equal time, {fast} faster \
         than any exact run\n",
        if all { "yes," } else { "no," },
        dominated + under,
        others.len(),
    );
    for (point, standing) in others.iter().zip(&standings) {
        let reason = match standing {
            Standing::Dominated | Standing::AboveCurve => continue,
            Standing::BelowCurve(error) => format!("exact has {error:.2e} in that time"),
            Standing::FasterThanCurve(fastest) => format!("exact's fastest run takes {fastest:.4} s"),
        };
        let _ = writeln!(text, "    not at {}: {:.2e} in {:.4} s; {reason}", point.label, point.error, point.seconds);
    }
    (all, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(seconds: f64, error: f64) -> Point {
        Point { label: format!("p {seconds}"), seconds, error }
    }

    #[test]
    fn the_curve_is_read_between_its_runs_on_logarithmic_axes() {
        let curve = envelope(&[point(4.0, 1e-4), point(1.0, 1e-2), point(2.0, 0.5), point(9.0, 1e-3)]);
        assert_eq!(curve, [(1.0, 1e-2), (4.0, 1e-4)]);
        assert_eq!(error_at(&curve, 0.5), None);
        assert_eq!(error_at(&curve, 1.0), Some(1e-2));
        assert!((error_at(&curve, 2.0).unwrap() - 1e-3).abs() < 1e-15);
        assert_eq!(error_at(&curve, 100.0), Some(1e-4));
        assert_eq!(error_at(&[], 1.0), None);
    }

    #[test]
    fn points_are_beaten_under_above_or_too_fast() {
        let curve = [point(1.0, 1e-2), point(4.0, 1e-4)];
        let others = [point(1.0, 1e-2), point(2.0, 2e-3), point(2.0, 5e-4), point(0.5, 1.0)];
        let standings = judge(&curve, &others);
        assert_eq!(standings[..2], [Standing::Dominated, Standing::AboveCurve]);
        assert!(matches!(standings[2], Standing::BelowCurve(e) if (e - 1e-3).abs() < 1e-12));
        assert_eq!(standings[3], Standing::FasterThanCurve(1.0));
        // A point that the curve cannot get down to, however long it takes.
        assert_eq!(judge(&curve, &[point(9.0, 1e-6)]), [Standing::BelowCurve(1e-4)]);
    }

    #[test]
    fn the_verdict_fails_where_it_must() {
        let curve = [point(1.0, 1e-2), point(4.0, 1e-4)];
        let (all, text) = verdict_report("s", "RMSE", &curve, &[point(1.0, 1e-1), point(3.0, 1e-5)]);
        assert!(!all);
        assert!(text.starts_with("s, RMSE: no, lower or equal at 1 of 2 points"), "{text}");
        assert!(text.contains("not at p 3: 1.00e-5 in 3.0000 s; exact has"), "{text}");
        let (all, text) = verdict_report("s", "RMSE", &curve, &[point(1.0, 1e-1), point(5.0, 1e-4)]);
        assert!(all && text.contains("yes, lower or equal at 2 of 2"), "{text}");
        // Without a curve nothing is lower.
        assert!(!verdict_report("s", "RMSE", &[], &[point(1.0, 1.0)]).0);
    }
}
