//! Results as a Markdown page.

use icoray_reference::stability::{GROUPS, RUNS, Row, Run};
use std::fmt::Write as _;

/// A number to one digit, which is reproducible across machines.
fn short(value: f64) -> String {
    if value == 0.0 { "0".into() } else { format!("{value:.0e}") }
}

/// The errors of one run, and without its ill-posed rays where there are some.
fn errors(run: &Run) -> String {
    if run.ill_posed == 0 {
        return short(run.error);
    }
    format!("{} ({} without {} ill-posed)", short(run.error), short(run.well_posed_error), run.ill_posed)
}

/// One line per case, a heading per group.
pub fn rows(rows: &[Row]) -> String {
    let mut text = String::new();
    for group in GROUPS {
        let members: Vec<&Row> = rows.iter().filter(|r| r.group == group).collect();
        if members.is_empty() {
            continue;
        }
        let _ = writeln!(text, "\n## {group}\n\n{}", head());
        for row in members {
            let [a, b, c] = row.run.map(|run| errors(&run));
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
above their own reported error. A ray is *ill-posed* when its exact answer moves by half the error or more as soon as the eye
moves by four units in the last place of f64 or, for f32, the values by one of f32, relative to the transfer function's
range. *Lost* are rays that miss a part of their way through the shell.
";

/// The whole page.
pub fn page(all: &[Row]) -> String {
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
