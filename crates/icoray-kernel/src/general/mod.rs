//! Single rays: through volumes, surfaces, lines and cuts, over layers of any shape, in double precision.
//!
//! In each frustum a ray collects the places at which a field takes the value of a knot or of an isosurface, all of them
//! roots of the same quadratic (`segment.rs`). In order along the ray, these places divide the frustum into pieces, with
//! surfaces between them. So volumes and surfaces hide each other exactly. `blend` integrates the pieces of several
//! volumes; one volume alone is integrated by its own rules (`single`), which need no places of knots. In single precision
//! packets of rays pass the frusta that contain only volumes, and leave the rest to these rays (`step.rs`).

mod blend;
mod clips;
mod cross;
mod frustum;
mod levels;
mod mean_color;
mod painted;
mod passage;
mod single;
mod source;
mod step;
mod surfaces;
mod wedge;

pub use blend::Medium;
pub use clips::{ClipRegion, Clips};
pub(crate) use cross::{ColumnVisitor, cross};
pub use levels::Levels;
pub(crate) use mean_color::{MeanColor, Nodes, Panel};
pub use painted::PaintedPlace;
pub use passage::{Passage, PassageKind};
pub use source::{FieldSource, TransferMap};
pub(crate) use step::Met;
pub use surfaces::{Isosurface, Material, SurfaceHeight, SurfaceLayer};
pub(crate) use wedge::{Facet, FacetSide, Wedge};

use crate::budget::Budget;
use crate::column::Flow;
use crate::counts::Counts;
use crate::ground::{Core, SurfaceHit};
use crate::piece::Radiance;
use crate::plane::RayLine;
use crate::shade::{RayShading, Shading};
use crate::signature::{Boundary, BoundarySignature, EyeDistance};
use crate::trace::queue::PrimaryRay;
use crate::volume_ray::VolumeRay;
use crate::walk::Column;
use clips::RayClips;
use frustum::Scratch;
use glam::{DVec3, Vec3};
use icoray_grid::Grid;
use icoray_grid::array::MapInline;
use icoray_grid::occupancy::OccupancyMask;
use icoray_scene::Method;
use std::borrow::Cow;

/// The contents of a picture, equal for all rays of a frame.
#[derive(Debug)]
pub struct KernelScene<'f> {
    /// Tables and directions.
    pub grid: &'f Grid<'f>,
    /// Radii of layers, common to all columns or different in each.
    pub levels: Levels<'f>,
    /// The fields, in the order of their numbers.
    pub sources: Vec<FieldSource<'f>>,
    /// Volumes, whose extinctions add up.
    pub media: Vec<Medium>,
    /// Surfaces of constant value.
    pub isosurfaces: Vec<Isosurface>,
    /// Coloured levels, and lines on levels.
    pub surface_layers: Vec<SurfaceLayer>,
    /// The parts of space that are cut away.
    pub clips: Clips,
    /// The blocks of gaps in which any of the volumes and isosurfaces is visible.
    pub visible: OccupancyMask<'f>,
    /// The blocks of gaps that other surfaces adjoin, in all columns.
    pub beside: u32,
    /// Normals at the vertices of lit layers that are not spheres: number of the layer, and a unit vector per cell.
    pub normals: Vec<(usize, Cow<'f, [[f32; 3]]>)>,
    /// The opaque core; `None` lets rays through the hollow core.
    pub core: Option<Core<'f>>,
    /// Least and greatest radius of the innermost layer, planet radii. Under holes of the mesh the core is a sphere of
    /// the least radius.
    pub core_radius: [f64; 2],
    /// Radius of the visible space, planet radii.
    pub outer: f64,
}

impl KernelScene<'_> {
    /// Whether there is at most one volume, whose opacity is that of its own field.
    pub fn has_one_field_of_volume(&self) -> bool {
        match self.media.as_slice() {
            [] => true,
            [medium] => medium.has_own_color(),
            _ => false,
        }
    }

    /// Whether there is that volume, between concentric layers, and nothing else but the core.
    pub fn is_volume_alone(&self) -> bool {
        self.has_one_field_of_volume()
            && !self.media.is_empty()
            && matches!(self.levels, Levels::Concentric(_))
            && self.isosurfaces.is_empty()
            && self.surface_layers.is_empty()
            && self.clips.regions().is_empty()
    }

    /// Bits of the visible blocks of gaps over a triangle with data.
    #[inline(always)]
    pub(crate) fn blocks_over(&self, triangle: u32) -> u32 {
        self.visible.blocks_over(triangle) | self.beside
    }
}

