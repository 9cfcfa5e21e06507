//! What a scene shows, by the numbers of its fields.

use super::radius_of;
use super::terrain::Terrain;
use crate::error::Result;
use crate::field::Field;
use crate::gradient::{self, Gradients, Wanted};
use crate::grid::Reals;
use crate::ground::Painter;
use crate::kernel::general::{Coat, Isosurface, Levels, Map, Medium, Sheet, SheetPlace, Source};
use crate::kernel::leap::Visible;
use crate::kernel::sample::{Sample, Samples};
use crate::kernel::transfer::{KernelKnot, Spans};
use crate::layers::Layers;
use crate::plan::{Sight, clear_values};
use crate::ranks::Ranks;
use crate::render::Setting;
use crate::render::spare::{self, LightKey, SightKey};
use crate::scene::{Heights, Level, Paint, TransferFunction};

/// Fields by number, while it is found out what is asked of each.
pub(super) struct Stage<'p, 'f> {
    setting: &'p Setting<'f>,
    fields: Vec<(&'p str, Field<'f>)>,
    /// Where something that is shown of each field begins, ends or bends.
    cuts: Vec<Vec<f64>>,
    thickness: f64,
}

impl<'p, 'f> Stage<'p, 'f> {
    pub fn new(setting: &'p Setting<'f>, others: &[(&'p str, Field<'f>)]) -> Self {
        let mut fields = vec![(setting.scene.field.as_str(), *setting.field)];
        fields.extend_from_slice(others);
        let radius = &setting.plan.radius;
        let thickness = radius[radius.len() - 1] - radius[0];
        Stage { setting, cuts: vec![Vec::new(); fields.len()], fields, thickness }
    }

    fn number(&self, name: &str) -> usize {
        self.fields
            .iter()
            .position(|(known, _)| *known == name)
            .expect("all fields that are shown were taken")
    }

    /// A transfer function's map, at the knots of which rays are cut.
    fn map(&mut self, field: &str, transfer: &TransferFunction) -> Map {
        let source = self.number(field);
        let knots = transfer.kernel_knots(self.thickness);
        self.cuts[source].extend(knots.iter().map(|knot| knot.value));
        Map::new(source, knots)
    }

    pub fn media(&mut self) -> Vec<Medium> {
        let scene = self.setting.scene;
        let first = (&scene.field, &scene.transfer, &scene.scenery.opacity);
        let others = scene.scenery.volumes.iter().map(|v| (&v.field, &v.transfer, &v.opacity));
        let volumes = std::iter::once(first).chain(others);
        let is_seen = |transfer: &TransferFunction| transfer.knots.iter().any(|knot| knot.extinction > 0.0);
        volumes
            .filter(|(_, transfer, opacity)| is_seen(opacity.as_ref().map_or(transfer, |by| &by.transfer)))
            .map(|(field, transfer, opacity)| {
                let (by, extinction) =
                    opacity.as_ref().map_or((field, transfer), |by| (&by.field, &by.transfer));
                Medium { color: self.map(field, transfer), extinction: self.map(by, extinction) }
            })
            .collect()
    }

    fn coat(&self, paint: &Paint) -> Coat {
        match paint {
            Paint::Plain(color) => Coat::Plain(*color),
            Paint::Field { field, transfer, by_cell, .. } => {
                // Surfaces ask for single values: rays need not be cut for them.
                Coat::By { map: Map::new(self.number(field), transfer.kernel_knots(1.0)), by_cell: *by_cell }
            }
        }
    }

    pub fn isosurfaces(&mut self) -> Vec<Isosurface> {
        let surfaces = &self.setting.scene.scenery.isosurfaces;
        surfaces
            .iter()
            .map(|surface| {
                let source = self.number(&surface.field);
                self.cuts[source].push(surface.value);
                let coat = self.coat(&surface.paint);
                Isosurface { source, value: surface.value, coat, opacity: surface.opacity }
            })
            .collect()
    }

