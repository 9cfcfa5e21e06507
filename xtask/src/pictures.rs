//! The pictures of a model, their report, and their contact sheet.

use std::path::PathBuf;

use xshell::Cmd;

use crate::error::Error;
use crate::files;
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
        let sh = &self.workspace.shell;
        sh.create_dir(&self.folder)?;
        let files = self.existing().into_iter().chain([self.report(), self.sheet()]);
        Ok(files.into_iter().try_for_each(|file| sh.remove_path(file))?)
    }

    /// The pictures so far, in order. They are complete when they appear under their names.
    pub fn existing(&self) -> Vec<PathBuf> {
        files::fitting(&self.folder, &format!("{}*.png", self.prefix))
    }

    /// The command that makes the contact sheet, by the program of [`SHEET_PACKAGE`] in a profile's products.
    pub fn make_sheet(&self, profile: &str) -> Cmd<'a> {
        let program = self.workspace.shell.cmd(self.workspace.products(profile).join("contact_sheet"));
        program.arg(&self.folder).arg(self.prefix).arg(self.sheet())
    }
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
        for name in ["tracer_0001.png", "tracer_0000.png", "report.csv", "contact_sheet.png", "mine.png"] {
            workspace.shell.write_file(out.join(name), "").unwrap();
        }
        assert_eq!(pictures.existing(), [out.join("tracer_0000.png"), out.join("tracer_0001.png")]);
        pictures.prepare().unwrap();
        assert_eq!(files::fitting(&out, "*"), [out.join("mine.png")]);
    }
}
