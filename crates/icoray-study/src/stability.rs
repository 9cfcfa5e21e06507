//! Prints and writes the errors of the [hard cases](icoray_reference::stability).

mod table;

use crate::results::{make_directory, progress, say, write_file};
use icoray::{Renderer, Result};
use icoray_reference::stability::{LARGE_LEVELS, LEVELS, measure_level};
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
    let page = table::page(&rows);
    say!(out, "\n{page}")?;
    let Some(directory) = &options.out else { return Ok(()) };
    make_directory(directory)?;
    write_file(&directory.join("STABILITY.md"), &page)?;
    say!(out, "STABILITY.md in {}", directory.display())
}
