//! `icoray info`: the contents of a file.

use crate::failure::CommandResult;
use crate::input::{self, Input};
use icoray::{ErrorKind, GridTables, Indices, Reals};
use icoray_dataset::{Dataset, FieldInfo, Kind, LayerHeights};
use icoray_progress::Progress;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;

/// Maximum number of times that are all printed; of more only the first and last are.
const MAX_TIMES: usize = 12;

/// Arguments of `icoray info`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  icoray info history.nc\n  icoray info history.nc --mesh init.nc --ranges")]
pub struct Args {
    #[command(flatten)]
    pub input: Input,
    /// Also read every field at the last time, for its least and greatest value
    #[arg(long)]
    ranges: bool,
}

/// Prints mesh, times, layers and fields; of files without a mesh the variables. A failed check of the grid and missing
/// layers are printed, not returned.
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    let progress = Progress::new();
    progress.stage(format!("reading {}", args.input.files[0].display()));
    let mut text = Vec::new();
    match args.input.open() {
        Ok(file) => describe(args, &file, &progress, &mut text)?,
        Err(e) if e.kind() == ErrorKind::Grid => {
            for path in args.input.paths() {
                writeln!(text, "file       {}", path.display())?;
                for variable in icoray_netcdf::contents(path)? {
                    writeln!(text, "           {variable}")?;
                }
            }
            writeln!(text, "mesh       {e}")?;
        }
        Err(e) => return Err(e.into()),
    }
    progress.finish();
    Ok(out.write_all(&text)?)
}

fn describe(args: &Args, file: &Dataset, progress: &Progress, out: &mut impl Write) -> CommandResult {
    let mesh = file.mesh();
    let tables = mesh.tables();
    let Input { files, minus, mesh: others, data_options: _ } = &args.input;
    for (name, paths) in [("file", files), ("minus", minus), ("mesh file", others)] {
        paths.iter().try_for_each(|path| writeln!(out, "{name:<9}  {}", path.display()))?;
    }
    writeln!(out, "mesh       {}", mesh.in_words())?;
    writeln!(out, "cells      {}", polygons(&tables))?;
    writeln!(out, "radius     {} m", file.sphere_radius_m())?;
    let is_single = matches!(tables.center.lon_rad, Reals::F32(_));
    writeln!(out, "positions  {}", if is_single { "f32" } else { "f64" })?;
    progress.stage("checking the grid");
    match mesh.grid() {
        Ok(grid) => {
            let holes = grid.describe_holes().map_or_else(String::new, |holes| format!("; {holes}"));
            writeln!(out, "grid       passes the check{holes}")?;
        }
        Err(e) => writeln!(out, "grid       {e}")?,
    }
    times(file, out)?;
    progress.stage("reading layers");
    layers(file, out)?;
    fields(file, args.ranges.then_some(progress), out)
}

/// Number of cells by number of corners.
fn polygons(tables: &GridTables) -> String {
    let mut kinds = BTreeMap::new();
    for count in tables.cell_corner_count.iter().flat_map(Indices::iter) {
        *kinds.entry(count).or_insert(0usize) += 1;
    }
    let parts: Vec<String> = kinds.iter().map(|(corners, cells)| format!("{cells} with {corners} corners")).collect();
    parts.join(", ")
}

fn times(file: &Dataset, out: &mut impl Write) -> CommandResult {
    let times = file.times();
    let name = |i: usize| {
        let date = times[i].as_deref().unwrap_or("without a date");
        format!("{i}: {date}")
    };
    let shown = if times.len() <= MAX_TIMES {
        (0..times.len()).map(name).collect::<Vec<_>>().join(", ")
    } else {
        format!("{}, ..., {}", name(0), name(times.len() - 1))
    };
    writeln!(out, "times      {shown}")?;
    Ok(())
}

