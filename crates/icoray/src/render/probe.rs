//! Probes: the values along the ray through a point of a picture, and the origin of its light.

use super::context::RenderInputs;
use super::renderer::Renderer;
use super::work::ray;
use crate::derive;
use crate::fields::Fields;
use crate::plan::Plan;
use crate::ranges::FieldValues;
use crate::ranks::{Decomposition, GatherInputs, Ranks};
use glam::DVec3;
use icoray_grid::array::MapInline;
use icoray_grid::real::lerp;
use icoray_grid::{Error, ErrorKind, Field, Grid, Layers, Result};
use icoray_kernel::transfer::KernelKnot;
use icoray_kernel::{Frustum, Stretch, Traversal};
use icoray_scene::Scene;
use std::ops::ControlFlow;

/// Points reported of each frustum, and parts around each over which the light is summed.
const POINTS: usize = 4;
const PARTS: usize = 4;
/// Fraction of the light below which the probe stops.
const DARK: f64 = 1e-6;

/// The result of a ray through the first volume. Other volumes, surfaces, isosurfaces and cuts are ignored, and layers
/// lie at their mean heights.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// Longitude and latitude, degrees, of the place before which the ray loses half of the light that the volume
    /// absorbs; or of the intersection with the core, if that absorbs more than the volume.
    pub lon_lat_deg: [f64; 2],
    /// Height there above the planet's surface, metres.
    pub height_m: f64,
    /// The field's value there; `None` where it is missing.
    pub value: Option<f64>,
    /// Fraction of the light that the volume absorbs.
    pub alpha: f64,
    /// Whether the place is on the core.
    pub is_core: bool,
    /// The points of the ray through the shell, in order.
    pub along: Vec<ProbePoint>,
    /// Heights, metres, and values of the nearest column, from the innermost layer outwards; NaN for a missing value.
    pub column: Vec<[f64; 2]>,
}

/// A point of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProbePoint {
    /// Distance from the eye, planet radii.
    pub distance: f64,
    /// Height above the planet's surface, metres.
    pub height_m: f64,
    /// The field's value; NaN where it is missing.
    pub value: f64,
    /// Length of the part of the ray around this point, planet radii.
    pub length: f64,
    /// Fraction of the ray's light that is absorbed along that length.
    pub weight: f64,
}

/// The data that a ray is followed through.
struct Shell<'s> {
    field: Field<'s>,
    radius: &'s [f64],
    falling: bool,
    knots: &'s [KernelKnot],
    /// Metres of height per planet radius.
    metres: f64,
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
        let (fields, mut ranks) = (fields.into(), Ranks::alone());
        let of = derive::DeriveInputs { scene, fields: &fields, grid, part: None, threads: &self.threads };
        let made = derive::make(&mut ranks, &self.derived, &of)?;
        let with_derived = made.as_ref().map(|made| made.fields(&fields));
        let fields = with_derived.as_ref().unwrap_or(&fields);
        let given = RenderInputs { grid, part: None, layers, fields };
        let plan = Plan::new(scene, grid, layers, fields.first(scene.field())?)?;
        let prepared = self.prepare_fields(&mut ranks, scene, &given, true)?;
        let shown: Vec<(&str, Field)> = prepared.iter().map(|field| (field.name(), field.field())).collect();
        let values = |name: &str| {
            let (_, field) = shown.iter().find(|(known, _)| *known == name).unwrap_or(&shown[0]);
            Ok(FieldValues { threads: &self.threads, field, part: None })
        };
        let settled = self.ranges.resolve(&mut ranks, scene, &values)?;
        let transfer = &settled.as_ref().unwrap_or(scene).volumes[0].transfer;
        let shell = Shell {
            field: prepared[0].field(),
            radius: &plan.radius,
            falling: plan.falling,
            knots: &KernelKnot::of(transfer, plan.thickness()),
            metres: layers.planet_radius_m() / scene.exaggeration,
        };
        let place = [at[0] * f64::from(scene.width), at[1] * f64::from(scene.height)];
        let (eye, dir) = ray(scene, place);
        shell.probe(grid, (eye, dir), scene.core.is_some())
    }
}

impl Renderer {
    /// As [`Self::probe`], for the `grid` and layers of ranks with the decomposition `held`. Collective; the result is
    /// on rank 0, others have `None`. Ranks with columns or parts gather the fields as for a frame.
    ///
    /// # Errors
    /// Those of [`Self::probe`] on rank 0; on all ranks as [`Self::render_columns`], and [`ErrorKind::Unsupported`] if
    /// parts are on several nodes.
    pub fn probe_held<'f>(
        &self,
        ranks: &mut Ranks,
        scene: &Scene,
        (grid, held, layers): (&Grid, Option<&Decomposition>, &Layers),
        fields: impl Into<Fields<'f>>,
        at: [f64; 2],
    ) -> Result<Option<Probe>> {
        let (fields, is_root) = (fields.into(), ranks.is_root());
        let probe = |grid: &Grid, fields| if is_root { self.probe(scene, grid, layers, fields, at) } else { Ok(None) };
        let Some(Decomposition::Columns(columns)) = held else { return probe(grid, fields) };
        let derivation_inputs = scene.derivation_inputs().collect();
        let inputs = GatherInputs { threads: &self.threads, grid, layers, derivation_inputs };
        let gathered = columns.gather(ranks, &inputs, || fields.needed_by(scene))?;
        let found = match gathered.part() {
            Some(_) => {
                let why = "a ray cannot be probed where nodes have their parts of the grid";
                Err(Error::new(ErrorKind::Unsupported, why))
            }
            None => gathered.fields().and_then(|fields| probe(gathered.grid(grid), fields.needed_by(scene)?)),
        };
        gathered.leave(ranks);
        found
    }
}

