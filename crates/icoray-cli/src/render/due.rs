//! What is drawn at which of a file's times, and the fields for it.

use super::subject::{is_native, lead};
use crate::input::Wanted;
use icoray::output::Stamp;
use icoray::{Field, Fields, Grid, Renderer, Result, Scene, Script, Statistic, View};
use icoray_netcdf::{ModelFile, NativeHeights, OwnedField};
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

/// The fields of one time, each read once, and the heights of their columns where a view asks for them.
pub struct Read {
    fields: BTreeMap<String, OwnedField>,
    /// By the field whose layers they are of.
    heights: BTreeMap<String, NativeHeights>,
    pub seconds: f64,
}

/// The same, borrowed.
pub struct Inputs<'r> {
    fields: BTreeMap<&'r str, Field<'r>>,
    heights: BTreeMap<&'r str, Field<'r>>,
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
    pub fn due(
        &self,
        time: usize,
        renderer: &Renderer,
        grid: &Grid,
        wanted: &Wanted,
    ) -> Result<(Vec<&View>, Read)> {
        let mut read = Read { fields: BTreeMap::new(), heights: BTreeMap::new(), seconds: 0.0 };
        let mut due = Vec::new();
        for view in self.scheduled(time) {
            let mut statistic = |field: &str, statistic: Statistic| {
                let field = read.field(self.file, wanted, field, time)?.field()?;
                Ok(renderer.run(|| statistic.of(&field)))
            };
            if !self.is_uncertain(view) || view.holds(&mut statistic)? {
                due.push(view);
            }
        }
        let needed: Vec<String> = due.iter().flat_map(|view| view.model_fields()).collect();
        read.fields.retain(|name, _| needed.contains(name));
        for name in &needed {
            read.field(self.file, wanted, name, time)?;
        }
        for scene in due.iter().flat_map(|view| view.scenes()).filter(is_native) {
            read.heights(self.file, grid, &lead(&scene), time)?;
        }
        Ok((due, read))
    }
}

impl Read {
    fn field(&mut self, file: &ModelFile, wanted: &Wanted, name: &str, time: usize) -> Result<&OwnedField> {
        if !self.fields.contains_key(name) {
            let start = Instant::now();
            let field = wanted.read(file, file.field_info(name)?, time)?;
            self.seconds += start.elapsed().as_secs_f64();
            self.fields.insert(name.to_owned(), field);
        }
        Ok(&self.fields[name])
    }

    fn heights(&mut self, file: &ModelFile, grid: &Grid, name: &str, time: usize) -> Result<()> {
        if self.heights.contains_key(name) {
            return Ok(());
        }
        let start = Instant::now();
        // A file without them was refused before anything was read.
        self.heights.extend(file.native_heights(grid, name, time)?.map(|heights| (name.to_owned(), heights)));
        self.seconds += start.elapsed().as_secs_f64();
        Ok(())
    }

    /// The fields, borrowed: the same ones for all views, so that what is made of them is made once.
    pub fn borrowed(&self, file: &ModelFile, wanted: &Wanted) -> Result<Inputs<'_>> {
        let fields = self.fields.iter().map(|(name, field)| Ok((name.as_str(), field.field()?)));
        let heights = self.heights.iter().map(|(name, heights)| {
            let info = file.field_info(name)?;
            Ok((name.as_str(), heights.over(info, wanted.of(info)?)?))
        });
        Ok(Inputs { fields: fields.collect::<Result<_>>()?, heights: heights.collect::<Result<_>>()? })
    }
}

impl<'r> Inputs<'r> {
    /// What a scene is drawn of.
    pub fn of(&self, scene: &Scene) -> Fields<'r> {
        let needed = scene.model_fields().into_iter();
        let fields = Fields::new(needed.filter_map(|name| Some((name, *self.fields.get(name)?))));
        match self.heights.get(lead(scene).as_str()) {
            Some(heights) if is_native(scene) => fields.with_heights(*heights),
            _ => fields,
        }
    }
}
