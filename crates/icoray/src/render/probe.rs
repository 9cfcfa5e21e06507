//! Probes: the contents of a pixel, and the values along its ray.
//!
//! The ray is traced as those of pictures in double precision, unlit and with nothing left out, and each part of a
//! frustum, surface and core that it passes is recorded (`icoray_kernel::passages`). Where ranks have parts of the
//! grid, each records the ray in its own columns.

use super::RenderInputs;
use super::context::FrameContext;
use super::draw::{ProbedScene, RayPart};
use super::renderer::Renderer;
use super::work::ray;
use crate::fields::Fields;
use crate::ranks::{Decomposition, DistributedGrid, GatherInputs, Ranks};
use glam::DVec3;
use icoray_grid::{Grid, Layers, Result};
use icoray_scene::{Backend, Method, Paint, Precision, Scene};
use serde::Serialize;
use std::time::Instant;

pub use super::draw::ScenePart;

/// The contents of a pixel, and the values along its ray.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// The part of the scene that absorbs most of the ray's light: the pixel's own light comes from it. `None` if
    /// nothing absorbs any.
    pub part: Option<ScenePart>,
    /// The name of the field that `value`, `along` and `column` are of: that of the part's colours, or the scene's
    /// first one.
    pub field: String,
    /// Longitude and latitude, degrees, of the place that is shown: of a volume, where half of the light that it
    /// absorbs is lost; of nothing, where the ray enters the shell.
    pub lon_lat_deg: [f64; 2],
    /// Height there above the planet's surface, metres.
    pub height_m: f64,
    /// The field's value there; `None` where it is missing.
    pub value: Option<f64>,
    /// Fraction of the light that all parts but the core absorb.
    pub alpha: f64,
    /// All parts that absorb light, the one that absorbs most first.
    pub contributions: Vec<Contribution>,
    /// The points of the ray through the shell, in order, up to the place where it ends.
    pub along: Vec<ProbePoint>,
    /// Heights, metres, and values of the nearest column, from the innermost layer outwards; NaN for a missing value.
    pub column: Vec<[f64; 2]>,
}

/// The light that a part of the scene absorbs of a ray.
#[derive(Debug, Clone, PartialEq)]
pub struct Contribution {
    /// The part.
    pub part: ScenePart,
    /// The field of its colours; `None` if it has one colour.
    pub field: Option<String>,
    /// Fraction of the ray's light that it absorbs.
    pub weight: f64,
    /// Distance of the place that it shows from the eye, planet radii; see [`Probe::lon_lat_deg`].
    pub distance: f64,
    /// Height there above the planet's surface, metres.
    pub height_m: f64,
    /// The field's value there; `None` where it is missing, and without a field.
    pub value: Option<f64>,
}

/// A point of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ProbePoint {
    /// Distance from the eye, planet radii.
    pub distance: f64,
    /// Height above the planet's surface, metres.
    pub height_m: f64,
    /// The field's value; NaN where it is missing.
    pub value: f64,
    /// Length of the part of the ray around this point, planet radii.
    pub length: f64,
    /// Fraction of the ray's light that volumes in the field's colours absorb along that length.
    pub weight: f64,
}

