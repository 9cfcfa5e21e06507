//! Seconds per frame and memory bandwidth: the paper's Table 2 scene, a multi-scale field under four transfer functions
//! of 16 knots, on grids of several sizes, with and without light.
//!
//! Each frame has a new field, as in a running model, so nothing derived from values is reused. Frames on one and on
//! several cores alternate, so that noise affects both.

pub(crate) use benchmark::{PACKED, bytes_read};
pub use options::{Options, Size};
pub(crate) use options::{count, size};

use crate::results::{Table, io_error, make_directory, progress, replace_section, say, write_file};
use benchmark::Benchmark;
use icoray::Result;
use instructions::{Tool, program};
use markdown::{COLUMNS, Measured, bandwidth_line, cells};
use options::Setting;
use std::io::{Write, stdin};

mod benchmark;
mod instructions;
mod machine;
mod markdown;
mod options;
mod pairs;

/// Measures, prints a line per scene and number of threads, and writes `speed.csv`, `speed.md` and pictures.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let settings = options.settings()?;
    if options.bare {
        return draw(options, &settings, out);
    }
    let counter = if options.uncounted { None } else { Some(Tool::find()) };
    if let Some(other) = &options.against {
        return pairs::compare(options, &settings, counter.transpose()?, other, out);
    }
    make_directory(&options.out)?;
    let bandwidths = machine::read_bandwidths(&options.threads)?;
    say!(out, "{}", bandwidth_line(&bandwidths))?;
    let mut csv = Table::create(options.out.join("speed.csv"), COLUMNS)?;
    let (mut setups, mut memory, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    let bar = progress(options.sizes().len() * settings.len(), "speed");
    for size in options.sizes() {
        let benchmark = Benchmark::new(size, options)?;
        setups.push(benchmark.setup.clone());
        memory.extend_from_slice(&benchmark.memory);
        let grid = benchmark.sphere.grid()?;
        bar.suspend(|| say!(out, "\n{size}\n{}", csv.heading()))?;
        for setting in &settings {
            bar.set_message(format!("{size} {} {}", setting.light, setting.case.name));
            for row in benchmark.rows(&grid, setting)? {
                let line = csv.row(&cells(&row, options, &bandwidths))?;
                bar.suspend(|| say!(out, "{line}"))?;
                rows.push(row);
            }
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    let counted = counter.map(|counter| counter.and_then(|counter| counter.count_all(&program()?, options, &settings)));
    let (rows, setups, memory, bandwidths) = (&rows, &setups, &memory, &bandwidths);
    let text = Measured { options, rows, setups, memory, bandwidths, counted }.markdown();
    write_file(&options.out.join("speed.md"), &text)?;
    replace_section(options.readme.as_deref(), "speed", &text)?;
    say!(out, "\n{text}\ntables in {}", options.out.display())
}

/// Renders all frames, on request if they are paced, and prints the number of frusta of the last one.
fn draw(options: &Options, settings: &[Setting], out: &mut dyn Write) -> Result<()> {
    for size in options.sizes() {
        let benchmark = Benchmark::new(size, options)?;
        let grid = benchmark.sphere.grid()?;
        for setting in settings {
            let (scene, mut frusta) = (setting.scene(options)?, 0);
            for _ in 0..options.frames {
                if options.paced {
                    stdin().read_line(&mut String::new()).map_err(|e| io_error("standard input".as_ref(), e))?;
                }
                let (seconds, frame) = benchmark.draw(&benchmark.of(setting)[0], &scene, &grid)?;
                if options.paced {
                    say!(out, "seconds {seconds}")?;
                }
                frusta = frame.report.counts.frusta;
            }
            say!(out, "frusta {frusta}")?;
        }
    }
    Ok(())
}
