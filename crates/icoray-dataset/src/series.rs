//! The views that are rendered at each time, and their fields.

use crate::dataset::Dataset;
use crate::drawing::Drawing;
use crate::field::OwnedField;
use crate::scene_fields::{Key, SceneField};
use icoray::output::Stamp;
use icoray::{Field, Reals, Result, Script, Statistic, View};
use std::collections::BTreeMap;
use std::time::Instant;

/// A script and the selected times.
pub struct Series<'a> {
    /// The views.
    pub script: &'a Script,
    /// The dates of all times of the dataset.
    pub dates: &'a [Option<String>],
    /// Numbers of the selected times.
    pub times: Vec<usize>,
    /// Whether the schedules of views apply; a time that is selected by itself is rendered by all views.
    pub is_scheduled: bool,
    /// Seconds from the dataset's first time to each, if known.
    pub seconds: Option<Vec<f64>>,
}

/// Fields of one time, each read once.
pub struct FieldCache {
    /// The fields, by name and layers.
    pub fields: BTreeMap<Key, OwnedField>,
    /// Seconds of reading.
    pub seconds: f64,
}

impl<'a> Series<'a> {
    /// Times of a dataset, with its dates.
    pub fn of(dataset: &'a Dataset, script: &'a Script, times: Vec<usize>, is_scheduled: bool) -> Self {
        Series { script, dates: dataset.times(), times, is_scheduled, seconds: dataset.seconds() }
    }

    /// The stamp of record `time`; its seconds count from the dataset's first record.
    pub fn stamp(&self, time: usize) -> Stamp {
        let time_s = self.seconds.as_ref().and_then(|seconds| seconds.get(time).copied()).unwrap_or(0.0);
        Stamp { step: time as i64, time_s, date: self.dates[time].clone() }
    }

    /// The views that are scheduled at a time, ignoring conditions.
    pub fn scheduled(&self, time: usize) -> Vec<&View> {
        if !self.is_scheduled {
            return self.script.views().iter().collect();
        }
        let before = time.checked_sub(1).map(|before| self.stamp(before));
        self.script.scheduled(&self.stamp(time), before.as_ref()).collect()
    }

    /// Whether the view has conditions, so that its fields decide if it is rendered.
    pub fn is_uncertain(&self, view: &View) -> bool {
        self.is_scheduled && !view.conditions().is_empty()
    }

    /// Maximum number of pictures.
    pub fn pictures(&self) -> usize {
        self.times.iter().flat_map(|time| self.scheduled(*time)).map(View::pictures).sum()
    }

    /// Number of scheduled pictures of a time that are skipped if only `views` are rendered.
    pub fn skipped_pictures(&self, time: usize, views: &[&View]) -> u64 {
        let scheduled: usize = self.scheduled(time).into_iter().map(View::pictures).sum();
        let drawn: usize = views.iter().map(|view| view.pictures()).sum();
        (scheduled - drawn) as u64
    }

    /// The views that are rendered at a time, with their fields.
    ///
    /// # Errors
    /// As [`SceneFields::of`](crate::SceneFields::of) and [`Dataset::read_layers`].
    pub fn views_of(&self, drawing: Drawing, time: usize) -> Result<(Vec<&View>, FieldCache)> {
        let Drawing { scene_fields, renderer, .. } = drawing;
        let dataset = scene_fields.dataset;
        let mut read = FieldCache { fields: BTreeMap::new(), seconds: 0.0 };
        let mut views = Vec::new();
        for view in self.scheduled(time) {
            let mut statistic = |field: &str, statistic: Statistic| {
                let scene_field = scene_fields.of_condition(view, field)?;
                let field = read.field(dataset, &scene_field, time)?.field()?;
                Ok(renderer.run(|| statistic.of(&field)))
            };
            if !self.is_uncertain(view) || view.holds(&mut statistic)? {
                views.push(view);
            }
        }
        let mut needed = Vec::new();
        for scene in views.iter().flat_map(|view| view.scenes()) {
            needed.extend(scene_fields.of(&scene)?);
        }
        read.fields.retain(|known, _| needed.iter().any(|scene_field| scene_field.key() == *known));
        for scene_field in &needed {
            read.field(dataset, scene_field, time)?;
        }
        Ok((views, read))
    }
}

impl FieldCache {
    fn field(&mut self, dataset: &Dataset, scene_field: &SceneField, time: usize) -> Result<&OwnedField> {
        let key = scene_field.key();
        if !self.fields.contains_key(&key) {
            let start = Instant::now();
            let field = dataset.read_layers(&scene_field.info.name, time, scene_field.range.clone())?;
            self.seconds += start.elapsed().as_secs_f64();
            self.fields.insert(key.clone(), field);
        }
        Ok(&self.fields[&key])
    }

    /// A field without any written value: all are missing.
    pub fn unwritten(&self) -> Option<&str> {
        let is_unwritten = |field: &OwnedField| {
            let fill = field.fill();
            match field.values() {
                Reals::F32(values) => values.iter().all(|value| value.is_nan() || f64::from(*value) == fill),
                Reals::F64(values) => values.iter().all(|value| value.is_nan() || *value == fill),
            }
        };
        let found = self.fields.iter().find(|(_, field)| is_unwritten(field));
        found.map(|((name, _), _)| name.as_str())
    }

    /// The fields, borrowed once for all views, so that derived data are computed once.
    ///
    /// # Errors
    /// As [`OwnedField::field`].
    pub fn borrowed(&self) -> Result<BTreeMap<Key, Field<'_>>> {
        self.fields.iter().map(|(key, field)| Ok((key.clone(), field.field()?))).collect()
    }
}
