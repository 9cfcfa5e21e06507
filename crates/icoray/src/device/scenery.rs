//! Surfaces, isosurfaces, cuts and further volumes of a scene, as tables for a device.

use super::fields::{FieldTable, Normal};
use super::{ENDLESS, FallbackReason, FieldId, SceneField, Span, Step};
use icoray_grid::array::MapInline;
use icoray_kernel::general::{self, ClipRegion, KernelScene, Levels, Medium, SurfaceHeight, TransferMap};
use icoray_kernel::transfer::{KernelKnot, Spans};
use icoray_scene::Scene;
use rayon::prelude::*;

/// Maximum number of volumes that a device takes.
pub const MAX_VOLUMES: usize = 4;

/// Maximum number of cuts that a device takes.
pub const MAX_CLIPS: usize = 8;

/// Maximum number of surfaces on layers that a device takes.
pub const MAX_SURFACES: usize = 8;

/// All parts of a scene but one volume and the core.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scenery {
    /// The cuts.
    pub clips: Vec<ClipRegion>,
    /// The layers and spheres with surfaces on them.
    pub surface_layers: Vec<SurfaceLayer>,
    /// The isosurfaces.
    pub isosurfaces: Vec<Isosurface>,
    /// The volumes, if there are several or the opacity of the only one is that of another field; else empty, and
    /// [`Job::spans`](super::Job::spans) describes the only one.
    pub volumes: Vec<SceneVolume>,
    /// The fields that volumes and isosurfaces need beside the job's.
    pub fields: Vec<SceneField>,
    /// The layers, if they lie at other heights over each cell.
    pub native: Option<NativeLayers>,
}

/// Layers at other heights over each cell.
#[derive(Debug, Clone, PartialEq)]
pub struct NativeLayers {
    /// 1 / radius of each layer over each cell, planet radii, level-fastest, from the innermost layer outwards.
    pub inverse: Vec<f64>,
    /// Least and greatest radius of the core.
    pub core_radius: [f64; 2],
    /// Radius of the visible space.
    pub outer: f64,
    /// For lit scenes, normals of the core (layer 0) and of layers with surfaces: the layer, and a unit vector per
    /// cell.
    pub normals: Vec<(usize, Vec<[f32; 3]>)>,
}

impl NativeLayers {
    fn new(scene: &KernelScene) -> Option<Self> {
        let Levels::Native(heights) = &scene.levels else { return None };
        let (cells, layers) = (scene.grid.cells(), scene.levels.count());
        let all = (0..cells * layers).into_par_iter();
        let inverse = all.map(|at| 1.0 / heights.radius((at / layers) as u32, at % layers)).collect();
        let KernelScene { core_radius, outer, ref normals, .. } = *scene;
        let normals = normals.iter().map(|(layer, normals)| (*layer, normals.to_vec())).collect();
        Some(NativeLayers { inverse, core_radius, outer, normals })
    }
}

impl Scenery {
    /// Collects the scenery. `knots` are those of the job's transfer function, and `range` returns the least and the
    /// greatest value of each field.
    ///
    /// # Errors
    /// A [`FallbackReason`] if devices do not support it.
    pub(crate) fn new(
        scene: &KernelScene,
        knots: &[KernelKnot],
        is_lit: bool,
        range: impl Fn(usize) -> Option<[f64; 2]>,
    ) -> Result<Self, FallbackReason> {
        let levels = scene.surface_layers.len();
        if levels > MAX_SURFACES {
            let reason =
                format!("the scene has surfaces and lines on {levels} levels, expected at most {MAX_SURFACES}");
            return Err(FallbackReason::new(reason));
        }
        let mut fields = FieldTable::new(scene, Spans::<f32>::new(knots).range());
        let volumes = SceneVolume::all(scene, knots, &mut fields);
        let surface = |surface| SurfaceLayer::new(surface, &mut fields, &range);
        let surface_layers = scene.surface_layers.iter().map(surface).collect();
        let surfaces = scene.isosurfaces.iter();
        let isosurfaces = surfaces.map(|surface| Isosurface::new(surface, &mut fields, &range)).collect();
        let (fields, native) = (fields.fields(is_lit)?, NativeLayers::new(scene));
        let clips = scene.clips.regions().to_vec();
        Ok(Scenery { clips, surface_layers, isosurfaces, volumes, fields, native })
    }
}

/// A layer or a sphere with all surfaces on it.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceLayer {
    /// Its position.
    pub place: SurfaceHeight,
    /// The surfaces, the first in front.
    pub materials: Vec<Material>,
    /// Whether there are lines in front of them.
    pub is_painted: bool,
}

/// Colours and opacity of a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// The part of the light behind that is absorbed.
    pub opacity: f32,
    /// The colours.
    pub paint: Paint,
}

/// Colours of a surface.
#[derive(Debug, Clone, PartialEq)]
pub enum Paint {
    /// One colour, linear RGB.
    Plain([f32; 3]),
    /// The colours of a field's values.
    Field {
        /// The transfer function, of which only the colours are used.
        spans: Vec<Span>,
        /// The value over each cell, normalised to the range of the spans; missing ones are [`ENDLESS`].
        values: Vec<f32>,
        /// Whether each cell has a uniform colour.
        by_cell: bool,
    },
    /// The colours of a field's values between layers.
    Between(ColorByField),
}

