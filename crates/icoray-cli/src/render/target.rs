//! Where pictures go, as the command says it.

use super::Time;
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
    pub fn new(output: Option<&Path>, time: Time) -> Result<Self> {
        let Some(path) = output else {
            return Ok(Target::Directory(PathBuf::new()));
        };
        let bad = |what: &str| Error::new(ErrorKind::Argument, format!("-o {}: {what}", path.display()));
        let ending = path.extension().and_then(|e| e.to_str());
        let is_directory = path.is_dir() || path.to_string_lossy().ends_with(['/', '\\']);
        match (ending, time) {
            _ if is_directory => Ok(Target::Directory(path.to_owned())),
            (Some("png" | "exr"), Time::Index(_)) => Ok(Target::Picture(path.to_owned())),
            (Some("png" | "exr"), Time::All) => Err(bad(
                "one picture for --time all; expected a directory, the scene's output.file names the pictures",
            )),
            (None, _) => Ok(Target::Directory(path.to_owned())),
            _ => Err(bad("expected a name that ends in .png or .exr, or a directory")),
        }
    }

    /// Where the picture of a time goes.
    pub fn path(&self, names: &Output, stamp: &Stamp, field: &str) -> Result<PathBuf> {
        match self {
            Target::Directory(directory) => Ok(directory.join(names.names(stamp, field)?.file)),
            Target::Picture(path) => Ok(path.clone()),
        }
    }
}

/// Refuses a map of errors that is no PNG or that would be one for several pictures.
pub fn expect_error_map(path: &Path, time: Time) -> Result<()> {
    match time {
        _ if path.extension().is_none_or(|e| e != "png") => {
            Err(bad_map(path, "expected a name that ends in .png"))
        }
        Time::All => {
            Err(bad_map(path, "one map for --time all; expected output.error in the scene to name the maps"))
        }
        Time::Index(_) => Ok(()),
    }
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
