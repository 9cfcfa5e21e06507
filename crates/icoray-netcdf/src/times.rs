//! When the records of a file were.

use crate::calendar::{Clock, seconds_of};
use crate::source::{Kind, Source, Variable};
use icoray::{ErrorKind, Result};

/// More time records than any file has: hourly ones for a century are fewer.
const MAX_RECORDS: usize = 1 << 20;

/// MPAS's dates as text: of history and restart files, and of MPAS-Ocean's means, at the beginning of what they cover.
const TEXTS: [&str; 4] = ["xtime", "xtime_startMonthly", "xtime_startDaily", "xtime_startYearly"];

/// Whether a dimension is that of the time records.
pub(crate) fn is_time(dimension: &str) -> bool {
    dimension.eq_ignore_ascii_case("time")
}

/// The number of time records, 0 where there is no such dimension.
pub(crate) fn records(source: &Source) -> Result<usize> {
    let mut records = 0;
    for name in ["Time", "time"] {
        records = source.dimension_len(name)?.unwrap_or(0).max(records);
    }
    if records <= MAX_RECORDS {
        return Ok(records);
    }
    let context = format!("Time is {records}, expected at most {MAX_RECORDS}: the header is damaged");
    Err(source.error(ErrorKind::Io, context))
}

/// The date of each of `count` records. They are labels: whatever is wrong with one gives none and stops nothing.
pub(crate) fn dates(source: &Source, count: usize) -> Vec<Option<String>> {
    let text = TEXTS.iter().filter_map(|name| source.variable(name)).find(|v| v.kind == Kind::Text);
    if let Some(variable) = text.filter(|v| v.dimensions.len() == 2 && is_time(&v.dimensions[0].name)) {
        let rows = source.text_rows(variable, count);
        return rows.into_iter().map(|text| text.filter(|text| !text.is_empty())).collect();
    }
    let counted = source.variables().iter().find_map(|v| Some((v, clock(source, v)?)));
    let numbers = counted.and_then(|(variable, clock)| Some((source.all_numbers(variable).ok()?, clock)));
    let Some((numbers, clock)) = numbers else {
        return vec![None; count];
    };
    (0..count).map(|record| numbers.get(record).and_then(|number| clock.date(*number))).collect()
}

/// Seconds from the first of these dates to each, in the file's calendar; `None` where a date lacks or is not understood.
pub(crate) fn seconds(source: &Source, dates: &[Option<String>]) -> Option<Vec<f64>> {
    let of_times = source.variables().iter().filter(|v| is_time(&v.name));
    let of_times = of_times.filter_map(|v| source.text_of(&v.name, "calendar").ok()?).next();
    let of_mpas = || source.text("config_calendar_type").ok()?;
    let calendar = of_times.or_else(of_mpas).unwrap_or_else(|| "standard".into());
    let all: Option<Vec<f64>> = dates.iter().map(|date| seconds_of(date.as_ref()?, &calendar)).collect();
    all.map(|all| all.iter().map(|seconds| seconds - all[0]).collect())
}

/// What the numbers of a time variable mean: of one over the time records alone that has CF's units of time.
fn clock(source: &Source, variable: &Variable) -> Option<Clock> {
    let is_over_time = matches!(&variable.dimensions[..], [only] if is_time(&only.name));
    let is_number = matches!(variable.kind, Kind::F32 | Kind::F64 | Kind::Integer);
    if !(is_over_time && is_number) {
        return None;
    }
    let units = source.text_of(&variable.name, "units").ok()??;
    let calendar = source.text_of(&variable.name, "calendar").ok()?;
    Clock::new(&units, calendar.as_deref())
}
