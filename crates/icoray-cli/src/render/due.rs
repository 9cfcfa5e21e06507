//! What is drawn at which of a file's times, and the fields for it.

use super::subject::{Subject, Subjects};
use icoray::output::Stamp;
use icoray::{Field, Renderer, Result, Script, Statistic, View};
use icoray_netcdf::{ModelFile, OwnedField};
use std::collections::BTreeMap;
use std::time::Instant;

/// A script and the times that it is asked about.
pub struct Series<'a> {
    pub script: &'a Script,
    pub file: &'a ModelFile,
    pub times: Vec<usize>,
    /// Whether views are drawn when they are due; a time that is asked for by itself is drawn by all.
    pub is_scheduled: bool,
    /// Seconds from the file's first time to each, where they are known.
    pub seconds: Option<Vec<f64>>,
}

/// A field's name and the ends of its layers.
pub type Key = (String, [usize; 2]);

/// The fields of one time, each read once.
pub struct Read {
    pub fields: BTreeMap<Key, OwnedField>,
    pub seconds: f64,
}

impl Series<'_> {
    /// When record `time` was: its seconds are those since the file's first one.
    pub fn stamp(&self, time: usize) -> Stamp {
        let time_s = self.seconds.as_ref().map_or(0.0, |seconds| seconds[time]);
        Stamp { step: time as i64, time_s, date: self.file.times()[time].clone() }
    }

    /// The views of a time, but for their conditions.
    pub fn scheduled(&self, time: usize) -> Vec<&View> {
        if !self.is_scheduled {
            return self.script.views().iter().collect();
        }
        let before = time.checked_sub(1).map(|before| self.stamp(before));
        self.script.scheduled(&self.stamp(time), before.as_ref()).collect()
    }

    /// Whether it takes the fields to know if the view is drawn.
    pub fn is_uncertain(&self, view: &View) -> bool {
        self.is_scheduled && !view.conditions().is_empty()
    }

    /// How many pictures there are at most.
    pub fn pictures(&self) -> usize {
        self.times.iter().flat_map(|time| self.scheduled(*time)).map(View::pictures).sum()
    }

    /// How many of a time's pictures are not drawn where these views are.
    pub fn given_up(&self, time: usize, due: &[&View]) -> u64 {
        let scheduled: usize = self.scheduled(time).into_iter().map(View::pictures).sum();
        let drawn: usize = due.iter().map(|view| view.pictures()).sum();
        (scheduled - drawn) as u64
    }

    /// The views that are drawn at a time, with their fields.
    pub fn due(&self, time: usize, renderer: &Renderer, subjects: &Subjects) -> Result<(Vec<&View>, Read)> {
        let mut read = Read { fields: BTreeMap::new(), seconds: 0.0 };
        let mut due = Vec::new();
        for view in self.scheduled(time) {
            let mut statistic = |field: &str, statistic: Statistic| {
                let subject = subjects.of_condition(view, field)?;
                let field = read.field(self.file, &subject, time)?.field()?;
                Ok(renderer.run(|| statistic.of(&field)))
            };
            if !self.is_uncertain(view) || view.holds(&mut statistic)? {
                due.push(view);
            }
        }
        let mut needed = Vec::new();
        for scene in due.iter().flat_map(|view| view.scenes()) {
            needed.extend(subjects.of(&scene)?);
        }
        read.fields.retain(|known, _| needed.iter().any(|subject| subject.key() == *known));
        for subject in &needed {
            read.field(self.file, subject, time)?;
        }
        Ok((due, read))
    }
}

impl Read {
    fn field(&mut self, file: &ModelFile, subject: &Subject, time: usize) -> Result<&OwnedField> {
        let key = subject.key();
        if !self.fields.contains_key(&key) {
            let start = Instant::now();
            let field = file.read_layers(&subject.info.name, time, subject.range.clone())?;
            self.seconds += start.elapsed().as_secs_f64();
            self.fields.insert(key.clone(), field);
        }
        Ok(&self.fields[&key])
    }

    /// The fields, borrowed: the same ones for all views, so that what is made of them is made once.
    pub fn borrowed(&self) -> Result<BTreeMap<Key, Field<'_>>> {
        self.fields.iter().map(|(key, field)| Ok((key.clone(), field.field()?))).collect()
    }
}
