//! Draws the picture of a scene: builds the kernel's scene, and its rays.

use super::Rendered;
use super::context::FrameContext;
use super::device::OnDevice;
use super::lazy::Lazy;
use super::levels::LevelRays;
use super::picture;
use super::prepare::FieldSummary;
use super::prepared_field::PreparedField;
use super::work::{Painter, Work, budget};
use crate::edges::Edges;
use crate::ranges::RangeAndMissing;
use crate::ranks::Ranks;
use gradients::NodeGradients;
use icoray_grid::Result;
use icoray_kernel::general::RaySettings;
use icoray_kernel::ground::Ground;
use icoray_kernel::shade::Shading;
use icoray_kernel::{SceneTracer, Tracer};
use icoray_output::{Colors, FrameReport};
use icoray_scene::{Lights, Quality};
use node_work::NodeWork;
use occupancy::NodeOccupancy;
pub(super) use scene_builder::BuiltScene;
use scene_builder::SceneBuilder;
use std::iter;
use terrain::Terrain;

mod gradients;
mod node_work;
mod occupancy;
mod recorded_ray;
mod scene_builder;
mod terrain;

pub use recorded_ray::ScenePart;
pub(super) use recorded_ray::{ProbedScene, RayPart};

/// Rays through the scene.
impl<'p, 'f> Work<'p, 'f> {
    pub(super) fn tracer(&self, quality: &Quality) -> Box<dyn Tracer + '_> {
        let packets = self.built.get().packets.as_ref().map(|(level, packets)| (*level, packets));
        SceneTracer { rays: self.settings(quality), packets, integrates: self.context.renderer.integrates }.boxed()
    }

    /// The light of lines and grounds that rays of a device meet, at a quality.
    pub(super) fn painter(&self, quality: &Quality) -> Box<Painter<'_>> {
        let settings = self.settings(quality);
        Box::new(move |eye, dir, place| settings.painted(eye, dir, place))
    }

    fn settings(&self, quality: &Quality) -> RaySettings<'p, 'f> {
        let FrameContext { renderer, scene, plan, .. } = *self.context;
        let built = &self.built.get().scene;
        let is_packed = built.sources.iter().any(|source| source.gradients.values().words().is_some());
        let shading = plan.shading.filter(|_| quality.lights != Lights::Off);
        RaySettings {
            scene: built,
            shading: shading.map(|shading| Shading { is_packed, ..shading }),
            budget: budget(renderer, scene, quality),
            method: scene.method,
            is_coarse: quality.lights == Lights::Coarse,
        }
    }
}

/// Draws the picture of a scene. Collective.
pub(super) fn draw(context: &FrameContext, ranks: &mut Ranks) -> Result<Rendered> {
    let FrameContext { renderer, scene, plan, .. } = *context;
    let field = &context.fields[0].field();
    let summary = FieldSummary::of(context, ranks)?;
    let is_alone = ranks.is_alone();
    let levels = renderer.run(|| renderer.frame_cache.levels.levels(context, is_alone));
    let inputs: Vec<_> = levels.iter().map(|level| level.inputs(plan, scene.field())).collect();
    let on_levels: Vec<_> = levels.iter().zip(&inputs).map(|(level, inputs)| level.context(context, inputs)).collect();
    // The picture's own grid comes first.
    let contexts: Vec<_> = iter::once(context).chain(&on_levels).collect();
    let terrains = contexts.iter().map(|context| Terrain::new(context, ranks)).collect::<Result<Vec<_>>>()?;
    compare(context, ranks, &terrains[0])?;
    let (ground, summary_of) = (Ground::new(scene), &summary);
    let ground = ground.as_ref();
    let (mut occupancy, mut gradients) = (None, None);
    let builder = |(context, terrain)| SceneBuilder::new(context, terrain, summary_of);
    let mut builders: Vec<_> = contexts.iter().copied().zip(&terrains).map(builder).collect();
    let node = NodeWork::agree(&builders[0], ranks)?;
    if let Some(node) = node {
        occupancy = NodeOccupancy::find(&builders[0], node, ranks)?;
        builders[0].node_occupancy = occupancy.as_ref();
        gradients = NodeGradients::allocate(&mut builders[0], node, ranks)?;
    }
    let mut scenes: Vec<_> = builders.iter().map(|of| Lazy::of(move || of.clone().build(ground))).collect();
    complete(&builders[0], ranks, &mut scenes[0], node.zip(gradients.as_mut()))?;
    let on_device = OnDevice::new(context, field, &scenes[0], &summary, ground.is_some());
    let radius = [terrains[0].core_radius[0], terrains[0].outer];
    let work = |(context, built)| Work { context, built, radius, ground, edges: Edges::default(), levels: &[] };
    let works: Vec<_> = on_levels.iter().zip(&scenes[1..]).map(work).collect();
    let level_rays: Vec<_> = works.iter().map(|work| work as &dyn LevelRays).collect();
    let edges = Edges::new(scene, radius, || context.lowest_facet());
    let work = Work { edges, levels: &level_rays, ..work((context, &scenes[0])) };
    let mut rendered = picture::draw(&work, ranks, &summary, on_device)?;
    for (context, built) in contexts.into_iter().zip(scenes) {
        let built = built.into_known();
        let bytes = built.as_ref().map_or(0, |built| built.bytes(node.is_some_and(|node| node.is_reporter())));
        rendered.report_mut().bytes_derived += context.bytes_derived + bytes;
        built.into_iter().for_each(|built| built.keep(context.cache));
    }
    drop(builders);
    gradients.into_iter().for_each(|gradients| gradients.leave(ranks));
    occupancy.into_iter().for_each(|occupancy| occupancy.leave(ranks));
    fill_report(context, ranks, rendered.report_mut());
    Ok(rendered)
}