impl Shell<'_> {
    fn probe(&self, grid: &Grid, (eye, dir): (DVec3, DVec3), is_solid: bool) -> Result<Option<Probe>> {
        let traversal = Traversal::new(grid, self.radius)?;
        let (mut along, mut left, mut core) = (Vec::new(), 1.0, None);
        let mut last = None;
        traversal.ray(eye, dir, &mut 0, |stretch| {
            match stretch {
                Stretch::Frustum(frustum) => {
                    last = Some(*frustum);
                    self.pass(frustum, &mut along, &mut left);
                }
                Stretch::Core { t } if is_solid => core = Some(*t),
                Stretch::Core { .. } => (),
            }
            if core.is_some() || left < DARK { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let alpha = 1.0 - left;
        let is_core = core.is_some() && left > alpha;
        let half = 0.5 * alpha;
        let mut sum = 0.0;
        let median = along.iter().find(|point: &&ProbePoint| {
            sum += point.weight;
            sum >= half && alpha > 0.0
        });
        let first = median.or(along.first()).copied();
        let distance = match core.filter(|_| is_core) {
            Some(distance) => distance,
            None => match first {
                Some(point) => point.distance,
                None => return Ok(None),
            },
        };
        let place = eye + distance * dir;
        let nearest = last.map(|_| nearest_cell(grid, &traversal, place));
        let column = nearest.map_or_else(Vec::new, |cell| self.column(cell as usize));
        let (value, height_m) = match core.filter(|_| is_core) {
            Some(_) => (along.last().map_or(f64::NAN, |point| point.value), self.height_m(self.radius[0])),
            None => first.map_or((f64::NAN, f64::NAN), |point| (point.value, point.height_m)),
        };
        Ok(Some(Probe {
            lon_lat_deg: [place.y.atan2(place.x), (place.z / place.length()).asin()].map(f64::to_degrees),
            height_m,
            value: Some(value).filter(|value| value.is_finite()),
            alpha,
            is_core,
            along,
            column,
        }))
    }

    /// Adds the points and the light of a frustum.
    fn pass(&self, frustum: &Frustum, along: &mut Vec<ProbePoint>, left: &mut f64) {
        let [t0, t1] = frustum.t;
        let step = (t1 - t0) / (POINTS * PARTS) as f64;
        let at = |part: f64| {
            let [from, to] = frustum.alpha;
            self.value(frustum, [0, 1, 2].map_inline(|i| lerp(from[i], to[i], part)))
        };
        for point in 0..POINTS {
            let before = *left;
            for part in 0..PARTS {
                let (_, value) = at(((PARTS * point + part) as f64 + 0.5) / (POINTS * PARTS) as f64);
                let extinction = if value.is_finite() { extinction(self.knots, value) } else { 0.0 };
                *left *= (-extinction * step).exp();
            }
            let middle = (point as f64 + 0.5) / POINTS as f64;
            let (rho, value) = at(middle);
            along.push(ProbePoint {
                distance: lerp(t0, t1, middle),
                height_m: self.height_m(rho),
                value,
                length: step * PARTS as f64,
                weight: before - *left,
            });
        }
    }

    /// Height ρ and value at a point of a frustum.
    fn value(&self, frustum: &Frustum, alpha: [f64; 3]) -> (f64, f64) {
        let rho: f64 = alpha.iter().sum();
        let [low, high] = [0, 1].map_inline(|k| self.radius[frustum.layer + k]);
        let part = ((rho - low) / (high - low)).clamp(0.0, 1.0);
        let of = |layer: usize, k: usize| self.at(frustum.cells[k] as usize, layer);
        let values = [0, 1, 2].map_inline(|k| lerp(of(frustum.layer, k), of(frustum.layer + 1, k), part));
        (rho, (0..3).map(|k| alpha[k] / rho * values[k]).sum())
    }

    /// The value of a cell at a layer, counted from the innermost.
    fn at(&self, cell: usize, layer: usize) -> f64 {
        let stored = if self.falling { self.radius.len() - 1 - layer } else { layer };
        self.field.value(cell, stored)
    }

    fn column(&self, cell: usize) -> Vec<[f64; 2]> {
        let layers = self.radius.iter().enumerate();
        layers.map(|(layer, radius)| [self.height_m(*radius), self.at(cell, layer)]).collect()
    }

    fn height_m(&self, rho: f64) -> f64 {
        (rho - 1.0) * self.metres
    }
}

/// The cell whose centre is nearest to a place, among those of the triangle over it.
fn nearest_cell(grid: &Grid, traversal: &Traversal, place: DVec3) -> u32 {
    let up = place.normalize();
    let mut cells = [0; 3];
    traversal.ray(2.0 * traversal.outer() * up, -up, &mut 0, |stretch| match stretch {
        Stretch::Frustum(frustum) => {
            cells = frustum.cells;
            ControlFlow::Break(())
        }
        Stretch::Core { .. } => ControlFlow::Continue(()),
    });
    let [a, b, c] = cells;
    let nearer = |a: u32, b: u32| if grid.direction(b).dot(up) > grid.direction(a).dot(up) { b } else { a };
    nearer(nearer(a, b), c)
}

/// The extinction at a value, per planet radius.
fn extinction(knots: &[KernelKnot], value: f64) -> f64 {
    let above = knots.partition_point(|knot| knot.value <= value);
    let (Some(low), Some(high)) = (knots.get(above.wrapping_sub(1)), knots.get(above)) else {
        let beyond = if above == 0 { knots.first() } else { knots.last() };
        return beyond.map_or(0.0, |knot| knot.extinction);
    };
    lerp(low.extinction, high.extinction, (value - low.value) / (high.value - low.value))
}
