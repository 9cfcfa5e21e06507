//! Labels that people would write, and properties of all ticks.

use super::*;
use icoray_test_support::Random;

const SYMLOG: Scale = Scale::SymLog { threshold: 1e-5 };

fn labels(scale: Scale, range: [f64; 2], max_count: usize) -> (Vec<String>, i32) {
    let ticks = ticks(scale, range, max_count);
    (ticks.major.into_iter().map(|(_, label)| label).collect(), ticks.exponent)
}

#[test]
fn ticks_are_numbers_that_people_would_write() {
    for (scale, range, max_count, expected, exponent) in [
        (Scale::Linear, [0.0, 1.0], 6, &["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"][..], 0),
        (Scale::Linear, [268.0, 304.0], 5, &["270", "280", "290", "300"], 0),
        (Scale::Linear, [-7e-5, 7e-5], 8, &["−6", "−4", "−2", "0", "2", "4", "6"], -5),
        (Scale::Linear, [-0.015, 0.015], 7, &["−0.015", "−0.010", "−0.005", "0.000", "0.005", "0.010", "0.015"], 0),
        (Scale::Linear, [-40.0, 37.5], 6, &["−40", "−20", "0", "20"], 0),
        (Scale::Linear, [98_000.0, 104_000.0], 4, &["98000", "100000", "102000", "104000"], 0),
        (Scale::Linear, [0.0, 3e6], 4, &["0", "1", "2", "3"], 6),
        (Scale::Linear, [1e-9, 3.1e-9], 3, &["1", "2", "3"], -9),
        (Scale::Linear, [1.000_01, 1.000_03], 3, &["1.00001", "1.00002", "1.00003"], 0),
        (Scale::Linear, [0.0, 1.0], 2, &["0.0", "0.5", "1.0"], 0),
        (Scale::Log, [1e-9, 3e-3], 9, &["10⁻⁹", "10⁻⁸", "10⁻⁷", "10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³"], 0),
        (Scale::Log, [1e-9, 3e-3], 4, &["10⁻⁸", "10⁻⁶", "10⁻⁴"], 0),
        (Scale::Log, [0.1, 1000.0], 6, &["0.1", "1", "10", "100", "1000"], 0),
        (Scale::Log, [2.0, 40.0], 6, &["2", "5", "10", "20"], 0),
        (Scale::Log, [2e-7, 4e-6], 6, &["0.2", "0.5", "1", "2"], -6),
        (Scale::Log, [3.0, 4.0], 6, &["3.0", "3.2", "3.4", "3.6", "3.8", "4.0"], 0),
        (SYMLOG, [-2e-3, 5e-2], 5, &["−10⁻⁴", "0", "10⁻⁴", "10⁻²"], 0),
        (SYMLOG, [-2e-3, 5e-2], 12, &["−10⁻³", "−10⁻⁴", "−10⁻⁵", "0", "10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²"], 0),
        (SYMLOG, [-1e-5, 1e-3], 9, &["−10⁻⁵", "0", "10⁻⁵", "10⁻⁴", "10⁻³"], 0),
        (SYMLOG, [-2e-6, 2e-6], 5, &["−2", "−1", "0", "1", "2"], -6),
        (SYMLOG, [-1e-2, -1e-4], 5, &["−10⁻²", "−10⁻³", "−10⁻⁴"], 0),
        (Scale::SymLog { threshold: 1.0 }, [-20.0, 200.0], 9, &["−10", "−1", "0", "1", "10", "100"], 0),
    ] {
        let (found, power) = labels(scale, range, max_count);
        assert_eq!(
            (found.as_slice(), power),
            (&expected.iter().map(ToString::to_string).collect::<Vec<_>>()[..], exponent),
            "{scale:?} {range:?}"
        );
    }
}

/// The number that a label stands for.
fn meant(label: &str, exponent: i32) -> f64 {
    let plain = label.replace('−', "-");
    let value = match plain.split_once("10").filter(|(_, rest)| rest.starts_with(|c| "⁻⁰¹²³⁴⁵⁶⁷⁸⁹".contains(c)))
    {
        None => plain.parse::<f64>().unwrap(),
        Some((sign, raised)) => {
            let digits = "⁰¹²³⁴⁵⁶⁷⁸⁹";
            let digit = |c| digits.chars().position(|d| d == c).map_or("-".into(), |d| d.to_string());
            let power: String = raised.chars().map(digit).collect();
            format!("{sign}1e{power}").parse().unwrap()
        }
    };
    value * 10f64.powi(exponent)
}

#[test]
fn ticks_rise_within_the_range_and_show_their_values() {
    let mut random = Random::new(1);
    for case in 0..20_000 {
        let threshold = 10f64.powf(8.0 * random.unit() - 6.0);
        let scale = [Scale::Linear, Scale::Log, Scale::SymLog { threshold }][case % 3];
        let mut end = || {
            let size = 10f64.powf(24.0 * random.unit() - 12.0);
            if scale != Scale::Log && random.unit() < 0.5 { -size } else { size }
        };
        let (a, b) = (end(), end());
        // Also narrow ranges far from 0.
        let b = if case % 5 == 0 { a * 1.001 } else { b };
        let range = [a.min(b), a.max(b)];
        let max_count = 2 + (9.0 * random.unit()) as usize;
        let Ticks { major, minor, exponent } = ticks(scale, range, max_count);
        let message = format!("{scale:?} {range:?} at most {max_count}: {major:?}");
        assert!(!major.is_empty() && major.len() <= max_count.max(3), "{message}");
        assert!(major.is_sorted_by(|a, b| a.0 < b.0), "{message}");
        let slack = 1e-8 * range[0].abs().max(range[1].abs());
        let all = major.iter().map(|(v, _)| v).chain(&minor);
        assert!(all.into_iter().all(|v| range[0] - slack <= *v && *v <= range[1] + slack), "{message}");
        for (value, label) in &major {
            let deviation = (meant(label, exponent) - value).abs();
            assert!(deviation <= 1e-9 * value.abs().max(slack), "{message}: {label} by {deviation}");
            assert!(!label.contains('-') && label.chars().count() <= 16, "{message}: {label}");
        }
        let mut different: Vec<&String> = major.iter().map(|(_, label)| label).collect();
        different.dedup();
        assert_eq!(different.len(), major.len(), "{message}");
    }
}

/// Steps are 1, 2 or 5 times a power of ten, and the next finer ones would be too many.
#[test]
fn linear_steps_are_the_finest_that_fit() {
    let mut random = Random::new(1);
    for _ in 0..5000 {
        let low = 200.0 * random.unit() - 100.0;
        let span = 10f64.powf(6.0 * random.unit() - 4.0);
        let max_count = 5 + (8.0 * random.unit()) as usize;
        let values: Vec<f64> = ticks(Scale::Linear, [low, low + span], max_count).major.iter().map(|t| t.0).collect();
        let [first, second] = values[..2] else { panic!("{values:?}") };
        let step = second - first;
        let lead = step / 10f64.powf(step.log10().floor() + 1e-9);
        assert!([1.0, 2.0, 5.0, 10.0].iter().any(|nice| (lead - nice).abs() < 1e-3), "{lead}");
        let finer = if (lead - 5.0).abs() < 1e-3 { step * 0.4 } else { step * 0.5 };
        assert!(span / finer > max_count as f64 - 1.0, "{low} {span} {max_count}: {step}");
    }
}
