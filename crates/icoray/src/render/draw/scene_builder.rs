//! Builds the kernel's scene, in which fields are identified by numbers instead of names.

use super::occupancy::NodeOccupancy;
use super::terrain::Terrain;
use crate::device::GradientSource;
use crate::plan::Savings;
use crate::ranks::{Part, Ranks};
use crate::render::context::FrameContext;
use crate::render::frame_cache::{FrameCache, GradientKey, NormalKey, OccupancyKey};
use crate::render::lazy::Lazy;
use crate::render::prepare::FieldSummary;
use fearless_simd::Level as VectorLevel;
use icoray_grid::Result;
use icoray_grid::gradient::{Gradients, PartialGradients};
use icoray_grid::occupancy::OccupancyMask;
use icoray_grid::real::Real;
use icoray_kernel::PacketScene;
use icoray_kernel::general::{
    Clips, FieldSource, Isosurface, KernelScene, Levels, Material, Medium, SurfaceHeight, SurfaceLayer, TransferMap,
};
use icoray_kernel::ground::{Core, Ground, Painter};
use icoray_kernel::transfer::KernelKnot;
use icoray_scene::{Heights, Level, Method, Paint, Precision, Scene, Scenery, TransferFunction, Volume};
use std::borrow::Cow;

/// The kernel's scene of a frame, with the keys of its cached parts.
#[derive(Debug)]
pub(in crate::render) struct BuiltScene<'f> {
    pub scene: KernelScene<'f>,
    /// The scene for packets of rays, and the vector instructions, if it is traced in packets.
    pub packets: Option<(VectorLevel, PacketScene<'f>)>,
    occupancy_key: Option<OccupancyKey>,
    pub gradient_keys: Vec<Option<GradientKey>>,
    pub normal_keys: Vec<NormalKey>,
}

impl BuiltScene<'_> {
    /// Bytes of gradients and visible blocks; also of those in the node's memory if this rank reports them.
    pub fn bytes(&self, reports_shared: bool) -> usize {
        let KernelScene { sources, visible, .. } = &self.scene;
        let own = sources.iter().map(|source| source.gradients.own_bytes()).sum::<usize>() + visible.own_bytes();
        if !reports_shared {
            return own;
        }
        let gradients = sources.iter().map(|source| source.gradients.values());
        let blocks = if let Cow::Borrowed(blocks) = visible.blocks { size_of_val(blocks) } else { 0 };
        own + blocks + gradients.map(|gradients| gradients.bytes().len() - gradients.own_bytes()).sum::<usize>()
    }

    /// Receives gradients and normals at the cells of a part's halo from other ranks. Collective.
    pub fn fill_halos(&mut self, ranks: &mut Ranks, part: &Part) -> Result<()> {
        let KernelScene { levels, sources, normals, .. } = &mut self.scene;
        let lit = sources.iter_mut().zip(&self.gradient_keys).filter(|(_, key)| key.is_some());
        lit.map(|(source, _)| source.gradients.values_mut().whole_mut())
            .try_for_each(|all| part.fill_halo(ranks, all, levels.count()))?;
        normals.iter_mut().try_for_each(|(_, normals)| part.fill_halo(ranks, normals.to_mut(), 1))
    }

    /// Stores gradients, visible blocks and normals for the next frame.
    pub fn keep(self, cache: &FrameCache) {
        let KernelScene { sources, visible, normals, .. } = self.scene;
        for (key, (_, normals)) in self.normal_keys.into_iter().zip(normals) {
            if let Cow::Owned(own) = normals {
                cache.normals.store(key, own);
            }
        }
        if let (Some(key), Some(own)) = (self.occupancy_key, visible.into_own()) {
            cache.visible.store(key, own);
        }
        for (key, source) in self.gradient_keys.into_iter().zip(sources) {
            if let (Some(key), Some(own)) = (key, source.gradients.into_own()) {
                cache.gradients.store(key, own);
            }
        }
    }
}

/// The gradients of the first field.
impl GradientSource for Lazy<'_, BuiltScene<'_>> {
    fn gradients(&self) -> &Gradients<'_> {
        self.get().scene.sources[0].gradients.values()
    }
}

