//! Ticks of a colour bar: steps of 1, 2 or 5 times a power of ten, powers of ten on a logarithmic scale.

use super::units::power_of_ten;
use icoray_scene::Scale;

/// Ticks of a range.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Ticks {
    /// Values with their labels, rising.
    pub major: Vec<(f64, String)>,
    /// Values of ticks without labels.
    pub minor: Vec<f64>,
    /// Power of ten by which labelled values are divided; it precedes the units.
    pub exponent: i32,
}

/// Largest and smallest powers of ten of a range's larger end that are written out.
const PLAIN: std::ops::Range<i32> = -2..6;
/// Powers of ten that are written out on logarithmic scales if all of a bar's are among them.
const PLAIN_DECADES: std::ops::RangeInclusive<i32> = -2..=3;
/// Largest number of decades with minor ticks.
const FINE_DECADES: usize = 9;

/// No more than `max_count` ticks with labels over a range that rises, where that is 3 or more.
pub(super) fn ticks(scale: Scale, range: [f64; 2], max_count: usize) -> Ticks {
    let max_count = max_count.max(3);
    match scale {
        Scale::Linear => linear(range, max_count),
        Scale::Log => log(range, max_count),
        Scale::SymLog { threshold } => symlog(range, threshold, max_count),
    }
}

/// Whole multiples of `step` within a range whose ends may be off by rounding.
fn multiples([low, high]: [f64; 2], step: f64) -> std::ops::RangeInclusive<i64> {
    (low / step - 1e-9).ceil() as i64..=(high / step + 1e-9).floor() as i64
}

/// `10^power`, correctly rounded where possible.
fn decade(power: i32) -> f64 {
    format!("1e{power}").parse().expect("it is a number")
}

/// The largest power of ten that does not exceed a positive number, up to rounding.
fn order(value: f64) -> i32 {
    (value.log10() + 1e-9).floor() as i32
}

fn linear(range: [f64; 2], max_count: usize) -> Ticks {
    let span = range[1] - range[0];
    let lowest = order(span / max_count as f64) - 1;
    // Multiplied by a whole number or divided by a power of ten, so that 3 steps of 0.1 are 0.3.
    let steps = (lowest..).flat_map(|power| [1, 2, 5].map(|times| (times, power)));
    let fits = |(times, power): &(i64, i32)| multiples(range, *times as f64 * decade(*power)).count() <= max_count;
    let Some((times, power)) = steps.take(16).find(fits) else { return Ticks::default() };
    let value = |k: i64| {
        let whole = (k * times) as f64;
        if power < 0 { whole / decade(-power) } else { whole * decade(power) }
    };
    let largest = order(range[0].abs().max(range[1].abs()));
    let exponent = if PLAIN.contains(&largest) { 0 } else { largest };
    let decimals = usize::try_from(exponent - power).unwrap_or(0);
    let label = |v: f64| minus(&format!("{:.decimals$}", v / decade(exponent)));
    let major = multiples(range, times as f64 * decade(power)).map(|k| (value(k), label(value(k)))).collect();
    Ticks { major, minor: Vec::new(), exponent }
}

/// With a minus sign in place of a hyphen, and no minus before 0.
fn minus(number: &str) -> String {
    match number.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|b| b"0.".contains(&b)) => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => number.to_owned(),
    }
}

/// Powers of ten from `low` to `high`, and the interval of labelled ones for at most `max_count` labels.
fn decades(low: i32, high: i32, max_count: usize) -> impl Iterator<Item = (i32, bool)> {
    let count = usize::try_from(high - low + 1).unwrap_or(0);
    let stride = count.div_ceil(max_count).max(1) as i32;
    (low..=high).map(move |power| (power, power.rem_euclid(stride) == 0 || count == 1))
}

/// Notation of powers of ten on one bar.
fn decade_label(power: i32, are_plain: bool) -> String {
    match are_plain {
        true => format!("{:.*}", usize::try_from(-power).unwrap_or(0), decade(power)),
        false => power_of_ten(power),
    }
}

