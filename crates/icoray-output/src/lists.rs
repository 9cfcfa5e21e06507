//! Index files of a series of pictures: a list for ffmpeg, and a Cinema database.
//!
//! An entry is added after its picture has been written. The file is replaced as a whole, so that it is complete
//! whenever a run is stopped; existing entries are not added again.

use crate::atomic::write_text;
use crate::folder::{existing_file, io_error, made_folder};
use crate::report::csv_cell;
use icoray_grid::{Error, ErrorKind, Result};
use icoray_scene::name::{Cinema, Concat, Series, Stamp};
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf, absolute};

/// An index file of a series: its path and its first line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct IndexFile {
    path: PathBuf,
    head: String,
    /// Name of the kind of file in errors.
    what: &'static str,
}

/// Index files of a series whose pictures are in `directory`; with error maps, the database has a column for them.
pub(super) fn index_files(series: &Series, directory: &Path, has_error: bool) -> impl Iterator<Item = IndexFile> {
    let list = series.concat.as_ref().map(|concat| list_of(concat, directory));
    let table = series.cinema.as_ref().map(|cinema| table_of(cinema, directory, has_error));
    list.into_iter().chain(table)
}

/// Adds entries for a written picture and the map of its errors.
pub(super) fn add(
    series: &Series,
    directory: &Path,
    stamp: &Stamp,
    picture: &Path,
    error: Option<&Path>,
) -> Result<()> {
    if let Some(concat) = &series.concat {
        add_to_list(concat, directory, picture)?;
    }
    if let Some(cinema) = &series.cinema {
        add_to_table(cinema, directory, stamp, picture, error)?;
    }
    Ok(())
}

fn list_of(concat: &Concat, directory: &Path) -> IndexFile {
    let (head, what) = ("ffconcat version 1.0".into(), "the list of pictures");
    IndexFile { path: directory.join(&concat.file), head, what }
}

fn add_to_list(concat: &Concat, directory: &Path, picture: &Path) -> Result<()> {
    let list = list_of(concat, directory);
    // ffmpeg reads everything between apostrophes literally except apostrophes.
    let file = format!("file '{}'", relative(&list.path, picture)?.replace('\'', "'\\''"));
    list.grow(|lines| {
        if !lines.contains(&file) {
            lines.extend([file, format!("duration {}", 1.0 / concat.fps)]);
        }
    })
}

/// The Cinema specification puts columns of files last; their names begin with FILE.
fn table_of(cinema: &Cinema, directory: &Path, has_error: bool) -> IndexFile {
    let names = cinema.parameters.iter().map(|(name, _)| *name);
    let files = ["FILE", "FILE_error"].into_iter().take(1 + usize::from(has_error));
    let head = ["step", "time"].into_iter().chain(names).chain(files).collect::<Vec<_>>().join(",");
    IndexFile { path: directory.join(&cinema.folder).join("data.csv"), head, what: "the Cinema database" }
}

fn add_to_table(cinema: &Cinema, directory: &Path, stamp: &Stamp, picture: &Path, error: Option<&Path>) -> Result<()> {
    let table = table_of(cinema, directory, error.is_some());
    // With a decimal point, so that all values of a column have one type.
    let when = [stamp.step.to_string(), format!("{:?}", stamp.time_s)];
    let cells = when.iter().chain(cinema.parameters.iter().map(|(_, value)| value));
    let key: String = cells.map(|cell| csv_cell(cell) + ",").collect();
    let files = [Some(picture), error].into_iter().flatten();
    let files = files.map(|file| Ok(csv_cell(&relative(&table.path, file)?)));
    let row = format!("{key}{}", files.collect::<Result<Vec<_>>>()?.join(","));
    table.grow(|rows| match rows.iter_mut().find(|row| row.starts_with(&key)) {
        Some(known) => *known = row,
        None => rows.push(row),
    })
}

/// Relative path from the folder of `from` to `to`, with slashes.
fn relative(from: &Path, to: &Path) -> Result<String> {
    let parts = |path: &Path| -> Result<Vec<String>> {
        let whole = absolute(path).map_err(|e| io_error(path, "cannot find the file", e))?;
        Ok(whole.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect())
    };
    let (mut from, to) = (parts(from)?, parts(to)?);
    from.pop();
    let same = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = from[same..].iter().map(|_| "..");
    Ok(up.chain(to[same..].iter().map(String::as_str)).collect::<Vec<_>>().join("/"))
}

impl IndexFile {
    fn failed(&self, e: io::Error) -> Error {
        io_error(&self.path, &format!("cannot write {}", self.what), e)
    }

    /// Fails if entries cannot be added to the file.
    pub(super) fn check(&self) -> Result<()> {
        self.read().map(drop)
    }

    /// The lines below the first one; `None` if the file does not exist.
    fn read(&self) -> Result<Option<Vec<String>>> {
        let Some(file) = existing_file(&self.path).map_err(|e| self.failed(e))? else { return Ok(None) };
        let text = io::read_to_string(file).map_err(|e| self.failed(e))?;
        let mut lines = text.lines().map(str::to_owned);
        match lines.next() {
            None => Ok(None),
            Some(first) if first == self.head => Ok(Some(lines.collect())),
            Some(_) => {
                let wish = "move it away, or give the scene another name for it";
                let (path, head) = (self.path.display(), &self.head);
                let context = format!("{path}: its first line is not {head:?}; {wish}");
                Err(Error::new(ErrorKind::Exists, context))
            }
        }
    }

    /// Changes the lines below the first one, and rewrites the file if they differ.
    fn grow(&self, change: impl FnOnce(&mut Vec<String>)) -> Result<()> {
        // The lock lets several processes add to one text, and is released when the folder is closed. Without it the
        // text of each process is still complete.
        let folder = File::open(made_folder(&self.path)?).ok();
        let _is_locked = folder.as_ref().is_some_and(|folder| folder.lock().is_ok());
        let known = self.read()?;
        let mut lines = known.clone().unwrap_or_default();
        change(&mut lines);
        if known.as_ref() == Some(&lines) {
            return Ok(());
        }
        let all = std::iter::once(&self.head).chain(&lines);
        let text: String = all.map(|line| format!("{line}\n")).collect();
        write_text(&self.path, self.what, &text)
    }
}

#[cfg(test)]
mod tests;
