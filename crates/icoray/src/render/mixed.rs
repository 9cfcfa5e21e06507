//! Pictures of several fields, surfaces and cuts: what the general kernel shows, made of a scene.

use super::device::OnDevice;
use super::prepare::Known;
use super::spare::{self, LightKey};
use super::work::{Rays, Work, budget};
use super::{Derived, Rendered, Setting, picture};
use crate::device::Job;
use crate::error::{Error, ErrorKind, Result};
use crate::field::Field;
use crate::gradient::{self, Gradients, Wanted};
use crate::grid::Reals;
use crate::ground::{Ground, Painter};
use crate::heights;
use crate::kernel::general::{
    Clips, Coat, Isosurface, Levels, Map, Medium, Sheet, SheetPlace, Source, Tracer, World,
};
use crate::kernel::leap::Visible;
use crate::kernel::sample::{Sample, Samples};
use crate::kernel::transfer::{KernelKnot, Spans};
use crate::layers::Layers;
use crate::plan::{Sight, clear_values};
use crate::quality::{Lights, Quality};
use crate::ranks::{Part, Ranks};
use crate::scene::{Heights, Level, Paint, Scene, TransferFunction};
use rayon::prelude::*;

/// Rays through all that a scene shows.
struct Mixed<'p, 'f> {
    setting: &'p Setting<'f>,
    world: &'p World<'f>,
}

impl<'f> Rays for Mixed<'_, 'f> {
    type Caster<'c>
        = Tracer<'c, 'f>
    where
        Self: 'c;

    fn get_ready(&self) {}

    fn caster(&self, quality: &Quality) -> Tracer<'_, 'f> {
        let Setting { renderer, scene, plan, .. } = *self.setting;
        let shading = plan.shading.filter(|_| quality.lights != Lights::Off);
        Tracer { world: self.world, shading, budget: budget(renderer, scene, quality) }
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
    let Setting { renderer, scene, plan, grid, part, ref field, .. } = *setting;
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
    compare(setting, ranks, others, &terrain)?;
    let visible = renderer.run(|| stage.visible(&media, &isosurfaces, &sheets));
    let (sources, light_keys) = stage.sources(ranks, &lit, &terrain)?;
    let derived: usize = sources.iter().map(|source| source.gradients().bytes()).sum();
    let normals = terrain.normals(setting, ranks, &sheets, known.is_lit())?;
    let ground = Ground::new(scene);
    let clip_radius = |height: f64| radius_of(height, scene, layers);
    let Terrain { levels, core_radius, outer, .. } = terrain;
    // Above the highest layer that is seen there is nothing to pass.
    let seen = match &levels {
        Levels::Concentric(_) if sheets.is_empty() && renderer.savings.layers => {
            plan.radius[visible.top.max(1)]
        }
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
    let rays = Mixed { setting, world: &world };
    let work = Work { renderer, scene, plan, radius: [core_radius[0], outer], ground: ground.as_ref(), rays };
    let mut rendered = picture::draw(setting, ranks, &known, &work, on_device)?;
    rendered.report_mut().derived_bytes += derived;
    for (key, source) in light_keys.into_iter().zip(world.sources) {
        if let Some(key) = key {
            renderer.spare.keep_gradients(key, source.into_gradients());
        }
    }
    Ok(rendered)
}

/// Ranks that have other fields beside the first, or other heights, would draw tiles that do not fit each other. Collective.
fn compare(setting: &Setting, ranks: &mut Ranks, others: &[(&str, Field)], terrain: &Terrain) -> Result<()> {
    let Setting { renderer, grid, part, .. } = *setting;
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
        let radii = format!("{:?} to {}", terrain.core_radius, terrain.outer);
        found.iter().map(told).chain([("has layers from and to radii (planet radii)", radii)]).collect()
    };
    ranks.of_one_mind(found, facts).map(drop)
}

/// The radius at a height in metres, in planet radii, exaggerated.
fn radius_of(height_m: f64, scene: &Scene, layers: &Layers) -> f64 {
    1.0 + scene.exaggeration * height_m / layers.planet_radius_m()
}

/// Where layers lie, and how far in and out they reach.
struct Terrain<'f> {
    levels: Levels<'f>,
    /// Least and greatest radius of the innermost layer.
    core_radius: [f64; 2],
    outer: f64,
    /// What gradients depend on where columns have heights of their own.
    key: Option<(spare::Source, f64)>,
}