impl Renderer {
    /// Probes the ray through `at` of a scene's picture, in fractions of its width and height from the upper left
    /// corner; `None` if it misses the shell.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn probe<'f>(
        &self,
        scene: &Scene,
        grid: &Grid,
        layers: &Layers,
        fields: impl Into<Fields<'f>>,
        at: [f64; 2],
    ) -> Result<Option<Probe>> {
        let given = RenderInputs { scene, grid, part: None, mates: None, layers, fields: &fields.into() };
        self.probe_inputs(&mut Ranks::alone(), &given, at)
    }

    /// As [`Self::probe`], for a grid that may be distributed over ranks. Collective; the result is on rank 0, others
    /// have `None`. Ranks with columns or parts gather the fields as for a frame.
    ///
    /// # Errors
    /// Those of [`Self::probe`]; on all ranks as [`Self::render_decomposed`].
    pub fn probe_decomposed<'f>(
        &self,
        ranks: &mut Ranks,
        scene: &Scene,
        data: DistributedGrid,
        fields: impl Into<Fields<'f>>,
        at: [f64; 2],
    ) -> Result<Option<Probe>> {
        let DistributedGrid { grid, decomposition, layers } = data;
        let fields = fields.into();
        let Some(Decomposition::Columns(columns)) = decomposition else {
            return if ranks.is_root() { self.probe(scene, grid, layers, fields, at) } else { Ok(None) };
        };
        let derivation_inputs = scene.derivation_inputs().collect();
        let inputs = GatherInputs { threads: &self.threads, grid, layers, derivation_inputs };
        let gathered = columns.gather(ranks, &inputs, || fields.needed_by(scene))?;
        let found = ranks.collective(gathered.fields()).and_then(|fields| {
            let (grid, part) = (gathered.grid(grid), gathered.part());
            self.probe_inputs(ranks, &RenderInputs { scene, grid, part, mates: None, layers, fields: &fields }, at)
        });
        gathered.leave(ranks);
        found
    }

    fn probe_inputs(&self, ranks: &mut Ranks, given: &RenderInputs, at: [f64; 2]) -> Result<Option<Probe>> {
        let scene = given.scene;
        let plain = Scene {
            lighting: None,
            precision: Precision::F64,
            method: Method::Exact,
            backend: Backend::Cpu,
            time_budget_ms: None,
            samples: 1,
            ..scene.clone()
        };
        let place = [at[0] * f64::from(scene.width), at[1] * f64::from(scene.height)];
        let (eye, dir) = ray(scene, place);
        self.in_context(Instant::now(), ranks, &RenderInputs { scene: &plain, ..*given }, |context, ranks| {
            let probed = ProbedScene::new(context, ranks)?;
            let parts = probed.record(ranks, eye, dir)?;
            let Some((mut probe, shown)) = (ProbedRay { context, eye, dir, parts: &parts }).probe() else {
                return Ok(None);
            };
            let rank = ranks.rank();
            let mut columns = ranks.share_work(|| {
                let field = context.number_of(&probe.field).unwrap_or(0);
                let own = shown.cells.filter(|_| shown.rank == rank);
                let column = |cells| probed.column(nearest(context.grid, cells, eye + middle(shown) * dir), field);
                Ok(own.map_or_else(Vec::new, column))
            })?;
            let column = columns.swap_remove(shown.rank);
            probe.column = column.into_iter().map(|[radius, value]| [context.height_m(radius), value]).collect();
            Ok(ranks.is_root().then_some(probe))
        })
    }
}

/// A recorded ray.
struct ProbedRay<'p, 'f> {
    context: &'p FrameContext<'f>,
    eye: DVec3,
    dir: DVec3,
    parts: &'p [RayPart],
}

