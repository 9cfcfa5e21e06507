//! What a comparison comes to: how many times icoray's time and memory the others take, and what fits in a memory.

use super::Options;
use super::row::{OURS, Row};
use std::fmt::Write as _;

/// The paper's largest grid: 655,362 cells, 99 layers.
const PAPER_WEDGES: f64 = 1_310_720.0 * 98.0;
const GIBI: f64 = (1u64 << 30) as f64;

/// Memory as a straight line over the number of wedges.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Line {
    /// Whatever the grid: a window, libraries, a picture.
    fixed: f64,
    per_wedge: f64,
    is_from: Source,
}

/// How the two parts of a [`Line`] are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Source {
    /// As icoray says itself: its share of the memory is less than what pictures and threads have more or less.
    Said,
    /// By the difference of two grids.
    Fit,
    /// Not at all.
    Whole,
}

impl Line {
    /// Through the smallest and the largest grid of a renderer, whose memory is the mean over transfer functions.
    fn of(rows: &[Row], renderer: &str) -> Option<Self> {
        let mut wedges: Vec<u64> =
            rows.iter().filter(|row| row.renderer == renderer).map(|row| row.wedges).collect();
        wedges.sort_unstable();
        let (least, most) = (*wedges.first()?, *wedges.last()?);
        let mean = |wedges: u64| {
            let all: Vec<f64> = rows
                .iter()
                .filter(|row| row.renderer == renderer && row.wedges == wedges)
                .map(|row| row.memory as f64)
                .collect();
            all.iter().sum::<f64>() / all.len() as f64
        };
        let largest = rows.iter().filter(|row| row.renderer == renderer && row.wedges == most);
        if let Some(derived) = largest.filter_map(|row| row.derived).max() {
            let derived = derived as f64;
            let fixed = (mean(most) - derived).max(0.0);
            return Some(Line { fixed, per_wedge: derived / most as f64, is_from: Source::Said });
        }
        if least == most {
            return Some(Line { fixed: 0.0, per_wedge: mean(most) / most as f64, is_from: Source::Whole });
        }
        let per_wedge = (mean(most) - mean(least)) / (most - least) as f64;
        Some(Line { fixed: mean(least) - per_wedge * least as f64, per_wedge, is_from: Source::Fit })
    }

    fn bytes(&self, wedges: f64) -> f64 {
        self.fixed + self.per_wedge * wedges
    }

    /// The most wedges that so many bytes hold.
    fn most(&self, bytes: f64) -> f64 {
        (bytes - self.fixed) / self.per_wedge
    }
}