fn log([low, high]: [f64; 2], max_count: usize) -> Ticks {
    let (first, last) = ((low.log10() - 1e-9).ceil() as i32, order(high));
    let count = usize::try_from(last - first + 1).unwrap_or(0);
    // Over few decades, labels at powers of ten alone are too sparse.
    if count < 2 {
        return within_decades([low, high], max_count);
    }
    let are_plain = PLAIN_DECADES.contains(&first) && PLAIN_DECADES.contains(&last);
    let mut ticks = Ticks::default();
    for (power, has_label) in decades(first, last, max_count) {
        match has_label {
            true => ticks.major.push((decade(power), decade_label(power, are_plain))),
            false => ticks.minor.push(decade(power)),
        }
    }
    if count <= FINE_DECADES {
        ticks.minor.extend(fine(first - 1..=last).filter(|v| low <= *v && *v <= high));
    }
    ticks
}

/// 2 to 9 times powers of ten.
fn fine(powers: std::ops::RangeInclusive<i32>) -> impl Iterator<Item = f64> {
    powers.flat_map(|power| (2..10).map(move |times| f64::from(times) * decade(power)))
}

/// 1, 2 and 5 times powers of ten if these are at least three, else even steps.
fn within_decades(range: [f64; 2], max_count: usize) -> Ticks {
    let is_in = |v: &f64| range[0] * (1.0 - 1e-9) <= *v && *v <= range[1] * (1.0 + 1e-9);
    let powers = order(range[0])..=order(range[1]);
    let values = powers.flat_map(|power| [1.0, 2.0, 5.0].map(|times| times * decade(power)));
    let values: Vec<f64> = values.filter(is_in).collect();
    if values.len() < 3 || values.len() > max_count {
        return linear(range, max_count);
    }
    let exponent = if PLAIN.contains(&order(range[1])) { 0 } else { order(range[1]) };
    let label = |v: f64| {
        let decimals = usize::try_from(exponent - order(v)).unwrap_or(0);
        format!("{:.decimals$}", v / decade(exponent))
    };
    let major = values.iter().map(|v| (*v, label(*v))).collect();
    let minor = fine(order(range[0])..=order(range[1])).filter(is_in).filter(|v| !values.contains(v)).collect();
    Ticks { major, minor, exponent }
}

fn symlog([low, high]: [f64; 2], threshold: f64, max_count: usize) -> Ticks {
    if low >= threshold {
        return log([low, high], max_count);
    }
    if high <= -threshold {
        return mirrored(log([-high, -low], max_count));
    }
    let first = (threshold.log10() - 1e-9).ceil() as i32;
    let last = [-low, high].map(|end| if end > 0.0 { order(end) } else { first - 1 });
    let count = last.map(|last| usize::try_from(last - first + 1).unwrap_or(0));
    let has_zero = low <= 0.0 && high >= 0.0;
    if count[0] + count[1] == 0 {
        return linear([low, high], max_count);
    }
    // A label for 0, and the same powers on both sides.
    let room = (max_count - usize::from(has_zero)).max(1) / if count[0] * count[1] > 0 { 2 } else { 1 };
    let top = last[0].max(last[1]);
    let stride = count[0].max(count[1]).div_ceil(room.max(1)) as i32;
    let has_plain_labels = PLAIN_DECADES.contains(&first) && PLAIN_DECADES.contains(&top);
    let side = |sign: f64, last: i32| {
        let powers = (first..=last).map(move |power| (power, (top - power) % stride == 0));
        powers.map(move |(power, has_label)| {
            let label = decade_label(power, has_plain_labels);
            let label = if sign < 0.0 { format!("−{label}") } else { label };
            (sign * decade(power), has_label.then_some(label))
        })
    };
    let zero = has_zero.then(|| (0.0, Some("0".to_owned())));
    let all = side(-1.0, last[0]).collect::<Vec<_>>().into_iter().rev().chain(zero).chain(side(1.0, last[1]));
    let mut ticks = Ticks::default();
    for (value, label) in all.filter(|(value, _)| is_between(*value, [low, high])) {
        match label {
            Some(label) => ticks.major.push((value, label)),
            None => ticks.minor.push(value),
        }
    }
    ticks
}

/// The ticks of the negated values.
fn mirrored(mut ticks: Ticks) -> Ticks {
    ticks.major = ticks.major.into_iter().rev().map(|(value, label)| (-value, format!("−{label}"))).collect();
    ticks.minor = ticks.minor.into_iter().rev().map(|value| -value).collect();
    ticks
}

/// Whether a value is within a range, up to rounding.
fn is_between(value: f64, [low, high]: [f64; 2]) -> bool {
    let slack = 1e-9 * value.abs();
    low - slack <= value && value <= high + slack
}

#[cfg(test)]
mod tests;
