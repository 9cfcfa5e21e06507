//! A frame's scene, plan, grid and prepared fields.

use super::frame_cache::FrameCache;
use super::prepared_field::PreparedField;
use super::renderer::{DeviceChoice, Renderer};
use crate::plan::Plan;
use crate::ranges::RangeAndMissing;
use crate::ranks::{NodeRanks, Part};
use icoray_grid::{Grid, Layers};
use icoray_kernel::Deviations;
use icoray_output::Sharing;
use icoray_scene::Scene;
use std::time::Instant;

/// A frame's scene, plan, grid and fields, with the renderer and the device that draw it.
pub(super) struct FrameContext<'f> {
    pub renderer: &'f Renderer,
    pub device: DeviceChoice,
    /// The scene that was asked for.
    pub asked: &'f Scene,
    /// The scene with the ranges of all colour maps.
    pub scene: &'f Scene,
    pub plan: &'f Plan,
    pub grid: &'f Grid<'f>,
    /// This rank's part of the grid; `None` is the whole grid.
    pub part: Option<&'f Part<'f>>,
    /// The ranks of this node, if they read the same fields in its memory.
    pub mates: Option<&'f NodeRanks>,
    /// Whether every rank has the whole grid and all values, even if it draws only a part.
    pub has_whole: bool,
    /// The distribution of the picture over ranks.
    pub sharing: Sharing,
    pub layers: &'f Layers,
    /// Heights of each column's layers, if the scene has native ones.
    pub heights: Option<&'f PreparedField<'f>>,
    /// The fields that the scene shows, at least one.
    pub fields: &'f [PreparedField<'f>],
    /// How far the model's field is from these, if the grid is a level of the model's.
    pub deviations: Option<&'f Deviations>,
    /// What pictures on this grid reuse.
    pub cache: &'f FrameCache,
    /// Bytes of averages, of moved layers and of derived fields.
    pub bytes_derived: usize,
    pub start: Instant,
}

impl FrameContext<'_> {
    /// Least and greatest value of field `number` on this rank, and the number of missing values.
    pub fn range(&self, number: usize) -> RangeAndMissing {
        let field = &self.fields[number];
        self.cache.range(&field.source(self.grid), || field.field().range())
    }

    /// Whether the kernel's scene, with its gradients, is built in any case: for a single volume of a whole grid
    /// between concentric layers a device needs none.
    pub fn needs_scene(&self) -> bool {
        self.device.is_err() || self.part.is_some() || self.has_scenery()
    }

    /// Whether there is more than one volume between concentric layers.
    pub fn has_scenery(&self) -> bool {
        self.heights.is_some() || !self.scene.has_single_volume()
    }

    /// Least radius of the facets of a layer that is a unit sphere.
    pub fn lowest_facet(&self) -> f64 {
        match self.part {
            Some(part) => part.region().lowest_facet(),
            None => self.renderer.run(|| self.grid.lowest_facet()),
        }
    }

    /// The number of a field; `None` if the scene does not show it.
    pub fn number_of(&self, name: &str) -> Option<usize> {
        self.fields.iter().position(|field| field.name() == name)
    }

    /// The height in metres at a radius in planet radii, without exaggeration.
    pub fn height_m(&self, radius: f64) -> f64 {
        (radius - 1.0) / self.scene.exaggeration * self.layers.planet_radius_m()
    }

    /// The radius at a height in metres, in planet radii, exaggerated.
    pub fn radius_of(&self, height_m: f64) -> f64 {
        1.0 + self.scene.exaggeration * height_m / self.layers.planet_radius_m()
    }
}
