//! Pictures of several fields, surfaces and clips: builds the scene of the general kernel and draws it.

use super::context::FrameContext;
use super::device::OnDevice;
use super::frame_cache;
use super::lazy::Lazy;
use super::picture;
use super::prepare::FieldSummary;
use super::prepared_field::PreparedField;
use super::rendered::Rendered;
use super::work::{Rays, Work, budget};
use crate::device::{ClipRegion, Scenery};
use crate::edges::Edges;
use crate::ranks::Ranks;
use fearless_simd::Level;
use icoray_grid::Reals;
use icoray_grid::Result;
use icoray_grid::gradient::Gradients;
use icoray_grid::samples::Samples;
use icoray_kernel::general::{Clips, KernelScene, Levels, MultiVolumeTracer};
use icoray_kernel::ground::{Core, Ground};
use icoray_kernel::ray::{PacketScene, SceneTracer, Tracer};
use icoray_scene::{Lights, Method, Precision, Quality};
use scene_builder::SceneBuilder;
use terrain::Terrain;

mod scene_builder;
mod terrain;

/// Rays through all volumes and surfaces of a scene.
struct MultiVolume<'p, 'f> {
    context: &'p FrameContext<'f>,
    world: &'p KernelScene<'f>,
    /// The scene for packets of rays, and the vector instructions, if it can be traced in packets.
    packets: Option<(PacketScene<'f>, Level)>,
}

impl Rays for MultiVolume<'_, '_> {
    fn get_ready(&self) {
        if self.packets.is_some() {
            self.context.grid.half_edges();
        }
    }

    fn tracer(&self, quality: &Quality) -> Box<dyn Tracer + '_> {
        let FrameContext { renderer, scene, plan, .. } = *self.context;
        let shading = plan.shading.filter(|_| quality.lights != Lights::Off);
        let general = MultiVolumeTracer {
            scene: self.world,
            shading,
            budget: budget(renderer, scene, quality),
            method: scene.method,
            is_coarse: quality.lights == Lights::Coarse,
        };
        let Some((packets, level)) = &self.packets else { return general.boxed() };
        // Before there are tiles, each of which would ask for them.
        self.get_ready();
        SceneTracer { general, packets, level: *level, integrates: renderer.integrates }.boxed()
    }
}

