//! A renderer's row of the table, and the summary of all: time relative to icoray's, and memory.

use super::Options;
use icoray_reference::comparison::Comparison;
use std::fmt::Write as _;

/// Memory as a straight line over the number of wedges.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Line {
    /// Bytes independent of the grid: a window, libraries, a picture.
    fixed: f64,
    per_wedge: f64,
}

impl Line {
    /// What icoray reports, or through the smallest and the largest grid of another renderer; memory is the mean over
    /// transfer functions.
    fn of(rows: &[Row], renderer: &str) -> Option<Self> {
        let rows: Vec<&Row> = rows.iter().filter(|row| row.renderer == renderer).collect();
        let wedges = || rows.iter().map(|row| row.wedges);
        let (min, max) = (wedges().min()?, wedges().max()?);
        let of = |wedges: u64| rows.iter().filter(move |row| row.wedges == wedges);
        let mean = |wedges: u64| of(wedges).map(|row| row.memory as f64).sum::<f64>() / of(wedges).count() as f64;
        let derived = of(max).filter_map(|row| row.derived).max();
        let fitted = || (min < max).then(|| (mean(max) - mean(min)) / (max - min) as f64);
        let per_wedge = derived.map(|derived| derived as f64 / max as f64).or_else(fitted)?;
        Some(Line { fixed: (mean(max) - per_wedge * max as f64).max(0.0), per_wedge })
    }

    fn cells(self) -> String {
        format!("{:.1} | {:.1}", self.per_wedge, self.fixed / f64::from(1 << 20))
    }
}

/// A Markdown table of ratios and memory, and the failures.
pub(super) fn summary(rows: &[Row], options: &Options, failures: &[String]) -> String {
    let memory = |renderer: &str| Line::of(rows, renderer).map_or_else(|| "- | -".to_owned(), Line::cells);
    let mut text = format!(
        "\nTimes icoray's, and memory:\n\n| | frame | frame of new values | preparation | bytes per wedge | MiB for \
         any grid |\n|---|---|---|---|---|---|\n| {OURS} | 1 | 1 | 1 | {} |\n",
        memory(OURS)
    );
    for renderer in options.renderers.iter().filter(|name| rows.iter().any(|row| row.renderer == **name)) {
        let ratio = |seconds: fn(&Row) -> f64| span(&ratios(rows, renderer, seconds));
        let _ = writeln!(
            text,
            "| {renderer} | {} | {} | {} | {} |",
            ratio(|row| row.seconds.frame),
            ratio(|row| row.seconds.step),
            ratio(|row| row.seconds.prepare + (row.seconds.first - row.seconds.frame).max(0.0)),
            memory(renderer)
        );
    }
    text.push('\n');
    failures.iter().for_each(|failure| text += &format!("- {failure}\n"));
    text
}

/// Ratios for each picture that both rendered.
fn ratios(rows: &[Row], renderer: &str, seconds: fn(&Row) -> f64) -> Vec<f64> {
    let pairs = rows.iter().filter(|row| row.renderer == *renderer).filter_map(|theirs| {
        let is_ours = |row: &&Row| row.renderer == OURS && row.level == theirs.level && row.transfer == theirs.transfer;
        Some((rows.iter().find(is_ours)?, theirs))
    });
    pairs.map(|(ours, theirs)| seconds(theirs) / seconds(ours)).collect()
}

fn span(all: &[f64]) -> String {
    let (low, high) = all.iter().fold((f64::INFINITY, 0.0f64), |(l, h), x| (l.min(*x), h.max(*x)));
    format!("{low:.1} to {high:.1}")
}

pub(super) const OURS: &str = "icoray";

/// Cost and error of a renderer's picture.
pub(super) struct Row {
    pub level: u32,
    pub transfer: &'static str,
    pub renderer: String,
    pub seconds: Seconds,
    /// Peak bytes beyond the model's arrays.
    pub memory: u64,
    /// Bytes that icoray derived from grid and field, which is all memory that grows with these; unknown for other
    /// renderers.
    pub derived: Option<u64>,
    pub wedges: u64,
    pub comparison: Comparison,
}

