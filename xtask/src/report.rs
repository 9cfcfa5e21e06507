//! Reads what a model reports of its run: the summary line, and `report.csv` with a line per frame.

/// The last line of a model, `summary steps=576 frames=25 simulation_s=21.3 ...`. Values that the line lacks, or that
/// cannot be read, are `None`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Summary {
    /// Number of time steps.
    steps: Option<u64>,
    /// Number of pictures.
    frames: Option<u64>,
    /// Seconds of the simulation.
    simulation: Option<f64>,
    /// Seconds of the pictures.
    visualization: Option<f64>,
}

impl Summary {
    /// Finds the summary among the lines that a model printed.
    pub fn find(lines: &[String]) -> Self {
        let mut summary = Self::default();
        let line = lines.iter().rev().find_map(|line| line.strip_prefix("summary "));
        let entries = line.unwrap_or_default().split_whitespace();
        for (name, value) in entries.filter_map(|entry| entry.split_once('=')) {
            match name {
                "steps" => summary.steps = value.parse().ok(),
                "frames" => summary.frames = value.parse().ok(),
                "simulation_s" => summary.simulation = number(value),
                "visualization_s" => summary.visualization = number(value),
                _ => {}
            }
        }
        summary
    }

    /// The summary; values that it lacks are those of the report of the frames.
    pub fn or_from(self, frames: &Frames) -> Self {
        Self {
            frames: self.frames.or(Some(frames.count)),
            visualization: self.visualization.or(frames.visualization),
            ..self
        }
    }

    /// A table of the seconds, in all, per time step and per picture.
    pub fn table(&self) -> String {
        let mut rows = vec![("in all".to_owned(), 1)];
        rows.extend(self.steps.map(|steps| (format!("per step ({steps})"), steps)));
        rows.extend(self.frames.map(|frames| (format!("per picture ({frames})"), frames)));
        let row = |(title, divisor): &(String, u64)| {
            let cell =
                |total: Option<f64>| total.map_or("unknown".into(), |total| format!("{:.4}", total / *divisor as f64));
            format!("\n{title:<24}{:>12}{:>16}", cell(self.simulation), cell(self.visualization))
        };
        let head = format!("{:<24}{:>12}{:>16}", "seconds", "simulation", "visualization");
        head + &rows.iter().filter(|row| row.1 > 0).map(row).collect::<String>()
    }
}

/// The report of all frames. Values that it lacks, or that cannot be read, are `None`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frames {
    count: u64,
    /// Seconds of all frames.
    visualization: Option<f64>,
    pub errors: Option<Errors>,
    pub ranks: Option<Ranks>,
}

impl Frames {
    /// Reads the text of `report.csv`.
    pub fn read(csv: &str) -> Self {
        let table = Table::read(csv);
        let parts = ["prepare_s", "render_s", "write_s"].into_iter().filter(|name| table.has(name));
        // One number that cannot be read makes the sum wrong.
        let seconds: Option<Vec<f64>> = parts.map(|name| Some(table.numbers(name)?.iter().sum())).collect();
        Self {
            count: table.rows.len() as u64,
            visualization: seconds.filter(|seconds| !seconds.is_empty()).map(|seconds| seconds.iter().sum()),
            errors: Errors::read(&table),
            ranks: Ranks::read(&table),
        }
    }
}

/// How ranks shared the work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ranks {
    /// Largest number of ranks that rendered a frame.
    pub count: u64,
    /// Mean of the frames' load balance; 1 is even.
    balance: f64,
}

impl Ranks {
    fn read(table: &Table) -> Option<Self> {
        let count = largest(&table.numbers("ranks")?)? as u64;
        Some(Self { count, balance: mean(&table.numbers("balance")?) })
    }

    /// The ranks in a sentence.
    pub fn sentence(&self) -> String {
        format!("drawn by {} ranks; balance {:.2} in the mean, where 1 is even", self.count, self.balance)
    }
}

/// Errors of the pixels of all frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    max: f64,
    /// Mean of the frames' means.
    mean: f64,
    /// Largest 99.9th percentile of a frame.
    p999: f64,
    /// Whether they are bounds; otherwise estimates.
    bound: bool,
}

impl Errors {
    fn read(table: &Table) -> Option<Self> {
        Some(Self {
            max: largest(&table.numbers("error_max")?)?,
            mean: mean(&table.numbers("error_mean")?),
            p999: largest(&table.numbers("error_p999")?)?,
            bound: table.column("error_kind")?.iter().all(|kind| *kind == Some("bound")),
        })
    }

    /// The errors in a sentence.
    pub fn sentence(&self) -> String {
        let certainty = if self.bound { "a bound" } else { "an estimate" };
        format!(
            "pictures' error, of a channel from 0 to 1: {:.1e} at most, {:.1e} in the mean,\n\
             99.9% of the pixels of each below {:.1e} ({certainty})",
            self.max, self.mean, self.p999
        )
    }
}

