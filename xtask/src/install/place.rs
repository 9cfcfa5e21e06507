//! Puts files where they belong without touching those in use.
//!
//! A file is written beside its place under a name of its own and then renamed into it. A program that has the old
//! library mapped keeps all of it as long as it runs; overwriting in place would change the code that it executes.

use std::fs;
use std::io;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process;

use crate::disk;
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

/// What lies in one place.
pub struct Item<'a> {
    /// Its path.
    pub path: PathBuf,
    /// What it is.
    pub content: Content<'a>,
    /// Its permissions; of no meaning for links.
    pub mode: u32,
}

/// Puts all items in their places, and makes the directories. All are written beside their places before the first is renamed, so
/// that a disk that runs full leaves what was there before.
pub fn place(items: &[Item]) -> Result<(), Error> {
    let remove = |items: &[Item]| {
        for item in items {
            // Not there, or in its place already.
            let _ = fs::remove_file(temporary(&item.path));
        }
    };
    let placed = items.iter().try_for_each(write).and_then(|()| {
        items.iter().try_for_each(|item| fs::rename(temporary(&item.path), &item.path).map_err(failed(item)))
    });
    placed.inspect_err(|_| remove(items))
}

/// Writes an item beside its place.
fn write(item: &Item) -> Result<(), Error> {
    // A file cannot be renamed to a directory's name.
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
        io::ErrorKind::StorageFull => Error::Failed(format!(
            "{path}: no space is left on the disk: free some, or choose another --prefix"
        )),
        _ => Error::Failed(format!("{path}: {cause}")),
    }
}

/// Fails where files could not be put into a directory, or the directory could not be made.
pub fn check(directory: &Path) -> Result<(), Error> {
    disk::writable(directory, "--prefix takes another place, such as \"$HOME/.local\"")
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

    fn item(path: PathBuf, text: &str, mode: u32) -> Item<'static> {
        Item { path, content: Content::Text(text.into()), mode }
    }

    #[test]
    fn who_has_the_old_file_open_keeps_it() {
        let directory = scratch("place").join("a/b");
        let path = directory.join("library");
        place(&[item(path.clone(), "old", 0o644)]).unwrap();
        let mut open = fs::File::open(&path).unwrap();
        place(&[item(path.clone(), "new and longer", 0o755)]).unwrap();
        let mut kept = String::new();
        open.read_to_string(&mut kept).unwrap();
        assert_eq!(kept, "old");
        assert_eq!(fs::read_to_string(&path).unwrap(), "new and longer");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o755);

        // A link that is there is replaced, not followed.
        let link = |to| [Item { path: directory.join("link"), content: Content::Link(to), mode: 0 }];
        place(&link("nowhere")).unwrap();
        place(&link("library")).unwrap();
        assert_eq!(fs::read_link(directory.join("link")).unwrap(), Path::new("library"));
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 2, "something temporary was left");
        fs::remove_dir_all(scratch("place")).unwrap_or_default();
    }

    #[test]
    fn a_failure_leaves_all_that_was_there() {
        let directory = scratch("refused");
        place(&[item(directory.join("library"), "old", 0o644)]).unwrap();
        let refused = |last: Item<'static>| {
            let name = last.path.display().to_string();
            let message =
                place(&[item(directory.join("library"), "new", 0o644), last]).unwrap_err().to_string();
            assert!(message.starts_with(&name), "{message}");
            assert_eq!(fs::read_to_string(directory.join("library")).unwrap(), "old");
        };
        let absent = Content::File(Path::new("/nonexistent"));
        refused(Item { path: directory.join("x"), content: absent, mode: 0o644 });
        fs::create_dir(directory.join("taken")).unwrap();
        refused(item(directory.join("taken"), "", 0o644));
        refused(item(directory.join("library/below"), "", 0o644));
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 2, "something temporary was left");
        assert!(check(&directory.join("library/below")).is_err());
        assert!(check(&directory.join("not/yet")).is_ok() && !directory.join("not").exists());
        fs::remove_dir_all(directory).unwrap();
    }
}