/// The layers of all fields, each kind once.
fn layers(file: &Dataset, out: &mut impl Write) -> CommandResult {
    let mut listed = BTreeSet::new();
    let layered = file.fields().iter().filter(|info| !info.is_2d());
    for info in layered.filter(|info| listed.insert((&info.layer_dimension, info.layers))) {
        let text = match file.layer_heights(&info.name) {
            Ok(heights) => heights_in_words(&heights, info.layers),
            Err(e) => format!("layers     {e}"),
        };
        writeln!(out, "{text}")?;
        match file.find_native_info(&info.name) {
            Ok(Some(own)) => writeln!(out, "           heights = \"native\" in a scene shows {}", own.description)?,
            Ok(None) => {}
            Err(e) => writeln!(out, "           {e}")?,
        }
    }
    if file.fields().iter().any(FieldInfo::is_2d) {
        writeln!(out, "layers     1: a 2D field, shown as a surface on the sphere")?;
    }
    Ok(())
}

fn heights_in_words(heights: &LayerHeights, layers: usize) -> String {
    let height = &heights.height_m;
    let (mut thinnest, mut thickest) = (f64::INFINITY, 0.0f64);
    for pair in height.windows(2) {
        let thickness = (pair[1] - pair[0]).abs();
        (thinnest, thickest) = (thinnest.min(thickness), thickest.max(thickness));
    }
    let of = match heights {
        LayerHeights { is_of_pressure: true, .. } => ", standard atmosphere",
        LayerHeights { is_counted: true, .. } => " counts them: evenly spaced",
        _ => "",
    };
    let lie = match heights.layers.count() {
        count if count == layers => format!("{layers} on heights"),
        count => format!("{layers} between {count} interfaces"),
    };
    let mut text = format!(
        "layers     {lie} ({}{of}): from {:.1} m to {:.1} m, {thinnest:.1} to {thickest:.1} m apart",
        heights.variable,
        height[0],
        height[height.len() - 1],
    );
    text += &match heights.deviation_m {
        Some(0.0) => String::new(),
        Some(deviation_m) => {
            format!("\n           columns deviate from these mean heights by up to {deviation_m:.1} m")
        }
        None if heights.is_counted => String::new(),
        None => "\n           how far columns deviate from these heights is not known".into(),
    };
    text
}

/// Prints the table of fields; with `ranges` (which shows progress) also the minimum and maximum of each.
fn fields(file: &Dataset, ranges: Option<&Progress>, out: &mut impl Write) -> CommandResult {
    if file.fields().is_empty() {
        writeln!(out, "fields     none")?;
        return Ok(());
    }
    let last = file.times().len() - 1;
    let mut heads = vec!["field", "at", "layers", "type", "units", "what it is"];
    heads.extend(ranges.map(|_| "range at the last time"));
    let mut table = vec![heads.into_iter().map(String::from).collect::<Vec<_>>()];
    for info in file.fields() {
        let text = |t: &Option<String>| t.clone().unwrap_or_else(|| "-".to_owned());
        let mut row = vec![
            info.name.clone(),
            input::place(info).to_owned(),
            info.layers.to_string(),
            (if info.precision == Kind::F32 { "f32" } else { "f64" }).to_owned(),
            text(&info.description.units),
            text(&info.description.long_name),
        ];
        if let Some(progress) = ranges {
            progress.stage(format!("reading {}", info.name));
            let read = file.read_field(&info.name, last);
            let range = read.and_then(|owned| Ok(owned.field()?.range()));
            row.push(match range {
                Ok((range, 0)) => input::range(range, None),
                Ok((range, n)) => format!("{} ({n} missing)", input::range(range, None)),
                Err(e) => e.to_string(),
            });
        }
        table.push(row);
    }
    let width = |column: usize| table.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..table[0].len()).map(width).collect();
    for row in &table {
        let cells = row.iter().zip(&widths).map(|(text, &width)| format!("{text:width$}"));
        writeln!(out, "{}", cells.collect::<Vec<_>>().join("  ").trim_end())?;
    }
    Ok(())
}
