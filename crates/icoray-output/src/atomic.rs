//! Atomic files: a file is written under another name in its own folder and renamed when it is complete.
//!
//! A model may be stopped at any moment, a disk may fill up, and other programs may read the folder meanwhile. A rename
//! within one folder is atomic on every file system that models run on, so a picture is either missing or complete. The
//! temporary name begins with a dot and ends in `.tmp`; that file is removed if anything fails, a panic included. Only
//! a killed process leaves it behind.

use crate::folder::{check_file, io_error, made_folder};
use icoray_grid::{Error, ErrorKind, Result};
use std::fs::{File, Permissions};
use std::io::{self, BufWriter, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

/// Treatment of an existing file of a picture's name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Existing {
    /// It stays unchanged, and writing fails with [`ErrorKind::Exists`]: starting a run again does not lose its
    /// pictures.
    #[default]
    NeverModify,
    /// It is replaced, atomically. A link of that name is replaced too, not followed.
    Overwrite,
}

impl Existing {
    /// Checks that a file of this name can be written.
    ///
    /// # Errors
    /// [`ErrorKind::Exists`] if it exists and this is [`Existing::NeverModify`]; [`ErrorKind::Io`] if it is a
    /// directory, or if a parent of it is not a folder. Missing folders are accepted.
    pub fn check(self, path: &Path) -> Result<()> {
        // The name itself counts, not the target of a link: a broken link is in the way too.
        match path.symlink_metadata() {
            Ok(there) if there.is_dir() => Err(io_error(path, "cannot write the file", "a directory has its name")),
            Ok(_) if self == Existing::NeverModify => Err(exists(path)),
            Err(e) if e.kind() == io::ErrorKind::NotADirectory => Err(io_error(path, "cannot write the file", e)),
            _ => Ok(()),
        }
    }

    /// Makes the folder of a file that is still to be computed, and checks that the file can be written then.
    ///
    /// # Errors
    /// As [`Existing::check`]; [`ErrorKind::Io`] if the folder cannot be made or written to.
    pub fn prepare(self, path: &Path) -> Result<()> {
        self.check(path)?;
        made_folder(path)?;
        check_file(path)
    }
}

/// Writes a text to the file at `path`, completely or not at all, and replaces an existing one. Makes the folder.
///
/// # Errors
/// [`ErrorKind::Io`] names the file.
pub fn write_text(path: &Path, what: &str, text: &str) -> Result<()> {
    made_folder(path)?;
    write(path, Existing::Overwrite, what, |out| {
        out.write_all(text.as_bytes()).map_err(|e| io_error(path, &format!("cannot write {what}"), cause(&e)))
    })
}

/// Writes the file at `path` with `encode`, which receives a buffered writer that can seek. `what` describes the file
/// for an error ("the picture").
///
/// The data are on the disk before the file has its name: a crash leaves no empty picture, and a network file system
/// that reports a full disk or quota late reports it in time.
pub(super) fn write(
    path: &Path,
    existing: Existing,
    what: &str,
    encode: impl FnOnce(&mut BufWriter<&File>) -> Result<()>,
) -> Result<()> {
    existing.check(path)?;
    let folder = folder(path);
    let failed = |e: io::Error| io_error(path, &format!("cannot write {what}"), cause(&e));
    let file = temporary(folder).map_err(|e| io_error(path, &format!("cannot create {what}"), cause(&e)))?;
    let mut out = BufWriter::new(file.as_file());
    encode(&mut out)?;
    out.flush().map_err(failed)?;
    drop(out);
    file.as_file().sync_data().map_err(failed)?;
    let moved = match existing {
        Existing::Overwrite => file.persist(path).map_err(|e| e.error),
        Existing::NeverModify => persist_new(file, path),
    };
    match moved {
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists && existing == Existing::NeverModify => Err(exists(path)),
        moved => moved.map(drop).map_err(failed),
    }
}

/// The folder of a file.
pub(super) fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The error that `path` exists.
pub(super) fn exists(path: &Path) -> Error {
    let wish = "move it away, write to another directory or under another name, or let files be overwritten (existing)";
    Error::new(ErrorKind::Exists, format!("{}: is there already and is not modified; {wish}", path.display()))
}

