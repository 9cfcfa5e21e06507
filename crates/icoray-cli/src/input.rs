//! The files that every command reads.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use icoray::output::printed_units;
use icoray::{Error, ErrorKind, Location, Result, Script};
use icoray_dataset::{Dataset, DatasetOptions, FieldInfo, LayerSelection};
use std::path::{Path, PathBuf};

/// The files with fields and mesh.
#[derive(clap::Args)]
pub struct Input {
    /// Files of MPAS, ICON or another model with the fields, mostly with the mesh too: several files of one run are one
    /// series by their dates, whose variables may be in files of their own. Addresses (https://, s3://) are
    /// opened by the NetCDF library; Zarr stores are folders, or https://HOST/PATH/STORE.zarr
    #[arg(value_name = "FILE.nc", required = true)]
    pub files: Vec<PathBuf>,
    /// Draw differences: the values less those of these files, of the same mesh and layers, at the same dates
    #[arg(long, value_name = "OTHER.nc", num_args = 1..)]
    pub minus: Vec<PathBuf>,
    /// File with what FILE.nc lacks: the mesh, as in the run's init or grid file, or the heights of layers; may be
    /// given several times
    #[arg(long, value_name = "MESH.nc")]
    pub mesh: Vec<PathBuf>,
    #[command(flatten)]
    pub data_options: DataOptions,
}

/// Facts that the files lack.
#[derive(clap::Args)]
pub struct DataOptions {
    /// Entry, from 0, that is read along a dimension beside columns, layers and time, such as nCategories=2; may be
    /// given several times
    #[arg(long, value_name = "DIM=N", value_parser = entry)]
    at: Vec<(String, usize)>,
    /// Heights of the first and of the last layer in metres, such as 0..20000 or 0..-5000, instead of those of the
    /// files; those between are evenly spaced
    #[arg(long, value_name = "A..B", allow_hyphen_values = true, value_parser = heights)]
    heights: Option<[f64; 2]>,
    /// Radius of the sphere in metres, instead of that of the files
    #[arg(long, value_name = "METRES")]
    radius: Option<f64>,
    /// Value that marks missing samples, such as -1e34, beside those of attributes; may be given several times
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    missing: Vec<f64>,
}

impl DataOptions {
    pub fn options(&self) -> DatasetOptions {
        let DataOptions { at, heights, radius, missing } = self;
        DatasetOptions { at: at.clone(), heights_m: *heights, radius_m: *radius, missing: missing.clone() }
    }

    /// The options as words of a command line.
    fn words(&self) -> Vec<String> {
        let at = self.at.iter().map(|(name, entry)| ["--at".into(), format!("{name}={entry}")]);
        let heights = self.heights.iter().map(|[first, last]| ["--heights".into(), format!("{first}..{last}")]);
        let radius = self.radius.iter().map(|radius| ["--radius".into(), radius.to_string()]);
        let missing = self.missing.iter().map(|value| ["--missing".into(), format!("{value:e}")]);
        at.chain(heights).chain(radius).chain(missing).flatten().collect()
    }
}

fn entry(text: &str) -> std::result::Result<(String, usize), String> {
    let parts = text.split_once('=').and_then(|(name, entry)| Some((name.to_owned(), entry.parse().ok()?)));
    parts.ok_or_else(|| "expected the name of a dimension and a number from 0, such as nCategories=2".to_owned())
}

fn heights(text: &str) -> std::result::Result<[f64; 2], String> {
    let ends = text.split_once("..").and_then(|(first, last)| Some([first.parse().ok()?, last.parse().ok()?]));
    ends.filter(|[first, last]: &[f64; 2]| (first - last).is_normal())
        .ok_or_else(|| "expected two different numbers of metres, such as 0..20000".to_owned())
}

