//! Prints and writes the errors of the [hard cases](icoray_reference::stability).

use crate::results::{make_directory, progress, say, write_file};
use icoray::{Renderer, Result};
use icoray_reference::stability::{GROUPS, LARGE_LEVELS, LEVELS, RUNS, Row, Run, measure_level};
use std::fmt::Write as _;
use std::io::Write;
use std::path::PathBuf;

/// Options of the check.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Meshes of up to 2.6 million cells too.
    #[arg(long)]
    pub large: bool,
    /// Only cases with this in their group or name.
    #[arg(long)]
    pub only: Option<String>,
    /// Threads, or as many as there are processors when 0.
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
    /// Directory for STABILITY.md; the page is only printed without it.
    #[arg(long)]
    pub out: Option<PathBuf>,
}

/// Measures, prints the page and writes it.
pub(crate) fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let renderer = Renderer::new(options.threads)?;
    let large: &[u32] = if options.large { &LARGE_LEVELS } else { &[] };
    let levels = [&LEVELS, large].concat();
    let only = options.only.as_deref().unwrap_or("");
    let mut rows = Vec::new();
    let bar = progress(levels.len(), "stability");
    for level in levels {
        bar.set_message(format!("n = {level}"));
        let more = measure_level(&renderer, level, only)?;
        bar.suspend(|| say!(out, "n = {level}: {} cases", more.len()))?;
        bar.inc(1);
        rows.extend(more);
    }
    bar.finish_and_clear();
    let page = page(&rows);
    say!(out, "\n{page}")?;
    let Some(directory) = &options.out else { return Ok(()) };
    make_directory(directory)?;
    write_file(&directory.join("STABILITY.md"), &page)?;
    say!(out, "STABILITY.md in {}", directory.display())
}

/// A number to one digit, which is reproducible across machines.
fn short(value: f64) -> String {
    if value == 0.0 { "0".into() } else { format!("{value:.0e}") }
}

/// One line per case, a heading per group.
fn rows(rows: &[Row]) -> String {
    let mut text = String::new();
    for group in GROUPS {
        let members: Vec<&Row> = rows.iter().filter(|r| r.group == group).collect();
        if members.is_empty() {
            continue;
        }
        let _ = writeln!(text, "\n## {group}\n\n{}", head());
        for row in members {
            let [a, b, c] = row.run.map(|run| short(run.error));
            let [x, y, z] = row.run.map(|run| short(run.bound));
            let over: usize = row.run.iter().map(|run| run.over_bound).sum();
            let not_finite: usize = row.run.iter().map(|run| run.not_finite).sum();
            let _ = writeln!(
                text,
                "| {} | {} | {a} | {b} | {c} | {x} | {y} | {z} | {over} | {not_finite} | {} |",
                row.name, row.rays, row.lost
            );
        }
    }
    text
}

fn head() -> String {
    let [a, b, c] =
        RUNS.map(|(precision, tolerance)| format!("{} at {tolerance:.0e}", format!("{precision:?}").to_lowercase()));
    format!(
        "| case | rays | {a} | {b} | {c} | bound {a} | bound {b} | bound {c} | over bound | not finite | lost |\n\
         |---|---|---|---|---|---|---|---|---|---|---|"
    )
}

const INTRODUCTION: &str = "# Stability

Written by `icoray-study stability --large`. Each case is a small picture, drawn in f64 and in f32 with the scene's
`tolerance` as the column says. The error is the largest over all pixels and channels (premultiplied linear, 0 to 1)
against the exact integral for the same inputs. That is computed by other means: every triangle is asked for its part of
the ray in double-double (31 digits), and Gauss quadrature in f64 goes in steps of little optical depth. A picture's
pixels are f32; half a unit in their last place is taken off each error, so 0 means that all pixels are rounded from a
number that is right to some 1e-10.

*Bound* is the largest error that the frames report, *over bound* the pixels of the three pictures whose error is
above their own reported error. *Lost* are rays that miss a part of their way through the shell.
";

fn page(all: &[Row]) -> String {
    let rays: usize = all.iter().map(|r| r.rays).sum();
    let seen: usize = all.iter().map(|r| r.seen).sum();
    let total = |of: fn(&Run) -> usize| all.iter().flat_map(|r| &r.run).map(of).sum::<usize>();
    let lost: usize = all.iter().map(|r| r.lost).sum();
    format!(
        "{INTRODUCTION}\n{} cases, {rays} rays, {seen} of which meet something. Not finite: {}; lost: {lost}; over their bound: {}.\n{}",
        all.len(),
        total(|r| r.not_finite),
        total(|r| r.over_bound),
        rows(all)
    )
}
