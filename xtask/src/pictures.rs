//! What a model leaves behind: its pictures, their report, and the sheet with all of them.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::error::Error;
use crate::report::Frames;
use crate::workspace::Workspace;

/// The package that makes contact sheets.
pub const SHEET_PACKAGE: &str = "contact-sheet";

/// The folder that a model draws into.
pub struct Pictures {
    folder: PathBuf,
    /// How the names of its pictures begin.
    prefix: &'static str,
}

impl Pictures {
    /// Those of a folder whose names begin so.
    pub fn new(folder: PathBuf, prefix: &'static str) -> Self {
        Self { folder, prefix }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The file that has a line per frame.
    pub fn report(&self) -> PathBuf {
        self.folder.join("report.csv")
    }

    /// The picture of all pictures.
    pub fn sheet(&self) -> PathBuf {
        self.folder.join("contact_sheet.png")
    }

    /// Makes the folder, and removes what an earlier run left in it, which would pass for this run's. Files of other
    /// names are the user's and stay.
    pub fn prepare(&self) -> Result<(), Error> {
        fs::create_dir_all(&self.folder).map_err(Error::while_doing(self.folder.display()))?;
        let mut stale = self.there()?;
        stale.extend([self.report(), self.sheet()]);
        for file in stale {
            match fs::remove_file(&file) {
                Err(cause) if cause.kind() != io::ErrorKind::NotFound => {
                    return Err(Error::while_doing(file.display())(cause));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The pictures of a run, in order: at least one.
    pub fn taken(&self) -> Result<Vec<PathBuf>, Error> {
        let pictures = self.there()?;
        if pictures.is_empty() {
            return Err(Error::Failed(format!("no pictures in {}", self.folder.display())));
        }
        Ok(pictures)
    }

    /// What the report says of them.
    pub fn frames(&self) -> Result<Frames, Error> {
        let report = self.report();
        let csv = fs::read_to_string(&report).map_err(Error::while_doing(report.display()))?;
        Ok(Frames::read(&csv))
    }

    /// The first picture, once it exists. Pictures appear under their names when they are complete.
    pub fn first(&self) -> Option<PathBuf> {
        self.there().ok()?.into_iter().next()
    }

    /// The command that makes the sheet, with the program of the package [`SHEET_PACKAGE`] in this profile's products.
    pub fn make_sheet(&self, workspace: &Workspace, profile: &str) -> Command {
        let mut command = workspace.command(workspace.products(profile).join("contact_sheet"));
        command.arg(&self.folder).arg(self.prefix).arg(self.sheet());
        command
    }

    fn there(&self) -> Result<Vec<PathBuf>, Error> {
        let entries = fs::read_dir(&self.folder).map_err(Error::while_doing(self.folder.display()))?;
        let mut pictures = Vec::new();
        for entry in entries {
            let path = entry.map_err(Error::while_doing(self.folder.display()))?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if name.starts_with(self.prefix) && name.ends_with(".png") {
                pictures.push(path);
            }
        }
        pictures.sort();
        Ok(pictures)
    }
}

/// Fails unless the file is a PNG that was written to its end.
pub fn check_picture(path: &Path) -> Result<(), Error> {
    let bytes = fs::read(path).map_err(Error::while_doing(path.display()))?;
    if is_png(&bytes) {
        Ok(())
    } else {
        Err(Error::Failed(format!("{} is not a complete PNG", path.display())))
    }
}

fn is_png(bytes: &[u8]) -> bool {
    // The last chunk is the same in every file: empty, its name, its checksum.
    const END: &[u8] = b"\0\0\0\0IEND\xae\x42\x60\x82";
    bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.ends_with(END)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A directory of its own for a test, removed at the end.
    struct Scratch(PathBuf);

    impl Scratch {
        fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("icoray-xtask-{name}-{}", std::process::id()));
            fs::create_dir_all(&path).unwrap();
            Self(path)
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn only_the_models_own_files_are_removed() {
        let scratch = Scratch::new("prepare");
        let out = scratch.0.join("a/b");
        let pictures = Pictures::new(out.clone(), "tracer_");
        pictures.prepare().unwrap();
        assert!(pictures.taken().is_err());
        let files = ["tracer_0001.png", "tracer_0000.png", "report.csv", "contact_sheet.png", "mine.png"];
        for name in files {
            fs::write(out.join(name), "").unwrap();
        }
        assert_eq!(pictures.first(), Some(out.join("tracer_0000.png")));
        assert_eq!(pictures.taken().unwrap(), [out.join("tracer_0000.png"), out.join("tracer_0001.png")]);
        pictures.prepare().unwrap();
        let left: Vec<_> = fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, ["mine.png"]);
    }

    #[test]
    fn a_picture_must_be_whole() {
        let whole = b"\x89PNG\r\n\x1a\n...\0\0\0\0IEND\xae\x42\x60\x82";
        assert!(is_png(whole));
        assert!(!is_png(&whole[..whole.len() - 1]));
        assert!(!is_png(b"GIF89a"));
        assert!(!is_png(b""));
    }
}
