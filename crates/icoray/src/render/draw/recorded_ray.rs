//! A ray that is recorded for a probe, and the columns that it passes.

use super::scene_builder::{SceneBuilder, seen_volumes, surface_levels};
use super::terrain::Terrain;
use crate::compose::first_inside_gap;
use crate::ranks::{Part, Ranks};
use crate::render::context::FrameContext;
use crate::render::prepare::FieldSummary;
use crate::render::work::{budget, requested_quality};
use glam::DVec3;
use icoray_grid::Result;
use icoray_grid::array::MapInline;
use icoray_kernel::general::{KernelScene, Passage, PassageKind, RaySettings};
use icoray_kernel::passages;
use icoray_kernel::plane::RayLine;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A part of a scene; numbers count from 0 in the scene's order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ScenePart {
    /// The core.
    Core,
    /// A volume.
    Volume(usize),
    /// An isosurface.
    Isosurface(usize),
    /// A surface on a layer or at a height.
    Surface(usize),
    /// Lines on a layer or at a height.
    Lines,
}

impl fmt::Display for ScenePart {
    /// Names the part, counted from 1.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ScenePart::Core => write!(f, "core"),
            ScenePart::Lines => write!(f, "lines"),
            ScenePart::Volume(number) => write!(f, "volume {}", number + 1),
            ScenePart::Isosurface(number) => write!(f, "isosurface {}", number + 1),
            ScenePart::Surface(number) => write!(f, "surface {}", number + 1),
        }
    }
}

/// A part of a ray: a stretch of a frustum, a surface, or the core.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::render) struct RayPart {
    /// The rank that recorded it.
    pub rank: usize,
    /// The cells of the triangle over it, as that rank numbers them; `None` over a hole of the mesh.
    pub cells: Option<[u32; 3]>,
    /// Distances from the eye at which it begins and ends, planet radii.
    pub t: [f64; 2],
    /// Height of its middle, planet radii: the radius of a layer on the layer's facets.
    pub rho: f64,
    /// The fraction of the light from behind that it absorbs.
    pub alpha: f64,
    /// The parts of the scene there, each with its share of that fraction.
    pub shares: Vec<(ScenePart, f64)>,
    /// The value of each of the frame's fields; NaN where it is missing.
    pub values: Vec<f64>,
}

impl RayPart {
    /// The value of a field; `None` where it is missing.
    pub fn value(&self, field: usize) -> Option<f64> {
        Some(self.values[field]).filter(|value| value.is_finite())
    }
}

/// A scene in which rays are recorded: unlit, in double precision, with all layers.
pub(in crate::render) struct ProbedScene<'p, 'f> {
    context: &'p FrameContext<'f>,
    scene: KernelScene<'f>,
}

impl<'p, 'f> ProbedScene<'p, 'f> {
    /// Builds the scene of a frame. Collective.
    pub fn new(context: &'p FrameContext<'f>, ranks: &mut Ranks) -> Result<Self> {
        let summary = FieldSummary::of(context, ranks)?;
        let terrain = Terrain::new(context, ranks)?;
        let built = ranks.attempt(|| {
            let builder = SceneBuilder::new(context, &terrain, &summary).with_all_visible();
            context.renderer.run(|| builder.build(None))
        });
        Ok(ProbedScene { context, scene: ranks.collective(built)?.scene })
    }

