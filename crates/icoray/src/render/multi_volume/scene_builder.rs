//! Builds the general kernel's scene, in which fields are identified by numbers instead of names.

use super::terrain::Terrain;
use crate::plan::{OccupancyTest, clear_values};
use crate::ranks::Ranks;
use crate::render::context::FrameContext;
use crate::render::frame_cache::{GradientKey, OccupancyKey};
use icoray_grid::Field;
use icoray_grid::Reals;
use icoray_grid::Result;
use icoray_grid::gradient;
use icoray_grid::gradient::{GradientOptions, Gradients, PartialGradients, PreparedSample};
use icoray_grid::occupancy::OccupancyMask;
use icoray_grid::samples::{Samples, SearchedSample};
use icoray_kernel::general::{
    FieldSource, Isosurface, Levels, Material, Medium, SurfaceHeight, SurfaceLayer, TransferMap,
};
use icoray_kernel::ground::Painter;
use icoray_kernel::transfer::{KernelKnot, Spans};
use icoray_scene::{Heights, Level, Paint, TransferFunction, Volume};

/// Builds the kernel's scene and collects the uses of each field in it.
pub(super) struct SceneBuilder<'p, 'f> {
    context: &'p FrameContext<'f>,
    /// Values at which a visible part of each field begins, ends or bends.
    cuts: Vec<Vec<f64>>,
    thickness: f64,
}

impl<'p, 'f> SceneBuilder<'p, 'f> {
    pub fn new(context: &'p FrameContext<'f>) -> Self {
        let radius = &context.plan.radius;
        let thickness = radius[radius.len() - 1] - radius[0];
        SceneBuilder { context, cuts: vec![Vec::new(); context.fields.len()], thickness }
    }

    fn number(&self, name: &str) -> usize {
        let found = self.context.fields.iter().position(|field| field.name() == name);
        found.expect("all fields that are shown were prepared")
    }

    /// The map of a transfer function, at whose knots rays are cut.
    fn map(&mut self, field: &str, transfer: &TransferFunction) -> TransferMap {
        let source = self.number(field);
        let knots = KernelKnot::of(transfer, self.thickness);
        self.cuts[source].extend(knots.iter().map(|knot| knot.value));
        TransferMap::new(source, knots)
    }

