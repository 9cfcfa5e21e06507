//! The general kernel: rays through several volumes, surfaces, lines and cuts, over layers of any shape.
//!
//! It walks over the same triangles as the kernel of one field ([`ray`](super::ray)) and interpolates alike, but one ray after the
//! other, in double precision throughout, and asks of each frustum what of all that is shown can be met there. What a ray
//! meets inside one is put in order: the places where a field takes the value of a knot or of an isosurface, all of them roots of the
//! same quadratic (`segment.rs`), part it into pieces, each for [`blend`], with surfaces between them. So volumes and
//! surfaces hide each other exactly where they lie.

mod blend;
mod cast;
mod clips;
mod frustum;
mod levels;
mod source;
mod surfaces;
mod wedge;

pub(crate) use blend::Medium;
pub(crate) use clips::Clips;
pub(crate) use levels::Levels;
pub(crate) use source::{Map, Source};
pub(crate) use surfaces::{Coat, Isosurface, Sheet, SheetPlace};

use super::column::Flow;
use super::leap::Visible;
use super::piece::Light;
use super::plane::RayLine;
use super::ray::{Budget, Counts};
use super::shade::{RayShading, Shading};
use super::signature::{Boundary, FromEye, Signature};
use super::walk::Column;
use crate::array::MapInline;
use crate::grid::Grid;
use crate::ground::{Ground, Sight};
use clips::RayClips;
use frustum::Scratch;
use glam::{DVec3, Vec3};
use wedge::{Facet, On, Wedge};

/// All that is shown, the same for all rays of a frame.
#[derive(Debug)]
pub(crate) struct World<'f> {
    pub grid: &'f Grid<'f>,
    pub levels: Levels<'f>,
    pub sources: Vec<Source<'f>>,
    pub media: Vec<Medium>,
    pub isosurfaces: Vec<Isosurface>,
    pub sheets: Vec<Sheet>,
    pub clips: Clips,
    /// Where each of the volumes and isosurfaces can be seen; one of all there is where more may be met.
    pub visible: Vec<Visible>,
    /// Normals at the vertices of layers that light falls on, where these are not round.
    pub normals: Vec<(usize, Vec<[f32; 3]>)>,
    /// Linear RGB of the opaque core; `None` lets rays through the hollow core.
    pub core: Option<[f64; 3]>,
    /// What the core looks like where it has more than one colour.
    pub ground: Option<&'f Ground>,
    /// Least and greatest radius of the innermost layer: under holes of the mesh the core is round, of the least.
    pub core_radius: [f64; 2],
    /// The greatest radius of all.
    pub outer: f64,
}

impl World<'_> {
    /// Whether `gap` can be seen by these blocks, which are of the same gaps for all that is shown.
    #[inline]
    fn shows(&self, blocks: u32, gap: usize) -> bool {
        self.visible.first().is_some_and(|visible| visible.shows(blocks, gap))
    }
}

/// How a picture's rays are traced.
#[derive(Debug)]
pub(crate) struct Tracer<'w, 'f> {
    pub world: &'w World<'f>,
    pub shading: Option<Shading>,
    pub budget: Budget,
}

/// One ray.
struct Run<'r, 'f> {
    world: &'r World<'f>,
    line: RayLine,
    shading: Option<RayShading<f64>>,
    /// Whether light comes from the eye: then surfaces are lit on the side that is seen.
    has_headlight: bool,
    clips: RayClips<'r>,
    budget: Budget,
    share: f64,
    rest: f64,
    light: Light<f64>,
    /// The surfaces that the ray has met and that are seen.
    surfaces: Signature,
    from_eye: FromEye,
    /// Whether the ray was last seen in what is cut away.
    is_cut: bool,
    counts: Counts,
    scratch: Scratch<'r>,
}

