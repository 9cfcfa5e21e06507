//! Dates from CF's times: a count of days, hours, minutes or seconds since a date, in the calendars of models.
//!
//! CF conventions 1.11, §4.4. Days are counted from 1970-01-01 in the Gregorian calendar, the algorithms are those of
//! Howard Hinnant, <https://howardhinnant.github.io/date_algorithms.html>.

/// Seconds of a day.
const DAY_S: i64 = 86_400;
/// The first day of the Gregorian calendar, 1582-10-15.
const REFORM: i64 = -141_427;
/// Maximum distance of dates from the epoch: a million years.
const MAX_DAYS: f64 = 366e6;

/// Lengths of months and years.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Calendar {
    /// Julian up to 1582-10-04, Gregorian from 1582-10-15: CF's `standard`.
    Mixed,
    Gregorian,
    Julian,
    /// All years have months of these lengths.
    Equal([i64; 12]),
}

/// Lengths of months in years that are never, or always, leap years.
const NO_LEAP: [i64; 12] = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
const ALL_LEAP: [i64; 12] = [31, 29, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];

impl Calendar {
    fn named(name: &str) -> Option<Self> {
        Some(match name.to_ascii_lowercase().as_str() {
            "standard" | "gregorian" => Calendar::Mixed,
            "proleptic_gregorian" => Calendar::Gregorian,
            "julian" => Calendar::Julian,
            "noleap" | "365_day" => Calendar::Equal(NO_LEAP),
            "all_leap" | "366_day" => Calendar::Equal(ALL_LEAP),
            "360_day" => Calendar::Equal([30; 12]),
            _ => return None,
        })
    }

    fn day_of(self, date: [i64; 3]) -> i64 {
        let [year, month, day] = date;
        match self {
            Calendar::Gregorian => GREGORIAN.day_of(date),
            Calendar::Julian => JULIAN.day_of(date),
            Calendar::Mixed if GREGORIAN.day_of(date) >= REFORM => GREGORIAN.day_of(date),
            Calendar::Mixed => JULIAN.day_of(date),
            Calendar::Equal(months) => {
                let before: i64 = months[..month as usize - 1].iter().sum();
                year * months.iter().sum::<i64>() + before + day - 1
            }
        }
    }

    /// The second of a date and time, as [`Self::day_of`] counts days.
    fn second_of(self, [year, month, day, hour, minute, second]: [i64; 6]) -> i64 {
        self.day_of([year, month, day]) * DAY_S + hour * 3600 + minute * 60 + second
    }

    fn date_of(self, days: i64) -> [i64; 3] {
        match self {
            Calendar::Gregorian => GREGORIAN.date_of(days),
            Calendar::Julian => JULIAN.date_of(days),
            Calendar::Mixed if days >= REFORM => GREGORIAN.date_of(days),
            Calendar::Mixed => JULIAN.date_of(days),
            Calendar::Equal(months) => {
                let length: i64 = months.iter().sum();
                let (mut month, mut day) = (0, days.rem_euclid(length));
                while day >= months[month] {
                    day -= months[month];
                    month += 1;
                }
                [days.div_euclid(length), month as i64 + 1, day + 1]
            }
        }
    }
}

/// Leap years that recur in cycles of `years` with `days`, of which the first begins `epoch` days before 1970-01-01.
struct Cycle {
    years: i64,
    days: i64,
    epoch: i64,
}

const GREGORIAN: Cycle = Cycle { years: 400, days: 146_097, epoch: 719_468 };
const JULIAN: Cycle = Cycle { years: 4, days: 1461, epoch: 719_470 };

/// Days of the first `years` of a cycle; a Julian cycle has no centuries.
fn days_of(years: i64) -> i64 {
    365 * years + years / 4 - years / 100
}

/// Years begin in March, so that leap days are the last of a year.
impl Cycle {
    fn day_of(&self, [year, month, day]: [i64; 3]) -> i64 {
        let year = if month <= 2 { year - 1 } else { year };
        let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
        let (cycle, year) = (year.div_euclid(self.years), year.rem_euclid(self.years));
        cycle * self.days + days_of(year) + day_of_year - self.epoch
    }

