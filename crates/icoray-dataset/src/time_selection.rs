//! Selection of a dataset's times: by number, by date, or by a range of either.

use icoray::{Error, ErrorKind, Result};
use std::borrow::Cow;
use std::cmp::Ordering;
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// A selection of times, as text: a number, a date, or a range of either.
#[derive(Debug, Clone, PartialEq)]
pub struct TimeSelection {
    text: Cow<'static, str>,
    selector: TimeSelector,
}

#[derive(Debug, Clone, PartialEq)]
enum TimeSelector {
    All,
    /// From 0; negative from the last.
    Number(i64),
    Numbers(Option<i64>, Option<i64>),
    Date(Date),
    Dates(Option<Date>, Option<Date>),
}

/// A prefix of `2003-01-01T06:00:00` with at least year and month: selects all times within.
#[derive(Debug, Clone, PartialEq)]
struct Date(Vec<i64>);

/// The expected syntax, for error messages.
const EXPECTED: &str = "expected a number, a date such as 2003-01-01T06 or 2003-01, a range such as 0..10 or \
                        2003-01..2003-03 (which ends before the second), or \"all\"";

impl FromStr for TimeSelection {
    type Err = &'static str;

    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        Ok(TimeSelection { text: text.to_owned().into(), selector: selector(text).ok_or(EXPECTED)? })
    }
}

impl fmt::Display for TimeSelection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

fn selector(text: &str) -> Option<TimeSelector> {
    if text == "all" {
        return Some(TimeSelector::All);
    }
    let Some((from, to)) = text.split_once("..") else {
        let number = text.parse().ok().map(TimeSelector::Number);
        return number.or_else(|| Date::new(text).map(TimeSelector::Date));
    };
    if let (Some(from), Some(to)) = (end(from, |t| t.parse().ok()), end(to, |t| t.parse().ok())) {
        return Some(TimeSelector::Numbers(from, to));
    }
    Some(TimeSelector::Dates(end(from, Date::new)?, end(to, Date::new)?))
}

/// Parses an end of a range, which may be empty.
fn end<T>(text: &str, read: impl Fn(&str) -> Option<T>) -> Option<Option<T>> {
    if text.is_empty() { Some(None) } else { read(text).map(Some) }
}

impl Date {
    fn new(text: &str) -> Option<Self> {
        let (date, time) = match text.split_once(['T', '_', ' ']) {
            Some((date, time)) => (date, Some(time)),
            None => (text, None),
        };
        let mut numbers = digits(date, '-')?;
        let fits = match time {
            None => (2..=3).contains(&numbers.len()),
            Some(_) => numbers.len() == 3,
        };
        numbers.extend(time.map_or(Some(Vec::new()), |time| digits(time, ':'))?);
        (fits && numbers.len() <= 6).then_some(Date(numbers))
    }

    /// Compares a time with this date; `Equal` if it is within.
    fn order_of(&self, time: &[i64]) -> Ordering {
        time[..self.0.len().min(time.len())].cmp(&self.0)
    }
}

fn digits(text: &str, between: char) -> Option<Vec<i64>> {
    let number = |part: &str| {
        let is_number = !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
        is_number.then(|| part.parse().ok()).flatten()
    };
    text.split(between).map(number).collect()
}

impl TimeSelection {
    /// All times.
    pub const ALL: Self = TimeSelection { text: Cow::Borrowed("all"), selector: TimeSelector::All };
    /// The last time.
    pub const LAST: Self = TimeSelection { text: Cow::Borrowed("-1"), selector: TimeSelector::Number(-1) };

    /// Whether the selection is a series: all times, or a range.
    pub fn is_series(&self) -> bool {
        !matches!(self.selector, TimeSelector::Number(_) | TimeSelector::Date(_))
    }

    /// The numbers of the selected times of a file, at least one.
    ///
    /// # Errors
    /// [`ErrorKind::Argument`] if none is selected, or a number that the file does not have.
    pub fn of(&self, times: &[Option<String>]) -> Result<Vec<usize>> {
        let within = |keeps: &dyn Fn(&[i64]) -> bool| {
            let dates = times.iter().enumerate().filter_map(|(i, date)| Some((i, Date::new(date.as_ref()?)?)));
            let found: Vec<usize> = dates.filter(|(_, date)| keeps(&date.0)).map(|(i, _)| i).collect();
            if found.is_empty() { Err(none_of(times)) } else { Ok(found) }
        };
        match &self.selector {
            TimeSelector::All => Ok((0..times.len()).collect()),
            TimeSelector::Number(number) => {
                let end = number.checked_add(1).filter(|&end| end != 0);
                self.numbers(Some(*number), end, times.len()).map(Iterator::collect)
            }
            TimeSelector::Numbers(from, to) => self.numbers(*from, *to, times.len()).map(Iterator::collect),
            TimeSelector::Date(date) => within(&|time| date.order_of(time).is_eq()),
            TimeSelector::Dates(from, to) => within(&|time| {
                from.as_ref().is_none_or(|from| from.order_of(time).is_ge())
                    && to.as_ref().is_none_or(|to| to.order_of(time).is_lt())
            }),
        }
    }

