//! Runs the binary and reads its output.

use crate::made::Made;
use icoray_test_support::PATIENCE;
use netcdf::Options;
use std::fs;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A scene for any field: opaque from `low` to `high`, so that something is seen.
pub fn scene(field: &str, low: f64, high: f64) -> String {
    format!(
        r##"field = "{field}"
exaggeration = 50
background = "#101820"
[image]
width = 96
height = 96
[camera]
lon = 190
lat = 45
distance = 3
fov = 45
[transfer]
map = "viridis"
range = [{low}, {high}]
opacity = [[{low}, 0.1], [{high}, 0.9]]
[light]
kind = "headlight"
"##
    )
}

/// A temporary folder in which the binary runs.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Folder(tempfile::tempdir().unwrap())
    }

    /// A folder with `made.nc`.
    pub fn of(made: &Made) -> Self {
        Folder(made.write(Options::_64BIT_OFFSET).0)
    }

    /// As [`Self::of`], in the format NetCDF-4.
    pub fn of_netcdf4(made: &Made) -> Self {
        Folder(made.write(Options::NETCDF4).0)
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    pub fn at(&self, name: impl AsRef<Path>) -> PathBuf {
        self.path().join(name)
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.at(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).unwrap()
    }

    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        fs::write(self.at(name), text).unwrap();
    }

    pub fn count(&self) -> usize {
        fs::read_dir(self.path()).unwrap().count()
    }

    /// As [`prints`], of a command line, whose words have no blanks.
    #[track_caller]
    pub fn prints(&self, line: &str) -> String {
        prints(icoray(self.path()).args(line.split_whitespace()))
    }

    /// Renders `made.nc` without `scene.toml`.
    #[track_caller]
    pub fn render_alone(&self, more: &str) -> String {
        self.prints(&format!("render made.nc --size 96x72 {more}"))
    }

    /// Renders `scene.toml`; all lines of the summaries.
    #[track_caller]
    pub fn render(&self, more: &str) -> String {
        self.prints(&format!("render made.nc --scene scene.toml -v {more}"))
    }

    /// As [`Self::render`], for a command that must fail.
    #[track_caller]
    pub fn render_fails(&self, more: &str, code: i32, parts: &[&str]) {
        self.fails(&format!("render made.nc --scene scene.toml {more}"), code, parts);
    }

    /// As [`fails`], of a command line, whose words have no blanks.
    #[track_caller]
    pub fn fails(&self, line: &str, code: i32, parts: &[&str]) {
        fails(icoray(self.path()).args(line.split_whitespace()), code, parts);
    }
}

/// The binary, in `folder`.
pub fn icoray(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_icoray"));
    command.current_dir(folder);
    // HDF5 locks the files that it writes, and a program that another test starts meanwhile inherits the lock.
    command.env("HDF5_USE_FILE_LOCKING", "FALSE");
    command
}

/// What a command printed; it must have succeeded, and been silent on stderr.
#[track_caller]
pub fn prints(command: &mut Command) -> String {
    let Output { status, stdout, stderr } = command.output().unwrap();
    let complaint = String::from_utf8_lossy(&stderr);
    assert!(status.success() && complaint.is_empty(), "{status}: {complaint}");
    String::from_utf8(stdout).unwrap()
}

/// Runs a command that must fail with `code`, one line on stderr, and each of `parts` in it.
#[track_caller]
pub fn fails(command: &mut Command, code: i32, parts: &[&str]) {
    let Output { status, stderr, .. } = command.output().unwrap();
    let complaint = String::from_utf8(stderr).unwrap();
    assert_eq!(status.code(), Some(code), "{complaint}");
    if code == 1 {
        assert!(complaint.starts_with("icoray: error: ") && complaint.lines().count() == 1, "{complaint}");
    }
    for part in parts {
        assert!(complaint.contains(part), "{part:?} is not in {complaint}");
    }
}

#[track_caller]
pub fn has(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "{part:?} is not in\n{text}");
    }
}

/// Waits until something holds.
#[track_caller]
pub fn wait_until(what: &str, holds: impl Fn() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < PATIENCE, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// The words of the line of a table that begins with `name`.
#[track_caller]
pub fn row<'t>(text: &'t str, name: &str) -> Vec<&'t str> {
    let mut rows = text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    rows.find(|row| row.first() == Some(&name)).unwrap_or_else(|| panic!("no row of {name} in\n{text}"))
}

/// Checks that the picture is of that size and shows something: pixels differ, and in more than the globe's outline.
#[track_caller]
pub fn shows_something(path: &Path, width: u32, height: u32) {
    let picture = image::open(path).unwrap().to_rgba32f();
    assert_eq!(picture.dimensions(), (width, height));
    let mut reds: Vec<u32> = picture.pixels().map(|p| p.0[0].to_bits()).collect();
    reds.sort_unstable();
    reds.dedup();
    assert!(reds.len() > 20, "{} shades in {}", reds.len(), path.display());
}

#[derive(Debug)]
pub struct Difference {
    pub mean: f64,
    pub max: u8,
}

/// Compares the pixels of two pictures of one size.
pub fn difference(one: &Path, other: &Path) -> Difference {
    let [one, other] = [one, other].map(|path| image::open(path).unwrap().to_rgba8());
    assert_eq!(one.dimensions(), other.dimensions());
    let each = || one.iter().zip(other.iter()).map(|(a, b)| a.abs_diff(*b));
    Difference { mean: each().map(f64::from).sum::<f64>() / one.len() as f64, max: each().max().unwrap() }
}

/// The names of the PNG files in a folder, sorted.
pub fn pictures(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.filter(|name| name.ends_with(".png")).collect();
    names.sort();
    names
}

/// The text chunks of a PNG file.
pub fn texts(path: &Path) -> Vec<(String, String)> {
    let decoder = png::Decoder::new(BufReader::new(fs::File::open(path).unwrap()));
    let reader = decoder.read_info().unwrap();
    let chunks = reader.info().utf8_text.iter();
    chunks.map(|chunk| (chunk.keyword.clone(), chunk.get_text().unwrap())).collect()
}

/// Checks that a PNG file says what it shows.
#[track_caller]
pub fn says(path: &Path, expected: &[(&str, &str)]) {
    let texts = texts(path);
    for (key, text) in expected {
        assert!(texts.iter().any(|(k, t)| k == key && t == text), "{key} = {text:?} is not in {texts:?}");
    }
}

/// The text chunk that names the program.
pub fn software() -> String {
    format!("icoray {}", env!("CARGO_PKG_VERSION"))
}
