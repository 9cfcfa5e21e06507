//! Draws one scene of a dataset, with native heights that are read once for several.

use crate::heights::native::NativeHeights;
use crate::scene_fields::{Key, SceneField, SceneFields};
use icoray::{Error, ErrorKind, Field, Fields, Frame, Grid, Ranks, Rendered, Renderer, Result, Scene};
use std::collections::{BTreeMap, HashMap};
use std::time::Instant;

/// The inputs of drawing scenes.
#[derive(Clone, Copy)]
pub struct Drawing<'a> {
    /// The layers and fields of all scenes.
    pub scene_fields: &'a SceneFields<'a>,
    /// The grid of the dataset's mesh.
    pub grid: &'a Grid<'a>,
    /// The renderer.
    pub renderer: &'a Renderer,
}

impl Drawing<'_> {
    /// Renders a scene with the other ranks; the frame, with the dataset's descriptions of its fields, is at rank 0.
    ///
    /// # Errors
    /// As [`Renderer::render_over`], and [`Drawing::fields`].
    pub fn frame(
        &self,
        scene: &Scene,
        fields: &BTreeMap<Key, Field>,
        heights: &NativeHeightCache,
        ranks: &mut Ranks,
    ) -> Result<Option<Frame>> {
        let needed = self.fields(scene, fields, heights)?;
        let layers = self.scene_fields.layers(scene)?;
        let rendered = self.renderer.render_over(ranks, scene, self.grid, layers, needed)?;
        let Rendered::Here(mut frame) = rendered else { return Ok(None) };
        for SceneField { info, .. } in self.scene_fields.of(scene)? {
            frame.descriptions.insert(info.name.clone(), info.description.clone());
        }
        frame.notes.extend(self.scene_fields.notes(scene)?.into_iter().map(|note| ("note", note)));
        if let Some(native) = self.scene_fields.native(scene)? {
            frame.notes.push(("heights", native.description.clone()));
        }
        Ok(Some(frame))
    }

    /// The fields of a scene, with the heights of each column if it shows these.
    ///
    /// # Errors
    /// As [`SceneFields::of`] and [`NativeHeightCache::of`].
    pub fn fields<'f>(
        &self,
        scene: &Scene,
        fields: &BTreeMap<Key, Field<'f>>,
        heights: &'f NativeHeightCache,
    ) -> Result<Fields<'f>> {
        let scene_fields = self.scene_fields.of(scene)?;
        let needed = scene_fields.iter().filter_map(|s| Some((s.info.name.as_str(), *fields.get(&s.key())?)));
        let needed = Fields::new(needed);
        Ok(match heights.of(self.scene_fields, scene)? {
            Some(heights) => needed.with_heights(heights),
            None => needed,
        })
    }
}

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
    pub fn get_ready(&mut self, drawing: Drawing, scenes: impl Iterator<Item = Scene>, time: usize) -> Result<f64> {
        let Drawing { scene_fields, grid, renderer } = drawing;
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
