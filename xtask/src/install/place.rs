//! Installs files without changing those in use.
//!
//! Each file is written under a temporary name and then renamed. A running program keeps the old library that it has
//! mapped; overwriting that would change the code that the program executes.

use std::fs;
use std::io;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process;

use crate::error::Error;

/// The content of an installed file.
pub enum Content<'a> {
    /// A copy of a file.
    File(&'a Path),
    Text(String),
    /// A symbolic link to a file in the same directory.
    Link(&'a str),
}

/// A file to install.
pub struct Item<'a> {
    pub path: PathBuf,
    pub content: Content<'a>,
    /// Permissions; links have none.
    pub mode: u32,
}

/// Installs all files, and makes their directories. All are written before the first is renamed, so that a full disk
/// changes nothing.
pub fn place(items: &[Item]) -> Result<(), Error> {
    let rename = |item: &Item| fs::rename(temporary(&item.path), &item.path).map_err(failed(item));
    let placed = items.iter().try_for_each(write).and_then(|()| items.iter().try_for_each(rename));
    placed.inspect_err(|_| {
        for item in items {
            // An error means that it was not written, or is renamed already.
            let _ = fs::remove_file(temporary(&item.path));
        }
    })
}

/// Writes an item under its temporary name.
fn write(item: &Item) -> Result<(), Error> {
    // A file cannot be renamed to the name of a directory.
    if item.path.is_dir() && !item.path.is_symlink() {
        return Err(Error::Failed(format!("{} is a directory: move it away", item.path.display())));
    }
    let directory = item.path.parent().unwrap_or(&item.path);
    fs::create_dir_all(directory)
        .and_then(|()| put(&temporary(&item.path), &item.content, item.mode))
        .map_err(failed(item))
}

fn failed(item: &Item) -> impl FnOnce(io::Error) -> Error {
    let path = item.path.display().to_string();
    move |cause| match cause.kind() {
        io::ErrorKind::StorageFull => {
            Error::Failed(format!("{path}: no space is left on the disk: free some, or choose another --prefix"))
        }
        _ => Error::Failed(format!("{path}: {cause}")),
    }
}

fn put(path: &Path, content: &Content, mode: u32) -> io::Result<()> {
    // A process with the same number that was killed may have left it.
    let _ = fs::remove_file(path);
    match content {
        Content::File(from) => fs::copy(from, path).map(drop)?,
        Content::Text(text) => fs::write(path, text)?,
        Content::Link(target) => return symlink(target, path),
    }
    // Independent of the umask.
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
    use xshell::{Shell, TempDir};

    fn scratch() -> TempDir {
        Shell::new().unwrap().create_temp_dir().unwrap()
    }

    fn item(path: PathBuf, text: &str, mode: u32) -> Item<'static> {
        Item { path, content: Content::Text(text.into()), mode }
    }

    #[test]
    fn an_open_file_keeps_its_content() {
        let scratch = scratch();
        let directory = scratch.path().join("a/b");
        let path = directory.join("library");
        place(&[item(path.clone(), "old", 0o644)]).unwrap();
        let mut open = fs::File::open(&path).unwrap();
        place(&[item(path.clone(), "new and longer", 0o755)]).unwrap();
        let mut kept = String::new();
        open.read_to_string(&mut kept).unwrap();
        assert_eq!(kept, "old");
        assert_eq!(fs::read_to_string(&path).unwrap(), "new and longer");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o755);

        // An existing link is replaced, not followed.
        let link = |to| [Item { path: directory.join("link"), content: Content::Link(to), mode: 0 }];
        place(&link("nowhere")).unwrap();
        place(&link("library")).unwrap();
        assert_eq!(fs::read_link(directory.join("link")).unwrap(), Path::new("library"));
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 2, "something temporary was left");
    }

    #[test]
    fn a_failure_leaves_all_that_was_there() {
        let scratch = scratch();
        let directory = scratch.path();
        place(&[item(directory.join("library"), "old", 0o644)]).unwrap();
        let refused = |last: Item<'static>| {
            let name = last.path.display().to_string();
            let message = place(&[item(directory.join("library"), "new", 0o644), last]).unwrap_err().to_string();
            assert!(message.starts_with(&name), "{message}");
            assert_eq!(fs::read_to_string(directory.join("library")).unwrap(), "old");
        };
        let absent = Content::File(Path::new("/nonexistent"));
        refused(Item { path: directory.join("x"), content: absent, mode: 0o644 });
        fs::create_dir(directory.join("taken")).unwrap();
        refused(item(directory.join("taken"), "", 0o644));
        refused(item(directory.join("library/below"), "", 0o644));
        assert_eq!(fs::read_dir(directory).unwrap().count(), 2, "something temporary was left");
    }
}