impl SurfaceLayer {
    /// A layer of the kernel's scene; `range` returns the least and the greatest value of each field.
    fn new(
        surface: &general::SurfaceLayer,
        fields: &mut FieldTable,
        range: &impl Fn(usize) -> Option<[f64; 2]>,
    ) -> Self {
        let mut paint = |material: &general::Material| match (material, surface.place) {
            (general::Material::Plain(color), _) => Paint::Plain(color.map_inline(|c| c as f32)),
            (general::Material::By { map, by_cell }, SurfaceHeight::Layer(layer)) => {
                let KernelScene { grid, sources, .. } = fields.scene;
                let source = &sources[map.source];
                // A cell is a triangle of three equal corners.
                let value = |cell: u32| map.normal(source.at([cell; 3], layer)[0]);
                let value = |cell| if value(cell).is_finite() { value(cell) as f32 } else { ENDLESS };
                let values = (0..grid.cells() as u32).into_par_iter().map(value).collect();
                Paint::Field { spans: Spans::new(map.knots()).all().to_vec(), values, by_cell: *by_cell }
            }
            (general::Material::By { map, .. }, SurfaceHeight::Radius(_)) => {
                Paint::Between(ColorByField::new(map, fields, range))
            }
        };
        let materials = surface.materials.iter();
        let materials =
            materials.map(|(material, opacity)| Material { opacity: *opacity as f32, paint: paint(material) });
        let is_painted = surface.painter.is_some();
        SurfaceLayer { place: surface.place, materials: materials.collect(), is_painted }
    }
}

/// A surface on which a field has one value.
#[derive(Debug, Clone, PartialEq)]
pub struct Isosurface {
    /// The field.
    pub field: FieldId,
    /// The value, normalised as the field.
    pub value: f32,
    /// The part of the light behind that is absorbed.
    pub opacity: f32,
    /// The colours.
    pub paint: IsosurfacePaint,
}

/// Colours of an isosurface.
#[derive(Debug, Clone, PartialEq)]
pub enum IsosurfacePaint {
    /// One colour, linear RGB.
    Plain([f32; 3]),
    /// The colours of a field's values.
    Field(ColorByField),
}

/// Colours of a field's values.
#[derive(Debug, Clone, PartialEq)]
pub struct ColorByField {
    /// The field.
    pub field: FieldId,
    /// The transfer function, of which only the colours are used.
    pub spans: Vec<Span>,
    /// From the field's normalised value to that of the spans: factor and summand.
    pub to_spans: [f32; 2],
}

impl ColorByField {
    /// The colours of a transfer function.
    fn new(map: &TransferMap, fields: &mut FieldTable, range: &impl Fn(usize) -> Option<[f64; 2]>) -> Self {
        let field = fields.of_source(map.source, range);
        let Normal { low, width, .. } = *fields.normal(field);
        let to_spans = [(width * map.scale()) as f32, map.normal(low) as f32];
        ColorByField { field, spans: Spans::new(map.knots()).all().to_vec(), to_spans }
    }
}

impl Isosurface {
    /// An isosurface of the kernel's scene; `range` returns the least and the greatest value of each field.
    fn new(surface: &general::Isosurface, fields: &mut FieldTable, range: &impl Fn(usize) -> Option<[f64; 2]>) -> Self {
        let field = fields.of_source(surface.source, range);
        let value = fields.normal(field).of(surface.value) as f32;
        let paint = match &surface.material {
            general::Material::Plain(color) => IsosurfacePaint::Plain(color.map_inline(|c| c as f32)),
            general::Material::By { map, .. } => IsosurfacePaint::Field(ColorByField::new(map, fields, range)),
        };
        Isosurface { field, value, opacity: surface.opacity as f32, paint }
    }
}

/// A volume: colour by one field, opacity by the same or another one.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneVolume {
    /// The transfer function of the extinctions, and of the colours if [`Self::color`] is `None`.
    pub extinction: VolumeMap,
    /// The transfer function of the colours.
    pub color: Option<VolumeMap>,
}

/// A transfer function with its field.
#[derive(Debug, Clone, PartialEq)]
pub struct VolumeMap {
    /// The field, normalised to the range of the spans.
    pub field: FieldId,
    /// The transfer function, in rising order.
    pub spans: Vec<Span>,
    /// Its discontinuities, as [`Job::steps`](super::Job::steps).
    pub steps: Vec<Step>,
}

impl VolumeMap {
    fn new(map: &TransferMap, fields: &mut FieldTable) -> Self {
        let spans = Spans::<f32>::new(map.knots());
        VolumeMap { field: fields.of_map(map), spans: spans.all().to_vec(), steps: spans.steps().to_vec() }
    }
}

impl SceneVolume {
    /// The volumes of a scene; none if the only one is that of the job, with this transfer function.
    fn all(scene: &KernelScene, knots: &[KernelKnot], fields: &mut FieldTable) -> Vec<Self> {
        let is_own = |medium: &Medium| medium.extinction.source == 0 && medium.extinction.knots() == knots;
        if scene.has_one_field_of_volume() && scene.media.iter().all(is_own) {
            return Vec::new();
        }
        let volume = |medium: &Medium| SceneVolume {
            extinction: VolumeMap::new(&medium.extinction, fields),
            color: (!medium.has_own_color()).then(|| VolumeMap::new(&medium.color, fields)),
        };
        scene.media.iter().map(volume).collect()
    }
}

/// The part of a scene that devices do not draw, if there is one.
pub(crate) fn unsupported(scene: &Scene) -> Option<String> {
    let scenery = &scene.scenery;
    let counts = [
        ("shows", "volumes", scene.volumes.len(), MAX_VOLUMES),
        ("has", "cuts", scenery.clips.len(), MAX_CLIPS),
        ("has", "surfaces", scenery.surfaces.len(), MAX_SURFACES),
        ("has", "isosurfaces", scenery.isosurfaces.len(), MAX_SURFACES),
    ];
    let (verb, what, count, most) = counts.into_iter().find(|(_, _, count, most)| count > most)?;
    Some(format!("the scene {verb} {count} {what}, expected at most {most}"))
}
