//! What labels say.

use super::Legend;
use super::units::{power_of_ten, pretty};
use crate::frame::{Frame, two_digits_up};
use crate::output::{Stamp, date};

/// The field's name.
fn name<'f>(frame: &'f Frame, legend: &'f Legend) -> &'f str {
    let given = legend.labels.name.as_ref().or(frame.description.long_name.as_ref());
    given.map_or(&frame.field, String::as_str)
}

fn units<'f>(frame: &'f Frame, legend: &'f Legend) -> &'f str {
    let given = legend.labels.units.as_ref().or(frame.description.units.as_ref());
    given.map_or("", String::as_str)
}

/// Name and units of values that the bar shows divided by a power of ten.
pub(super) fn caption(frame: &Frame, legend: &Legend, exponent: i32) -> String {
    let name = name(frame, legend);
    pretty(units(frame, legend), exponent)
        .map_or_else(|| name.to_owned(), |units| format!("{name} ({units})"))
}

/// The title's lines. Where it has a date and the frame has none, the time stands for all of it.
pub(super) fn title(frame: &Frame, legend: &Legend) -> Vec<String> {
    let word = |word: &str| match word {
        "name" => name(frame, legend).to_owned(),
        "units" => pretty(units(frame, legend), 0).unwrap_or_default(),
        "time" => time(&frame.stamp),
        "exaggeration" => legend.scene.exaggeration.to_string(),
        _ => frame.field.clone(),
    };
    let text = legend.labels.title.fill(&frame.stamp, word).unwrap_or_else(|_| time(&frame.stamp));
    text.lines().filter(|line| !line.trim().is_empty()).map(str::to_owned).collect()
}

/// When a frame is: its date, else the model's day and time of day, else its step.
fn time(stamp: &Stamp) -> String {
    if let Ok([year, month, day, hour, minute, second]) = date(stamp) {
        let second =
            if second.trim_matches(['0', '.']).is_empty() { String::new() } else { format!(":{second}") };
        return format!("{year}-{month}-{day} {hour}:{minute}{second}");
    }
    if let Some(date) = &stamp.date {
        return date.trim().to_owned();
    }
    // Files that know of no time have 0 at every step.
    if stamp.time_s == 0.0 && stamp.step != 0 || stamp.time_s.abs() >= 1e15 {
        return format!("step {}", stamp.step);
    }
    let whole = stamp.time_s.floor() as i64;
    let (days, rest) = (whole.div_euclid(86_400), whole.rem_euclid(86_400));
    let (hours, minutes, seconds) = (rest / 3600, rest / 60 % 60, rest % 60);
    let seconds = if seconds == 0 { String::new() } else { format!(":{seconds:02}") };
    format!("day {days} {hours:02}:{minutes:02}{seconds}").replace('-', "−")
}

/// How the picture is to be read: exaggeration, and how far it may be off.
pub(super) fn notes(frame: &Frame, legend: &Legend) -> Vec<String> {
    let mut notes = Vec::new();
    if legend.labels.scale_note && legend.scene.exaggeration != 1.0 {
        notes.push(format!("vertical × {}", legend.scene.exaggeration));
    }
    if legend.labels.error_note {
        let error = &frame.report.error;
        notes.push(format!("error ≤ {} ({})", printed(&two_digits_up(error.max)), error.certainty));
    }
    notes
}

/// A number as print has it: `1.2e-3` as 1.2 × 10⁻³.
fn printed(number: &str) -> String {
    let parts = number.split_once('e').and_then(|(digits, power)| Some((digits, power.parse().ok()?)));
    match parts {
        Some((digits, power)) => format!("{digits} × {}", power_of_ten(power)),
        None => number.replace("inf", "∞"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_dates_or_days_or_steps() {
        let stamp = |step, time_s, date: Option<&str>| Stamp { step, time_s, date: date.map(Into::into) };
        for (stamp, text) in [
            (stamp(3, 0.0, Some("0000-01-07_06:30:00")), "0000-01-07 06:30"),
            (stamp(3, 9.0, Some("2026-11-21T01:02:03Z")), "2026-11-21 01:02:03"),
            (stamp(3, 9.0, Some(" spring ")), "spring"),
            (stamp(0, 0.0, None), "day 0 00:00"),
            (stamp(7, 0.0, None), "step 7"),
            (stamp(7, 12.0 * 86_400.0 + 6.5 * 3600.0, None), "day 12 06:30"),
            (stamp(7, 61.7, None), "day 0 00:01:01"),
            (stamp(7, -60.0, None), "day −1 23:59"),
            (stamp(7, 1e300, None), "step 7"),
        ] {
            assert_eq!(time(&stamp), text);
        }
    }

    #[test]
    fn numbers_are_printed_with_powers() {
        assert_eq!(["1.2e-3", "0", "inf"].map(printed), ["1.2 × 10⁻³", "0", "∞"]);
    }
}
