//! Where pictures go, as the command says it.

use icoray::output::{Output, Stamp};
use icoray::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf, absolute};

/// Where pictures go.
pub enum Target {
    /// To this very file.
    Picture(PathBuf),
    /// Into this directory, named by the scene's template, with `report.csv`.
    Directory(PathBuf),
}

impl Target {
    /// Where `pictures` go.
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

    /// Where a picture goes.
    pub fn path(&self, names: &Output, stamp: &Stamp, field: &str) -> Result<PathBuf> {
        match self {
            Target::Directory(directory) => Ok(directory.join(names.names(stamp, field)?.file)),
            Target::Picture(path) => Ok(path.clone()),
        }
    }
}

/// Refuses a map of errors that is no PNG or that would be one for several pictures.
pub fn expect_error_map(path: &Path, pictures: usize) -> Result<()> {
    if path.extension().is_none_or(|e| e != "png") {
        return Err(bad_map(path, "expected a name that ends in .png"));
    }
    if pictures > 1 {
        let what =
            format!("one map for {pictures} pictures; expected output.error in the scene to name the maps");
        return Err(bad_map(path, &what));
    }
    Ok(())
}

/// Refuses a map of errors that would replace the picture.
pub fn expect_apart(map: &Path, picture: &Path) -> Result<()> {
    let same =
        map == picture || absolute(map).ok().is_some_and(|map| absolute(picture).is_ok_and(|p| p == map));
    if same { Err(bad_map(map, "names the picture too, expected another file")) } else { Ok(()) }
}

fn bad_map(path: &Path, what: &str) -> Error {
    Error::new(ErrorKind::Argument, format!("--error {}: {what}", path.display()))
}
