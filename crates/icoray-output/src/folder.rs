//! Folders of files: makes them, and checks whether files can be created there before the run draws the first picture.

use super::atomic;
use icoray_grid::{Error, ErrorKind, Result};
use std::fmt::Display;
use std::fs::{self, File};
use std::io;
use std::path::Path;

/// An error of kind [`ErrorKind::Io`] that names the path.
pub(crate) fn io_error(path: &Path, what: &str, error: impl Display) -> Error {
    Error::new(ErrorKind::Io, format!("{}: {what}: {error}", path.display()))
}

/// A file to be read; `None` if there is none. Opening a pipe would wait for a writer.
pub(super) fn existing_file(path: &Path) -> io::Result<Option<File>> {
    match fs::metadata(path) {
        Ok(found) if !found.is_file() => Err(io::Error::other("it is not a file")),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
        found => found.and_then(|_| File::open(path)).map(Some),
    }
}

/// The folder of a file, made if missing.
pub(crate) fn made_folder(path: &Path) -> Result<&Path> {
    let folder = atomic::folder(path);
    fs::create_dir_all(folder).map_err(|e| io_error(folder, "cannot make the directory", e))?;
    Ok(folder)
}

/// Checks that a file can be made: its name is possible, all its parents are folders, and its folder, or the existing
/// parent in which that would be made, can be written to. Leaves nothing behind.
///
/// # Errors
/// [`ErrorKind::Io`] names `path` and the obstacle.
pub(super) fn check_file(path: &Path) -> Result<()> {
    let refused = |what: &str, e: io::Error| io_error(path, what, e);
    let mut ancestors = path.ancestors();
    if let Some(name) = ancestors.next() {
        is_there(name).map_err(|e| refused("cannot write the file", e))?;
    }
    check_ancestors(ancestors)
        .map_err(|(folder, e)| refused(&format!("cannot write to the folder {}", folder.display()), e))
}

/// Checks that a folder can be written to, or can be made.
///
/// # Errors
/// As [`check_file`].
pub(super) fn check_folder(path: &Path) -> Result<()> {
    check_ancestors(path.ancestors()).map_err(|(folder, e)| {
        let of = if folder == path { String::new() } else { format!(" in {}", folder.display()) };
        io_error(path, &format!("cannot make pictures{of}"), e)
    })
}

/// Checks that the first existing folder is writable.
fn check_ancestors<'p>(ancestors: impl Iterator<Item = &'p Path>) -> std::result::Result<(), (&'p Path, io::Error)> {
    for folder in ancestors {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        if is_there(folder).map_err(|e| (folder, e))? {
            return may_write(folder).map_err(|e| (folder, e));
        }
    }
    Ok(())
}

/// Whether the name exists, also as a broken link.
fn is_there(path: &Path) -> io::Result<bool> {
    match path.symlink_metadata() {
        Ok(_) => Ok(true),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(e) => Err(e),
    }
}

/// Whether this process can make files in a folder: makes one without a name, since permissions do not reveal file
/// systems that are read-only or full, or servers with rules of their own.
fn may_write(folder: &Path) -> io::Result<()> {
    if !folder.metadata()?.is_dir() {
        return Err(io::ErrorKind::NotADirectory.into());
    }
    tempfile::tempfile_in(folder).map(drop).map_err(|e| io::Error::other(atomic::cause(&e)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(path: &Path) -> String {
        check_file(path).unwrap_err().to_string()
    }

    #[test]
    fn folders_that_are_there_or_can_be_made_are_fine() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("there.png"), "").unwrap();
        for name in ["new.png", "there.png", "new/newer/x.png"] {
            check_file(&at(name)).unwrap();
        }
        check_folder(folder.path()).unwrap();
        check_folder(&at("new/newer")).unwrap();
        check_folder(Path::new("")).unwrap();
        check_file(Path::new("x.png")).unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left");
    }

    #[test]
    fn obstacles_of_a_folder_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("file"), "").unwrap();
        for path in [at("file/x.png"), at("file/y/x.png")] {
            assert!(refused(&path).contains("ot a directory"), "{}", refused(&path));
        }
        assert!(check_folder(&at("file")).unwrap_err().to_string().contains("file: cannot make pictures: "));
        assert!(refused(&at(&"x".repeat(300))).contains("too long"));
        assert!(refused(Path::new("x\0.png")).contains("cannot write the file"));
        std::os::unix::fs::symlink(at("nothing"), at("link")).unwrap();
        let error = check_folder(&at("link/pictures")).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Io);
        assert!(error.to_string().contains("link/pictures: cannot make pictures in "), "{error}");
    }

    /// A file system in which no user can create files, not even root.
    #[cfg(target_os = "linux")]
    #[test]
    fn folders_without_write_access_are_named() {
        for path in ["/proc", "/proc/pictures/more"] {
            let error = check_folder(Path::new(path)).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Io);
            assert!(error.to_string().contains(&format!("{path}: cannot make pictures")), "{error}");
        }
        let error = refused(Path::new("/proc/x.png"));
        assert!(error.contains("/proc/x.png: cannot write to the folder /proc: "), "{error}");
    }
}