impl Input {
    pub fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        self.files.iter().chain(&self.minus).chain(&self.mesh)
    }

    pub fn open(&self) -> Result<Dataset> {
        let mut dataset = icoray_netcdf::open_all(&self.files, &self.mesh, None, self.data_options.options())?;
        if !self.minus.is_empty() {
            let (mesh, options) = (Some(dataset.shared_mesh()), self.data_options.options());
            dataset.subtract(icoray_netcdf::open_all(&self.minus, &self.mesh, mesh, options)?)?;
        }
        Ok(dataset)
    }

    /// The files as words of a command line.
    pub fn words(&self) -> Vec<String> {
        let mut words: Vec<String> = self.files.iter().map(|file| file.to_string_lossy().into()).collect();
        for (option, paths) in [("--minus", &self.minus), ("--mesh", &self.mesh)] {
            words.extend(paths.iter().flat_map(|path| [option.into(), path.to_string_lossy().into()]));
        }
        words.extend(self.data_options.words());
        words
    }
}

/// The layers of the first field that are read and drawn.
#[derive(clap::Args)]
pub struct LayerOption {
    /// Layers that are read and drawn, from 0 and without the last, instead of all; either end may be left out. Those
    /// of a view's first field; of others that lie on interfaces or between them, those around or between
    #[arg(long, value_name = "A..B", default_value = "..", hide_default_value = true)]
    pub layers: LayerSelection,
}

/// A parser of one of these words, each with its value and its help.
pub fn one_of<T: Copy + Send + Sync + 'static, const N: usize>(
    words: [(&'static str, T, &'static str); N],
) -> impl TypedValueParser<Value = T> {
    let values = words.map(|(word, _, help)| PossibleValue::new(word).help(help));
    let value = move |given: String| words.iter().find(|(word, ..)| *word == given).expect("a possible value").1;
    PossibleValuesParser::new(values).map(value)
}

pub fn scene_text(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).map_err(|e| {
        let context = format!("{}: cannot read the scene: {e}", path.display());
        Error::new(ErrorKind::Io, context)
    })
}

/// Reads and checks a scene file; `None` if it has no keys and draws nothing.
pub fn script(path: &Path) -> Result<Option<Script>> {
    Script::parse_optional(&scene_text(path)?).map_err(|e| e.within(path.display()))
}

/// The location of a field as words after "at".
pub fn place(info: &FieldInfo) -> &'static str {
    match (info.location, info.is_from_edges()) {
        (Location::Center, false) => "cells",
        (Location::Corner, false) => "corners",
        (Location::Center, true) => "cells, from edges",
        (Location::Corner, true) => "corners, from edges",
    }
}

/// Formats minimum and maximum, with units if known.
pub fn range(range: Option<[f64; 2]>, units: Option<&str>) -> String {
    let units = units.filter(|units| printed_units(units).is_some()).map_or_else(String::new, |u| format!(" {u}"));
    range.map_or_else(|| "no values".to_owned(), |[low, high]| format!("{} to {}{units}", number(low), number(high)))
}

/// A value to six digits.
fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e7).contains(&size) {
        let whole_digits = if size < 1.0 { 1 } else { size.log10() as usize + 1 };
        let text = format!("{value:.*}", 6usize.saturating_sub(whole_digits));
        if text.contains('.') {
            return text.trim_end_matches('0').trim_end_matches('.').to_owned();
        }
        return text;
    }
    format!("{value:.5e}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_six_digits() {
        for (value, text) in [
            (0.0, "0"),
            (288.0, "288"),
            (-288.123_456, "-288.123"),
            (6_371_229.0, "6371229"),
            (0.01, "0.01"),
            (1.234_567_8e-5, "1.23457e-5"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(number(value), text);
        }
        assert_eq!(range(Some([1.0, 2.5]), Some("K")), "1 to 2.5 K");
        assert_eq!(range(Some([1.0, 2.5]), Some("1")), "1 to 2.5");
        assert_eq!(range(None, Some("K")), "no values");
    }
}