/// Builds the kernel's scene and collects the uses of each field in it.
#[derive(Clone)]
pub(super) struct SceneBuilder<'p, 'f> {
    pub context: &'p FrameContext<'f>,
    pub terrain: &'p Terrain<'f>,
    pub summary: &'p FieldSummary,
    /// Values at which a visible part of each field begins, ends or bends.
    cuts: Vec<Vec<f64>>,
    pub savings: Savings,
    /// Whether gradients are in visible blocks only and may be packed: no other rank or device reads them.
    pub partial_gradients: bool,
    /// Whether the scene is built with its gradients and normals.
    has_gradients: bool,
    /// The visible blocks that the ranks of the node have found together.
    pub node_occupancy: Option<&'f NodeOccupancy>,
}

impl<'p, 'f> SceneBuilder<'p, 'f> {
    pub fn new(context: &'p FrameContext<'f>, terrain: &'p Terrain<'f>, summary: &'p FieldSummary) -> Self {
        let (cuts, savings) = (vec![Vec::new(); context.fields.len()], context.renderer.savings);
        let partial_gradients = context.device.is_err() && context.part.is_none() && terrain.key.is_none();
        SceneBuilder {
            context,
            terrain,
            summary,
            cuts,
            savings,
            partial_gradients,
            has_gradients: true,
            node_occupancy: None,
        }
    }

    /// Leaves out gradients and normals, which the ranks of a node compute together: gradients in visible blocks only if
    /// `partial`.
    pub fn leave_out_gradients(&mut self, partial: bool) {
        (self.partial_gradients, self.has_gradients) = (partial, false);
    }

    /// The same, for rays that pass all layers and blocks.
    pub fn with_all_visible(self) -> Self {
        SceneBuilder { savings: Savings { empty_space: false, layers: false, ..self.savings }, ..self }
    }

    /// The scene, over a core with this ground. Gradients and normals at halo cells are those of this rank's cells.
    pub fn build(mut self, ground: Option<&'f Ground>) -> Result<BuiltScene<'f>> {
        let FrameContext { scene, plan, grid, .. } = *self.context;
        let (media, isosurfaces) = (self.media(), self.isosurfaces());
        let surface_layers = self.surface_layers();
        let (occupancy_key, visible) = self.visible(&media, &isosurfaces);
        let (sources, gradient_keys) = self.sources(&media, &isosurfaces, occupancy_key.as_ref(), &visible)?;
        let normal_keys = self.terrain.normal_keys(&surface_layers, self.summary.is_lit());
        let normals = normal_keys.iter().map(|key| (key.layer[0], self.normals(key))).collect();
        let Terrain { levels, core_radius, outer, .. } = self.terrain;
        // Everything above the highest visible layer is invisible.
        let tops = surface_layers.iter().map(|surface| match surface.place {
            SurfaceHeight::Layer(layer) => layer,
            SurfaceHeight::Radius(radius) => self.gap_at(radius),
        });
        let top = tops.fold(visible.top, usize::max);
        let seen = match levels {
            Levels::Concentric(_) if self.savings.layers => plan.radius[top.clamp(1, plan.radius.len() - 1)],
            _ => *outer,
        };
        let scene = KernelScene {
            grid,
            levels: levels.clone(),
            sources,
            media,
            isosurfaces,
            clips: Clips::new(&scene.scenery.clips, |height| self.context.radius_of(height)),
            visible,
            beside: self.beside(&surface_layers),
            surface_layers,
            normals,
            core: Core::new(scene.core, ground),
            core_radius: *core_radius,
            // A facet touches that sphere at its highest vertex, which rays meet only if they start above it.
            outer: seen * (1.0 + 1e-9),
        };
        let packets = self.packets(&scene)?;
        Ok(BuiltScene { scene, packets, occupancy_key, gradient_keys, normal_keys })
    }

    /// The normals of a layer, unless the ranks of the node compute them together.
    fn normals(&self, key: &NormalKey) -> Cow<'f, [[f32; 3]]> {
        if !self.has_gradients {
            return Cow::Borrowed(&[]);
        }
        let FrameContext { grid, cache, .. } = *self.context;
        let compute =
            |memory: Option<_>| self.terrain.normals(grid, key.layer[0], 0..grid.cells(), memory.unwrap_or_default());
        cache.normals.take(key).unwrap_or_else(compute).into()
    }