impl<'r, 'f> Run<'r, 'f> {
    #[inline]
    fn new(tracer: &Tracer<'r, 'f>, line: RayLine, eye: DVec3, dir: DVec3) -> Self {
        let share = tracer.budget.share.max(f64::EPSILON);
        Run {
            world: tracer.world,
            line,
            // Of isosurfaces nothing else would tell what is left out of a highlight.
            shading: tracer.shading.map(|shading| shading.along(dir, 0.0)),
            has_headlight: tracer.shading.is_some_and(|shading| shading.towards_light.is_none()),
            clips: tracer.world.clips.along(&line),
            budget: tracer.budget,
            share,
            rest: tracer.budget.rest,
            light: Light::none(),
            surfaces: Signature::default(),
            from_eye: FromEye::new(eye, dir),
            is_cut: false,
            counts: Counts { rays: 1, ..Counts::default() },
            scratch: Scratch::default(),
        }
    }

    /// Passes a column over a triangle with data, from the gap `hint` on or near it; gives the gap at its end.
    #[inline]
    fn column(&mut self, column: &Column, triangle: u32, hint: usize) -> (usize, Flow) {
        self.counts.columns += 1;
        let world = self.world;
        let wedge = Wedge::new(column, triangle);
        let levels = &world.levels;
        let facet = |layer: usize| Facet::new(&wedge, levels.inverse(wedge.cells, layer));
        let blocks = world.visible.iter().fold(0, |all, visible| all | visible.over(triangle));
        if blocks == 0 && world.sheets.is_empty() {
            return (hint, self.clear_column(&wedge, &facet(0)));
        }
        let top = levels.count();
        let mut gap = gap_at(hint, top, |layer| facet(layer).is_below_entry());
        let mut lower = gap.checked_sub(1).map(facet);
        let mut upper = (gap < top).then(|| facet(gap));
        let (mut a, mut from) = (0.0, On::Between);
        self.scratch.forget();
        loop {
            let up = upper.and_then(|facet| facet.up());
            let down = lower.and_then(|facet| facet.down());
            let rises = up.is_some_and(|up| down.is_none_or(|down| up <= down));
            let crossing = if rises { up } else { down };
            let b = crossing.map_or(1.0, |u| u.max(a));
            let to = match crossing {
                Some(_) if rises => On::Upper,
                Some(_) => On::Lower,
                None => On::Between,
            };
            let flow = match (&lower, &upper) {
                (None, _) => self.core(&wedge, upper.as_ref(), a),
                (Some(_), None) => Flow::On,
                (Some(_), Some(_)) if !world.shows(blocks, gap) => Flow::On,
                (Some(lower), Some(upper)) => self.gap(&wedge, (gap, [lower, upper]), [(a, from), (b, to)]),
            };
            if flow == Flow::Stop || crossing.is_none() {
                return (gap, flow);
            }
            let (layer, met) = if rises { (gap, upper) } else { (gap - 1, lower) };
            if let Some(met) = met
                && self.layer(&wedge, (layer, &met), b) == Flow::Stop
            {
                return (gap, Flow::Stop);
            }
            if rises {
                gap += 1;
                (lower, upper) = (upper, (gap < top).then(|| facet(gap)));
            } else {
                gap -= 1;
                (upper, lower) = (lower, gap.checked_sub(1).map(facet));
            }
            self.scratch.shift(rises);
            (a, from) = (b, if rises { On::Lower } else { On::Upper });
        }
    }

    /// Over a triangle above which nothing is seen.
    #[inline]
    fn clear_column(&mut self, wedge: &Wedge, lowest: &Facet) -> Flow {
        let met = if lowest.is_below_entry() { lowest.down() } else { Some(0.0) };
        met.map_or(Flow::On, |u| self.core(wedge, Some(lowest), u))
    }

    /// Over a void triangle nothing is met but the core, which is round there.
    #[inline]
    fn void_column(&mut self, column: &Column) -> Flow {
        self.counts.columns += 1;
        let met = self.line.first_inside(self.world.core_radius[0], [column.entry.t, column.exit.t]);
        met.map_or(Flow::On, |t| self.ground(t, &Sight::round(self.line.position(t)), None))
    }

    /// Below the lowest layer, from `u` on.
    #[inline]
    fn core(&mut self, wedge: &Wedge, lowest: Option<&Facet>, u: f64) -> Flow {
        let t = wedge.distance(u);
        let position = self.line.position(t);
        let normal = lowest.map_or(position, |facet| self.normal(wedge, (0, facet), u, position));
        self.ground(t, &Sight { position, normal }, Some(wedge.triangle))
    }