    fn numbers(&self, from: Option<i64>, to: Option<i64>, count: usize) -> Result<Range<usize>> {
        let max = i64::try_from(count).unwrap_or(i64::MAX);
        let place = |number: i64| usize::try_from(if number < 0 { number.saturating_add(max) } else { number }).ok();
        let range = place(from.unwrap_or(0)).zip(place(to.unwrap_or(max)));
        match range {
            Some((from, to)) if from < to && to <= count => Ok(from..to),
            _ => {
                let context = format!("expected {} to {}, the file's times", -max, max - 1);
                Err(Error::new(ErrorKind::Argument, context))
            }
        }
    }
}

/// The error about a date that no time has.
fn none_of(times: &[Option<String>]) -> Error {
    let dates = || times.iter().flatten();
    let context = match (dates().next(), dates().next_back()) {
        (Some(first), Some(last)) => format!("no time of the file, which has {first} to {last}"),
        _ => "the file's times have no dates, expected a number".into(),
    };
    Error::new(ErrorKind::Argument, context)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times() -> Vec<Option<String>> {
        let days = ["2003-01-30_00:00:00", "2003-01-30_12:00:00", "2003-01-31_00:00:00", "2003-02-01_00:00:00"];
        let mut times: Vec<_> = days.map(|day| Some(day.to_owned())).into();
        times.push(None);
        times
    }

    #[test]
    fn times_are_found_by_number_date_and_range() {
        for (text, expected) in [
            ("0", &[0][..]),
            ("4", &[4]),
            ("-1", &[4]),
            ("-5", &[0]),
            ("all", &[0, 1, 2, 3, 4]),
            ("..", &[0, 1, 2, 3, 4]),
            ("1..3", &[1, 2]),
            ("..2", &[0, 1]),
            ("-2..", &[3, 4]),
            ("0..-1", &[0, 1, 2, 3]),
            ("2003-01", &[0, 1, 2]),
            ("2003-01-30", &[0, 1]),
            ("2003-01-30T12", &[1]),
            ("2003-01-31_00:00:00", &[2]),
            ("2003-01-30T12..2003-02", &[1, 2]),
            ("2003-02..", &[3]),
            ("..2003-01-31", &[0, 1]),
        ] {
            assert_eq!(text.parse::<TimeSelection>().unwrap().of(&times()).unwrap(), expected, "{text}");
        }
    }

    #[test]
    fn errors_name_times_that_do_not_exist() {
        for (text, part) in [
            ("5", "expected -5 to 4, the file's times"),
            ("-6", "expected -5 to 4"),
            ("9223372036854775807", "expected -5 to 4"),
            ("-9223372036854775808", "expected -5 to 4"),
            ("3..3", "expected -5 to 4"),
            ("0..6", "expected -5 to 4"),
            ("2004-01", "no time of the file, which has 2003-01-30_00:00:00 to 2003-02-01_00:00:00"),
            ("2003-02..2003-01", "no time of the file"),
        ] {
            let error = text.parse::<TimeSelection>().unwrap().of(&times()).unwrap_err();
            assert!(error.to_string().contains(part), "{text}: {error}");
        }
        let error = "2003-01".parse::<TimeSelection>().unwrap().of(&[None]).unwrap_err();
        assert!(error.to_string().contains("have no dates"), "{error}");
    }

    #[test]
    fn ranges_are_series() {
        for (text, expected) in [("3", false), ("2003-01", false), ("all", true), ("3..", true), ("..2003-01", true)] {
            assert_eq!(text.parse::<TimeSelection>().unwrap().is_series(), expected, "{text}");
        }
    }

    #[test]
    fn texts_that_are_not_times_are_refused() {
        for text in ["", "now", "1.5", "2003-", "2003-01T00", "2003-01-01T", "1..2..3", "0..2003-01", "2003-01-01-01"] {
            assert_eq!(text.parse::<TimeSelection>(), Err(EXPECTED), "{text}");
        }
    }
}