    /// Surfaces and lines by level, in the order in which the scene names levels.
    pub fn sheets(&self, layers: &Layers) -> Vec<Sheet> {
        let Setting { scene, plan, .. } = *self.setting;
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
                    Level::Layer(layer) => SheetPlace::Layer(layer),
                    Level::Top | Level::Ground => SheetPlace::Layer(plan.radius.len() - 1),
                    Level::Height(height) => self.place_at(radius_of(height, scene, layers)),
                };
                let here = scenery.surfaces.iter().filter(|surface| surface.at == level);
                let coats = here.map(|s| (self.coat(&s.paint), s.opacity)).collect();
                Sheet { place, coats, painter: Painter::new(scene, level) }
            })
            .collect()
    }

    /// Where each of the volumes and isosurfaces can be seen, and what that is known by; all there is, without a key, where sheets
    /// may be met between layers.
    pub fn visible(
        &self,
        media: &[Medium],
        isosurfaces: &[Isosurface],
        sheets: &[Sheet],
    ) -> (Vec<SightKey>, Vec<Visible>) {
        let Setting { renderer, plan, .. } = *self.setting;
        let has_radii = sheets.iter().any(|sheet| matches!(sheet.place, SheetPlace::Radius(_)));
        if has_radii || !renderer.savings.leaps {
            return (Vec::new(), vec![Visible::default().all_in(plan.radius.len())]);
        }
        let of_media =
            media.iter().map(|medium| (medium.extinction.source, medium.extinction.knots().to_vec()));
        let of_surfaces =
            isosurfaces.iter().map(|s| (s.source, spike(s.value, self.range(s.source).unwrap_or([0.0; 2]))));
        let all = of_media.chain(of_surfaces).map(|(source, knots)| match self.fields[source].1.samples() {
            Reals::F32(data) => self.visible_of(data, source, &knots),
            Reals::F64(data) => self.visible_of(data, source, &knots),
        });
        all.unzip()
    }

    /// Least and greatest value of a field.
    fn range(&self, source: usize) -> Option<[f64; 2]> {
        let Setting { renderer, grid, .. } = *self.setting;
        let field = &self.fields[source].1;
        renderer.spare.range(&spare::Source::new(grid, field), || field.range()).0
    }

    fn visible_of<S: Sample>(&self, data: &[S], source: usize, knots: &[KernelKnot]) -> (SightKey, Visible) {
        let Setting { renderer, plan, grid, .. } = *self.setting;
        let field = &self.fields[source].1;
        let spans = Spans::<f64>::new(knots);
        let samples = Samples::new(data, field, plan.falling, spans.range());
        let clear = clear_values(&spans, &samples, self.range(source));
        let bits = clear.iter().map(|range| range.map(|value| value.wide().to_bits())).collect();
        let key = SightKey { source: spare::Source::new(grid, field), falling: plan.falling, clear: bits };
        let sight = Sight { grid, samples, layers: plan.radius.len(), clear };
        let visible = renderer.spare.visible(&key, |memory| sight.visible(memory));
        (key, visible)
    }

    /// On the layer that lies at this radius, but for rounding, which must not leave a surface a hair above the outermost one,
    /// where nothing is shown.
    fn place_at(&self, radius: f64) -> SheetPlace {
        let Setting { scene, plan, .. } = *self.setting;
        let layer = plan.radius.iter().position(|r| (r - radius).abs() <= 1e-12 * radius);
        let layer = layer.filter(|_| scene.scenery.heights == Heights::Mean);
        layer.map_or(SheetPlace::Radius(radius), SheetPlace::Layer)
    }

    /// The fields, with gradients of those that are `lit`, and what these are known by. Collective.
    pub fn sources(
        mut self,
        ranks: &mut Ranks,
        lit: &[usize],
        terrain: &Terrain,
    ) -> Result<(Vec<Source<'f>>, Vec<Option<LightKey>>)> {
        let Setting { renderer, plan, grid, part, .. } = *self.setting;
        let (mut sources, mut keys) = (Vec::new(), Vec::new());
        for (number, (_, field)) in self.fields.iter().enumerate() {
            let mut cuts = std::mem::take(&mut self.cuts[number]);
            cuts.sort_by(f64::total_cmp);
            cuts.dedup();
            let (mut light, mut key) = (Gradients::none(), None);
            if lit.contains(&number) {
                // Ranks give each other gradients: all divide by the same.
                let low = cuts.first().copied().unwrap_or(0.0);
                let width = cuts.last().map_or(0.0, |high| high - low);
                let width = if width > 0.0 { width } else { low.abs().max(1.0) };
                let range = [low, low + width];
                let asked = LightKey {
                    source: spare::Source::new(grid, field),
                    falling: plan.falling,
                    range,
                    radius: plan.radius.clone(),
                    packed: false,
                    sight: None,
                    heights: terrain.key.clone(),
                };
                let compute = |memory| self.gradients(field, range, &terrain.levels, memory);
                let computed =
                    ranks.attempt(|| Ok(renderer.run(|| renderer.spare.gradients(&asked, compute))));
                light = ranks.together(computed)?;
                key = Some(asked);
                if let Some(part) = part {
                    let layers = plan.radius.len();
                    let all = light.whole_mut();
                    part.fill_halo(ranks, all, |all, cell| &mut all[cell as usize * layers..][..layers])?;
                }
            }
            sources.push(Source::new(field, plan.falling, light, cuts));
            keys.push(key);
        }
        Ok((sources, keys))
    }

    fn gradients(&self, field: &Field, range: [f64; 2], levels: &Levels, memory: Gradients) -> Gradients {
        match field.samples() {
            Reals::F32(data) => self.gradients_of(data, field, range, levels, memory),
            Reals::F64(data) => self.gradients_of(data, field, range, levels, memory),
        }
    }

    fn gradients_of<S: Sample>(
        &self,
        data: &[S],
        field: &Field,
        range: [f64; 2],
        levels: &Levels,
        memory: Gradients,
    ) -> Gradients {
        let Setting { plan, grid, .. } = *self.setting;
        let samples = Samples::new(data, field, plan.falling, range);
        let wanted = Wanted { visible: None, packed: false };
        match levels {
            Levels::Native(heights) => gradient::native::gradients(grid, heights, &samples, memory),
            Levels::Concentric(_) => {
                gradient::gradients(grid, &plan.radius, &samples, 0..grid.cells(), wanted, memory)
            }
        }
    }
}

/// A transfer function that is clear but next to `value`, for a field of this range.
fn spike(value: f64, [low, high]: [f64; 2]) -> Vec<KernelKnot> {
    let near = if high > low { 1e-6 * (high - low) } else { value.abs().max(1.0) };
    let knot = |value: f64, extinction: f64| KernelKnot { value, color: [0.0; 3], extinction };
    vec![knot(value - near, 0.0), knot(value, 1.0), knot(value + near, 0.0)]
}