/// The cells of a report by the names of its columns.
pub struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Reads the text of `report.csv`: a header, and a line per frame.
    pub fn read(csv: &str) -> Self {
        let mut lines = csv.lines().filter(|line| !line.trim().is_empty()).map(fields);
        Self { header: lines.next().unwrap_or_default(), rows: lines.collect() }
    }

    /// The number in the column `name` of the last row with the text `value` in the column `key`.
    pub fn number(&self, key: &str, value: &str, name: &str) -> Option<f64> {
        let row = self.column(key)?.iter().rposition(|cell| *cell == Some(value))?;
        number(self.column(name)?[row]?)
    }

    fn has(&self, name: &str) -> bool {
        self.header.iter().any(|head| head == name)
    }

    /// A column; `None` for the cells of rows that are too short.
    fn column(&self, name: &str) -> Option<Vec<Option<&str>>> {
        let column = self.header.iter().position(|head| head == name)?;
        Some(self.rows.iter().map(|row| row.get(column).map(String::as_str)).collect())
    }

    /// A column of numbers; `None` where one of them cannot be read.
    fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        self.column(name)?.into_iter().map(|cell| number(cell?)).collect()
    }
}

fn largest(numbers: &[f64]) -> Option<f64> {
    numbers.iter().copied().reduce(f64::max)
}

fn mean(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / numbers.len() as f64
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

/// The fields of a line of CSV; names of pictures may be quoted.
fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![];
    let mut field = String::new();
    let mut quoted = false;
    let mut characters = line.chars().peekable();
    while let Some(character) = characters.next() {
        match character {
            '"' if quoted && characters.next_if_eq(&'"').is_some() => field.push('"'),
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(std::mem::take(&mut field)),
            _ => field.push(character),
        }
    }
    fields.push(field);
    fields.iter().map(|field| field.trim().to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(count: u64, visualization: Option<f64>) -> Frames {
        Frames { count, visualization, errors: None, ranks: None }
    }

    #[test]
    fn the_summary_has_what_the_line_has() {
        let summary = |steps, frames, simulation, visualization| Summary { steps, frames, simulation, visualization };
        let line = "frame 0\nframe 1\nsummary steps=576 frames=25 simulation_s=21.3 visualization_s=3.1 \
                    mass_drift=1.2e-15 pictures_failed=0\n";
        for (text, expected) in [
            (line, summary(Some(576), Some(25), Some(21.3), Some(3.1))),
            ("frame 0\nframe 1", Summary::default()),
            ("", Summary::default()),
            ("summary steps=many frames=2 simulation_s=nan rest", summary(None, Some(2), None, None)),
        ] {
            let lines: Vec<_> = text.lines().map(str::to_owned).collect();
            assert_eq!(Summary::find(&lines), expected, "{text}");
        }
    }

    #[test]
    fn the_seconds_of_the_frames_are_summed_where_all_can_be_read() {
        let whole = "frame,picture,write_s,prepare_s,samples,render_s\n\
                     0,\"a, \"\"b\"\".png\",0.25,0.5,100,1\n\
                     1,c.png,0.25,0,100,1\r\n";
        for (csv, expected) in [
            (whole, frames(2, Some(3.0))),
            ("", frames(0, None)),
            ("frame\n0\n1\n", frames(2, None)),
            ("frame,render_s\n0,1.5\n1", frames(2, None)),
        ] {
            assert_eq!(Frames::read(csv), expected, "{csv}");
        }
    }

    #[test]
    fn the_errors_of_all_frames_are_put_together() {
        let csv = "file,error_max,error_mean,error_p999,error_kind,left_out\n\
                   \"a,b.png\",2e-4,1e-6,5e-5,bound,gradients\n\
                   c.png,1e-4,3e-6,8e-5,KIND,\n";
        let errors = |kind: &str| Frames::read(&csv.replace("KIND", kind)).errors.unwrap();
        assert_eq!(errors("bound"), Errors { max: 2e-4, mean: 2e-6, p999: 8e-5, bound: true });
        assert_eq!(
            errors("estimate").sentence(),
            "pictures' error, of a channel from 0 to 1: 2.0e-4 at most, 2.0e-6 in the mean,\n\
             99.9% of the pixels of each below 8.0e-5 (an estimate)"
        );
        for odd in [csv.replace("3e-6", "?"), csv.replace("error_p999", "p999")] {
            assert_eq!(Frames::read(&odd).errors, None, "{odd}");
        }
        assert_eq!(Frames::read(csv.lines().next().unwrap()).errors, None);
    }

    #[test]
    fn ranks_are_those_of_all_frames() {
        let csv = "file,ranks,balance\na.png,2,0.5\nb.png,2,1\n";
        assert_eq!(
            Frames::read(csv).ranks.unwrap().sentence(),
            "drawn by 2 ranks; balance 0.75 in the mean, where 1 is even"
        );
        assert_eq!(Frames::read(&csv.replace("balance", "evenness")).ranks, None);
    }

    #[test]
    fn the_table_has_what_the_summary_or_the_report_has() {
        let summary = Summary { steps: Some(100), simulation: Some(20.0), ..Summary::default() };
        let filled = summary.or_from(&frames(4, Some(2.0)));
        assert_eq!(
            filled.table(),
            "seconds                   simulation   visualization\n\
             in all                       20.0000          2.0000\n\
             per step (100)                0.2000          0.0200\n\
             per picture (4)               5.0000          0.5000"
        );
        assert_eq!(filled.or_from(&frames(5, Some(3.0))), filled);
        assert!(Summary::default().table().contains("unknown"));
    }
}