    /// The ray meets a boundary at `t`.
    #[inline]
    fn meets(&mut self, boundary: Boundary, t: f64) {
        if self.budget.sees_behind(self.light.absorbed) {
            self.surfaces.meet(boundary, self.from_eye.distance(t));
        }
    }

    /// An opaque core ends the ray, a hollow one lets it pass.
    #[inline]
    fn ground(&mut self, t: f64, sight: &Sight, triangle: Option<u32>) -> Flow {
        let Some(core) = self.world.core else { return Flow::On };
        self.meets(Boundary::Core, t);
        let over = triangle.map(|triangle| (self.world.grid, triangle));
        let color = self.world.ground.map_or(core, |ground| ground.color(sight, over));
        let body = self.solid(sight.normal);
        self.light.over(&Light::plain(color.map_inline(|c| c * body), 1.0));
        Flow::Stop
    }

    /// The normal of a layer, outwards, where it is met: concentric ones are as good as round.
    #[inline]
    fn normal(&self, wedge: &Wedge, (layer, facet): (usize, &Facet), u: f64, position: DVec3) -> DVec3 {
        let known = self.world.normals.iter().find(|(known, _)| *known == layer);
        let Some((_, normals)) = known else { return position };
        let [b, c] = facet.weights(wedge, u);
        let [x, y, z] = wedge.cells.map_inline(|cell| Vec3::from_array(normals[cell as usize]).as_dvec3());
        x + b * (y - x) + c * (z - x)
    }

    /// The part of its colour that a surface shows.
    #[inline]
    fn solid(&self, normal: DVec3) -> f64 {
        let normal = normal.normalize_or_zero();
        let is_seen_inside = self.has_headlight && normal.dot(self.line.plane.y) > 0.0;
        self.shading
            .as_ref()
            .map_or(1.0, |shading| shading.solid(if is_seen_inside { -normal } else { normal }))
    }

    /// What lies on a layer that the ray crosses at `u`.
    #[inline]
    fn layer(&mut self, wedge: &Wedge, (layer, facet): (usize, &Facet), u: f64) -> Flow {
        let world = self.world;
        let t = wedge.distance(u);
        if !world.sheets.iter().any(|sheet| sheet.place == SheetPlace::Layer(layer))
            || !self.clips.shows([layer, layer], t)
        {
            return Flow::On;
        }
        let position = self.line.position(t);
        let sight = Sight { position, normal: self.normal(wedge, (layer, facet), u, position) };
        let body = self.solid(sight.normal);
        for (k, sheet) in world.sheets.iter().enumerate() {
            if sheet.place == SheetPlace::Layer(layer) {
                let color = |coat: &Coat| coat.on_layer(&world.sources, world.grid, wedge, (layer, facet), u);
                let met = sheet.light(body, (&sight, (world.grid, wedge.triangle)), color);
                self.sheet(k, met, t);
            }
        }
        self.passed()
    }

    /// The light of sheet `k`, met at `t`, and the coats that are painted there.
    #[inline]
    fn sheet(&mut self, k: usize, (light, coats): (Light<f64>, u32), t: f64) {
        // Lines are smooth by themselves.
        if coats != 0 {
            self.meets(Boundary::Sheet(k, coats), t);
        }
        self.light.over(&light);
    }

    /// Behind something: whether the ray ends there.
    #[inline]
    fn passed(&mut self) -> Flow {
        let through = 1.0 - self.light.absorbed;
        if through > self.rest {
            return Flow::On;
        }
        self.light.error += through * self.budget.brightest;
        Flow::Stop
    }
}

/// The number of layers that the ray enters a column above, searched from `hint` on.
#[inline]
fn gap_at(hint: usize, layers: usize, is_below: impl Fn(usize) -> bool) -> usize {
    let hint = hint.min(layers);
    if (hint == 0 || is_below(hint - 1)) && (hint == layers || !is_below(hint)) {
        return hint;
    }
    let (mut low, mut high) = (0, layers);
    while low < high {
        let middle = (low + high) / 2;
        if is_below(middle) { low = middle + 1 } else { high = middle }
    }
    low
}
