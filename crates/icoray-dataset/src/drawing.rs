//! Draws one scene of a dataset.

use crate::native_height_cache::NativeHeightCache;
use crate::scene_fields::{Key, SceneField, SceneFields};
use icoray::{Field, Fields, Frame, Grid, Ranks, Rendered, Renderer, Result, Scene};
use std::collections::BTreeMap;

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