    fn date_of(&self, days: i64) -> [i64; 3] {
        let days = days + self.epoch;
        let (cycle, day) = (days.div_euclid(self.days), days.rem_euclid(self.days));
        let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
        let day_of_year = day - days_of(year);
        let month = (5 * day_of_year + 2) / 153;
        let day = day_of_year - (153 * month + 2) / 5 + 1;
        let (year, month) = (year + cycle * self.years, if month < 10 { month + 3 } else { month - 9 });
        [if month <= 2 { year + 1 } else { year }, month, day]
    }
}

/// Meaning of the numbers of a time variable.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Clock {
    /// Units since a date.
    Since { calendar: Calendar, unit_s: f64, epoch_s: i64 },
    /// `day as %Y%m%d.%f`: digits of the date, and the day's fraction, as written by the CDO.
    Digits,
}

impl Clock {
    /// The clock of CF's attributes `units` and `calendar`; `None` if they do not determine a date, such as months
    /// since one.
    pub(crate) fn new(units: &str, calendar: Option<&str>) -> Option<Self> {
        if units.trim() == "day as %Y%m%d.%f" {
            return Some(Clock::Digits);
        }
        let calendar = Calendar::named(calendar.unwrap_or("standard"))?;
        let (unit, since) = units.split_once(" since ")?;
        let unit_s = match unit.trim().to_ascii_lowercase().as_str() {
            "days" | "day" | "d" => 86_400.0,
            "hours" | "hour" | "hrs" | "hr" | "h" => 3600.0,
            "minutes" | "minute" | "mins" | "min" => 60.0,
            "seconds" | "second" | "secs" | "sec" | "s" => 1.0,
            _ => return None,
        };
        let epoch_s = calendar.second_of(date_and_time(since)?);
        Some(Clock::Since { calendar, unit_s, epoch_s })
    }

    /// The date of `number` as `YYYY-MM-DD_hh:mm:ss`; `None` if it is not a date.
    pub(crate) fn date(&self, number: f64) -> Option<String> {
        let (date, second) = match self {
            Clock::Digits => {
                let (digits, fraction) = (number.floor(), number - number.floor());
                let second = (fraction * DAY_S as f64).round() as i64;
                let digits = (1e4..1e11).contains(&digits).then_some(digits as i64)?;
                let date = [digits / 10_000, digits / 100 % 100, digits % 100];
                (date, second.min(DAY_S - 1))
            }
            Clock::Since { calendar, unit_s, epoch_s } => {
                let seconds = number * unit_s;
                let is_near = seconds.abs() <= MAX_DAYS * DAY_S as f64;
                let seconds = is_near.then(|| seconds.round() as i64 + epoch_s)?;
                let date = calendar.date_of(seconds.div_euclid(DAY_S));
                (date, seconds.rem_euclid(DAY_S))
            }
        };
        let [year, month, day] = date;
        let (hour, minute) = (second / 3600, second / 60 % 60);
        Some(format!("{year:04}-{month:02}-{day:02}_{hour:02}:{minute:02}:{:02}", second % 60))
    }
}

/// Seconds from a day that is equal for all dates to one in MPAS's notation, in a calendar by CF's or MPAS's name.
pub(crate) fn seconds_of(date: &str, calendar: &str) -> Option<f64> {
    let calendar = match calendar {
        "gregorian_noleap" => "noleap",
        "360day" => "360_day",
        other => other,
    };
    Some(Calendar::named(calendar)?.second_of(date_and_time(date)?) as f64)
}