/// A scene, and the settings for tracing its rays.
#[derive(Debug, Clone, Copy)]
pub struct RaySettings<'w, 'f> {
    /// The scene's volumes, surfaces and cuts.
    pub scene: &'w KernelScene<'f>,
    /// Lighting; `None` shows the transfer functions' own colours.
    pub shading: Option<Shading>,
    /// Division of the tolerance along a ray.
    pub budget: Budget,
    /// The rule of integration of a single volume.
    pub method: Method,
    /// When set, pieces of a single volume are not cut where the gradient turns.
    pub is_coarse: bool,
}

/// One ray.
pub(crate) struct RayState<'r, 'f> {
    scene: &'r KernelScene<'f>,
    line: RayLine,
    shading: Option<RayShading<f64>>,
    /// Whether light comes from the eye: then surfaces are lit on the visible side.
    has_headlight: bool,
    clips: RayClips<'r>,
    budget: Budget,
    color_tolerance: f64,
    min_transmittance: f64,
    light: Radiance<f64>,
    /// The visible surfaces that the ray has met.
    surfaces: BoundarySignature,
    from_eye: EyeDistance,
    /// Whether the ray is in space that is cut away.
    is_cut: bool,
    /// The gap at the exit of the last column with data: where the search for the next one starts.
    gap: usize,
    /// The scene's volume, if it has one alone, in the colours of its own field.
    single: Option<VolumeRay<'r, f64>>,
    counts: Counts,
    scratch: Scratch<'r>,
    /// The places that the ray has passed, if they are recorded.
    passages: Option<Vec<Passage>>,
}

impl<'r, 'f> RayState<'r, 'f> {
    /// The ray at its start; `line` is the same ray in its plane.
    #[inline]
    pub fn new(tracer: &RaySettings<'r, 'f>, line: RayLine, start: &PrimaryRay) -> Self {
        Self::from_eye(tracer, line, start.dir, EyeDistance::new(start.eye, start.dir))
    }

    #[inline]
    fn from_eye(tracer: &RaySettings<'r, 'f>, line: RayLine, dir: DVec3, from_eye: EyeDistance) -> Self {
        let color_tolerance = tracer.budget.color_tolerance_in::<f64>(tracer.shading.as_ref());
        let single = tracer.scene.media.first().filter(|_| tracer.scene.has_one_field_of_volume());
        RayState {
            scene: tracer.scene,
            line,
            // Omitted highlights have no error estimate on isosurfaces, so none is omitted.
            shading: tracer.shading.map(|shading| shading.along(dir)),
            has_headlight: tracer.shading.is_some_and(|shading| shading.towards_light.is_none()),
            clips: tracer.scene.clips.along(&line),
            budget: tracer.budget,
            color_tolerance,
            min_transmittance: tracer.budget.min_transmittance,
            light: Radiance::none(),
            surfaces: BoundarySignature::default(),
            from_eye,
            is_cut: false,
            gap: 0,
            single: single.map(|medium| VolumeRay::new(medium.extinction.spans(), tracer, dir)),
            counts: Counts { rays: 1, ..Counts::default() },
            scratch: Scratch::default(),
            passages: None,
        }
    }

    /// The same ray, whose passages are recorded.
    pub fn recorded(self) -> Self {
        RayState { passages: Some(Vec::new()), ..self }
    }

    /// The places that the ray has passed, in order.
    pub fn into_passages(self) -> Vec<Passage> {
        self.passages.unwrap_or_default()
    }

    /// Records what the ray has passed or met since its light had this transmittance, if that is recorded; `passage`
    /// receives the absorbed fraction.
    #[inline]
    fn record(&mut self, before: f64, passage: impl FnOnce(&Self, f64) -> Passage) {
        if self.passages.is_none() {
            return;
        }
        let alpha = if before > 0.0 { 1.0 - self.light.transmittance() / before } else { 0.0 };
        let passage = passage(self, alpha);
        if let Some(passages) = &mut self.passages {
            passages.push(passage);
        }
    }

    /// Records a place of the column at which a field has these values.
    #[inline]
    fn record_at(
        &mut self,
        before: f64,
        kind: PassageKind,
        wedge: &Wedge,
        u: f64,
        values: impl FnOnce(&Self) -> Vec<f64>,
    ) {
        self.record(before, |ray, alpha| {
            let (t, rho) = (wedge.distance(u), wedge.alpha(u).iter().sum());
            Passage { kind, cells: Some(wedge.cells), t: [t; 2], rho, alpha, values: values(ray) }
        });
    }

