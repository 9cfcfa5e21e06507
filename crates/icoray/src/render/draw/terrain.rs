//! Positions of layers: at the same height everywhere, or at the heights of each column.

use crate::ranges::around;
use crate::ranks::Ranks;
use crate::render::context::FrameContext;
use crate::render::frame_cache::{self, NormalKey};
use icoray_grid::{Grid, Result, gradient, heights};
use icoray_kernel::general::{Levels, SurfaceHeight, SurfaceLayer};
use rayon::prelude::*;
use std::ops::Range;

/// Positions of layers, and their extent inwards and outwards.
pub(super) struct Terrain<'f> {
    pub levels: Levels<'f>,
    /// Least and greatest radius of the innermost layer.
    pub core_radius: [f64; 2],
    pub outer: f64,
    /// Geometry for gradients on native heights.
    pub key: Option<(frame_cache::SourceKey, f64)>,
}

impl<'f> Terrain<'f> {
    /// The terrain of the heights if the scene requests native ones. Collective.
    pub fn new(context: &FrameContext<'f>, ranks: &mut Ranks) -> Result<Self> {
        let FrameContext { renderer, scene, plan, grid, part, layers, heights: given, .. } = *context;
        let radius = &plan.radius;
        let [inner, outer] = [radius[0], radius[radius.len() - 1]];
        let Some(given) = given else {
            let levels = Levels::concentric(radius);
            return Ok(Terrain { levels, core_radius: [inner, inner], outer, key: None });
        };
        let (heights, mut core_radius) = ranks.collective_work(|| {
            renderer.run(|| {
                let heights = heights::Heights::new(&given.field(), layers, grid, radius.len(), scene.exaggeration)?;
                let lowest = (0..grid.cells() as u32).into_par_iter().map(|cell| heights.radius(cell, 0));
                // Cells that are not in this grid have the mean heights.
                let lowest = lowest.map(|radius| [radius; 2]).reduce(|| [inner; 2], around);
                Ok((heights, lowest))
            })
        })?;
        let mut bounds = heights.bounds();
        if part.is_some() {
            for range in [&mut core_radius, &mut bounds] {
                *range = ranks.reduce_values(*range, around)?;
            }
        }
        let stretch = scene.exaggeration / layers.planet_radius_m();
        let key = Some((given.source(grid), stretch));
        Ok(Terrain { levels: Levels::Native(heights), core_radius, outer: bounds[1], key })
    }
}

impl Terrain<'_> {
    /// The keys of the normals of the ground and of the layers of sheets, if these are not spheres and are lit.
    pub fn normal_keys(&self, surface_layers: &[SurfaceLayer], is_lit: bool) -> Vec<NormalKey> {
        let (Levels::Native(heights), Some(key), true) = (&self.levels, &self.key, is_lit) else {
            return Vec::new();
        };
        let mut layers = vec![0];
        layers.extend(surface_layers.iter().filter_map(|surface| match surface.place {
            SurfaceHeight::Layer(layer) if layer > 0 => Some(layer),
            _ => None,
        }));
        layers.sort_unstable();
        layers.dedup();
        layers.into_iter().map(|layer| NormalKey { heights: key.clone(), layer: [layer, heights.layers()] }).collect()
    }

    /// The normals of a layer over some cells; none of spheres.
    pub fn normals(&self, grid: &Grid, layer: usize, cells: Range<usize>, memory: Vec<[f32; 3]>) -> Vec<[f32; 3]> {
        match &self.levels {
            Levels::Native(heights) => gradient::native::normals(grid, heights, layer, cells, memory),
            Levels::Concentric(_) => Vec::new(),
        }
    }
}