impl<'p> ProbedRay<'p, '_> {
    /// The result without its column, and the part of the ray that is shown; `None` if the ray misses the shell.
    fn probe(&self) -> Option<(Probe, &'p RayPart)> {
        let weights = self.weights();
        let mut absorbed = self.absorbed(&weights);
        absorbed.sort_by(|(a, _), (b, _)| b.weight.total_cmp(&a.weight));
        let shown = absorbed.first();
        let at = shown.map_or(self.parts.first()?, |(_, at)| *at);
        let part = shown.map(|(shown, _)| shown.part);
        let field = part.and_then(|part| self.field_of(part)).unwrap_or(0);
        let place = self.eye + middle(at) * self.dir;
        let contributions: Vec<Contribution> = absorbed.into_iter().map(|(contribution, _)| contribution).collect();
        let probe = Probe {
            part,
            field: self.context.fields[field].name().to_owned(),
            lon_lat_deg: [place.y.atan2(place.x), (place.z / place.length()).asin()].map(f64::to_degrees),
            height_m: self.context.height_m(at.rho),
            value: at.value(field),
            alpha: contributions.iter().filter(|one| one.part != ScenePart::Core).map(|one| one.weight).sum(),
            contributions,
            along: self.along(field, &weights),
            column: Vec::new(),
        };
        Some((probe, at))
    }

    /// The fraction of the ray's light that each of its parts absorbs.
    fn weights(&self) -> Vec<f64> {
        let mut left = 1.0;
        let absorbed = self.parts.iter().map(|part| {
            let before = left;
            left *= 1.0 - part.alpha;
            before - left
        });
        absorbed.collect()
    }

    /// The parts of the scene that absorb light, each with the part of the ray that it shows: a volume is shown where
    /// half of its weight is reached, another part where it absorbs most.
    fn absorbed(&self, weights: &[f64]) -> Vec<(Contribution, &'p RayPart)> {
        let mut all: Vec<(ScenePart, Vec<(f64, &RayPart)>)> = Vec::new();
        for (part, weight) in self.parts.iter().zip(weights) {
            for (number, share) in part.shares.iter().filter(|(_, share)| share * weight > 0.0) {
                let entry = (share * weight, part);
                match all.iter_mut().find(|(known, _)| known == number) {
                    Some((_, entries)) => entries.push(entry),
                    None => all.push((*number, vec![entry])),
                }
            }
        }
        all.into_iter()
            .map(|(part, entries)| {
                let weight = entries.iter().map(|(weight, _)| weight).sum();
                let at = match part {
                    ScenePart::Volume(_) => median(&entries, weight),
                    _ => entries.iter().max_by(|a, b| a.0.total_cmp(&b.0)).map_or(entries[0].1, |(_, at)| at),
                };
                let number = self.field_of(part);
                let field = number.map(|number| self.context.fields[number].name().to_owned());
                let (distance, height_m) = (middle(at), self.context.height_m(at.rho));
                let value = number.and_then(|number| at.value(number));
                (Contribution { part, field, weight, distance, height_m, value }, at)
            })
            .collect()
    }

    /// The number of the field of a part's colours.
    fn field_of(&self, part: ScenePart) -> Option<usize> {
        let scene = self.context.scene;
        let name = match part {
            ScenePart::Core | ScenePart::Lines => None,
            ScenePart::Volume(number) => Some(scene.volumes[number].field.as_str()),
            ScenePart::Isosurface(number) => Some(scene.scenery.isosurfaces[number].field.as_str()),
            ScenePart::Surface(number) => match &scene.scenery.surfaces[number].paint {
                Paint::Plain(_) => None,
                Paint::Field { field, .. } => Some(field.as_str()),
            },
        };
        self.context.number_of(name?)
    }

    /// The stretches of the ray through frusta, with the values of a field.
    fn along(&self, field: usize, weights: &[f64]) -> Vec<ProbePoint> {
        let shows = |part: ScenePart| self.field_of(part) == Some(field);
        let stretches = self.parts.iter().zip(weights).filter(|(part, _)| part.t[0] < part.t[1]);
        stretches
            .map(|(part, weight)| ProbePoint {
                distance: middle(part),
                height_m: self.context.height_m(part.rho),
                value: part.values[field],
                length: part.t[1] - part.t[0],
                weight: weight
                    * part.shares.iter().filter(|(part, _)| shows(*part)).map(|(_, share)| share).sum::<f64>(),
            })
            .collect()
    }
}

/// Distance from the eye of a part's middle.
fn middle(part: &RayPart) -> f64 {
    0.5 * (part.t[0] + part.t[1])
}

/// The entry at which half of the weight of all is reached.
fn median<'p>(entries: &[(f64, &'p RayPart)], all: f64) -> &'p RayPart {
    let mut sum = 0.0;
    let found = entries.iter().find(|(weight, _)| {
        sum += weight;
        sum >= 0.5 * all
    });
    found.unwrap_or(&entries[0]).1
}

/// The cell whose centre is nearest to a place over their triangle.
fn nearest(grid: &Grid, cells: [u32; 3], place: DVec3) -> u32 {
    let [a, b, c] = cells;
    let nearer = |a: u32, b: u32| if grid.direction(b).dot(place) > grid.direction(a).dot(place) { b } else { a };
    nearer(nearer(a, b), c)
}
