//! What the tracer model says about its run: the summary line, and the report of its frames.

/// The last line of the tracer, `summary steps=576 frames=25 simulation_s=21.3 ...`.
///
/// Whatever the line lacks, or says in a way not understood, is absent here.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Summary {
    /// Time steps of the simulation.
    pub steps: Option<u64>,
    /// Pictures that were taken.
    pub frames: Option<u64>,
    /// Seconds spent simulating.
    pub simulation: Option<f64>,
    /// Seconds spent on the pictures.
    pub visualization: Option<f64>,
}

impl Summary {
    /// Finds the summary among the lines that the tracer printed.
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

    /// The summary with what it lacks taken from the report of the frames.
    pub fn or_from(self, frames: &Frames) -> Self {
        Self {
            frames: self.frames.or(Some(frames.count)),
            visualization: self.visualization.or(frames.visualization),
            ..self
        }
    }

    /// A table of the seconds spent, in all, per time step and per picture.
    pub fn table(&self) -> String {
        let mut lines = vec![format!("{:<24}{:>12}{:>16}", "seconds", "simulation", "visualization")];
        let mut row = |title: String, divisor: f64| {
            let cell = |total: Option<f64>| match total {
                Some(total) => format!("{:.4}", total / divisor),
                None => "unknown".into(),
            };
            let (simulation, visualization) = (cell(self.simulation), cell(self.visualization));
            lines.push(format!("{title:<24}{simulation:>12}{visualization:>16}"));
        };
        row("in all".into(), 1.0);
        if let Some(steps) = self.steps.filter(|&steps| steps > 0) {
            row(format!("per step ({steps})"), steps as f64);
        }
        if let Some(frames) = self.frames.filter(|&frames| frames > 0) {
            row(format!("per picture ({frames})"), frames as f64);
        }
        lines.join("\n")
    }
}

/// The report of the frames, in short.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frames {
    /// How many frames there are.
    pub count: u64,
    /// Seconds spent on all of them; absent where the report does not say.
    pub visualization: Option<f64>,
    /// How far their pixels may be off; absent where the report does not say.
    pub errors: Option<Errors>,
    /// Who drew them; absent where the report does not say.
    pub ranks: Option<Ranks>,
}

/// How ranks shared the work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ranks {
    /// The most that drew a frame.
    pub count: u64,
    /// Mean over the frames of how even they were loaded; 1 is even.
    balance: f64,
}

impl Ranks {
    fn read(header: &[String], rows: &[Vec<String>]) -> Option<Self> {
        let counts = numbers(header, rows, "ranks")?.into_iter().map(|count| count as u64);
        let balances = numbers(header, rows, "balance")?;
        Some(Self { count: counts.max()?, balance: balances.iter().sum::<f64>() / rows.len() as f64 })
    }

    /// The ranks in a sentence.
    pub fn sentence(&self) -> String {
        format!("drawn by {} ranks; balance {:.2} in the mean, where 1 is even", self.count, self.balance)
    }
}

/// How far the pixels of all frames may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Largest of a pixel.
    max: f64,
    /// Mean over the frames of their means.
    mean: f64,
    /// Largest 99.9th percentile of a frame.
    p999: f64,
    /// Whether they are bounds; otherwise estimates.
    bound: bool,
}

