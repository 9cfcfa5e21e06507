//! Where pictures go, from the option `--output`: a single named one is written at once, those in a directory on a
//! writer thread, so that the next one is rendered while one is encoded.

use icoray::output::{Existing, Output, Stamp, Writer, WriterOptions, write_error_map, write_picture_with};
use icoray::{Error, ErrorKind, Frame, Result};
use std::collections::VecDeque;
use std::path::{Path, PathBuf, absolute};
use std::time::Instant;

pub enum Target {
    /// This file.
    Picture(PathBuf),
    /// This directory; the scene's template names the pictures, and `report.csv` lies beside them.
    Directory(PathBuf),
}

impl Target {
    /// The target of `pictures` pictures.
    pub fn new(output: Option<&Path>, pictures: usize) -> Result<Self> {
        let Some(path) = output else {
            return Ok(Target::Directory(PathBuf::new()));
        };
        let bad = |what: String| Error::new(ErrorKind::Argument, format!("-o {}: {what}", path.display()));
        let ending = path.extension().and_then(|e| e.to_str());
        let is_directory = path.is_dir() || path.to_string_lossy().ends_with(['/', '\\']);
        match (ending, pictures) {
            _ if is_directory => Ok(Target::Directory(path.to_owned())),
            (Some("png" | "exr"), 1) => Ok(Target::Picture(path.to_owned())),
            (Some("png" | "exr"), _) => Err(bad(format!(
                "one name for {pictures} pictures; expected a directory, the scene's output.file names the pictures"
            ))),
            (None, _) => Ok(Target::Directory(path.to_owned())),
            _ => Err(bad("expected a name that ends in .png or .exr, or a directory".into())),
        }
    }

    /// The directory at `path`, for pictures whose number is not known; makes it.
    pub fn directory(path: &Path) -> Result<Self> {
        let is_picture = path.extension().is_some_and(|ending| ending == "png" || ending == "exr");
        if is_picture && !path.is_dir() {
            let what = "expected a directory, the scene's output.file names the pictures";
            return Err(Error::new(ErrorKind::Argument, format!("-o {}: {what}", path.display())));
        }
        Existing::Overwrite.prepare(&path.join("report.csv"))?;
        Ok(Target::Directory(path.to_owned()))
    }

    pub fn path(&self, names: &Output, stamp: &Stamp, field: &str) -> Result<PathBuf> {
        match self {
            Target::Directory(directory) => Ok(directory.join(names.names(stamp, field)?.file)),
            Target::Picture(path) => Ok(path.clone()),
        }
    }
}

/// Checks that the error map is a PNG and that there is one picture.
pub fn expect_error_map(path: &Path, pictures: usize) -> Result<()> {
    if path.extension().is_none_or(|e| e != "png") {
        return Err(bad_map(path, "expected a name that ends in .png"));
    }
    if pictures > 1 {
        let what = format!("one map for {pictures} pictures; expected output.error in the scene to name the maps");
        return Err(bad_map(path, &what));
    }
    Ok(())
}

/// Checks that the error map is another file than the picture.
pub fn expect_apart(map: &Path, picture: &Path) -> Result<()> {
    let same = map == picture || absolute(map).ok().is_some_and(|map| absolute(picture).is_ok_and(|p| p == map));
    if same { Err(bad_map(map, "names the picture too, expected another file")) } else { Ok(()) }
}

fn bad_map(path: &Path, what: &str) -> Error {
    Error::new(ErrorKind::Argument, format!("--error {}: {what}", path.display()))
}

pub struct PictureSummary {
    pub text: String,
    /// Details to print before and after the seconds of writing, if any.
    pub details: Option<[String; 2]>,
}

impl PictureSummary {
    fn with_write_time(self, write_s: f64) -> String {
        let details = self.details.map(|[before, after]| format!("\n{before}{write_s:.3}{after}"));
        self.text + &details.unwrap_or_default()
    }
}

/// Writes the pictures of a run and returns the summary of each that is on disk.
pub struct OutputQueue<'a> {
    destination: Destination<'a>,
    existing: Existing,
    /// Path of the error map, if given.
    error_map: Option<&'a Path>,
    /// Summaries of pictures in the writer's queue, in order.
    pending: VecDeque<PictureSummary>,
}

enum Destination<'a> {
    File(&'a Path),
    Directory(Writer),
}

impl<'a> OutputQueue<'a> {
    pub fn new(target: &'a Target, existing: Existing, error_map: Option<&'a Path>) -> Result<Self> {
        let destination = match target {
            Target::Picture(path) => Destination::File(path),
            Target::Directory(directory) => {
                Destination::Directory(Writer::new(WriterOptions { existing, ..WriterOptions::new(directory) })?)
            }
        };
        Ok(OutputQueue { destination, existing, error_map, pending: VecDeque::new() })
    }

    /// Gives frames to `next` once they are written to a directory.
    pub fn pass_on(&self, next: Box<dyn FnMut(Frame) + Send>) {
        if let Destination::Directory(writer) = &self.destination {
            writer.pass_on(Some(next));
        }
    }

    /// Checks that the files of a picture can be written.
    pub fn check(&self, names: &Output, stamp: &Stamp, field: &str) -> Result<()> {
        if let Some(map) = self.error_map {
            self.existing.prepare(map)?;
        }
        match &self.destination {
            Destination::File(path) => self.existing.prepare(path),
            Destination::Directory(writer) => {
                writer.check_folders(names, stamp, field)?;
                writer.check(names, stamp, field).map(drop)
            }
        }
    }

    /// Writes or enqueues the frame; returns the summaries of completed pictures, the first failure last.
    pub fn submit(
        &mut self,
        mut frame: Frame,
        names: Output,
        stamp: Stamp,
        summary: PictureSummary,
    ) -> Vec<Result<String>> {
        let start = Instant::now();
        frame.stamp = stamp.clone();
        if let Err(error) = self.write_error_map(&frame) {
            return vec![Err(error)];
        }
        match &self.destination {
            Destination::File(path) => {
                let written = write_picture_with(path, &frame, self.existing);
                vec![written.map(|()| summary.with_write_time(start.elapsed().as_secs_f64()))]
            }
            Destination::Directory(writer) => {
                self.pending.push_back(summary);
                writer.submit(frame, names, stamp);
                self.completed()
            }
        }
    }

    /// Waits for pending pictures; returns as [`Self::submit`].
    pub fn finish(mut self) -> Vec<Result<String>> {
        if let Destination::Directory(writer) = &self.destination {
            writer.wait();
        }
        self.completed()
    }

    fn write_error_map(&self, frame: &Frame) -> Result<()> {
        self.error_map.map_or(Ok(()), |path| write_error_map(path, frame, self.existing))
    }

    fn completed(&mut self) -> Vec<Result<String>> {
        let Destination::Directory(writer) = &self.destination else { return Vec::new() };
        // Outcomes are taken after each picture, so the writer keeps every one.
        let outcomes = writer.take_outcomes().kept;
        let summary = self.pending.drain(..outcomes.len()).collect::<Vec<_>>();
        let completed = outcomes.into_iter().zip(summary);
        completed.map(|(written, summary)| written.result.map(|_| summary.with_write_time(written.write_s))).collect()
    }
}
