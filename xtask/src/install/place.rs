//! Putting files where they belong without touching those in use.
//!
//! A file is written beside its place under a name of its own and then renamed into it. A program that has the old
//! library mapped keeps it, whole, as long as it runs; overwriting in place would change code under its feet.

use std::fs;
use std::io;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process;

use crate::error::Error;

/// What is to lie in one place.
pub enum Content<'a> {
    /// A copy of a file.
    File(&'a Path),
    /// A text.
    Text(String),
    /// A symbolic link to a file beside it.
    Link(&'a str),
}

/// Puts `content` at `path`, in one step. The directory must be there.
pub fn place(path: &Path, content: &Content, mode: u32) -> Result<(), Error> {
    let beside = temporary(path);
    put(&beside, content, mode).and_then(|()| fs::rename(&beside, path)).map_err(|cause| {
        let _ = fs::remove_file(&beside);
        Error::Failed(format!("{}: {cause}", path.display()))
    })
}

/// Makes a directory, with those above it, and sees that files can be put there.
pub fn prepare(directory: &Path) -> Result<(), Error> {
    let probe = temporary(&directory.join("probe"));
    fs::create_dir_all(directory)
        .and_then(|()| fs::write(&probe, ""))
        .and_then(|()| fs::remove_file(&probe))
        .map_err(|cause| {
            let advice = match cause.kind() {
                io::ErrorKind::PermissionDenied => "\n--prefix takes another place, such as \"$HOME/.local\"",
                _ => "",
            };
            Error::Failed(format!("{}: {cause}{advice}", directory.display()))
        })
}

fn put(path: &Path, content: &Content, mode: u32) -> io::Result<()> {
    // Left by a process of the same number that was killed.
    let _ = fs::remove_file(path);
    match content {
        Content::File(from) => fs::copy(from, path).map(drop)?,
        Content::Text(text) => fs::write(path, text)?,
        Content::Link(target) => return symlink(target, path),
    }
    // Whoever installs, with whatever umask, others are to read it.
    fs::set_permissions(path, fs::Permissions::from_mode(mode))
}

fn temporary(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}", process::id()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    fn scratch(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("icoray-xtask-{name}-{}", process::id()));
        let _ = fs::remove_dir_all(&path);
        path
    }

    #[test]
    fn who_has_the_old_file_open_keeps_it() {
        let directory = scratch("place").join("a/b");
        prepare(&directory).unwrap();
        let path = directory.join("library");
        place(&path, &Content::Text("old".into()), 0o644).unwrap();
        let mut open = fs::File::open(&path).unwrap();
        place(&path, &Content::Text("new and longer".into()), 0o755).unwrap();
        let mut kept = String::new();
        open.read_to_string(&mut kept).unwrap();
        assert_eq!(kept, "old");
        assert_eq!(fs::read_to_string(&path).unwrap(), "new and longer");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o755);

        // A link that is there is replaced, not followed.
        let link = directory.join("link");
        place(&link, &Content::Link("nowhere"), 0).unwrap();
        place(&link, &Content::Link("library"), 0).unwrap();
        assert_eq!(fs::read_link(&link).unwrap(), Path::new("library"));
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 2, "something temporary was left");
        fs::remove_dir_all(scratch("place")).unwrap_or_default();
    }

    #[test]
    fn what_cannot_be_placed_is_named_and_leaves_nothing() {
        let directory = scratch("refused");
        prepare(&directory).unwrap();
        let error =
            place(&directory.join("x"), &Content::File(Path::new("/nonexistent")), 0o644).unwrap_err();
        assert!(error.to_string().starts_with(&directory.join("x").display().to_string()), "{error}");
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 0);
        fs::write(directory.join("file"), "").unwrap();
        assert!(prepare(&directory.join("file/below")).is_err());
        fs::remove_dir_all(directory).unwrap();
    }
}
