//! The target of pictures, from the option `--output`.

use icoray::output::{Existing, Output, Stamp};
use icoray::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf, absolute};

pub enum Target {
    /// This file.
    Picture(PathBuf),
    /// This directory; the scene's template names the pictures, and `report.csv` lies beside them.
    Directory(PathBuf),
}

impl Target {
    /// The target of `pictures` pictures.
    pub fn new(output: Option<&Path>, pictures: usize) -> Result<Self> {
        let Some(path) = output else {
            return Ok(Target::Directory(PathBuf::new()));
        };
        let bad = |what: String| Error::new(ErrorKind::Argument, format!("-o {}: {what}", path.display()));
        let ending = path.extension().and_then(|e| e.to_str());
        let is_directory = path.is_dir() || path.to_string_lossy().ends_with(['/', '\\']);
        match (ending, pictures) {
            _ if is_directory => Ok(Target::Directory(path.to_owned())),
            (Some("png" | "exr"), 1) => Ok(Target::Picture(path.to_owned())),
            (Some("png" | "exr"), _) => Err(bad(format!(
                "one name for {pictures} pictures; expected a directory, the scene's output.file names the pictures"
            ))),
            (None, _) => Ok(Target::Directory(path.to_owned())),
            _ => Err(bad("expected a name that ends in .png or .exr, or a directory".into())),
        }
    }

    /// The directory at `path`, for pictures whose number is not known; makes it.
    pub fn directory(path: &Path) -> Result<Self> {
        let is_picture = path.extension().is_some_and(|ending| ending == "png" || ending == "exr");
        if is_picture && !path.is_dir() {
            let what = "expected a directory, the scene's output.file names the pictures";
            return Err(Error::new(ErrorKind::Argument, format!("-o {}: {what}", path.display())));
        }
        Existing::Overwrite.prepare(&path.join("report.csv"))?;
        Ok(Target::Directory(path.to_owned()))
    }

    pub fn path(&self, names: &Output, stamp: &Stamp, field: &str) -> Result<PathBuf> {
        match self {
            Target::Directory(directory) => Ok(directory.join(names.names(stamp, field)?.file)),
            Target::Picture(path) => Ok(path.clone()),
        }
    }
}

/// Checks that the error map is a PNG and that there is one picture.
pub fn expect_error_map(path: &Path, pictures: usize) -> Result<()> {
    if path.extension().is_none_or(|e| e != "png") {
        return Err(bad_map(path, "expected a name that ends in .png"));
    }
    if pictures > 1 {
        let what = format!("one map for {pictures} pictures; expected output.error in the scene to name the maps");
        return Err(bad_map(path, &what));
    }
    Ok(())
}

/// Checks that the error map is another file than the picture.
pub fn expect_apart(map: &Path, picture: &Path) -> Result<()> {
    let same = map == picture || absolute(map).ok().is_some_and(|map| absolute(picture).is_ok_and(|p| p == map));
    if same { Err(bad_map(map, "names the picture too, expected another file")) } else { Ok(()) }
}

fn bad_map(path: &Path, what: &str) -> Error {
    Error::new(ErrorKind::Argument, format!("--error {}: {what}", path.display()))
}