/// A new file in `folder` with the permissions of the umask: tempfile's default is the owner alone.
fn temporary(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".icoray-").suffix(".tmp").permissions(Permissions::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// Gives `file` its name if that is free: atomically if the file system supports a rename that replaces nothing, or
/// hard links. If it supports neither (FAT, some FUSE and network ones), a check and a rename, so that a file created
/// between the two would be replaced.
fn persist_new(file: tempfile::NamedTempFile, path: &Path) -> io::Result<File> {
    let refused = match file.persist_noclobber(path) {
        Ok(file) => return Ok(file),
        Err(refused) => refused,
    };
    use io::ErrorKind::{InvalidInput, PermissionDenied, Unsupported};
    if !matches!(refused.error.kind(), InvalidInput | PermissionDenied | Unsupported) {
        return Err(refused.error);
    }
    rename_new(refused.file, path)
}

/// [`persist_new`] without the file system's help.
fn rename_new(file: tempfile::NamedTempFile, path: &Path) -> io::Result<File> {
    match path.symlink_metadata() {
        Ok(_) => Err(io::ErrorKind::AlreadyExists.into()),
        Err(_) => file.persist(path).map_err(|e| e.error),
    }
}

/// The system's message, without the temporary file's name that the crate adds.
pub(super) fn cause(error: &io::Error) -> String {
    let text = error.to_string();
    text.split_once(" at path ").map_or(text.as_str(), |(cause, _)| cause).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::path::PathBuf;

    fn write_text(path: &Path, existing: Existing, text: &str) -> Result<()> {
        write(path, existing, "the text", |out| out.write_all(text.as_bytes()).map_err(|e| io_error(path, "", e)))
    }

    /// A folder, and a path in it.
    fn place() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        (folder, path)
    }

    fn names(folder: &tempfile::TempDir) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_file_that_is_there_stays_or_is_replaced_whole() {
        let (folder, path) = place();
        write_text(&path, Existing::NeverModify, "first").unwrap();
        let refused = write_text(&path, Existing::NeverModify, "second").unwrap_err();
        assert_eq!(refused.kind(), ErrorKind::Exists);
        for part in [path.to_str().unwrap(), "is there already", "move it away"] {
            assert!(refused.to_string().contains(part), "{refused}");
        }
        assert_eq!(fs::read_to_string(&path).unwrap(), "first");
        write(&path, Existing::Overwrite, "the text", |out| {
            out.write_all(&[b'x'; 100_000]).unwrap();
            out.flush().unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), "first", "nothing is seen before it is complete");
            Ok(())
        })
        .unwrap();
        assert_eq!(fs::read(&path).unwrap().len(), 100_000);
        assert_eq!(names(&folder), ["picture.png"]);
    }

    #[test]
    fn a_file_that_comes_meanwhile_stays() {
        let (folder, path) = place();
        let refused = write(&path, Existing::NeverModify, "the text", |_| {
            fs::write(&path, "another's").unwrap();
            Ok(())
        });
        assert_eq!(refused.unwrap_err().kind(), ErrorKind::Exists);
        assert_eq!(fs::read_to_string(&path).unwrap(), "another's");
        assert_eq!(names(&folder), ["picture.png"]);
    }

    #[test]
    fn without_the_file_systems_help_a_look_comes_before_the_rename() {
        let (folder, path) = place();
        rename_new(temporary(folder.path()).unwrap(), &path).unwrap();
        let refused = rename_new(temporary(folder.path()).unwrap(), &path).unwrap_err();
        assert_eq!(refused.kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(names(&folder), ["picture.png"]);
    }

    #[test]
    fn failed_writes_leave_no_file() {
        let (folder, path) = place();
        let failed = write(&path, Existing::Overwrite, "the text", |out| {
            out.write_all(b"half").unwrap();
            out.flush().unwrap();
            assert_eq!(names(&folder).len(), 1);
            Err(Error::new(ErrorKind::Io, "no more"))
        });
        assert_eq!(failed.unwrap_err().context(), "no more");
        assert_eq!(names(&folder), [""; 0]);
        let panicked = Error::of_panics(|| write(&path, Existing::Overwrite, "the text", |_| panic!("in between")));
        assert_eq!(panicked.unwrap_err().to_string(), "internal error: in between");
        assert_eq!(names(&folder), [""; 0]);
    }

    #[test]
    fn errors_name_files_that_cannot_be_written() {
        let (folder, path) = place();
        fs::create_dir(&path).unwrap();
        for existing in [Existing::NeverModify, Existing::Overwrite] {
            let error = write_text(&path, existing, "").unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Io);
            assert!(error.to_string().contains("picture.png: cannot write the file: a directory"), "{error}");
        }
        fs::write(folder.path().join("file"), "").unwrap();
        let below = folder.path().join("file/x.png");
        assert_eq!(Existing::Overwrite.check(&below).unwrap_err().kind(), ErrorKind::Io);
        Existing::NeverModify.check(&folder.path().join("nowhere/x.png")).unwrap();
        let lost = folder.path().join("nowhere/x.png");
        let error = write_text(&lost, Existing::Overwrite, "").unwrap_err().to_string();
        assert!(error.contains("nowhere/x.png: cannot create the text: ") && !error.contains(".icoray-"), "{error}");
    }

    #[test]
    fn links_count_by_their_own_name_and_the_umask_decides_who_reads() {
        let (folder, path) = place();
        std::os::unix::fs::symlink(folder.path().join("nothing"), &path).unwrap();
        let refused = write_text(&path, Existing::NeverModify, "").unwrap_err();
        assert_eq!(refused.kind(), ErrorKind::Exists);
        write_text(&path, Existing::Overwrite, "new").unwrap();
        assert!(path.symlink_metadata().unwrap().is_file());
        let usual = folder.path().join("usual");
        fs::write(&usual, "").unwrap();
        let mode = |path: &Path| path.metadata().unwrap().permissions().mode();
        assert_eq!(mode(&path), mode(&usual));
    }

    #[test]
    fn a_bare_name_is_in_the_working_directory() {
        let name = format!("atomic-{}.txt", std::process::id());
        write_text(Path::new(&name), Existing::NeverModify, "here").unwrap();
        assert_eq!(fs::read_to_string(std::env::current_dir().unwrap().join(&name)).unwrap(), "here");
        fs::remove_file(name).unwrap();
    }

    #[test]
    fn texts_replace_existing_files_and_follow_no_link() {
        let folder = tempfile::tempdir().unwrap();
        let [path, partial, other] = ["a.toml", "a.toml.part", "other"].map(|name| folder.path().join(name));
        fs::write(&other, "another's").unwrap();
        [&path, &partial].into_iter().for_each(|link| std::os::unix::fs::symlink(&other, link).unwrap());
        super::write_text(&path, "the scene", "new").unwrap();
        assert_eq!([&path, &other].map(|file| fs::read_to_string(file).unwrap()), ["new", "another's"]);
        assert!(super::write_text(&path.join("within"), "the scene", "new").is_err());
    }
}
