//! The texts of labels.

use super::bar::Bar;
use super::units::{power_of_ten, pretty};
use crate::frame::{Frame, Legend, two_digits_up};
use icoray_scene::Paint;
use icoray_scene::name::Stamp;
use icoray_scene::template::date;

/// A field's name. The scene may give one to the first field.
pub(super) fn name<'f>(frame: &'f Frame, legend: &'f Legend, field: &'f str) -> &'f str {
    let given = legend.labels.name.as_deref().filter(|_| field == frame.field);
    let known = || frame.descriptions.get(field).and_then(|known| known.long_name.as_deref());
    given.or_else(known).unwrap_or(field)
}

/// Units of a field, for values divided by a power of ten; the scene may set those of the first field. `None` for a
/// field without units or factor.
pub(super) fn units(frame: &Frame, legend: &Legend, field: &str, exponent: i32) -> Option<String> {
    let given = legend.labels.units.as_deref().filter(|_| field == frame.field);
    let known = || frame.descriptions.get(field).and_then(|known| known.units.as_deref());
    pretty(given.or_else(known).unwrap_or(""), exponent)
}

/// Caption of a bar: name and units of its values divided by a power of ten, and the field of their opacity.
pub(super) fn caption(frame: &Frame, legend: &Legend, bar: &Bar, exponent: i32) -> Vec<String> {
    let name = name(frame, legend, bar.field);
    let units = units(frame, legend, bar.field, exponent);
    let first = units.map_or_else(|| name.to_owned(), |units| format!("{name} ({units})"));
    let by = bar.opacity_by.map(|by| format!("opacity by {}", self::name(frame, legend, by)));
    [Some(first), by].into_iter().flatten().collect()
}

/// The isosurfaces of one field.
pub(super) struct Key {
    /// The field's name.
    pub name: String,
    /// Values with their colours, the last with the field's units; a surface that is painted by another field has none.
    pub values: Vec<(String, Option<[f64; 3]>)>,
}

/// Legend of the isosurfaces' colours, by field.
pub(super) fn keys(frame: &Frame, legend: &Legend) -> Vec<Key> {
    let mut fields: Vec<&str> = Vec::new();
    let surfaces = &legend.scene.scenery.isosurfaces;
    for surface in surfaces {
        if !fields.contains(&surface.field.as_str()) {
            fields.push(&surface.field);
        }
    }
    let key = |field: &str| {
        let values = surfaces.iter().filter(|surface| surface.field == field).map(|surface| {
            let color = match &surface.paint {
                Paint::Plain(color) => Some(*color),
                Paint::Field { field: painter, transfer, .. } => {
                    (painter == field).then(|| transfer.at(surface.value).0)
                }
            };
            (value(surface.value), color)
        });
        let mut values: Vec<_> = values.collect();
        if let (Some((last, _)), Some(units)) = (values.last_mut(), units(frame, legend, field, 0)) {
            *last += &format!(" {units}");
        }
        Key { name: name(frame, legend, field).to_owned(), values }
    };
    fields.into_iter().map(key).collect()
}

/// A value in typographic form.
fn value(value: f64) -> String {
    const PLAIN: std::ops::Range<f64> = 1e-3..1e5;
    let text = if value == 0.0 || PLAIN.contains(&value.abs()) { value.to_string() } else { format!("{value:e}") };
    let (digits, power) = text.split_at(text.find('e').unwrap_or(text.len()));
    match digits {
        "1" | "-1" if !power.is_empty() => printed(&text).replacen("1 × ", "", 1),
        _ => printed(&text),
    }
    .replacen('-', "−", 1)
}

/// The title's lines, without those that are empty. A title with a date becomes the model's time if the frame has no date.
pub(super) fn title(frame: &Frame, legend: &Legend) -> Vec<String> {
    let word = |word: &str| match word {
        "name" => name(frame, legend, &frame.field).to_owned(),
        "units" => units(frame, legend, &frame.field, 0).unwrap_or_default(),
        "time" => time(&frame.stamp),
        "exaggeration" => legend.scene.exaggeration.to_string(),
        _ => frame.field.clone(),
    };
    let text = legend.labels.title.fill(&frame.stamp, word).unwrap_or_else(|_| time(&frame.stamp));
    // A field without units has no brackets for them.
    let lines = text.lines().map(|line| line.replace(" ()", ""));
    lines.filter(|line| !line.trim().is_empty()).collect()
}

/// Time of a frame: its date, else the model's day and time of day, else its step.
fn time(stamp: &Stamp) -> String {
    if let Ok([year, month, day, hour, minute, second]) = date(stamp) {
        let second = if second.trim_matches(['0', '.']).is_empty() { String::new() } else { format!(":{second}") };
        return format!("{year}-{month}-{day} {hour}:{minute}{second}");
    }
    if let Some(date) = &stamp.date {
        return date.trim().to_owned();
    }
    // Files without times have 0 at every step.
    if stamp.time_s == 0.0 && stamp.step != 0 || stamp.time_s.abs() >= 1e15 {
        return format!("step {}", stamp.step);
    }
    let whole = stamp.time_s.floor() as i64;
    let (days, rest) = (whole.div_euclid(86_400), whole.rem_euclid(86_400));
    let (hours, minutes, seconds) = (rest / 3600, rest / 60 % 60, rest % 60);
    let seconds = if seconds == 0 { String::new() } else { format!(":{seconds:02}") };
    format!("day {days} {hours:02}:{minutes:02}{seconds}").replace('-', "−")
}

/// Whether the last note reports an error above the tolerance: that of more than one in a thousand pixels.
pub(super) fn is_over(frame: &Frame, legend: &Legend) -> bool {
    let [p999, tolerance] = [frame.report.error.p999, frame.report.quality.tolerance].map(|error| error as f32);
    legend.labels.error_note != Some(false) && p999 > tolerance
}

/// Notes on the picture: exaggeration and, if requested or above the tolerance, error.
pub(super) fn notes(frame: &Frame, legend: &Legend) -> Vec<String> {
    let mut notes = Vec::new();
    if legend.labels.scale_note && legend.scene.exaggeration != 1.0 {
        notes.push(format!("vertical × {}", legend.scene.exaggeration));
    }
    if legend.labels.error_note == Some(true) || is_over(frame, legend) {
        let error = &frame.report.error;
        let mut note = format!("error ≤ {} ({})", printed(&two_digits_up(error.max)), error.certainty);
        if is_over(frame, legend) {
            note += &format!(", above {} in {} px", value(frame.report.quality.tolerance), error.pixels_over_tolerance);
        }
        notes.push(note);
    }
    notes
}

/// A number in typographic form: `1.2e-3` as 1.2 × 10⁻³.
fn printed(number: &str) -> String {
    let parts = number.split_once('e').and_then(|(digits, power)| Some((digits, power.parse().ok()?)));
    match parts {
        Some((digits, 0)) => digits.to_owned(),
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
        let values = [0.0, 250.0, -0.02, 1e-4, -1e-4, 2.5e-4, -3e7, 1e5].map(value);
        assert_eq!(values, ["0", "250", "−0.02", "10⁻⁴", "−10⁻⁴", "2.5 × 10⁻⁴", "−3 × 10⁷", "10⁵"]);
    }
}