    /// The parts of the ray from `eye` along the unit vector `dir`, in order. Collective.
    pub fn record(&self, ranks: &mut Ranks, eye: DVec3, dir: DVec3) -> Result<Vec<RayPart>> {
        let FrameContext { renderer, scene, part, .. } = *self.context;
        let (rank, along) = (ranks.rank(), eye.dot(dir));
        let recorded = ranks.share_work(|| {
            let rays = RaySettings {
                scene: &self.scene,
                shading: None,
                budget: budget(renderer, scene, &requested_quality(scene)),
                method: scene.method,
                is_coarse: false,
            };
            // The ranks of a node have the same part of the grid, and all ranks without a part have the whole grid.
            let (passed, fragments) = match part.map_or(rank, |part| part.node().place()) {
                0 => passages(&rays, part.map(Part::region), eye, dir),
                1.. => (Vec::new(), Vec::new()),
            };
            let parts: Vec<RayPart> = passed.into_iter().map(|passage| self.ray_part(passage, rank, along)).collect();
            let runs: Vec<[f64; 2]> = fragments.iter().map(|fragment| fragment.t).collect();
            Ok((parts, runs))
        });
        let (parts, runs): (Vec<_>, Vec<_>) = recorded?.into_iter().unzip();
        let mut parts = parts.concat();
        parts.sort_by(|a, b| a.t[0].total_cmp(&b.t[0]));
        if part.is_some()
            && let Some(t) = self.core_below_hole(eye, dir, runs.concat())
        {
            parts.retain(|part| part.t[0] < t);
            let values = vec![f64::NAN; self.scene.sources.len()];
            let (rho, shares) = (self.scene.core_radius[0], vec![(ScenePart::Core, 1.0)]);
            parts.push(RayPart { rank: 0, cells: None, t: [t; 2], rho, alpha: 1.0, shares, values });
        }
        Ok(parts)
    }

    /// Distance from the eye at which the ray meets the core between the runs of columns of all ranks: no rank owns the
    /// triangles over holes of the mesh.
    fn core_below_hole(&self, eye: DVec3, dir: DVec3, mut runs: Vec<[f64; 2]>) -> Option<f64> {
        self.scene.core?;
        let line = RayLine::new(eye, dir, self.scene.outer)?;
        runs.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut reached = line.start;
        for [from, to] in runs.into_iter().chain([[line.end; 2]]) {
            if let Some(t) = first_inside_gap(&line, self.scene.core_radius[0], [reached, from]) {
                return Some(t - eye.dot(dir));
            }
            reached = reached.max(to);
        }
        None
    }

    fn ray_part(&self, passage: Passage, rank: usize, along: f64) -> RayPart {
        let Passage { kind, cells, t, rho, alpha, values } = passage;
        let shares = match kind {
            PassageKind::Core => vec![(ScenePart::Core, 1.0)],
            PassageKind::Isosurface(number) => vec![(ScenePart::Isosurface(number), 1.0)],
            PassageKind::Frustum(shares) => {
                let volumes = seen_volumes(self.context.scene).map(|(number, _)| ScenePart::Volume(number));
                volumes.zip(shares).collect()
            }
            PassageKind::SurfaceLayer(number, painted) => self.surface_shares(number, painted, alpha),
        };
        RayPart { rank, cells, t: t.map_inline(|t| t - along), rho, alpha, shares, values }
    }

    /// The shares of lines and surfaces on a layer in what all of them absorb, with the bits of those that are painted.
    fn surface_shares(&self, layer: usize, painted: u32, alpha: f64) -> Vec<(ScenePart, f64)> {
        let scenery = &self.context.scene.scenery;
        let level = surface_levels(scenery)[layer];
        let numbers = scenery.surfaces.iter().enumerate().filter(|(_, surface)| surface.at == level);
        let is_painted = |material: usize| painted & 1u32.rotate_left(material as u32) != 0;
        let opacities: Vec<(usize, f64)> = numbers
            .enumerate()
            .filter(|(material, _)| is_painted(*material))
            .map(|(_, (number, surface))| (number, surface.opacity))
            .collect();
        // Lines are in front of the surfaces.
        let through = opacities.iter().fold(1.0, |through, (_, opacity)| through * (1.0 - opacity));
        let lines = if through > 0.0 { (1.0 - (1.0 - alpha) / through).max(0.0) } else { 0.0 };
        let mut shares = vec![(ScenePart::Lines, lines / alpha)];
        let mut left = (1.0 - lines) / alpha;
        for (number, opacity) in opacities {
            shares.push((ScenePart::Surface(number), left * opacity));
            left *= 1.0 - opacity;
        }
        shares.retain(|(_, share)| *share > 0.0);
        shares
    }

    /// Radii of the layers over a cell, in planet radii, and the values of a field there.
    pub fn column(&self, cell: u32, field: usize) -> Vec<[f64; 2]> {
        let KernelScene { levels, sources, .. } = &self.scene;
        let radius = |layer: usize| 1.0 / levels.inverse([cell; 3], layer)[0];
        (0..levels.count()).map(|layer| [radius(layer), sources[field].at([cell; 3], layer)[0]]).collect()
    }
}