/// Year to second of texts like `1979-01-01 06:00:00.0 UTC`; a zone other than UTC is not supported.
fn date_and_time(text: &str) -> Option<[i64; 6]> {
    let text = text.trim();
    let zone = ["UTC", "Z", "+00:00", "+0:00"].iter().find_map(|zone| text.strip_suffix(zone));
    let text = zone.unwrap_or(text).trim();
    let (date, time) = text.split_once([' ', 'T', '_']).unwrap_or((text, ""));
    let mut numbers = [0; 6];
    let mut date = date.splitn(3, '-');
    for number in &mut numbers[..3] {
        *number = date.next()?.parse().ok()?;
    }
    let fine = (-1_000_000..1_000_000).contains(&numbers[0]) && (1..=12).contains(&numbers[1]);
    if !(fine && (1..=31).contains(&numbers[2])) {
        return None;
    }
    for (number, text) in numbers[3..].iter_mut().zip(time.split(':').filter(|text| !text.is_empty())) {
        let seconds: f64 = text.trim().parse().ok()?;
        *number = (0.0..=60.0).contains(&seconds).then_some(seconds as i64)?;
    }
    Some(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn date(units: &str, calendar: &str, number: f64) -> String {
        Clock::new(units, Some(calendar)).unwrap().date(number).unwrap()
    }

    /// From cftime 1.6.4's `num2date`.
    #[test]
    fn dates_are_those_of_cftime() {
        for (units, calendar, number, expected) in [
            ("days since 1979-01-01 00:00:00", "standard", 15_000.25, "2020-01-26_06:00:00"),
            ("days since 1582-10-04", "standard", 1.0, "1582-10-15_00:00:00"),
            ("days since 1582-10-04", "proleptic_gregorian", 1.0, "1582-10-05_00:00:00"),
            ("days since 0001-01-01", "julian", 700_000.0, "1917-07-01_00:00:00"),
            ("hours since 1900-01-01", "proleptic_gregorian", 1_000_000.0, "2014-01-29_16:00:00"),
            ("days since 2000-02-28", "noleap", 1.0, "2000-03-01_00:00:00"),
            ("days since 2001-02-28", "all_leap", 1.0, "2001-02-29_00:00:00"),
            ("days since 2001-02-28", "360_day", 2.0, "2001-02-30_00:00:00"),
            ("seconds since 2001-01-01T00:00:00Z", "365_day", -1.0, "2000-12-31_23:59:59"),
            ("minutes since 2016-2-28 12:00", "gregorian", 1440.0, "2016-02-29_12:00:00"),
            ("day as %Y%m%d.%f", "proleptic_gregorian", 19_790_131.75, "1979-01-31_18:00:00"),
        ] {
            assert_eq!(date(units, calendar, number), expected, "{number} {units} ({calendar})");
        }
    }

    #[test]
    fn days_and_dates_are_inverse_in_every_calendar() {
        for name in ["standard", "proleptic_gregorian", "julian", "noleap", "all_leap", "360_day"] {
            let calendar = Calendar::named(name).unwrap();
            let mut last = calendar.date_of(-800_001);
            for days in -800_000..800_000 {
                let date = calendar.date_of(days);
                assert_eq!(calendar.day_of(date), days, "{calendar:?} {date:?}");
                assert!(date > last, "{calendar:?} {date:?} after {last:?}");
                last = date;
            }
        }
    }

    #[test]
    fn differences_of_dates_follow_their_calendar() {
        let days = |calendar: &str| {
            let [from, to] = ["2004-02-28_12:00:00", "2004-03-01_12:00:30"].map(|date| seconds_of(date, calendar));
            Some((to? - from? - 30.0) / 86_400.0)
        };
        for (calendar, expected) in [
            ("gregorian", Some(2.0)),
            ("gregorian_noleap", Some(1.0)),
            ("360day", Some(3.0)),
            ("all_leap", Some(2.0)),
            ("martian", None),
        ] {
            assert_eq!(days(calendar), expected, "{calendar}");
        }
        assert_eq!(seconds_of("some day", "standard"), None);
    }

    #[test]
    fn texts_that_are_not_dates_give_none() {
        for units in ["months since 2000-01-01", "K", "days since tomorrow", "days since 2000-13-01", "days"] {
            assert_eq!(Clock::new(units, None), None, "{units}");
        }
        assert_eq!(Clock::new("days since 2000-01-01", Some("martian")), None);
        let clock = Clock::new("days since 2000-01-01", None).unwrap();
        for number in [f64::NAN, f64::INFINITY, 1e300, -1e12] {
            assert_eq!(clock.date(number), None, "{number}");
        }
        assert_eq!(Clock::Digits.date(f64::NAN), None);
    }
}
