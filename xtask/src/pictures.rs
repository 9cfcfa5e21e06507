//! The pictures of a model, their report, and their contact sheet.

use std::fs;
use std::path::{Path, PathBuf};

use xshell::Cmd;

use crate::error::Error;
use crate::files;
use crate::report::Frames;
use crate::workspace::Workspace;

/// The package that makes contact sheets.
pub const SHEET_PACKAGE: &str = "contact-sheet";

/// The pictures of a model in a directory.
pub struct Pictures<'a> {
    workspace: &'a Workspace,
    pub folder: PathBuf,
    /// The start of their names.
    prefix: &'static str,
}

impl<'a> Pictures<'a> {
    pub fn new(workspace: &'a Workspace, folder: PathBuf, prefix: &'static str) -> Self {
        Self { workspace, folder, prefix }
    }

    /// The file that has a line per frame.
    pub fn report(&self) -> PathBuf {
        self.folder.join("report.csv")
    }

    /// The file of the contact sheet.
    pub fn sheet(&self) -> PathBuf {
        self.folder.join("contact_sheet.png")
    }

    /// Makes the directory, and removes the files that an earlier run left in it. Files of other names are the user's.
    pub fn prepare(&self) -> Result<(), Error> {
        self.workspace.shell.create_dir(&self.folder)?;
        let more = [self.report(), self.sheet()].into_iter().filter(|file| file.exists());
        for file in self.existing().into_iter().chain(more) {
            fs::remove_file(&file).map_err(Error::while_doing(file.display()))?;
        }
        Ok(())
    }

    /// The pictures of a run, in order: at least one.
    pub fn taken(&self) -> Result<Vec<PathBuf>, Error> {
        let pictures = self.existing();
        if pictures.is_empty() {
            return Err(Error::Failed(format!("no pictures in {}", self.folder.display())));
        }
        Ok(pictures)
    }

    /// The report of the pictures.
    pub fn frames(&self) -> Result<Frames, Error> {
        Ok(Frames::read(&self.workspace.shell.read_file(self.report())?))
    }

    /// The first picture, once it exists. Pictures are complete when they appear under their names.
    pub fn first(&self) -> Option<PathBuf> {
        self.existing().into_iter().next()
    }

    /// The command that makes the contact sheet, by the program of [`SHEET_PACKAGE`] in a profile's products.
    pub fn make_sheet(&self, profile: &str) -> Cmd<'a> {
        let program = self.workspace.shell.cmd(self.workspace.products(profile).join("contact_sheet"));
        program.arg(&self.folder).arg(self.prefix).arg(self.sheet())
    }

    fn existing(&self) -> Vec<PathBuf> {
        files::fitting(&self.folder, &format!("{}*.png", self.prefix))
    }
}

/// Fails unless the file is a PNG that was written to its end.
pub fn check_picture(path: &Path) -> Result<(), Error> {
    let bytes = fs::read(path).map_err(Error::while_doing(path.display()))?;
    if is_png(&bytes) { Ok(()) } else { Err(Error::Failed(format!("{} is not a complete PNG", path.display()))) }
}

fn is_png(bytes: &[u8]) -> bool {
    // The last chunk of every PNG: its length 0, its name, its checksum.
    const END: &[u8] = b"\0\0\0\0IEND\xae\x42\x60\x82";
    bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.ends_with(END)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_models_own_files_are_removed() {
        let workspace = Workspace::find().unwrap();
        let scratch = workspace.shell.create_temp_dir().unwrap();
        let out = scratch.path().join("a/b");
        let pictures = Pictures::new(&workspace, out.clone(), "tracer_");
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