    pub fn media(&mut self) -> Vec<Medium> {
        let volumes = self.context.scene.volumes.iter().map(|volume| {
            let Volume { field, transfer, opacity, .. } = volume;
            let extinction = opacity.as_ref().map_or((field, transfer), |by| (&by.field, &by.transfer));
            ((field, transfer), extinction)
        });
        let is_seen = |transfer: &TransferFunction| transfer.knots.iter().any(|knot| knot.extinction > 0.0);
        volumes
            .filter(|(_, (_, extinction))| is_seen(extinction))
            .map(|((field, transfer), (by, extinction))| Medium {
                color: self.map(field, transfer),
                extinction: self.map(by, extinction),
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

    pub fn isosurfaces(&mut self) -> Vec<Isosurface> {
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
    pub fn surface_layers(&self) -> Vec<SurfaceLayer> {
        let FrameContext { scene, plan, .. } = *self.context;
        let scenery = &scene.scenery;
        let mut all: Vec<Level> = Vec::new();
        for level in scenery.lines.iter().map(|l| l.on).chain(scenery.surfaces.iter().map(|s| s.at)) {
            if level != Level::Ground && !all.contains(&level) {
                all.push(level);
            }
        }
        all.into_iter()
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

    /// Occupancy of each volume and isosurface, with its key; everything is occupied, without a key,
    /// if surfaces may lie between layers.
    pub fn visible(
        &self,
        media: &[Medium],
        isosurfaces: &[Isosurface],
        surface_layers: &[SurfaceLayer],
    ) -> (Vec<OccupancyKey>, Vec<OccupancyMask>) {
        let FrameContext { renderer, plan, .. } = *self.context;
        let has_radii = surface_layers.iter().any(|surface| matches!(surface.place, SurfaceHeight::Radius(_)));
        if has_radii || !renderer.savings.empty_space {
            return (Vec::new(), vec![OccupancyMask::default().full(plan.radius.len())]);
        }
        let of_media = media.iter().map(|medium| (medium.extinction.source, medium.extinction.knots().to_vec()));
        let of_surfaces =
            isosurfaces.iter().map(|s| (s.source, spike(s.value, self.context.range(s.source).0.unwrap_or([0.0; 2]))));
        let all =
            of_media.chain(of_surfaces).map(|(source, knots)| match self.context.fields[source].field().samples() {
                Reals::F32(data) => self.visible_of(data, source, &knots),
                Reals::F64(data) => self.visible_of(data, source, &knots),
            });
        all.unzip()
    }

    fn visible_of<S: SearchedSample>(
        &self,
        data: &[S],
        source: usize,
        knots: &[KernelKnot],
    ) -> (OccupancyKey, OccupancyMask) {
        let FrameContext { renderer, plan, grid, .. } = *self.context;
        let field = &self.context.fields[source];
        let spans = Spans::<f64>::new(knots);
        let samples = Samples::new(data, &field.field(), plan.falling, spans.range());
        let clear = clear_values(&spans, &samples, self.context.range(source).0);
        let bits = clear.iter().map(|range| range.map(|value| value.wide().to_bits())).collect();
        let key = OccupancyKey { source: field.source(grid), falling: plan.falling, clear: bits, leaps: false };
        let occupancy = OccupancyTest { grid, samples, layers: plan.radius.len(), clear, leaps: false };
        let cached = renderer.frame_cache.visible.take(&key);
        let visible = cached.unwrap_or_else(|memory| occupancy.visible(memory.unwrap_or_default()));
        (key, visible)
    }

    /// Places a surface on the layer at this radius, up to rounding, which must not leave it slightly above the
    /// outermost one, where nothing is shown.
    fn place_at(&self, radius: f64) -> SurfaceHeight {
        let FrameContext { scene, plan, .. } = *self.context;
        let layer = plan.radius.iter().position(|r| (r - radius).abs() <= 1e-12 * radius);
        let layer = layer.filter(|_| scene.scenery.heights == Heights::Mean);
        layer.map_or(SurfaceHeight::Radius(radius), SurfaceHeight::Layer)
    }

    /// The fields, with gradients of those that are `lit`, and the keys of these gradients. Collective.
    pub fn sources(
        mut self,
        ranks: &mut Ranks,
        lit: &[usize],
        terrain: &Terrain,
    ) -> Result<(Vec<FieldSource<'f>>, Vec<Option<GradientKey>>)> {
        let FrameContext { renderer, plan, grid, part, .. } = *self.context;
        let (mut sources, mut keys) = (Vec::new(), Vec::new());
        for (number, prepared) in self.context.fields.iter().enumerate() {
            let field = &prepared.field();
            let mut cuts = std::mem::take(&mut self.cuts[number]);
            cuts.sort_by(f64::total_cmp);
            cuts.dedup();
            let (mut light, mut key) = (PartialGradients::from(Gradients::none()), None);
            if lit.contains(&number) {
                // Ranks exchange gradients, so all divide by the same range.
                let low = cuts.first().copied().unwrap_or(0.0);
                let width = cuts.last().map_or(0.0, |high| high - low);
                let width = if width > 0.0 { width } else { low.abs().max(1.0) };
                let range = [low, low + width];
                let asked = GradientKey {
                    source: prepared.source(grid),
                    falling: plan.falling,
                    range,
                    radius: plan.radius.clone(),
                    packed: false,
                    // The general kernel has double precision for every scene.
                    single: false,
                    occupancy: None,
                    heights: terrain.key.clone(),
                };
                let computed = ranks.attempt(|| {
                    let compute = || self.gradients(field, &asked, &terrain.levels);
                    renderer.run(compute)
                });
                light = ranks.collective(computed)?;
                key = Some(asked);
                if let Some(part) = part {
                    let layers = plan.radius.len();
                    let all = light.values_mut().whole_mut();
                    part.fill_halo(ranks, all, |all, cell| &mut all[cell as usize * layers..][..layers])?;
                }
            }
            let value_range = renderer.run(|| self.context.range(number).0);
            sources.push(FieldSource::new(field, plan.falling, light, cuts, value_range));
            keys.push(key);
        }
        Ok((sources, keys))
    }

    fn gradients(&self, field: &Field, key: &GradientKey, levels: &Levels) -> Result<PartialGradients> {
        match field.samples() {
            Reals::F32(data) => self.gradients_of(data, field, key, levels),
            Reals::F64(data) => self.gradients_of(data, field, key, levels),
        }
    }

    /// The gradients that are cached for `key`, and the further ones that the picture needs.
    fn gradients_of<S: PreparedSample>(
        &self,
        data: &[S],
        field: &Field,
        key: &GradientKey,
        levels: &Levels,
    ) -> Result<PartialGradients> {
        let FrameContext { renderer, scene, plan, grid, part, .. } = *self.context;
        let samples = Samples::new(data, field, plan.falling, key.range);
        match levels {
            Levels::Native(heights) => renderer.frame_cache.gradients.take(key).or_else(|memory| {
                let memory = memory.map_or_else(Gradients::none, PartialGradients::into_values);
                Ok(gradient::native::gradients(grid, heights, &samples, memory)?.into())
            }),
            Levels::Concentric(_) => {
                let wanted = GradientOptions { visible: None, packed: false, single: key.single };
                let seen = (part.is_none() && renderer.savings.gradients).then(|| plan.visible_cells(scene, grid));
                let known = renderer.frame_cache.known_gradients(key);
                known.with_cells(grid, &plan.radius, &samples, wanted, seen.as_ref())
            }
        }
    }
}

/// A transfer function that is clear except near `value`, for a field of this range.
fn spike(value: f64, [low, high]: [f64; 2]) -> Vec<KernelKnot> {
    let near = if high > low { 1e-6 * (high - low) } else { value.abs().max(1.0) };
    let knot = |value: f64, extinction: f64| KernelKnot { value, color: [0.0; 3], extinction };
    vec![knot(value - near, 0.0), knot(value, 1.0), knot(value + near, 0.0)]
}
