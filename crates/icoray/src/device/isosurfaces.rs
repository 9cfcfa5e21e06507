//! Isosurfaces and the fields that they are found in, for a device.

use super::{ENDLESS, FallbackReason, Span};
use icoray_grid::array::MapInline;
use icoray_kernel::general::{self, FieldSource, KernelScene};
use icoray_kernel::transfer::Spans;
use rayon::prelude::*;

/// Largest number of fields beside the volume's that a device is given.
pub const MAX_FIELDS: usize = 4;

/// A field beside the volume's.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneField {
    /// The values, level-fastest, from the innermost layer outwards, normalised to the field's range; missing ones are
    /// [`ENDLESS`].
    pub values: Vec<f32>,
    /// Gradients there, in any unit; empty without light.
    pub gradients: Vec<[f32; 3]>,
}

/// A field of a scene: the volume's, or else the number of another one in [`Scenery::fields`](super::Scenery).
pub type FieldId = Option<usize>;

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
    /// The transfer function, of which the colours count.
    pub spans: Vec<Span>,
    /// From the field's normalised value to that of the spans: factor and summand.
    pub to_spans: [f32; 2],
}

/// The range to which the values of a field are normalised.
struct Normal {
    source: usize,
    low: f64,
    width: f64,
}

impl Normal {
    fn of(&self, value: f64) -> f64 {
        (value - self.low) / self.width
    }
}

/// Collects the fields that isosurfaces need.
struct Fields<'w, 'f> {
    world: &'w KernelScene<'f>,
    own: Option<Normal>,
    others: Vec<Normal>,
}

impl Fields<'_, '_> {
    fn id(&mut self, source: usize, range: &impl Fn(usize) -> Option<[f64; 2]>) -> FieldId {
        if self.own.as_ref().is_some_and(|own| own.source == source) {
            return None;
        }
        let known = self.others.iter().position(|other| other.source == source);
        Some(known.unwrap_or_else(|| {
            let [low, high] = range(source).unwrap_or([0.0, 1.0]);
            let width = if high > low { high - low } else { low.abs().max(1.0) };
            self.others.push(Normal { source, low, width });
            self.others.len() - 1
        }))
    }

    fn normal(&self, id: FieldId) -> Option<&Normal> {
        id.map_or(self.own.as_ref(), |number| self.others.get(number))
    }

    fn surface(
        &mut self,
        surface: &general::Isosurface,
        range: &impl Fn(usize) -> Option<[f64; 2]>,
    ) -> Option<Isosurface> {
        let field = self.id(surface.source, range);
        let value = self.normal(field)?.of(surface.value) as f32;
        let paint = match &surface.material {
            general::Material::Plain(color) => IsosurfacePaint::Plain(color.map_inline(|c| c as f32)),
            general::Material::By { map, .. } => {
                let field = self.id(map.source, range);
                let Normal { low, width, .. } = *self.normal(field)?;
                let spans = Spans::new(map.knots()).all().to_vec();
                let to_spans = [(width * map.scale()) as f32, map.normal(low) as f32];
                IsosurfacePaint::Field(ColorByField { field, spans, to_spans })
            }
        };
        Some(Isosurface { field, value, opacity: surface.opacity as f32, paint })
    }
}

/// The isosurfaces of a scene and the fields beside the volume's that these need: `range` gives the least and the
/// greatest value of each.
///
/// # Errors
/// A [`FallbackReason`] where these are too many.
pub(crate) fn isosurface_tables(
    world: &KernelScene,
    (cells, layers): (usize, usize),
    is_lit: bool,
    range: impl Fn(usize) -> Option<[f64; 2]>,
) -> Result<(Vec<Isosurface>, Vec<SceneField>), FallbackReason> {
    let own = world.media.first().map(|medium| {
        let [low, high] = Spans::<f32>::new(medium.extinction.knots()).range();
        Normal { source: medium.extinction.source, low, width: high - low }
    });
    let mut fields = Fields { world, own, others: Vec::new() };
    let surfaces: Vec<_> = world.isosurfaces.iter().filter_map(|surface| fields.surface(surface, &range)).collect();
    let count = fields.others.len();
    if count > MAX_FIELDS {
        let reason = format!("the scene's isosurfaces need {count} fields, expected at most {MAX_FIELDS}");
        return Err(FallbackReason::new(reason));
    }
    let others = fields.others.iter().map(|normal| {
        let source = &fields.world.sources[normal.source];
        let is_lit = is_lit && world.isosurfaces.iter().any(|surface| surface.source == normal.source);
        SceneField {
            values: values(source, (cells, layers), normal),
            gradients: if is_lit { gradients(source, cells * layers) } else { Vec::new() },
        }
    });
    Ok((surfaces, others.collect()))
}

fn values(source: &FieldSource, (cells, layers): (usize, usize), normal: &Normal) -> Vec<f32> {
    let value = |at: usize| {
        // A cell is a triangle of three alike.
        let value = normal.of(source.at([(at / layers) as u32; 3], at % layers)[0]);
        if value.is_finite() { value as f32 } else { ENDLESS }
    };
    (0..cells * layers).into_par_iter().map(value).collect()
}

fn gradients(source: &FieldSource, count: usize) -> Vec<[f32; 3]> {
    /// Bound of components: larger ones have no squares in single precision.
    const MOST: f32 = 1e30;
    let gradients = source.gradients().values();
    let bounded = |x: f32| if x.is_nan() { 0.0 } else { x.clamp(-MOST, MOST) };
    (0..count).into_par_iter().map(|at| gradients.at(at).map_inline(bounded)).collect()
}
