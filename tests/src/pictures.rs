//! Pictures and reports that programs leave in a directory.

use image::RgbaImage;
use std::collections::{BTreeMap, HashSet};
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Pictures by their files' names.
pub type Pictures = BTreeMap<String, RgbaImage>;

/// The PNG files of a directory, which need not exist.
pub fn pictures(directory: &Path) -> Pictures {
    let Ok(entries) = std::fs::read_dir(directory) else { return Pictures::new() };
    let paths = entries.map(|entry| entry.unwrap().path());
    let pictures = paths.filter(|path| path.extension().is_some_and(|extension| extension == "png"));
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    pictures.map(|path| (name(&path), image::open(&path).unwrap().into_rgba8())).collect()
}

/// The files of a directory but its report, whose lines have seconds.
pub fn files(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
    let named = entries.map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), path));
    let kept = named.filter(|(name, _)| name != "report.csv");
    // Of a directory in it only the name.
    let read = |path: &Path| if path.is_dir() { Vec::new() } else { std::fs::read(path).unwrap() };
    kept.map(|(name, path)| (name, read(&path))).collect()
}

/// Fails unless the pictures have the same names, and channels that differ by no more than 1 of 255.
pub fn assert_same(drawn: &Pictures, expected: &Pictures, what: impl Display) {
    assert_eq!(drawn.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>(), "{what}");
    for (name, expected) in expected {
        let difference = drawn[name].iter().zip(expected.iter()).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        assert!(difference <= 1, "{what}: {name}: {difference} of 255");
    }
}

/// [`assert_same`] for the pictures that a run has left in its directory.
pub fn assert_drew(run: &Path, expected: &Pictures) {
    assert_same(&pictures(&run.join("pictures")), expected, run.display());
}

/// Largest and root-mean-square difference of the channels of two files.
pub fn difference(one: &Path, other: &Path) -> [f64; 2] {
    let [one, other] = [one, other].map(|path| {
        let picture = image::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        picture.into_rgba32f()
    });
    assert_eq!(one.dimensions(), other.dimensions());
    let channels = || one.as_raw().iter().zip(other.as_raw()).map(|(a, b)| f64::from((a - b).abs()));
    let squares: f64 = channels().map(|d| d * d).sum();
    [channels().fold(0.0, f64::max), (squares / one.as_raw().len() as f64).sqrt()]
}

/// Fails unless each picture has more than `colors` colours, and none is another one.
pub fn assert_distinct(pictures: &Pictures, colors: usize) {
    for (name, picture) in pictures {
        let count = count_colors(picture);
        assert!(count > colors, "{name}: {count} colours");
        let same = pictures.iter().find(|(other, pixels)| *other != name && *pixels == picture);
        assert!(same.is_none(), "{name}: {same:?}");
    }
}

/// Number of different colours.
pub fn count_colors(picture: &RgbaImage) -> usize {
    picture.pixels().collect::<HashSet<_>>().len()
}

/// The rows of a CSV file: their cells by the names of the columns.
pub fn rows(file: &Path) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_path(file).unwrap().into_deserialize().collect::<Result<_, _>>().unwrap()
}

/// The cells of a column of a CSV file.
pub fn column(file: &Path, name: &str) -> Vec<String> {
    rows(file).into_iter().map(|mut row| row.remove(name).unwrap()).collect()
}

/// Pictures that are the same.
#[derive(Debug)]
pub struct Group {
    /// How many there are.
    pub count: usize,
    /// One of them.
    pub picture: RgbaImage,
}

/// The pictures of these files, of 64 x 64 pixels, by their names up to the last underscore; others are left out. Fails
/// where pictures of a group differ.
pub fn groups(paths: impl IntoIterator<Item = PathBuf>) -> BTreeMap<String, Group> {
    let mut groups: BTreeMap<String, Group> = BTreeMap::new();
    for path in paths {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let Some((name, _)) = name.rsplit_once('_') else { continue };
        let picture = image::open(&path).unwrap().into_rgba8();
        assert_eq!(picture.dimensions(), (64, 64));
        let group = groups.entry(name.into()).or_insert_with(|| Group { count: 0, picture: picture.clone() });
        assert!(group.picture == picture, "{} differs from others of its name", path.display());
        group.count += 1;
    }
    groups
}