/// Draws the picture of any scene. Collective.
pub(super) fn draw(context: &FrameContext, ranks: &mut Ranks) -> Result<Rendered> {
    let FrameContext { renderer, scene, plan, grid, part, .. } = *context;
    let is_plain = scene.is_plain();
    let field = &context.fields[0].field();
    let field_summary = match field.samples() {
        Reals::F32(data) => FieldSummary::of(context, ranks, &Samples::new(data, field, plan.falling, [0.0, 1.0])),
        Reals::F64(data) => FieldSummary::of(context, ranks, &Samples::new(data, field, plan.falling, [0.0, 1.0])),
    }?;
    let terrain = Terrain::new(context, ranks)?;
    let mut stage = SceneBuilder::new(context);
    let (media, isosurfaces) = (stage.media(), stage.isosurfaces());
    let surface_layers = stage.surface_layers();
    let lit: Vec<usize> = match field_summary.is_lit() {
        true => media.iter().map(|m| m.extinction.source).chain(isosurfaces.iter().map(|s| s.source)).collect(),
        false => Vec::new(),
    };
    compare(context, ranks, &terrain)?;
    let (occupancy_keys, visible) = renderer.run(|| stage.visible(&media, &isosurfaces, &surface_layers));
    let top = visible.iter().map(|visible| visible.top).max().unwrap_or(0);
    let (sources, light_keys) = stage.sources(ranks, &lit, &terrain)?;
    let derived: usize = sources.iter().map(|source| source.gradients().bytes()).sum();
    let normals = terrain.normals(context, ranks, &surface_layers, field_summary.is_lit())?;
    let (normal_keys, normals): (Vec<_>, Vec<_>) = normals.into_iter().unzip();
    let normals = normal_keys.iter().map(|key| key.layer[0]).zip(normals).collect();
    let ground = Ground::new(scene);
    let Terrain { levels, core_radius, outer, .. } = terrain;
    // Everything above the highest visible layer is invisible.
    let seen = match &levels {
        Levels::Concentric(_) if surface_layers.is_empty() && renderer.savings.layers => plan.radius[top.max(1)],
        _ => outer,
    };
    let world = KernelScene {
        grid,
        levels,
        sources,
        media,
        isosurfaces,
        surface_layers,
        clips: Clips::new(&scene.scenery.clips, |height| context.radius_of(height)),
        visible,
        normals,
        core: Core::new(scene.core, ground.as_ref()),
        core_radius,
        // A facet touches that sphere at its highest vertex, which rays meet only if they start above it.
        outer: seen * (1.0 + 1e-9),
    };
    let none = Lazy::of(|| Gradients::none().into());
    let mut on_device = OnDevice::new(context, field, &none, field_summary.quality);
    if !is_plain || part.is_some() {
        on_device = on_device.with_scenery(|| {
            let clips =
                scene.scenery.clips.iter().map(|clip| ClipRegion::new(clip, |height| context.radius_of(height)));
            let tables = ((grid.cells(), plan.radius.len()), plan.knots.as_slice());
            let range = |source| context.range(source).0;
            renderer.run(|| Scenery::new(&world, clips.collect(), tables, field_summary.is_lit(), range))
        });
    }
    let is_exact = scene.method == Method::Exact && scene.precision == Precision::F32;
    let level = renderer.vectors().filter(|_| is_exact);
    let packets = level.and_then(|level| Some((PacketScene::new(&world, &plan.radius)?, level)));
    let rays = &MultiVolume { context, world: &world, packets };
    let has_surfaces = scene.core.is_some()
        || !world.surface_layers.is_empty()
        || !world.isosurfaces.is_empty()
        || !world.clips.is_empty();
    let is_round = matches!(world.levels, Levels::Concentric(_));
    let top = context.facets(outer).filter(|_| is_round);
    let core = context.facets(core_radius[0]).filter(|_| is_plain && scene.core.is_some());
    let edges = Edges::new(scene, core, top, has_surfaces && !is_plain);
    let (radius, ground) = ([core_radius[0], outer], ground.as_ref());
    let work = Work { context, radius, ground, rays, edges };
    let mut rendered = picture::draw(&work, ranks, &field_summary, on_device)?;
    rendered.report_mut().bytes_derived += derived;
    for (key, (_, normals)) in normal_keys.into_iter().zip(world.normals) {
        renderer.frame_cache.normals.store(key, normals);
    }
    for (key, visible) in occupancy_keys.into_iter().zip(world.visible) {
        renderer.frame_cache.visible.store(key, visible);
    }
    for (key, source) in light_keys.into_iter().zip(world.sources) {
        if let Some(key) = key {
            renderer.frame_cache.gradients.store(key, source.into_gradients());
        }
    }
    Ok(rendered)
}

/// Checks that all ranks have the same further fields and heights: otherwise their tiles would not fit each other.
/// Collective.
fn compare(context: &FrameContext, ranks: &mut Ranks, terrain: &Terrain) -> Result<()> {
    let FrameContext { renderer, scene, has_whole, layers, heights, fields, .. } = *context;
    if ranks.is_alone() || !has_whole {
        return Ok(());
    }
    let found = ranks.attempt(|| {
        let range = |number: usize| (fields[number].name(), renderer.run(|| context.range(number)));
        Ok((1..fields.len()).map(range).collect::<Vec<_>>())
    });
    let facts = |found: &Vec<(&str, frame_cache::Range)>| {
        let told = |(name, (range, missing)): &(&str, frame_cache::Range)| {
            ("has", format!("{name:?} of range and missing values {range:?} and {missing}"))
        };
        let metres = |radius: f64| (radius - 1.0) / scene.exaggeration * layers.planet_radius_m();
        let [low, high] = terrain.core_radius.map(metres);
        let extent = format!("{low} to {high} m, at most {} m", metres(terrain.outer));
        let extent = ("has heights of the lowest and highest layers", extent);
        found.iter().map(told).chain([extent]).chain(heights.map(PreparedField::values_fact)).collect()
    };
    ranks.agree_all(found, facts).map(drop)
}
