//! Conditions on fields, such as `max(vorticity) > 1e-4`, and the statistics of fields that they compare.

use icoray_grid::Field;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A statistic of a field, computed in one pass. Each value, at a centre or corner, has the same weight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Statistic {
    /// The least value.
    Min,
    /// The greatest value.
    Max,
    /// The mean of the values.
    Mean,
}

const STATISTICS: [(&str, Statistic); 3] =
    [("min", Statistic::Min), ("max", Statistic::Max), ("mean", Statistic::Mean)];

impl Statistic {
    /// The statistic of the values that are not missing; `None` if all are. Bitwise equal on any number of threads and
    /// ranks.
    pub fn of(self, field: &Field) -> Option<f64> {
        Summary::of(field, None, &[self]).get(self)
    }
}

impl fmt::Display for Statistic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = STATISTICS.iter().find(|(_, statistic)| statistic == self);
        f.write_str(named.map_or("", |(name, _)| name))
    }
}

/// Whether a value and a limit compare in a way.
type Relation = fn(&f64, &f64) -> bool;

/// Relations by their signs: longer ones first, since some begin with a shorter one.
const RELATIONS: [(&str, Relation); 4] = [("<=", f64::le), (">=", f64::ge), ("<", f64::lt), (">", f64::gt)];

/// A comparison of a field's statistic with a number.
#[derive(Debug, Clone, PartialEq)]
pub struct Condition {
    statistic: Statistic,
    field: String,
    /// That of a relation.
    sign: &'static str,
    limit: f64,
}

impl Condition {
    /// Parses `max(field) > 1e-4`; the error names the text that is not understood and what was expected.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let unexpected = |rest: &str, wish: &str| {
            let found = if rest.is_empty() { "its end".to_owned() } else { format!("{rest:?}") };
            let place = text.chars().count() - rest.chars().count() + 1;
            format!("{text:?}: {found} at character {place}, expected {wish}")
        };
        let rest = text.trim_start();
        let word = rest.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(rest.len());
        let named = STATISTICS.iter().find(|(name, _)| *name == &rest[..word]);
        let (_, statistic) = named.ok_or_else(|| unexpected(rest, "min, max or mean"))?;
        let rest = rest[word..].trim_start();
        let inside = rest.strip_prefix('(').ok_or_else(|| unexpected(rest, "a field's name in parentheses"))?;
        let close = inside.find(')').ok_or_else(|| unexpected(inside, "a field's name and )"))?;
        let field = inside[..close].trim();
        if field.is_empty() {
            return Err(unexpected(inside, "a field's name"));
        }
        let rest = inside[close + 1..].trim_start();
        let relation = RELATIONS.iter().find(|(sign, _)| rest.starts_with(sign));
        let (sign, _) = relation.ok_or_else(|| unexpected(rest, "<, <=, > or >="))?;
        let rest = rest[sign.len()..].trim();
        let limit = rest.parse().ok().filter(|limit: &f64| limit.is_finite());
        let limit = limit.ok_or_else(|| unexpected(&text[text.rfind(rest).unwrap_or(0)..], "a finite number"))?;
        Ok(Condition { statistic: *statistic, field: field.into(), sign, limit })
    }

    /// Name of the field.
    pub fn field(&self) -> &str {
        &self.field
    }

    /// The statistic of the field that is compared.
    pub fn statistic(&self) -> Statistic {
        self.statistic
    }

    /// Whether the condition holds for a statistic of `value`; false for `None`.
    pub fn holds(&self, value: Option<f64>) -> bool {
        let relation = RELATIONS.iter().find(|(sign, _)| *sign == self.sign);
        value.zip(relation).is_some_and(|(value, (_, holds))| holds(&value, &self.limit))
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}({}) {} {}", self.statistic, self.field, self.sign, self.limit)
    }
}

/// Number of columns that are summed separately: fixed, so that sums do not depend on the number of threads, and small,
/// so that rounding errors stay small.
const PIECE: usize = 1024;

/// Tests whether a column is included.
pub(crate) type Counted<'c> = &'c (dyn Fn(usize) -> bool + Sync);

/// The statistics of a field that were asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    low: f64,
    high: f64,
    sum: f64,
    count: u64,
}

impl Summary {
    /// The statistics of an empty set of values.
    pub const NOTHING: Summary = Summary { low: f64::INFINITY, high: f64::NEG_INFINITY, sum: 0.0, count: 0 };

