//! Reads and draws the pictures of one time after the other.

use super::{Job, OutputQueue, agree, print_blocks};
use crate::failure::CommandResult;
use icoray::{Frame, Ranks, Result, Shot, View};
use icoray_dataset::view::Data;
use icoray_dataset::{FieldCache, NativeHeightCache, Series};
use icoray_live::Question;
use icoray_progress::Progress;
use std::io::Write;

/// The pictures of a run.
pub struct Pictures<'a> {
    series: &'a Series<'a>,
    job: Job<'a>,
    progress: &'a Progress,
    heights: NativeHeightCache,
    /// Number of pictures drawn.
    pub drawn: usize,
    count: usize,
}

/// The views that are drawn at a time, with their data.
pub struct Due<'a> {
    pub time: usize,
    views: Vec<&'a View>,
    pub read: FieldCache,
    /// Seconds of reading.
    seconds: f64,
}

impl<'a> Pictures<'a> {
    pub fn new(series: &'a Series<'a>, job: Job<'a>, progress: &'a Progress) -> Self {
        let count = series.pictures();
        progress.pictures(count);
        Pictures { series, job, progress, heights: NativeHeightCache::default(), drawn: 0, count }
    }

    /// Reads fields and heights of a time, and decides which views are drawn.
    pub fn read(&mut self, time: usize) -> Result<Due<'a>> {
        self.progress.stage(format!("reading time {time}"));
        let drawing = self.job.drawing;
        let (views, read) = self.series.views_of(drawing, time)?;
        let scenes = views.iter().flat_map(|view| view.scenes());
        let seconds = read.seconds + self.heights.get_ready(drawing, scenes, time)?;
        self.progress.fewer_pictures(self.series.skipped_pictures(time, &views));
        Ok(Due { time, views, read, seconds })
    }

    /// The picture of a view at a time that was read, if it is due.
    pub fn shot(&self, due: &Due, view: &str) -> Option<Shot> {
        let stamp = self.series.stamp(due.time);
        due.views.iter().filter(|its| its.name() == view).flat_map(|view| view.shots(&stamp)).next()
    }

    /// Draws a picture alone and writes nothing.
    pub fn frame(&self, due: &Due, shot: &Shot) -> Result<Option<Frame>> {
        let fields = due.read.borrowed()?;
        let stamp = self.series.stamp(due.time);
        let drawn = self.job.picture(shot, &stamp, &fields, &self.heights, due.seconds, &mut Ranks::alone())?;
        Ok(drawn.map(|(frame, _)| Frame { stamp, ..frame }))
    }

    /// Answers a question about a time that was read, from a picture.
    pub fn answer(&self, question: Question, due: &Due, shot: &Shot, shown: &Frame) {
        let fields = match due.read.borrowed() {
            Ok(fields) => fields,
            Err(error) => return question.refuse(error),
        };
        let (drawing, heights, time, stamp) = (self.job.drawing, &self.heights, due.time, self.series.stamp(due.time));
        let data = Data { drawing, fields: &fields, heights, time, stamp, is_steered: true };
        data.answer(question, &shot.scene, Some(shown));
    }

    /// Draws the pictures for which `wants` is true with the other ranks; writes them and prints their summaries at
    /// rank 0, which has the queue.
    pub fn draw(
        &mut self,
        due: &Due,
        wants: impl Fn(&Shot) -> bool,
        queue: &mut Option<OutputQueue>,
        out: &mut impl Write,
        ranks: &mut Ranks,
    ) -> CommandResult {
        let fields = ranks.collective(due.read.borrowed())?;
        let (stamp, mut read_s) = (self.series.stamp(due.time), due.seconds);
        for shot in due.views.iter().flat_map(|view| view.shots(&stamp)).filter(|shot| wants(shot)) {
            self.drawn += 1;
            self.progress.stage(format!("drawing picture {} of {}", self.drawn, self.count));
            let read_s = std::mem::take(&mut read_s);
            let picture = self.job.picture(&shot, &stamp, &fields, &self.heights, read_s, ranks)?;
            self.progress.drawn(self.drawn);
            let outcome = match (&mut *queue, picture) {
                (Some(queue), Some((frame, summary))) => {
                    let blocks = queue.submit(frame, shot.scene.output, stamp.clone(), summary);
                    print_blocks(blocks, self.progress, out)
                }
                _ => Ok(()),
            };
            agree(ranks, outcome)?;
        }
        Ok(())
    }
}