impl<'f> Terrain<'f> {
    /// Of `heights` where the scene asks for them. Collective.
    fn new(setting: &Setting, ranks: &mut Ranks, layers: &Layers, given: Option<&Field<'f>>) -> Result<Self> {
        let Setting { renderer, scene, plan, grid, part, .. } = *setting;
        let radius = &plan.radius;
        let [inner, outer] = [radius[0], radius[radius.len() - 1]];
        if scene.scenery.heights == Heights::Mean {
            let levels = Levels::concentric(radius);
            return Ok(Terrain { levels, core_radius: [inner, inner], outer, key: None });
        }
        let checked = ranks.attempt(|| {
            let none = "the scene has heights = \"native\", and no heights of columns are given";
            let heights = given.ok_or_else(|| Error::new(ErrorKind::Scene, none))?;
            let shape = (grid.cells(), radius.len());
            renderer.run(|| {
                let heights = heights::Heights::new(heights, layers, shape, scene.exaggeration)?;
                let lowest = (0..grid.cells() as u32).into_par_iter().map(|cell| heights.radius(cell, 0));
                // The mean ones stand over cells that are not here.
                let lowest = lowest
                    .fold(|| [inner, inner], around)
                    .reduce(|| [inner, inner], |[a, b], c| [a.min(c[0]), b.max(c[1])]);
                Ok((heights, lowest))
            })
        });
        let (heights, mut core_radius) = ranks.together(checked)?;
        let mut bounds = heights.bounds();
        if part.is_some() {
            for range in [&mut core_radius, &mut bounds] {
                *range = Part::whole_range(ranks, (Some(*range), 0))?.0.unwrap_or(*range);
            }
        }
        let stretch = scene.exaggeration / layers.planet_radius_m();
        let key = given.map(|field| (spare::Source::new(grid, field), stretch));
        Ok(Terrain { levels: Levels::Native(heights), core_radius, outer: bounds[1], key })
    }
}

impl Terrain<'_> {
    /// Normals of the ground and of the layers of sheets, where these are not round and light falls on them. Collective.
    fn normals(
        &self,
        setting: &Setting,
        ranks: &mut Ranks,
        sheets: &[Sheet],
        is_lit: bool,
    ) -> Result<Vec<(usize, Vec<[f32; 3]>)>> {
        let Setting { renderer, grid, part, .. } = *setting;
        let (Levels::Native(heights), true) = (&self.levels, is_lit) else { return Ok(Vec::new()) };
        let mut layers = vec![0];
        layers.extend(sheets.iter().filter_map(|sheet| match sheet.place {
            SheetPlace::Layer(layer) if layer > 0 => Some(layer),
            _ => None,
        }));
        layers.dedup();
        let mut all = Vec::new();
        for layer in layers {
            let made = ranks.attempt(|| Ok(renderer.run(|| gradient::native::normals(grid, heights, layer))));
            let mut normals = ranks.together(made)?;
            if let Some(part) = part {
                let row = |cell: u32| cell as usize..cell as usize + 1;
                part.fill_halo(ranks, normals.as_mut_slice(), |all, cell| &mut all[row(cell)])?;
            }
            all.push((layer, normals));
        }
        Ok(all)
    }
}

fn around([low, high]: [f64; 2], value: f64) -> [f64; 2] {
    [low.min(value), high.max(value)]
}

/// Fields by number, while it is found out what is asked of each.
struct Stage<'p, 'f> {
    setting: &'p Setting<'f>,
    fields: Vec<(&'p str, Field<'f>)>,
    /// Where something that is shown of each field begins, ends or bends.
    cuts: Vec<Vec<f64>>,
    thickness: f64,
}

impl<'p, 'f> Stage<'p, 'f> {
    fn new(setting: &'p Setting<'f>, others: &[(&'p str, Field<'f>)]) -> Self {
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

    fn media(&mut self) -> Vec<Medium> {
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

    fn isosurfaces(&mut self) -> Vec<Isosurface> {
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
    fn sheets(&self, layers: &Layers) -> Vec<Sheet> {
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

    /// Where something of the volumes and isosurfaces can be seen; anywhere where sheets may be met between layers.
    fn visible(&self, media: &[Medium], isosurfaces: &[Isosurface], sheets: &[Sheet]) -> Visible {
        let Setting { renderer, plan, grid, .. } = *self.setting;
        let layers = plan.radius.len();
        let has_radii = sheets.iter().any(|sheet| matches!(sheet.place, SheetPlace::Radius(_)));
        if has_radii || !renderer.savings.leaps {
            return Visible::default().all_in(layers);
        }
        let of_media =
            media.iter().map(|medium| (medium.extinction.source, medium.extinction.knots().to_vec()));
        let of_surfaces = isosurfaces.iter().map(|surface| {
            let range = self.fields[surface.source].1.range().0;
            (surface.source, spike(surface.value, range.unwrap_or([0.0; 2])))
        });
        let all = of_media.chain(of_surfaces).map(|(source, knots)| {
            let field = &self.fields[source].1;
            match field.samples() {
                Reals::F32(data) => self.visible_of(data, field, &knots),
                Reals::F64(data) => self.visible_of(data, field, &knots),
            }
        });
        Visible::joined(all.collect(), layers, grid.triangles())
    }

    fn visible_of<S: Sample>(&self, data: &[S], field: &Field, knots: &[KernelKnot]) -> Visible {
        let Setting { plan, grid, .. } = *self.setting;
        let spans = Spans::<f64>::new(knots);
        let samples = Samples::new(data, field, plan.falling, spans.range());
        let clear = clear_values(&spans, &samples, field.range().0);
        Sight { grid, samples, layers: plan.radius.len(), clear }.visible(Visible::default())
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
    fn sources(
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