impl Errors {
    /// Reads the columns of errors; nothing where one is missing, or a number cannot be read.
    fn read(header: &[String], rows: &[Vec<String>]) -> Option<Self> {
        let numbers = |name: &str| numbers(header, rows, name);
        let kind = column(header, "error_kind")?;
        let largest = |numbers: Vec<f64>| numbers.into_iter().reduce(f64::max);
        Some(Self {
            max: largest(numbers("error_max")?)?,
            mean: numbers("error_mean")?.iter().sum::<f64>() / rows.len() as f64,
            p999: largest(numbers("error_p999")?)?,
            bound: rows.iter().all(|row| row.get(kind).is_some_and(|kind| kind == "bound")),
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

impl Frames {
    /// Reads `report.csv`: a header, and then a line per frame.
    pub fn read(csv: &str) -> Self {
        const PARTS: [&str; 3] = ["prepare_s", "render_s", "write_s"];
        let Table { header, rows } = Table::read(csv);
        let columns: Vec<usize> =
            (0..header.len()).filter(|&at| PARTS.contains(&header[at].as_str())).collect();
        let cells = rows.iter().flat_map(|row| columns.iter().map(|&column| row.get(column)));
        // One number that cannot be read makes the sum wrong, and no sum is better.
        let visualization: Option<f64> = cells.map(|cell| number(cell?)).sum();
        Self {
            count: rows.len() as u64,
            visualization: visualization.filter(|_| !columns.is_empty()),
            errors: Errors::read(&header, &rows),
            ranks: Ranks::read(&header, &rows),
        }
    }
}

/// A report's cells by the names of its columns.
pub struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Reads `report.csv`.
    pub fn read(csv: &str) -> Self {
        let mut lines = csv.lines().filter(|line| !line.trim().is_empty()).map(fields);
        Self { header: lines.next().unwrap_or_default(), rows: lines.collect() }
    }

    /// The number in a column, of the last row that has a word in another.
    pub fn number(&self, key: &str, word: &str, name: &str) -> Option<f64> {
        let (key, name) = (column(&self.header, key)?, column(&self.header, name)?);
        let row = self.rows.iter().rev().find(|row| row.get(key).is_some_and(|cell| cell == word))?;
        number(row.get(name)?)
    }
}

fn column(header: &[String], name: &str) -> Option<usize> {
    header.iter().position(|head| head == name)
}

/// A column of numbers; nothing where it is missing, or one of them cannot be read.
fn numbers(header: &[String], rows: &[Vec<String>], name: &str) -> Option<Vec<f64>> {
    let column = column(header, name)?;
    rows.iter().map(|row| number(row.get(column)?)).collect()
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

/// The fields of one line of CSV, which may be quoted, as the names of pictures might be.
fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut quoted = false;
    let mut characters = line.chars().peekable();
    while let Some(character) = characters.next() {
        // There is always a last field: the vector starts with one and only grows.
        let last = fields.len() - 1;
        match character {
            '"' if quoted && characters.peek() == Some(&'"') => {
                characters.next();
                fields[last].push('"');
            }
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            _ => fields[last].push(character),
        }
    }
    fields.iter().map(|field| field.trim().to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<String> {
        text.lines().map(str::to_owned).collect()
    }

    #[test]
    fn the_summary_line_is_found() {
        let output = lines(
            "frame 0\nframe 1\nsummary steps=576 frames=25 simulation_s=21.3 \
             visualization_s=3.1 mass_drift=1.2e-15 pictures_failed=0\n",
        );
        let expected =
            Summary { steps: Some(576), frames: Some(25), simulation: Some(21.3), visualization: Some(3.1) };
        assert_eq!(Summary::find(&output), expected);
    }

    #[test]
    fn a_summary_may_be_absent_or_odd() {
        assert_eq!(Summary::find(&lines("frame 0\nframe 1")), Summary::default());
        assert_eq!(Summary::find(&[]), Summary::default());
        let odd = Summary::find(&lines("summary steps=many frames=2 simulation_s=nan rest"));
        assert_eq!(odd, Summary { frames: Some(2), ..Summary::default() });
    }

    #[test]
    fn the_report_adds_up() {
        let csv = "frame,picture,write_s,prepare_s,samples,render_s\n\
                   0,\"a, \"\"b\"\".png\",0.25,0.5,100,1\n\
                   1,c.png,0.25,0,100,1\r\n";
        assert_eq!(
            Frames::read(csv),
            Frames { count: 2, visualization: Some(3.0), errors: None, ranks: None }
        );
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
    fn a_report_may_be_empty_or_odd() {
        assert_eq!(Frames::read(""), Frames { count: 0, visualization: None, errors: None, ranks: None });
        assert_eq!(
            Frames::read("frame\n0\n1\n"),
            Frames { count: 2, visualization: None, errors: None, ranks: None }
        );
        let cut_short = Frames::read("frame,render_s\n0,1.5\n1");
        assert_eq!(cut_short, Frames { count: 2, visualization: None, errors: None, ranks: None });
    }

    #[test]
    fn the_report_fills_in_for_the_summary() {
        let frames = Frames { count: 4, visualization: Some(2.0), errors: None, ranks: None };
        let filled = Summary::default().or_from(&frames);
        assert_eq!((filled.frames, filled.visualization), (Some(4), Some(2.0)));
        let summary = Summary { visualization: Some(3.0), ..Summary::default() };
        assert_eq!(summary.or_from(&frames).visualization, Some(3.0));
    }

    #[test]
    fn the_table_shows_what_is_known() {
        let summary =
            Summary { steps: Some(100), frames: Some(4), simulation: Some(20.0), visualization: Some(2.0) };
        assert_eq!(
            summary.table(),
            "seconds                   simulation   visualization\n\
             in all                       20.0000          2.0000\n\
             per step (100)                0.2000          0.0200\n\
             per picture (4)               5.0000          0.5000"
        );
        assert!(Summary::default().table().contains("unknown"));
    }
}
