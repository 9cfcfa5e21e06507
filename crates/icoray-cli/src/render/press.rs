//! Gets pictures onto the disk: one named by the command at once, those in a directory from a thread of their own, so that
//! the next one is drawn while one is encoded.

use super::target::Target;
use icoray::output::{
    Existing, Output, Stamp, Writer, WriterOptions, write_error_map_with, write_picture_with,
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
    place: Place<'a>,
    existing: Existing,
    /// Where the map of errors goes, where the command says.
    error_map: Option<&'a Path>,
    /// The words of pictures that are with the writer, in order.
    waiting: VecDeque<Said>,
}

/// Where pictures go.
enum Place<'a> {
    File(&'a Path),
    Directory(Writer),
}

impl<'a> Press<'a> {
    /// A press for a run's pictures.
    pub fn new(target: &'a Target, existing: Existing, error_map: Option<&'a Path>) -> Result<Self> {
        let place = match target {
            Target::Picture(path) => Place::File(path),
            Target::Directory(directory) => {
                Place::Directory(Writer::new(WriterOptions { existing, ..WriterOptions::new(directory) })?)
            }
        };
        Ok(Press { place, existing, error_map, waiting: VecDeque::new() })
    }

    /// Refuses files that cannot be written, before the first ray.
    pub fn check(&self, names: &Output, stamp: &Stamp, field: &str) -> Result<()> {
        if let Some(map) = self.error_map {
            self.existing.check(map)?;
        }
        match &self.place {
            Place::File(path) => self.existing.check(path),
            Place::Directory(writer) => writer.check(names, stamp, field).map(drop),
        }
    }

    /// Writes the frame or has it written; returns the words of those that are done, and the first failure last.
    pub fn put(&mut self, mut frame: Frame, names: Output, stamp: Stamp, said: Said) -> Vec<Result<String>> {
        let start = Instant::now();
        frame.stamp = stamp.clone();
        if let Err(error) = self.put_error_map(&frame) {
            return vec![Err(error)];
        }
        match &self.place {
            Place::File(path) => {
                let written = write_picture_with(path, &frame, self.existing);
                vec![written.map(|()| said.whole(start.elapsed().as_secs_f64()))]
            }
            Place::Directory(writer) => {
                self.waiting.push_back(said);
                writer.submit(frame, names, stamp);
                self.done()
            }
        }
    }

    /// Waits for what is being written; as [`Self::put`].
    pub fn finish(mut self) -> Vec<Result<String>> {
        if let Place::Directory(writer) = &self.place {
            writer.wait();
        }
        self.done()
    }

    fn put_error_map(&self, frame: &Frame) -> Result<()> {
        self.error_map.map_or(Ok(()), |path| write_error_map_with(path, frame, self.existing))
    }

    fn done(&mut self) -> Vec<Result<String>> {
        let Place::Directory(writer) = &self.place else { return Vec::new() };
        // They are taken after each picture, so that all are kept one by one.
        let outcomes = writer.take_outcomes().kept;
        let said = self.waiting.drain(..outcomes.len()).collect::<Vec<_>>();
        let done = outcomes.into_iter().zip(said);
        done.map(|(written, said)| written.result.map(|_| said.whole(written.write_s))).collect()
    }
}