/// Adds what a frame knows of its fields, colours, threads and ranks to its report.
fn fill_report(context: &FrameContext, ranks: &Ranks, report: &mut FrameReport) {
    let FrameContext { renderer, asked, scene, fields, has_whole, sharing, .. } = *context;
    report.threads = renderer.threads();
    report.ranks.count = ranks.size();
    report.colors = Colors::of(asked, scene);
    report.ranks.sharing = (!ranks.is_alone()).then_some(sharing);
    let has_first = report.value_range.is_some();
    let is_empty = |number: usize, field: &PreparedField| match number {
        0 => !has_first,
        _ => has_whole && !field.field().has_values(),
    };
    let empty = fields.iter().enumerate().filter(|(number, field)| is_empty(*number, field));
    report.without_values = empty.map(|(_, field)| field.name().to_owned()).collect();
    let range = |(number, field): (usize, &PreparedField)| {
        let range = match number {
            0 => report.value_range,
            _ if has_whole => context.range(number).0,
            _ => None,
        };
        Some((field.name().to_owned(), range?))
    };
    report.value_ranges = fields.iter().enumerate().filter_map(range).collect();
    report.off_values = scene.off_values(&report.value_ranges);
}

/// Builds the kernel's scene where it is needed in any case, with the gradients and normals that the node's ranks compute
/// together, and receives those of halo cells from other ranks. Collective.
fn complete<'n>(
    builder: &SceneBuilder,
    ranks: &mut Ranks,
    built: &mut Lazy<BuiltScene<'n>>,
    shared: Option<(NodeWork, &'n mut NodeGradients)>,
) -> Result<()> {
    let (context, part) = (builder.context, builder.context.part.filter(|_| builder.summary.is_lit()));
    ranks.collective_work(|| match context.needs_scene() {
        true => context.renderer.run(|| built.try_get().map(drop)),
        false => Ok(()),
    })?;
    if let Some((node, shared)) = shared {
        shared.compute(builder, node, ranks, built.get())?;
        let shared: &NodeGradients = shared;
        return ranks.collective_work(|| shared.lend(built.get_mut()));
    }
    part.map_or(Ok(()), |part| built.get_mut().fill_halos(ranks, part))
}

/// Checks that all ranks have the same further fields and heights: otherwise their tiles would not fit each other.
/// Collective.
fn compare(context: &FrameContext, ranks: &mut Ranks, terrain: &Terrain) -> Result<()> {
    let FrameContext { renderer, has_whole, heights, fields, .. } = *context;
    if ranks.is_alone() || !has_whole {
        return Ok(());
    }
    let found = ranks.attempt(|| {
        let range = |number: usize| (fields[number].name(), renderer.run(|| context.range(number)));
        Ok((1..fields.len()).map(range).collect::<Vec<_>>())
    });
    let facts = |found: &Vec<(&str, RangeAndMissing)>| {
        let range_fact = |(name, (range, missing)): &(&str, RangeAndMissing)| {
            ("has", format!("{name:?} of range and missing values {range:?} and {missing}"))
        };
        let [low, high] = terrain.core_radius.map(|radius| context.height_m(radius));
        let extent = format!("{low} to {high} m, at most {} m", context.height_m(terrain.outer));
        let extent = ("has heights of the lowest and highest layers", extent);
        found.iter().map(range_fact).chain([extent]).chain(heights.map(PreparedField::values_fact)).collect()
    };
    ranks.agree_all(found, facts).map(drop)
}
