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
                "simulation_s" => summary.simulation = seconds(value),
                "visualization_s" => summary.visualization = seconds(value),
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
}

impl Frames {
    /// Reads `report.csv`: a header, and then a line per frame.
    pub fn read(csv: &str) -> Self {
        const PARTS: [&str; 3] = ["prepare_s", "render_s", "write_s"];
        let mut lines = csv.lines().filter(|line| !line.trim().is_empty());
        let header = fields(lines.next().unwrap_or_default());
        let columns: Vec<usize> =
            (0..header.len()).filter(|&at| PARTS.contains(&header[at].as_str())).collect();
        let mut frames = Self { count: 0, visualization: (!columns.is_empty()).then_some(0.0) };
        for line in lines {
            frames.count += 1;
            let fields = fields(line);
            for &column in &columns {
                let spent = fields.get(column).and_then(|field| seconds(field));
                // One number that cannot be read makes the sum wrong, and no sum is better.
                frames.visualization = frames.visualization.and_then(|total| Some(total + spent?));
            }
        }
        frames
    }
}

fn seconds(text: &str) -> Option<f64> {
    text.parse().ok().filter(|seconds: &f64| seconds.is_finite())
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
        assert_eq!(Frames::read(csv), Frames { count: 2, visualization: Some(3.0) });
    }

    #[test]
    fn a_report_may_be_empty_or_odd() {
        assert_eq!(Frames::read(""), Frames { count: 0, visualization: None });
        assert_eq!(Frames::read("frame\n0\n1\n"), Frames { count: 2, visualization: None });
        let cut_short = Frames::read("frame,render_s\n0,1.5\n1");
        assert_eq!(cut_short, Frames { count: 2, visualization: None });
    }

    #[test]
    fn the_report_fills_in_for_the_summary() {
        let frames = Frames { count: 4, visualization: Some(2.0) };
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
