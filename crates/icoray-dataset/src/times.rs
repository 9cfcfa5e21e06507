//! Dates of the time records of a dataset.

use crate::calendar::{Clock, seconds_of};
use crate::source::{Kind, Source, SourceVariable, Variable};
use icoray::{ErrorKind, Result, printable};

/// Limit of the number of time records; a century has fewer hours.
const MAX_RECORDS: usize = 1 << 20;

/// MPAS's dates as text: of history and restart files, and of MPAS-Ocean's means, at the beginning of their intervals.
const TEXTS: [&str; 4] = ["xtime", "xtime_startMonthly", "xtime_startDaily", "xtime_startYearly"];

/// The time records of a source.
#[derive(Debug, Clone, PartialEq)]
pub struct Times {
    /// The number of records; 0 if there is no such dimension.
    pub records: usize,
    /// The date of each record, as in [`Dataset::times`](crate::Dataset::times).
    pub dates: Vec<Option<String>>,
    /// Whether a variable has the dates: then a record without one is not written yet.
    pub is_dated: bool,
    /// Seconds from the first record to each, as in [`Dataset::seconds`](crate::Dataset::seconds).
    pub seconds: Option<Vec<f64>>,
}

impl Times {
    /// Reads the times of a source.
    ///
    /// # Errors
    /// [`ErrorKind::Io`] if there are more than a million, as in a damaged header.
    pub fn read(source: &dyn Source) -> Result<Self> {
        let records = records(source)?;
        let dates = dates(source, records.max(1));
        let seconds = seconds(source, &dates);
        let is_dated = text(source).is_some() || source.each_variable().any(|found| clock(found).is_some());
        Ok(Times { records, is_dated, seconds, dates })
    }
}

/// The number of time records; 0 if there is no such dimension.
fn records(source: &dyn Source) -> Result<usize> {
    let own = source.variables().iter().filter(|v| v.changes()).map(|v| v.dimensions[0].len);
    let mut records = own.max().unwrap_or(0);
    for name in ["Time", "time"] {
        records = source.dimension_len(name)?.unwrap_or(0).max(records);
    }
    if records <= MAX_RECORDS {
        return Ok(records);
    }
    let context = format!("Time is {records}, expected at most {MAX_RECORDS}: the header is damaged");
    Err(source.error(ErrorKind::Io, context))
}

/// The variable with MPAS's dates.
fn text(source: &dyn Source) -> Option<&Variable> {
    let text = TEXTS.iter().filter_map(|name| source.variable(name)).find(|v| v.kind == Kind::Text);
    text.filter(|v| v.dimensions.len() == 2 && v.changes())
}

/// The date of each of `count` records; `None` if it cannot be read.
fn dates(source: &dyn Source, count: usize) -> Vec<Option<String>> {
    if let Some(variable) = text(source) {
        let rows = source.text_rows(variable, count);
        let date = |text: String| (!text.is_empty()).then(|| printable(&text).into_owned());
        return rows.into_iter().map(|text| text.and_then(date)).collect();
    }
    let counted = source.each_variable().find_map(|found| Some((found.variable, clock(found)?)));
    let Some((variable, clock)) = counted else { return vec![None; count] };
    let read = |first: usize, count: usize| -> Result<Vec<f64>> {
        let numbers = source.reals(variable, &[first], &[count])?;
        Ok((0..count).map(|record| numbers.as_reals().get(record)).collect())
    };
    // In a file that is cut off, the numbers before its end.
    let before_end = || (0..count).map_while(|record| read(record, 1).ok()).flatten().collect();
    let numbers = read(0, variable.dimensions[0].len).unwrap_or_else(|_| before_end());
    (0..count).map(|record| numbers.get(record).and_then(|number| clock.date(*number))).collect()
}

/// Seconds from the first of these dates to each, in the file's calendar, up to the last date; `None` if an earlier one
/// is missing or invalid.
fn seconds(source: &dyn Source, dates: &[Option<String>]) -> Option<Vec<f64>> {
    let of_times = source.variables().iter().filter(|v| v.changes() && v.dimensions.len() == 1);
    let of_times = of_times.filter_map(|v| source.text_of(&v.name, "calendar").ok()?).next();
    let of_mpas = || source.text("config_calendar_type").ok()?;
    let calendar = of_times.or_else(of_mpas).unwrap_or_else(|| "standard".into());
    let written = dates.iter().rposition(Option::is_some)?;
    let all: Option<Vec<f64>> = dates[..=written].iter().map(|date| seconds_of(date.as_ref()?, &calendar)).collect();
    all.map(|all| all.iter().map(|seconds| seconds - all[0]).collect())
}

/// The clock of a variable over time records only that has CF's units of time.
fn clock(found: SourceVariable) -> Option<Clock> {
    let variable = found.variable;
    if !(variable.changes() && variable.dimensions.len() == 1 && variable.kind.is_number()) {
        return None;
    }
    let units = found.text("units").ok()??;
    let calendar = found.text("calendar").ok()?;
    Clock::new(&units, calendar.as_deref())
}
