//! Gets pictures onto the disk: one at once, several from a thread of their own, so that the next one is drawn while one
//! is encoded.

use super::target::Target;
use icoray::output::{
    Existing, Output, Stamp, Writer, WriterOptions, write_error_map_with, write_frame_with,
    write_picture_with,
};
use icoray::{Frame, Result};
use std::collections::VecDeque;
use std::path::Path;
use std::time::Instant;

/// What is said of a picture, but for the seconds of writing that stand between the two.
pub struct Said(pub String, pub String);

impl Said {
    fn whole(self, write_s: f64) -> String {
        let Said(before, after) = self;
        format!("{before}{write_s:.3}{after}")
    }
}

/// Writes the pictures of a run, and says each one's words when it is on the disk.
pub struct Press<'a> {
    target: &'a Target,
    names: &'a Output,
    existing: Existing,
    /// Where the map of errors goes, where the command says.
    error_map: Option<&'a Path>,
    /// For several pictures.
    writer: Option<Writer>,
    /// The words of pictures that are with the writer, in order.
    waiting: VecDeque<Said>,
}

impl<'a> Press<'a> {
    /// A press for `count` pictures.
    pub fn new(
        target: &'a Target,
        names: &'a Output,
        existing: Existing,
        error_map: Option<&'a Path>,
        count: usize,
    ) -> Result<Self> {
        let writer = match target {
            Target::Directory(directory) if count > 1 => {
                Some(Writer::new(WriterOptions { existing, ..WriterOptions::new(directory) })?)
            }
            _ => None,
        };
        Ok(Press { target, names, existing, error_map, writer, waiting: VecDeque::new() })
    }

    /// Refuses files that cannot be written, before the first ray.
    pub fn check(&self, stamp: &Stamp, field: &str) -> Result<()> {
        if let Some(map) = self.error_map {
            self.existing.check(map)?;
        }
        match (self.target, &self.writer) {
            (_, Some(writer)) => writer.check(self.names, stamp, field).map(drop),
            (Target::Picture(path), None) => self.existing.check(path),
            (Target::Directory(directory), None) => {
                let names = self.names.names(stamp, field)?;
                let mut names = [Some(names.file), names.error].into_iter().flatten();
                names.try_for_each(|name| self.existing.check(&directory.join(name)))
            }
        }
    }

    /// Writes the frame or has it written; returns the words of those that are done, and the first failure last.
    pub fn put(&mut self, mut frame: Frame, stamp: Stamp, said: Said) -> Vec<Result<String>> {
        if let Some(writer) = &self.writer {
            self.waiting.push_back(said);
            writer.submit(frame, self.names.clone(), stamp);
            return self.done();
        }
        let start = Instant::now();
        let written = self.write(&mut frame, stamp);
        vec![written.map(|()| said.whole(start.elapsed().as_secs_f64()))]
    }

    /// Waits for what is being written; as [`Self::put`].
    pub fn finish(mut self) -> Vec<Result<String>> {
        if let Some(writer) = &self.writer {
            writer.wait();
        }
        self.done()
    }

    fn write(&self, frame: &mut Frame, stamp: Stamp) -> Result<()> {
        match self.target {
            Target::Directory(directory) => {
                write_frame_with(directory, self.names, &stamp, frame, self.existing)?;
            }
            Target::Picture(path) => {
                frame.stamp = stamp;
                write_picture_with(path, frame, self.existing)?;
            }
        }
        self.error_map.map_or(Ok(()), |path| write_error_map_with(path, frame, self.existing))
    }

    fn done(&mut self) -> Vec<Result<String>> {
        let Some(writer) = &self.writer else { return Vec::new() };
        // They are taken after each picture, so that all are kept one by one.
        let outcomes = writer.take_outcomes().kept;
        let said = self.waiting.drain(..outcomes.len()).collect::<Vec<_>>();
        let done = outcomes.into_iter().zip(said);
        done.map(|(written, said)| written.result.map(|_| said.whole(written.write_s))).collect()
    }
}
