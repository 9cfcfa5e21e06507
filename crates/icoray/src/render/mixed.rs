//! Pictures of several fields, surfaces and cuts: what the general kernel shows, made of a scene.

use super::device::OnDevice;
use super::prepare::Known;
use super::spare;
use super::work::{Rays, Work, budget};
use super::{Derived, Rendered, Setting, facets, picture};
use crate::device::Job;
use crate::edges::Edges;
use crate::error::Result;
use crate::field::Field;
use crate::gradient::Gradients;
use crate::grid::Reals;
use crate::ground::Ground;
use crate::kernel::general::{Clips, Levels, Tracer, World};
use crate::kernel::ray::Casts;
use crate::kernel::sample::Samples;
use crate::layers::Layers;
use crate::quality::{Lights, Quality};
use crate::ranks::Ranks;
use crate::scene::Scene;
use stage::Stage;
use terrain::Terrain;

mod stage;
mod terrain;

/// Rays through all that a scene shows.
struct Mixed<'p, 'f> {
    setting: &'p Setting<'f>,
    world: &'p World<'f>,
}

impl Rays for Mixed<'_, '_> {
    fn get_ready(&self) {}

    fn caster(&self, quality: &Quality) -> Box<dyn Casts + '_> {
        let Setting { renderer, scene, plan, .. } = *self.setting;
        let shading = plan.shading.filter(|_| quality.lights != Lights::Off);
        Box::new(Tracer { world: self.world, shading, budget: budget(renderer, scene, quality) })
    }
}

/// Draws the picture of `setting`, whose scene shows the first field and `others`, by name. Collective.
pub(super) fn draw(
    setting: &Setting,
    ranks: &mut Ranks,
    layers: &Layers,
    others: &[(&str, Field)],
    heights: Option<&Field>,
) -> Result<Rendered> {
    let Setting { renderer, scene, plan, grid, part, field, .. } = *setting;
    let known = match field.samples() {
        Reals::F32(data) => Known::of(setting, ranks, &Samples::new(data, field, plan.falling, [0.0, 1.0])),
        Reals::F64(data) => Known::of(setting, ranks, &Samples::new(data, field, plan.falling, [0.0, 1.0])),
    }?;
    let terrain = Terrain::new(setting, ranks, layers, heights)?;
    let mut stage = Stage::new(setting, others);
    let (media, isosurfaces) = (stage.media(), stage.isosurfaces());
    let sheets = stage.sheets(layers);
    let lit: Vec<usize> = match known.is_lit() {
        true => {
            media.iter().map(|m| m.extinction.source).chain(isosurfaces.iter().map(|s| s.source)).collect()
        }
        false => Vec::new(),
    };
    compare(setting, ranks, layers, others, &terrain)?;
    let (sight_keys, visible) = renderer.run(|| stage.visible(&media, &isosurfaces, &sheets));
    let top = visible.iter().map(|visible| visible.top).max().unwrap_or(0);
    let (sources, light_keys) = stage.sources(ranks, &lit, &terrain)?;
    let derived: usize = sources.iter().map(|source| source.gradients().bytes()).sum();
    let normals = terrain.normals(setting, ranks, &sheets, known.is_lit())?;
    let (normal_keys, normals): (Vec<_>, Vec<_>) = normals.into_iter().unzip();
    let normals = normal_keys.iter().map(|key| key.layer[0]).zip(normals).collect();
    let ground = Ground::new(scene);
    let clip_radius = |height: f64| radius_of(height, scene, layers);
    let Terrain { levels, core_radius, outer, .. } = terrain;
    // Above the highest layer that is seen there is nothing to pass.
    let seen = match &levels {
        Levels::Concentric(_) if sheets.is_empty() && renderer.savings.layers => plan.radius[top.max(1)],
        _ => outer,
    };
    let world = World {
        grid,
        levels,
        sources,
        media,
        isosurfaces,
        sheets,
        clips: Clips::new(&scene.scenery.clips, clip_radius),
        visible,
        normals,
        core: scene.core,
        ground: ground.as_ref(),
        core_radius,
        outer: seen,
    };
    let none = Derived::of(Gradients::none);
    let job = Job::new(scene, plan, grid, field, &none, known.quality, part.is_some());
    let on_device = OnDevice::new(&setting.device, job);
    let rays = &Mixed { setting, world: &world };
    let has_surfaces = scene.core.is_some()
        || !world.sheets.is_empty()
        || !world.isosurfaces.is_empty()
        || !world.clips.is_empty();
    let is_round = matches!(world.levels, Levels::Concentric(_));
    let top = facets(setting, outer).filter(|_| is_round);
    let edges = Edges::new(scene, None, top, has_surfaces);
    let (radius, ground) = ([core_radius[0], outer], ground.as_ref());
    let work = Work { renderer, scene, plan, radius, ground, rays, edges };
    let mut rendered = picture::draw(setting, ranks, &known, &work, on_device)?;
    rendered.report_mut().derived_bytes += derived;
    for (key, (_, normals)) in normal_keys.into_iter().zip(world.normals) {
        renderer.spare.keep_normals(key, normals);
    }
    for (key, visible) in sight_keys.into_iter().zip(world.visible) {
        renderer.spare.keep_visible(key, visible);
    }
    for (key, source) in light_keys.into_iter().zip(world.sources) {
        if let Some(key) = key {
            renderer.spare.keep_gradients(key, source.into_gradients());
        }
    }
    Ok(rendered)
}

/// Ranks that have other fields beside the first, or other heights, would draw tiles that do not fit each other. Collective.
fn compare(
    setting: &Setting,
    ranks: &mut Ranks,
    layers: &Layers,
    others: &[(&str, Field)],
    terrain: &Terrain,
) -> Result<()> {
    let Setting { renderer, scene, grid, part, .. } = *setting;
    if ranks.is_alone() || part.is_some() {
        return Ok(());
    }
    let found = ranks.attempt(|| {
        let range = |field: &Field| {
            let source = spare::Source::new(grid, field);
            renderer.run(|| renderer.spare.range(&source, || field.range()))
        };
        Ok(others.iter().map(|(name, field)| (*name, range(field))).collect::<Vec<_>>())
    });
    let facts = |found: &Vec<(&str, spare::Range)>| {
        let told = |(name, (range, missing)): &(&str, spare::Range)| {
            ("has", format!("{name:?} of range and missing values {range:?} and {missing}"))
        };
        let metres = |radius: f64| (radius - 1.0) / scene.exaggeration * layers.planet_radius_m();
        let [low, high] = terrain.core_radius.map(metres);
        let heights = format!("{low} to {high} m, at most {} m", metres(terrain.outer));
        found.iter().map(told).chain([("has heights of the lowest and highest layers", heights)]).collect()
    };
    ranks.of_one_mind(found, facts).map(drop)
}

/// The radius at a height in metres, in planet radii, exaggerated.
fn radius_of(height_m: f64, scene: &Scene, layers: &Layers) -> f64 {
    1.0 + scene.exaggeration * height_m / layers.planet_radius_m()
}