    /// Passes a column in which only the core can be visible.
    #[inline]
    fn clear_column(&mut self, wedge: &Wedge, lowest: &Facet) -> Flow {
        let met = if lowest.is_below_entry() { lowest.down() } else { Some(0.0) };
        met.map_or(Flow::On, |u| self.core(wedge, lowest, u))
    }

    /// Continues below the lowest layer from `u` on.
    #[inline]
    fn core(&mut self, wedge: &Wedge, lowest: &Facet, u: f64) -> Flow {
        let t = wedge.distance(u);
        let position = self.line.position(t);
        let normal = self.normal(wedge, lowest, u, position);
        let before = self.light.transmittance();
        let flow = self.ground(t, &SurfaceHit { position, normal }, Some(wedge.triangle));
        if flow == Flow::Stop {
            self.record_at(before, PassageKind::Core, wedge, u, |ray| ray.scene.values_on_layer(wedge, lowest, u));
        }
        flow
    }

    /// Records a boundary at `t`.
    #[inline]
    fn cross_boundary(&mut self, boundary: Boundary, t: f64) {
        if Budget::sees_behind(self.light.alpha) {
            self.surfaces.push(boundary, self.from_eye.distance(t));
        }
    }

    /// Ends the ray at an opaque core, or passes a hollow one.
    #[inline]
    fn ground(&mut self, t: f64, hit: &SurfaceHit, triangle: Option<u32>) -> Flow {
        let Some(core) = self.scene.core else { return Flow::On };
        self.cross_boundary(Boundary::Core, t);
        let over = triangle.map(|triangle| (self.scene.grid, triangle));
        let body = self.shading.as_ref().map_or(1.0, |shading| shading.solid(hit.normal.normalize_or_zero()));
        self.light.over(&core.light(hit, over, body));
        Flow::Stop
    }

    /// The outward normal of a layer at `position`; that of a sphere if layers are concentric.
    #[inline]
    fn normal(&self, wedge: &Wedge, facet: &Facet, u: f64, position: DVec3) -> DVec3 {
        let known = self.scene.normals.iter().find(|(layer, _)| *layer == facet.layer);
        let Some((_, normals)) = known else { return position };
        let [b, c] = facet.weights(wedge, u);
        let [x, y, z] = wedge.cells.map_inline(|cell| Vec3::from_array(normals[cell as usize]).as_dvec3());
        x + b * (y - x) + c * (z - x)
    }

    /// The factor that lighting gives to the colour of a surface; a headlight lights both sides.
    #[inline]
    fn solid(&self, normal: DVec3) -> f64 {
        let normal = normal.normalize_or_zero();
        let is_seen_inside = self.has_headlight && normal.dot(self.line.plane.y) > 0.0;
        self.shading.as_ref().map_or(1.0, |shading| shading.solid(if is_seen_inside { -normal } else { normal }))
    }

    /// Adds the light of the surfaces on a layer that the ray crosses at `u`.
    #[inline]
    fn layer(&mut self, wedge: &Wedge, facet: &Facet, u: f64) -> Flow {
        let (scene, layer) = (self.scene, facet.layer);
        let t = wedge.distance(u);
        if !scene.surface_layers.iter().any(|surface| surface.place == SurfaceHeight::Layer(layer))
            || !self.clips.shows([layer, layer], t)
        {
            return Flow::On;
        }
        let position = self.line.position(t);
        let hit = SurfaceHit { position, normal: self.normal(wedge, facet, u, position) };
        let body = self.solid(hit.normal);
        for (k, surface) in scene.surface_layers.iter().enumerate() {
            if surface.place == SurfaceHeight::Layer(layer) {
                let color = |material: &Material| material.on_layer(&scene.sources, scene.grid, wedge, facet, u);
                let (light, materials) = surface.light(body, (&hit, (scene.grid, wedge.triangle)), color);
                let values = |ray: &Self| ray.scene.values_on_layer(wedge, facet, u);
                self.surface_layer(k, light, materials, wedge, u, values);
            }
        }
        self.passed()
    }

