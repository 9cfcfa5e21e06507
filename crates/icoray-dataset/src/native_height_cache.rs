//! Native heights of columns, for scenes that show them.

use crate::heights::native::NativeHeights;
use crate::scene_fields::SceneFields;
use icoray::{Error, ErrorKind, Field, Grid, Renderer, Result, Scene};
use std::collections::HashMap;
use std::time::Instant;

/// Heights that were read: once per time, or once if they do not change.
#[derive(Default)]
pub struct NativeHeightCache {
    /// The heights by description; with the time if they change.
    read: HashMap<String, (Option<usize>, NativeHeights)>,
}

impl NativeHeightCache {
    /// Reads the heights that `scenes` need at a time, if not cached; returns the seconds that this took.
    ///
    /// # Errors
    /// As [`SceneFields::native`] and [`Dataset::native_heights`](crate::Dataset::native_heights).
    pub fn get_ready(
        &mut self,
        scene_fields: &SceneFields,
        grid: &Grid,
        renderer: &Renderer,
        scenes: impl Iterator<Item = Scene>,
        time: usize,
    ) -> Result<f64> {
        let start = Instant::now();
        self.read.retain(|_, (of, _)| of.is_none_or(|of| of == time));
        for scene in scenes {
            let Some(info) = scene_fields.native(&scene)? else { continue };
            if self.read.contains_key(&info.description) {
                continue;
            }
            let name = &scene_fields.layering(&scene)?.height_field().name;
            let read = renderer.run(|| scene_fields.dataset.native_heights(grid, name, time))?;
            if let Some(read) = read {
                let of = info.time_dependent.then_some(time);
                self.read.insert(info.description.clone(), (of, read));
            }
        }
        Ok(start.elapsed().as_secs_f64())
    }

    /// The heights of a scene; `None` if it shows mean heights.
    ///
    /// # Errors
    /// As [`SceneFields::native`]; [`ErrorKind::Internal`] if they were not read.
    pub fn of(&self, scene_fields: &SceneFields, scene: &Scene) -> Result<Option<Field<'_>>> {
        let Some(info) = scene_fields.native(scene)? else { return Ok(None) };
        let Some((_, read)) = self.read.get(&info.description) else {
            let context = format!("{} was not read", info.description);
            return Err(Error::new(ErrorKind::Internal, context));
        };
        let layering = scene_fields.layering(scene)?;
        let height_field = layering.height_field();
        read.over(height_field, layering.range(height_field)?).map(Some)
    }
}