    /// The machine's vector instructions, if rays are in single precision.
    pub(super) fn vectors(&self) -> Option<VectorLevel> {
        let FrameContext { renderer, scene, .. } = *self.context;
        renderer.vectors().filter(|_| scene.method == Method::Exact && scene.precision == Precision::F32)
    }

    /// Whether rays leap over empty space between concentric layers.
    pub(super) fn leaps(&self) -> bool {
        self.savings.empty_space
            && self.context.device.is_err()
            && self.context.part.is_none()
            && self.terrain.key.is_none()
    }

    fn packets(&self, built: &KernelScene<'f>) -> Result<Option<(VectorLevel, PacketScene<'f>)>> {
        let Some(level) = self.vectors() else { return Ok(None) };
        let Some(packets) = PacketScene::new(built, &self.context.plan.radius, self.leaps()) else { return Ok(None) };
        let packets = match self.context.deviations {
            Some(deviations) => packets.with_deviations(deviations),
            None => packets,
        };
        Ok(Some((level, packets)))
    }

    fn number(&self, name: &str) -> usize {
        self.context.number_of(name).expect("all fields that are shown were prepared")
    }

    /// The map of a transfer function, at whose knots rays are cut.
    fn map(&mut self, field: &str, transfer: &TransferFunction) -> TransferMap {
        let source = self.number(field);
        let knots = KernelKnot::of(transfer, self.context.plan.thickness());
        self.cuts[source].extend(knots.iter().map(|knot| knot.value));
        TransferMap::new(source, knots)
    }

    pub(super) fn media(&mut self) -> Vec<Medium> {
        seen_volumes(self.context.scene)
            .map(|(_, Volume { field, transfer, opacity, .. })| {
                let (by, extinction) = opacity.as_ref().map_or((field, transfer), |by| (&by.field, &by.transfer));
                Medium::new(self.map(field, transfer), self.map(by, extinction))
            })
            .collect()
    }

    fn material(&self, paint: &Paint) -> Material {
        match paint {
            Paint::Plain(color) => Material::Plain(*color),
            Paint::Field { field, transfer, by_cell, .. } => {
                // Surfaces read single values: rays need not be cut for them.
                Material::By {
                    map: TransferMap::new(self.number(field), KernelKnot::of(transfer, 1.0)),
                    by_cell: *by_cell,
                }
            }
        }
    }

    pub(super) fn isosurfaces(&mut self) -> Vec<Isosurface> {
        let surfaces = &self.context.scene.scenery.isosurfaces;
        surfaces
            .iter()
            .map(|surface| {
                let source = self.number(&surface.field);
                self.cuts[source].push(surface.value);
                let material = self.material(&surface.paint);
                Isosurface { source, value: surface.value, material, opacity: surface.opacity }
            })
            .collect()
    }

    /// Surfaces and lines by level, in the order in which the scene names levels.
    pub(super) fn surface_layers(&self) -> Vec<SurfaceLayer> {
        let FrameContext { scene, plan, .. } = *self.context;
        let scenery = &scene.scenery;
        surface_levels(scenery)
            .into_iter()
            .map(|level| {
                let place = match level {
                    Level::Layer(layer) => SurfaceHeight::Layer(layer),
                    Level::Top | Level::Ground => SurfaceHeight::Layer(plan.radius.len() - 1),
                    Level::Height(height) => self.place_at(self.context.radius_of(height)),
                };
                let here = scenery.surfaces.iter().filter(|surface| surface.at == level);
                let materials = here.map(|s| (self.material(&s.paint), s.opacity)).collect();
                SurfaceLayer { place, materials, painter: Painter::new(scene, level) }
            })
            .collect()
    }

