//! A renderer's row of the table, and the summary of all: time and memory relative to icoray's, and the largest grids
//! in a given memory.

use super::Options;
use icoray_reference::comparison::Comparison;
use std::fmt::Write as _;

/// The paper's largest grid: 655,362 cells, 99 layers.
const PAPER_WEDGES: f64 = 1_310_720.0 * 98.0;
const GIBI: f64 = (1u64 << 30) as f64;

/// Memory as a straight line over the number of wedges.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Line {
    /// Independent of the grid: a window, libraries, a picture.
    fixed: f64,
    per_wedge: f64,
    source: LineSource,
}

/// How the two parts of a [`Line`] are determined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LineSource {
    /// Reported by icoray.
    Reported,
    /// From the difference of two grids.
    Fit,
    /// Not determined.
    Total,
}

impl Line {
    /// Through the smallest and the largest grid of a renderer; memory is the mean over transfer functions.
    fn of(rows: &[Row], renderer: &str) -> Option<Self> {
        let rows: Vec<&Row> = rows.iter().filter(|row| row.renderer == renderer).collect();
        let wedges = || rows.iter().map(|row| row.wedges);
        let (min, max) = (wedges().min()?, wedges().max()?);
        let of = |wedges: u64| rows.iter().filter(move |row| row.wedges == wedges);
        let mean = |wedges: u64| {
            let sum: f64 = of(wedges).map(|row| row.memory as f64).sum();
            sum / of(wedges).count() as f64
        };
        let largest = of(max);
        if let Some(derived) = largest.filter_map(|row| row.derived).max() {
            let derived = derived as f64;
            let fixed = (mean(max) - derived).max(0.0);
            return Some(Line { fixed, per_wedge: derived / max as f64, source: LineSource::Reported });
        }
        if min == max {
            return Some(Line { fixed: 0.0, per_wedge: mean(max) / max as f64, source: LineSource::Total });
        }
        let per_wedge = (mean(max) - mean(min)) / (max - min) as f64;
        Some(Line { fixed: mean(min) - per_wedge * min as f64, per_wedge, source: LineSource::Fit })
    }

    fn bytes(&self, wedges: f64) -> f64 {
        self.fixed + self.per_wedge * wedges
    }

    fn max_wedges(&self, bytes: f64) -> f64 {
        (bytes - self.fixed) / self.per_wedge
    }
}

/// A Markdown table of ratios, a sentence per renderer on grids that fit in memory, and the failures.
pub(super) fn summary(rows: &[Row], options: &Options, failures: &[String]) -> String {
    let renderers = &options.renderers;
    let mut text = String::from(
        "\nTimes icoray's:\n\n| | frame | frame of new values | preparation | bytes per wedge |\n|---|---|---|---|---|\n",
    );
    let ours = Line::of(rows, OURS);
    let drew: Vec<&String> = renderers.iter().filter(|name| rows.iter().any(|row| row.renderer == **name)).collect();
    for renderer in &drew {
        let ratio = |seconds: fn(&Row) -> f64| span(&ratios(rows, renderer, seconds));
        let memory = ours.zip(Line::of(rows, renderer)).map(|(ours, theirs)| theirs.per_wedge / ours.per_wedge);
        let memory = memory.filter(|times| *times > 0.0).map_or_else(|| "-".into(), |times| format!("{times:.0}"));
        let _ = writeln!(
            text,
            "| {renderer} | {} | {} | {} | {memory} |",
            ratio(|row| row.seconds.frame),
            ratio(|row| row.seconds.step),
            ratio(|row| row.seconds.prepare + (row.seconds.first - row.seconds.frame).max(0.0)),
        );
    }
    text.push('\n');
    for name in std::iter::once(OURS).chain(drew.iter().map(|name| name.as_str())) {
        let Some(line) = Line::of(rows, name).filter(|line| line.per_wedge > 0.0) else { continue };
        let _ = writeln!(text, "- {}", fits(name, &line, options));
    }
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

/// The finest grid of no more wedges: a bisection has four times as many triangles as the one before, from 20 on.
fn finest(max: f64, layers: usize) -> Option<u32> {
    let wedges = |level: u32| 20.0 * 4f64.powi(level as i32) * (layers - 1) as f64;
    (0..=icoray::MAX_LEVEL).rev().find(|level| wedges(*level) <= max)
}

fn fits(name: &str, line: &Line, options: &Options) -> String {
    let (gibi, layers) = (options.memory, options.layers);
    let max = line.max_wedges(gibi * GIBI);
    let finest = finest(max, layers).map_or_else(|| "none".into(), |level| format!("n = {level}"));
    let fixed = format!("{:.1} MiB for any grid", line.fixed / f64::from(1 << 20));
    let fixed = match line.source {
        LineSource::Reported => format!(" as it reports, and {fixed}"),
        LineSource::Fit => format!(" and {fixed}"),
        LineSource::Total => " including the fixed part".to_owned(),
    };
    format!(
        "{name}: {:.1} bytes per wedge{fixed}; {gibi} GiB then hold {:.1} million wedges (finest grid of {layers} layers: \
         {finest}), and the paper's 655,362 cells x 99 layers, {:.0} million wedges, take {:.2} GiB (extrapolated)",
        line.per_wedge,
        1e-6 * max,
        1e-6 * PAPER_WEDGES,
        line.bytes(PAPER_WEDGES) / GIBI,
    )
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
        assert_eq!(line, Line { fixed: 2.0 * mebi as f64, per_wedge: 1024.0, source: LineSource::Fit });
        assert_eq!(line.max_wedges(line.bytes(12345.0)), 12345.0);
        let asked = Asked::try_parse_from(["vtk", "--layers", "11", "--memory", "0.1"]).unwrap();
        let text = summary(&rows, &asked.options, &["n=6, dense, zsweep: no".into()]);
        assert!(text.contains("| bunyk | 15.0 to 20.0 | 15.0 to 20.0 | 15.0 to 20.0 | 1024 |"), "{text}");
        assert!(text.contains("bunyk: 1024.0 bytes per wedge and 2.0 MiB"), "{text}");
        assert!(
            text.contains("icoray: 1.0 bytes per wedge as it reports, and 1.0 MiB")
                && text.ends_with("\n- n=6, dense, zsweep: no\n"),
            "{text}"
        );
        // 105267 wedges; n = 4 has 51,200.
        assert!(text.contains("0.1 GiB then hold 0.1 million wedges (finest grid of 11 layers: n = 4)"), "{text}");
        assert_eq!([51_199.0, 51_200.0, 199.0].map(|max| finest(max, 11)), [Some(3), Some(4), None]);
        assert_eq!(Line::of(&rows[..2], "bunyk").unwrap().per_wedge, 3072.0);
        assert_eq!(Line::of(&rows, "zsweep"), None);
    }
}
