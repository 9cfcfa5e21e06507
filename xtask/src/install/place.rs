//! Installs files without changing those in use.
//!
//! Each file is written under a temporary name and then renamed. A running program keeps the old library that it has
//! mapped; overwriting that would change the code that the program executes.

use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::{fs, io};

use tempfile::{Builder, TempPath};

use crate::error::Error;

pub enum Content<'a> {
    /// A copy of a file.
    File(&'a Path),
    Text(String),
    /// A symbolic link to a file in the same directory.
    Link(&'a str),
}

pub struct Item<'a> {
    pub path: PathBuf,
    pub content: Content<'a>,
    /// Permissions; links have none.
    pub mode: u32,
}

/// Installs all files, and makes their directories. All are written before the first is renamed, so that a full disk
/// changes nothing.
pub fn place(items: &[Item]) -> Result<(), Error> {
    let written = items.iter().map(write).collect::<Result<Vec<_>, _>>()?;
    let pairs = written.into_iter().zip(items);
    pairs.into_iter().try_for_each(|(file, item)| file.persist(&item.path).map_err(|at| failed(item, at.error)))
}

/// Writes an item under a temporary name.
fn write(item: &Item) -> Result<TempPath, Error> {
    // A file cannot be renamed to the name of a directory.
    if item.path.is_dir() && !item.path.is_symlink() {
        return Err(Error(format!("{} is a directory: move it away", item.path.display())));
    }
    let directory = item.path.parent().unwrap_or(&item.path);
    let written = fs::create_dir_all(directory)
        .and_then(|()| Builder::new().make_in(directory, |path| put(path, &item.content, item.mode)));
    Ok(written.map_err(|cause| failed(item, cause))?.into_temp_path())
}

fn failed(item: &Item, cause: io::Error) -> Error {
    Error(format!("{}: {cause}; --prefix takes another place", item.path.display()))
}

fn put(path: &Path, content: &Content, mode: u32) -> io::Result<()> {
    match content {
        Content::File(from) => fs::copy(from, path).map(drop)?,
        Content::Text(text) => fs::write(path, text)?,
        Content::Link(target) => return symlink(target, path),
    }
    // Independent of the umask.
    fs::set_permissions(path, fs::Permissions::from_mode(mode))
}

#[cfg(test)]
mod tests {
    use super::*;
    use xshell::Shell;

    fn item(path: PathBuf, content: Content<'static>, mode: u32) -> Item<'static> {
        Item { path, content, mode }
    }

    #[test]
    fn a_file_in_use_keeps_its_content() {
        let scratch = Shell::new().unwrap().create_temp_dir().unwrap();
        let directory = scratch.path().join("a/b");
        let (path, link) = (directory.join("library"), directory.join("link"));
        place(&[item(path.clone(), Content::Text("old".into()), 0o644), item(link.clone(), Content::Link("no"), 0)])
            .unwrap();
        let open = fs::File::open(&path).unwrap();
        // An existing link is replaced, not followed.
        let new = Content::Text("new and longer".into());
        place(&[item(path.clone(), new, 0o755), item(link.clone(), Content::Link("library"), 0)]).unwrap();
        assert_eq!(io::read_to_string(open).unwrap(), "old");
        assert_eq!(fs::read_to_string(link).unwrap(), "new and longer");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o755);
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 2, "something temporary was left");
    }

    #[test]
    fn a_failure_leaves_all_that_was_there() {
        let scratch = Shell::new().unwrap().create_temp_dir().unwrap();
        let library = scratch.path().join("library");
        let with = |text: &str| item(library.clone(), Content::Text(text.into()), 0o644);
        place(&[with("old")]).unwrap();
        fs::create_dir(scratch.path().join("taken")).unwrap();
        for (name, content) in [
            ("x", Content::File(Path::new("/nonexistent"))),
            ("taken", Content::Text(String::new())),
            ("library/below", Content::Text(String::new())),
        ] {
            let path = scratch.path().join(name);
            let message = place(&[with("new"), item(path.clone(), content, 0o644)]).unwrap_err().to_string();
            assert!(message.starts_with(&path.display().to_string()), "{message}");
            assert_eq!(fs::read_to_string(&library).unwrap(), "old");
        }
        assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 2, "something temporary was left");
    }
}