pub(super) struct Seconds {
    /// Preparation before the first ray.
    pub prepare: f64,
    /// The first frame, in which VTK sorts and splits cells.
    pub first: f64,
    /// A later frame of the same values, and one of new values.
    pub frame: f64,
    pub step: f64,
}

impl Seconds {
    pub fn all(&self) -> [f64; 4] {
        [self.prepare, self.first, self.frame, self.step]
    }
}

pub(super) const HEAD: [&str; 2] = [
    "| n | transfer | renderer | prepare s | first frame s | frame s | frame of new values s | memory MiB | RMSE | max |",
    "|---|---|---|---|---|---|---|---|---|---|",
];

pub(super) const COLUMNS: &str = "level,layers,transfer,renderer,prepare_s,first_frame_s,frame_s,step_frame_s,\
    memory_bytes,wedges,rmse,max_error";

impl Row {
    pub fn line(&self) -> String {
        let seconds = self.seconds.all().map(|s| format!("{s:.3}")).join(" | ");
        format!(
            "| {} | {} | {} | {seconds} | {:.1} | {:.1e} | {:.3} |",
            self.level,
            self.transfer,
            self.renderer,
            self.memory as f64 / f64::from(1 << 20),
            self.comparison.rmse,
            self.comparison.max,
        )
    }

    pub fn cells(&self, options: &Options) -> Vec<String> {
        let mut cells = vec![self.level.to_string(), options.layers.to_string()];
        cells.extend([self.transfer.to_owned(), self.renderer.clone()]);
        cells.extend(self.seconds.all().map(|s| format!("{s:.6}")));
        cells.extend([self.memory, self.wedges].map(|n| n.to_string()));
        cells.extend([self.comparison.rmse, self.comparison.max].map(|d| format!("{d:.6e}")));
        cells
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Asked {
        #[command(flatten)]
        options: Options,
    }

    fn row(renderer: &str, level: u32, memory: u64, wedges: u64, frame: f64) -> Row {
        let seconds = Seconds { prepare: 0.5 * frame, first: 1.5 * frame, frame, step: 2.0 * frame };
        let comparison = Comparison::new(&[[0.0; 4]], &[[0.0; 4]]);
        let derived = (renderer == OURS).then_some(wedges);
        let (transfer, renderer) = ("dense", renderer.into());
        Row { level, transfer, renderer, seconds, memory, derived, wedges, comparison }
    }

    #[test]
    fn memory_is_a_line_through_two_grids() {
        let mebi = 1u64 << 20;
        let rows = [
            row(OURS, 4, mebi, 1 << 10, 0.1),
            row("bunyk", 4, 3 * mebi, 1 << 10, 2.0),
            row(OURS, 5, mebi + 3072, 1 << 12, 0.2),
            row("bunyk", 5, 6 * mebi, 1 << 12, 3.0),
        ];
        let line = Line::of(&rows, "bunyk").unwrap();
        assert_eq!(line, Line { fixed: 2.0 * mebi as f64, per_wedge: 1024.0 });
        let asked = Asked::try_parse_from(["vtk"]).unwrap();
        let text = summary(&rows, &asked.options, &["n=6, dense, zsweep: no".into()]);
        assert!(text.contains("| bunyk | 15.0 to 20.0 | 15.0 to 20.0 | 15.0 to 20.0 | 1024.0 | 2.0 |"), "{text}");
        assert!(text.contains("| icoray | 1 | 1 | 1 | 1.0 | 1.0 |"), "{text}");
        assert!(text.ends_with("\n- n=6, dense, zsweep: no\n") && !text.contains("| zsweep |"), "{text}");
        assert_eq!(Line::of(&rows[..2], "bunyk"), None, "one grid determines no line");
        assert_eq!(Line::of(&rows, "zsweep"), None);
    }
}