/// A Markdown table of ratios, and what fits in the memory that VTK may have: a sentence per renderer, and what failed.
pub(super) fn summary(rows: &[Row], options: &Options, failures: &[String]) -> String {
    let renderers = &options.renderers;
    let mut text = String::from(
        "\nTimes icoray's:\n\n| | frame | frame of new values | preparation | bytes per wedge |\n|---|---|---|---|---|\n",
    );
    let ours = Line::of(rows, OURS);
    let drew: Vec<&String> =
        renderers.iter().filter(|name| rows.iter().any(|row| row.renderer == **name)).collect();
    for renderer in &drew {
        let ratio = |seconds: fn(&Row) -> f64| span(&ratios(rows, renderer, seconds));
        let memory =
            ours.zip(Line::of(rows, renderer)).map(|(ours, theirs)| theirs.per_wedge / ours.per_wedge);
        let memory =
            memory.filter(|times| *times > 0.0).map_or_else(|| "-".into(), |times| format!("{times:.0}"));
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

/// Of each picture that both drew.
fn ratios(rows: &[Row], renderer: &str, seconds: fn(&Row) -> f64) -> Vec<f64> {
    let pairs = rows.iter().filter(|row| row.renderer == *renderer).filter_map(|theirs| {
        let is_ours =
            |row: &&Row| row.renderer == OURS && row.level == theirs.level && row.transfer == theirs.transfer;
        Some((rows.iter().find(is_ours)?, theirs))
    });
    pairs.map(|(ours, theirs)| seconds(theirs) / seconds(ours)).collect()
}

fn span(all: &[f64]) -> String {
    let (low, high) = all.iter().fold((f64::INFINITY, 0.0f64), |(l, h), x| (l.min(*x), h.max(*x)));
    format!("{low:.1} to {high:.1}")
}

/// The finest grid of no more wedges: a bisection has four times as many triangles as the one before, from 20 on.
fn finest(most: f64, layers: usize) -> Option<u32> {
    let wedges = |level: u32| 20.0 * 4f64.powi(level as i32) * (layers - 1) as f64;
    (0..=icoray::MAX_LEVEL).rev().find(|level| wedges(*level) <= most)
}

fn fits(name: &str, line: &Line, options: &Options) -> String {
    let (gibi, layers) = (options.memory, options.layers);
    let most = line.most(gibi * GIBI);
    let finest = finest(most, layers).map_or_else(|| "no grid".into(), |level| format!("n = {level}"));
    let fixed = format!("{:.1} MiB whatever the grid", line.fixed / f64::from(1 << 20));
    let fixed = match line.is_from {
        Source::Said => format!(" by its own account, and {fixed}"),
        Source::Fit => format!(" and {fixed}"),
        Source::Whole => " with what it takes whatever the grid".to_owned(),
    };
    format!(
        "{name}: {:.1} bytes per wedge{fixed}; by that {gibi} GiB hold {:.1} million wedges, of grids of {layers} \
         layers none finer than {finest}, and the paper's 655,362 cells x 99 layers, {:.0} million wedges, take {:.2} GiB (extrapolated)",
        line.per_wedge,
        1e-6 * most,
        1e-6 * PAPER_WEDGES,
        line.bytes(PAPER_WEDGES) / GIBI,
    )
}

#[cfg(test)]
mod tests {
    use super::super::row::Seconds;
    use super::*;
    use crate::compare::Comparison;
    use clap::Parser;

    #[derive(Parser)]
    struct Asked {
        #[command(flatten)]
        options: Options,
    }

    fn row(renderer: &str, level: u32, memory: u64, wedges: u64, frame: f64) -> Row {
        let seconds = Seconds { prepare: 0.5 * frame, first: 1.5 * frame, frame, step: 2.0 * frame };
        let far = Comparison::new(&[[0.0; 4]], &[[0.0; 4]]);
        let derived = (renderer == OURS).then_some(wedges);
        Row { level, transfer: "dense", renderer: renderer.into(), seconds, memory, derived, wedges, far }
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
        assert_eq!(line, Line { fixed: 2.0 * mebi as f64, per_wedge: 1024.0, is_from: Source::Fit });
        assert_eq!(line.most(line.bytes(12345.0)), 12345.0);
        let asked = Asked::try_parse_from(["vtk", "--layers", "11", "--memory", "0.1"]).unwrap();
        let text = summary(&rows, &asked.options, &["n=6, dense, zsweep: no".into()]);
        assert!(text.contains("| bunyk | 15.0 to 20.0 | 15.0 to 20.0 | 15.0 to 20.0 | 1024 |"), "{text}");
        assert!(text.contains("bunyk: 1024.0 bytes per wedge and 2.0 MiB"), "{text}");
        assert!(
            text.contains("icoray: 1.0 bytes per wedge by its own account, and 1.0 MiB")
                && text.ends_with("\n- n=6, dense, zsweep: no\n"),
            "{text}"
        );
        // 105267 wedges; n = 4 has 51,200.
        assert!(
            text.contains("0.1 GiB hold 0.1 million wedges, of grids of 11 layers none finer than n = 4"),
            "{text}"
        );
        assert_eq!([51_199.0, 51_200.0, 199.0].map(|most| finest(most, 11)), [Some(3), Some(4), None]);
        assert_eq!(Line::of(&rows[..2], "bunyk").unwrap().per_wedge, 3072.0);
        assert_eq!(Line::of(&rows, "zsweep"), None);
    }
}