    /// The gap between concentric layers that contains a radius.
    fn gap_at(&self, radius: f64) -> usize {
        self.context.plan.radius.partition_point(|layer| *layer < radius)
    }

    /// The blocks of gaps that surfaces adjoin.
    fn beside(&self, surface_layers: &[SurfaceLayer]) -> u32 {
        let layers = self.context.plan.radius.len();
        let mask = OccupancyMask::default().full(layers);
        let blocks = |surface: &SurfaceLayer| match (surface.place, &self.terrain.levels) {
            (SurfaceHeight::Layer(layer), _) => mask.between([layer, layer + 1], layers),
            (SurfaceHeight::Radius(radius), Levels::Concentric(_)) => mask.between([self.gap_at(radius); 2], layers),
            (SurfaceHeight::Radius(_), Levels::Native(_)) => u32::MAX,
        };
        surface_layers.iter().fold(0, |all, surface| all | blocks(surface))
    }

    /// Places a surface on the layer at this radius, up to rounding, which must not leave it slightly above the
    /// outermost one, where nothing is shown.
    fn place_at(&self, radius: f64) -> SurfaceHeight {
        let FrameContext { scene, plan, .. } = *self.context;
        let layer = plan.radius.iter().position(|r| (r - radius).abs() <= 1e-12 * radius);
        let layer = layer.filter(|_| scene.scenery.heights == Heights::Mean);
        layer.map_or(SurfaceHeight::Radius(radius), SurfaceHeight::Layer)
    }

    /// The least and the greatest value of a field.
    pub(super) fn range(&self, source: usize) -> Option<[f64; 2]> {
        self.summary.range(self.context, source)
    }

    /// The fields, with gradients of those that are lit, and the keys of these gradients.
    fn sources(
        &mut self,
        media: &[Medium],
        isosurfaces: &[Isosurface],
        occupancy: Option<&OccupancyKey>,
        visible: &OccupancyMask,
    ) -> Result<(Vec<FieldSource<'f>>, Vec<Option<GradientKey>>)> {
        let FrameContext { scene, plan, .. } = *self.context;
        // The values of a single volume without surfaces may be as large as any.
        let largest = if scene.has_volume_alone() { f64::MAX } else { f64::LARGEST };
        let (mut sources, mut gradient_keys) = (Vec::new(), Vec::new());
        for (number, prepared) in self.context.fields.iter().enumerate() {
            let field = prepared.field();
            let mut cuts = std::mem::take(&mut self.cuts[number]);
            cuts.sort_by(f64::total_cmp);
            cuts.dedup();
            let is_seen = media.iter().any(|medium| medium.extinction.source == number)
                || isosurfaces.iter().any(|surface| surface.source == number);
            let key = (is_seen && self.summary.is_lit()).then(|| self.gradient_key(number, &cuts, occupancy));
            let gradients = match &key {
                Some(key) if self.has_gradients => self.gradients(number, key, visible)?,
                _ => PartialGradients::none(),
            };
            let field = if plan.falling { field.upside_down() } else { field };
            sources.push(FieldSource { field, gradients, cuts, value_range: self.range(number), largest });
            gradient_keys.push(key);
        }
        Ok((sources, gradient_keys))
    }
}

/// The volumes of which anything can be visible, with their numbers.
pub(super) fn seen_volumes(scene: &Scene) -> impl Iterator<Item = (usize, &Volume)> {
    scene.volumes.iter().enumerate().filter(|(_, volume)| {
        let extinction = volume.opacity.as_ref().map_or(&volume.transfer, |by| &by.transfer);
        extinction.knots.iter().any(|knot| knot.extinction > 0.0)
    })
}

/// The levels above the ground with surfaces or lines, in the order in which the scene names them.
pub(super) fn surface_levels(scenery: &Scenery) -> Vec<Level> {
    let mut all: Vec<Level> = Vec::new();
    for level in scenery.lines.iter().map(|lines| lines.on).chain(scenery.surfaces.iter().map(|surface| surface.at)) {
        if level != Level::Ground && !all.contains(&level) {
            all.push(level);
        }
    }
    all
}