    /// Adds the light of surface layer `k` at `u`, where fields have `values`; `materials` are the bits of the materials
    /// that are painted there.
    #[inline]
    fn surface_layer(
        &mut self,
        k: usize,
        light: Radiance<f64>,
        materials: u32,
        wedge: &Wedge,
        u: f64,
        values: impl FnOnce(&Self) -> Vec<f64>,
    ) {
        // Lines are already smooth.
        if materials != 0 {
            self.cross_boundary(Boundary::SurfaceLayer(k, materials), wedge.distance(u));
        }
        let before = self.light.transmittance();
        self.light.over(&light);
        self.record_at(before, PassageKind::SurfaceLayer(k, materials), wedge, u, values);
    }

    /// The ray passes where no volume is.
    #[inline]
    fn pass_void(&mut self) {
        if let Some(single) = &mut self.single {
            single.span = None;
        }
    }

    /// Whether the ray ends behind a piece or a surface.
    #[inline]
    fn passed(&mut self) -> Flow {
        if self.light.ends(self.min_transmittance, self.budget.brightest) { Flow::Stop } else { Flow::On }
    }
}

impl RayState<'_, '_> {
    /// Bits of the visible blocks of gaps over a triangle.
    #[inline]
    pub fn blocks(&self, triangle: u32) -> u32 {
        self.scene.blocks_over(triangle)
    }

    /// Passes a column over a triangle with data.
    #[inline]
    pub fn column(&mut self, column: &Column, triangle: u32, blocks: u32) -> Flow {
        self.counts.columns += 1;
        let scene = self.scene;
        let wedge = Wedge::new(column, triangle);
        if blocks == 0 && scene.surface_layers.is_empty() {
            let levels = &scene.levels;
            return self.clear_column(&wedge, &Facet::new(&wedge, levels, 0));
        }
        self.scratch.forget();
        let hint = self.gap;
        let (gap, flow) = cross(&wedge, &scene.levels, hint, &mut VisibleParts { ray: self, blocks });
        self.gap = gap;
        flow
    }

    /// Passes a column over a void triangle: only the core, a sphere there, can be met.
    #[inline]
    pub fn void_column(&mut self, column: &Column) -> Flow {
        self.counts.columns += 1;
        let rho = self.scene.core_radius[0];
        let Some(t) = self.line.first_inside(rho, [column.entry.t, column.exit.t]) else { return Flow::On };
        let before = self.light.transmittance();
        let flow = self.ground(t, &SurfaceHit::round(self.line.position(t)), None);
        if flow == Flow::Stop {
            self.record(before, |ray, alpha| {
                let values = vec![f64::NAN; ray.scene.sources.len()];
                Passage { kind: PassageKind::Core, cells: None, t: [t; 2], rho, alpha, values }
            });
        }
        flow
    }

    /// The counts since the ray began.
    #[inline]
    pub fn counts(&mut self) -> &mut Counts {
        &mut self.counts
    }

    /// Light and surfaces since the ray's start, or since it was restarted.
    #[inline]
    pub fn met(&self) -> (&Radiance<f64>, BoundarySignature) {
        (&self.light, self.surfaces)
    }

    /// Starts a new fragment without light. The transmittance at which the ray ends counts from its start.
    #[inline]
    pub fn restart(&mut self) {
        self.min_transmittance /= self.light.transmittance();
        (self.light, self.surfaces, self.is_cut) = (Radiance::none(), BoundarySignature::default(), false);
        self.pass_void();
    }
}

/// A ray in a column with these visible blocks.
struct VisibleParts<'c, 'r, 'f> {
    ray: &'c mut RayState<'r, 'f>,
    blocks: u32,
}

impl ColumnVisitor for VisibleParts<'_, '_, '_> {
    #[inline]
    fn gap(&mut self, wedge: &Wedge, facets: [&Facet; 2], ends: [(f64, FacetSide); 2]) -> Flow {
        if self.ray.scene.visible.is_occupied(self.blocks, facets[1].layer) {
            return self.ray.gap(wedge, facets, ends);
        }
        self.ray.pass_void();
        Flow::On
    }

    #[inline]
    fn layer(&mut self, wedge: &Wedge, facet: &Facet, u: f64, rises: bool) -> Flow {
        let flow = self.ray.layer(wedge, facet, u);
        self.ray.scratch.shift(rises);
        flow
    }

    #[inline]
    fn core(&mut self, wedge: &Wedge, lowest: &Facet, u: f64) -> Flow {
        self.ray.core(wedge, lowest, u)
    }
}
