//! Levels of detail: seconds and errors of pictures on the model's grid and, of the same values, on coarser ones.

mod each;
mod random;

use crate::results::{Table, in_turn, progress, replace_section, say, timed};
use crate::scenes::multi_scale;
use crate::speed::{self, Size};
use icoray::{Field, Frame, Renderer, Result, Scene};
use icoray_reference::sphere::{Sphere, multi_scale as field};
use std::io::Write;
use std::path::PathBuf;

/// Options of the measurement.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Bisections of the icosahedron x layers, one size after another.
    #[arg(long, value_delimiter = ',', value_parser = speed::size, default_value = "7x26,8x26,9x26")]
    pub sizes: Vec<Size>,
    /// Tolerances.
    #[arg(long, value_delimiter = ',', default_value = "1e-2,1e-3")]
    pub tolerances: Vec<f64>,
    /// Width and height of the pictures.
    #[arg(long, default_value_t = 512)]
    pub pixels: u32,
    /// Number of threads.
    #[arg(long, value_parser = speed::count, default_value = "1")]
    pub threads: usize,
    /// Pairs of frames.
    #[arg(long, default_value_t = 3)]
    pub frames: usize,
    /// Checks every pixel of this number of random scenes on each level instead.
    #[arg(long, value_name = "N")]
    pub random: Option<u64>,
    /// Seed of the first random scene; each of the others has the next.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Draws each level of three fields instead, of the first size and of a file of MPAS: seconds, errors and pictures.
    #[arg(long)]
    pub each: bool,
    /// With `--each`: directory of the data files; else that of ICORAY_TEST_DATA, else ../shared/data.
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
    /// Directory of levels.csv.
    #[arg(long, default_value = "out/levels")]
    pub out: PathBuf,
    /// A file in which the table takes the place of that between its lines `<!-- icoray-study levels -->` and `<!--
    /// end -->`.
    #[arg(long)]
    pub readme: Option<PathBuf>,
}

const COLUMNS: &str =
    "grid,scene,tolerance,grid_s,grids_s,values_s,level,levels_s,ratio,reported,mean_reported,difference,cell_bytes";

/// Measures all sizes and tolerances, prints a line for each and writes the table.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    if let Some(count) = options.random {
        return random::run(count, options.seed, options.threads, out);
    }
    if options.each {
        return each::run(options, out);
    }
    let mut table = Table::create(options.out.join("levels.csv"), COLUMNS)?;
    let mut markdown = "| grid | scene | tolerance | model's grid s | making grids s | values s | level | s | ratio | error \
                        reported, largest | mean | largest difference | bytes per cell |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    say!(out, "{}", table.heading())?;
    // Dense and lobes.
    let scenes = &multi_scale::TRANSFERS[..2];
    let bar = progress(options.sizes.len() * scenes.len() * options.tolerances.len(), "pictures");
    for size in &options.sizes {
        let renderers = [Renderer::new(options.threads)?, Renderer::new(options.threads)?.with_levels()];
        let sphere = renderers[0].run(|| Sphere::new(size.level, size.layers, [1.0, 1.15], field))?;
        for &(name, opacity) in scenes {
            let volume = multi_scale::volume("f", &multi_scale::knots(16, opacity));
            for &tolerance in &options.tolerances {
                let text = format!("tolerance = {tolerance:e}\n{volume}");
                let row = measure(&renderers, &sphere, &multi_scale::view(options.pixels, &text)?, options.frames)?;
                let row = [vec![size.to_string(), name.to_owned(), format!("{tolerance:e}")], row].concat();
                markdown += &format!("| {} |\n", row.join(" | "));
                table.print(&row, &bar, out)?;
            }
        }
    }
    replace_section(options.readme.as_deref(), "levels", &markdown)
}

/// The columns from `grid_s` on, of pictures of one field.
fn measure([finest, coarser]: &[Renderer; 2], sphere: &Sphere, scene: &Scene, frames: usize) -> Result<Vec<String>> {
    let (grid, first, field) = (sphere.grid()?, sphere.field()?, sphere.field()?);
    let draw = |renderer: &Renderer, field: &Field| timed(renderer, scene, &grid, &sphere.layers, field);
    // The second picture of a field makes its levels, that of the grid's first field the coarser grids too.
    draw(coarser, &first)?;
    let (grids_s, _) = draw(coarser, &first)?;
    draw(coarser, &field)?;
    let (values_s, _) = draw(coarser, &field)?;
    draw(finest, &field)?;
    let mut drawn = [const { None }; 2];
    let [levels_s, grid_s, ratio] = in_turn(frames, |which| {
        let (seconds, frame) = draw([coarser, finest][which], &field)?;
        drawn[which] = Some(frame);
        Ok(seconds)
    })?;
    let [on_levels, on_grid] = drawn.map(|frame: Option<Frame>| frame.expect("one of each is drawn"));
    let pairs = on_grid.pixels.as_flattened().iter().zip(on_levels.pixels.as_flattened());
    let difference = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let level = on_levels.report.quality.level.to_string();
    let seconds = |number: f64| format!("{number:.3}");
    let error = &on_levels.report.error;
    let bytes = on_levels.report.bytes_derived - on_grid.report.bytes_derived;
    Ok(vec![
        seconds(grid_s),
        seconds(grids_s - values_s),
        seconds(values_s - levels_s),
        level,
        seconds(levels_s),
        seconds(ratio),
        format!("{:.1e}", error.max),
        format!("{:.1e}", error.mean),
        format!("{difference:.1e}"),
        format!("{:.0}", bytes as f64 / grid.cells() as f64),
    ])
}