    /// The statistics in `asked` over the columns that count; `None` counts all.
    pub fn of(field: &Field, counts: Option<Counted>, asked: &[Statistic]) -> Self {
        let mut summary = Self::NOTHING;
        if asked.iter().any(|statistic| *statistic != Statistic::Mean)
            && let (Some([low, high]), _) = field.range_over(counts)
        {
            summary.low = low;
            summary.high = high;
        }
        if asked.contains(&Statistic::Mean) {
            (summary.sum, summary.count) = sum(field, counts);
        }
        summary
    }

    /// A statistic that was asked for; `None` if all values are missing.
    pub fn get(&self, statistic: Statistic) -> Option<f64> {
        let is_known = self.low <= self.high;
        match statistic {
            Statistic::Min => is_known.then_some(self.low),
            Statistic::Max => is_known.then_some(self.high),
            Statistic::Mean => (self.count > 0).then(|| self.sum / self.count as f64),
        }
    }

    /// The statistics of both sets of values together.
    pub fn joined(self, other: Self) -> Self {
        Summary {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            sum: self.sum + other.sum,
            count: self.count + other.count,
        }
    }
}

/// The sum of the values that are not missing, and their number.
fn sum(field: &Field, counts: Option<Counted>) -> (f64, u64) {
    let shape = field.shape();
    let of_column = |column: usize| {
        let known = (0..shape.layers).map(|layer| field.value(column, layer)).filter(|v| !v.is_nan());
        known.fold((0.0, 0), |(sum, n), value| (sum + value, n + 1))
    };
    let added = |(a, n): (f64, u64), (b, m): (f64, u64)| (a + b, n + m);
    let of_piece = |piece: usize| {
        let columns = piece * PIECE..((piece + 1) * PIECE).min(shape.columns);
        let counted = columns.filter(|column| counts.is_none_or(|counts| counts(*column)));
        counted.map(of_column).fold((0.0, 0), added)
    };
    let pieces: Vec<_> = (0..shape.columns.div_ceil(PIECE)).into_par_iter().map(of_piece).collect();
    pieces.into_iter().fold((0.0, 0), added)
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray_grid::{Location, Shape};

    #[test]
    fn conditions_hold_on_their_side() {
        for (text, below, at, above) in [
            ("max(q) > 2", false, false, true),
            (" max ( q )>=2.0 ", false, true, true),
            ("max(q)<2", true, false, false),
            ("max(q) <= 0.2e1", true, true, false),
        ] {
            let condition = Condition::parse(text).unwrap();
            assert_eq!((condition.field(), condition.statistic()), ("q", Statistic::Max));
            let holds = [1.9, 2.0, 2.1].map(|value| condition.holds(Some(value)));
            assert_eq!(holds, [below, at, above], "{text}");
            assert!(!condition.holds(None) && !condition.holds(Some(f64::NAN)));
        }
        let text = Condition::parse("mean(relative humidity)<=-1e-7").unwrap().to_string();
        assert_eq!(text, "mean(relative humidity) <= -0.0000001");
    }

    #[test]
    fn errors_point_at_the_part_of_a_condition() {
        for (text, part) in [
            ("", "its end at character 1, expected min, max or mean"),
            ("most(q) > 1", "\"most(q) > 1\" at character 1, expected min, max or mean"),
            ("max q > 1", "\"q > 1\" at character 5, expected a field's name in parentheses"),
            ("max(q > 1", "\"q > 1\" at character 5, expected a field's name and )"),
            ("max( ) > 1", "\" ) > 1\" at character 5, expected a field's name"),
            ("max(q) = 1", "\"= 1\" at character 8, expected <, <=, > or >="),
            ("max(q)", "its end at character 7, expected <"),
            ("max(q) > ", "its end at character 10, expected a finite number"),
            ("max(q) > 1 K", "\"1 K\" at character 10, expected a finite number"),
            ("max(q) >> 1", "\"> 1\" at character 9, expected a finite number"),
            ("max(q) > inf", "\"inf\" at character 10"),
        ] {
            let error = Condition::parse(text).unwrap_err();
            assert!(error.contains(part), "{error}");
            assert!(error.starts_with(&format!("{text:?}: ")), "{error}");
        }
    }

    #[test]
    fn statistics_are_of_the_values_that_are_there() {
        let values = [1.0, -3.0, 9e9, 4.0, f64::NAN, 6.0];
        let of = |values: &[f64], statistic: Statistic| {
            let shape = Shape::level_fastest(2, 3);
            statistic.of(&Field::new(values.into(), shape, Location::Center, Some(9e9)).unwrap())
        };
        let all = [Statistic::Min, Statistic::Max, Statistic::Mean];
        assert_eq!(all.map(|statistic| of(&values, statistic)), [Some(-3.0), Some(6.0), Some(2.0)]);
        assert_eq!(all.map(|statistic| of(&[9e9; 6], statistic)), [None; 3]);
    }
}
