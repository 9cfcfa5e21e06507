//! A single volume on native heights, which packets of rays are traced through.

use crate::plan::budget::allowed_to_single;
use crate::render::context::FrameContext;
use crate::render::work::with_ends;
use icoray_grid::Field;
use icoray_grid::heights::Heights;
use icoray_grid::sample::AnySamples;
use icoray_kernel::column::Shell;
use icoray_kernel::general::{KernelScene, Levels};
use icoray_kernel::ray::{NativeLayers, NativeVolumeTracer, SingleVolumeTracer, Tracer};
use icoray_kernel::transfer::Spans;
use icoray_scene::{Lights, Method, Precision, Quality};

/// What packets of rays need of a frame beside the general kernel's scene.
pub(super) struct NativeVolume<'f> {
    heights: &'f Heights<'f>,
    /// Mean radii.
    shell: Shell<f32>,
    spans: Spans<f32>,
    samples: AnySamples<'f>,
}

impl<'f> NativeVolume<'f> {
    /// Of a scene that shows one volume of `field` on native heights in single precision, on a machine with vectors.
    pub fn new(context: &FrameContext, field: &Field<'f>, world: &'f KernelScene<'_>) -> Option<Self> {
        let FrameContext { renderer, scene, plan, part, .. } = *context;
        let is_single = scene.has_single_volume() && world.media.len() == 1 && part.is_none();
        let is_exact = scene.method == Method::Exact && scene.precision == Precision::F32;
        let Levels::Native(heights) = &world.levels else { return None };
        if !is_single || !is_exact || renderer.vectors().is_none() {
            return None;
        }
        let spans = Spans::new(&plan.knots);
        let samples = AnySamples::new(field, plan.falling, spans.range());
        Some(NativeVolume { heights, shell: Shell::new(&plan.radius), spans, samples })
    }

    /// A tracer at a quality, with the general kernel for what packets do not trace.
    pub fn tracer<'t>(
        &'t self,
        context: &'t FrameContext,
        world: &'t KernelScene<'_>,
        quality: &Quality,
        general: Box<dyn Tracer + 't>,
    ) -> Box<dyn Tracer + 't> {
        let FrameContext { renderer, scene, plan, grid, .. } = *context;
        let medium = &world.media[0];
        // Before there are tiles, each of which would ask for them.
        grid.half_edges();
        let volume = SingleVolumeTracer {
            grid,
            shell: &self.shell,
            spans: &self.spans,
            samples: self.samples,
            visible: &world.visible[0],
            outer: world.outer,
            gradients: world.sources[medium.extinction.source].gradients().values(),
            method: scene.method,
            budget: with_ends(renderer, allowed_to_single(scene, quality)),
            shading: plan.shading.filter(|_| quality.lights != Lights::Off),
            is_coarse: quality.lights == Lights::Coarse,
            level: renderer.vectors(),
            integrates: renderer.integrates,
            core: world.core,
        };
        let ground = world.normals.iter().find(|(layer, _)| *layer == 0);
        let layers = NativeLayers {
            heights: self.heights,
            core_radius: world.core_radius[0],
            normals: ground.map_or(&[], |(_, normals)| normals),
        };
        NativeVolumeTracer { volume, layers, general }.boxed()
    }
}
