//! Describes a model's run, from its summary line and from `report.csv` with a line per frame.

use std::collections::BTreeMap;

use csv::{ReaderBuilder, Trim};

/// The lines on a run: seconds of the simulation and of its pictures, in all, per time step and per picture; the errors
/// of the pixels; the ranks. `printed` has the model's last line, `summary steps=576 frames=25 simulation_s=21.3 ...`.
pub fn describe(printed: &[String], csv: &str) -> String {
    let line = printed.iter().rev().find_map(|line| line.strip_prefix("summary ")).unwrap_or_default();
    let value = |key: &str| {
        let mut entries = line.split_whitespace().filter_map(|entry| entry.split_once('='));
        entries.find(|(name, _)| *name == key).and_then(|(_, value)| number(value))
    };
    let seconds = [value("simulation_s"), value("visualization_s")];
    let mut text = format!("{:<24}{:>12}{:>16}", "seconds", "simulation", "visualization");
    let per = |name: &str, count: Option<f64>| Some((format!("per {name} ({})", count?), count.filter(|n| *n > 0.0)?));
    let rows = [Some(("in all".into(), 1.0)), per("step", value("steps")), per("picture", value("frames"))];
    for (title, divisor) in rows.into_iter().flatten() {
        let [simulation, pictures] =
            seconds.map(|seconds| seconds.map_or("unknown".into(), |seconds: f64| format!("{:.4}", seconds / divisor)));
        text += &format!("\n{title:<24}{simulation:>12}{pictures:>16}");
    }
    let table = Table::read(csv);
    text + &errors(&table).unwrap_or_default() + &ranks(&table).unwrap_or_default()
}

/// The errors of the pixels of all frames.
fn errors(table: &Table) -> Option<String> {
    let column = |name| table.numbers(name);
    let (max, mean, p999) = (column("error_max")?, column("error_mean")?, column("error_p999")?);
    let is_bound = table.column("error_is_bound")?.iter().all(|cell| *cell == "true");
    Some(format!(
        "\n\npictures' error, of a channel from 0 to 1: {:.1e} at most, {:.1e} in the mean,\n\
         99.9% of the pixels of each below {:.1e} ({})",
        largest(&max),
        average(&mean),
        largest(&p999),
        if is_bound { "a bound" } else { "an estimate" }
    ))
}

/// How ranks shared the work, where there were several.
fn ranks(table: &Table) -> Option<String> {
    let count = Some(largest(&table.numbers("ranks")?)).filter(|count| *count > 1.0)?;
    let balance = average(&table.numbers("balance")?);
    Some(format!("\ndrawn by {count} ranks; balance {balance:.2} in the mean, where 1 is even"))
}

/// The cells of a report by the names of its columns.
pub struct Table(Vec<BTreeMap<String, String>>);

impl Table {
    /// Reads the text of `report.csv`: a header, and a line per frame. Lines that cannot be read are left out.
    pub fn read(csv: &str) -> Self {
        let mut reader = ReaderBuilder::new().trim(Trim::All).from_reader(csv.as_bytes());
        Self(reader.deserialize().flatten().collect())
    }

    /// The number in the column `name` of the last row with the text `value` in the column `key`.
    pub fn number(&self, key: &str, value: &str, name: &str) -> Option<f64> {
        let row = self.0.iter().rfind(|row| row.get(key).is_some_and(|cell| cell == value))?;
        number(row.get(name)?)
    }

    /// A column.
    fn column(&self, name: &str) -> Option<Vec<&str>> {
        self.0.iter().map(|row| row.get(name).map(String::as_str)).collect()
    }

    /// A column of numbers; `None` where there are none, or one of them cannot be read.
    fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        let numbers: Option<Vec<f64>> = self.column(name)?.into_iter().map(number).collect();
        numbers.filter(|numbers| !numbers.is_empty())
    }
}

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

fn average(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / numbers.len() as f64
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    const CSV: &str = "file,error_max,error_mean,error_p999,error_is_bound,ranks,balance\n\
                       \"a,b.png\",2e-4,1e-6,5e-5,true,2,0.5\n\
                       c.png,1e-4,3e-6,8e-5,BOUND,2,1\r\n";

    #[test]
    fn a_run_is_described_by_its_summary_and_its_report() {
        let printed = ["summary steps=100 frames=4 simulation_s=20 visualization_s=2 rest", "end"].map(str::to_owned);
        let expected = "seconds                   simulation   visualization\n\
                        in all                       20.0000          2.0000\n\
                        per step (100)                0.2000          0.0200\n\
                        per picture (4)               5.0000          0.5000\n\n\
                        pictures' error, of a channel from 0 to 1: 2.0e-4 at most, 2.0e-6 in the mean,\n\
                        99.9% of the pixels of each below 8.0e-5 (an estimate)\n\
                        drawn by 2 ranks; balance 0.75 in the mean, where 1 is even";
        assert_eq!(describe(&printed, CSV), expected);
        assert!(describe(&printed, &CSV.replace("BOUND", "true")).contains("(a bound)"));
    }

    #[test]
    fn what_cannot_be_read_is_left_out() {
        let text = describe(&["summary steps=many frames=0 simulation_s=nan".to_owned()], CSV.lines().next().unwrap());
        assert_eq!(text.lines().count(), 2, "{text}");
        assert!(text.ends_with("in all                       unknown         unknown"), "{text}");
        for odd in [CSV.replace("3e-6", "?"), CSV.replace("error_p999", "p999")] {
            assert!(!describe(&[], &odd).contains("error"), "{odd}");
        }
        assert_eq!(Table::read(CSV).number("file", "a,b.png", "error_max"), Some(2e-4));
    }
}
