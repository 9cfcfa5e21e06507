//! The fields beside the volume's that a device reads.

use super::{ENDLESS, FallbackReason};
use icoray_grid::array::MapInline;
use icoray_grid::real::Real;
use icoray_kernel::general::{FieldSource, KernelScene, TransferMap};
use icoray_kernel::transfer::Spans;
use rayon::prelude::*;

/// Maximum number of fields beside the volume's that a device takes.
pub const MAX_FIELDS: usize = 8;

/// A field beside the volume's.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneField {
    /// The values, level-fastest, from the innermost layer outwards, normalised to a range; missing ones are
    /// [`ENDLESS`].
    pub values: Vec<f32>,
    /// Gradients at these values, in any unit; empty where nothing of the field is lit.
    pub gradients: Vec<[f32; 3]>,
}

/// A field of a scene: `None` for that of [`Job::values`](super::Job::values), or else the number of another one in
/// [`Scenery::fields`](super::Scenery).
pub type FieldId = Option<usize>;

/// The range to which the values of a field are normalised.
#[derive(Debug, PartialEq)]
pub(super) struct Normal {
    source: usize,
    pub low: f64,
    pub width: f64,
}

impl Normal {
    /// The values of `map`, normalised to the range of its knots.
    fn of_map(map: &TransferMap) -> Self {
        let [low, high] = Spans::<f32>::new(map.knots()).range();
        Normal { source: map.source, low, width: high - low }
    }

    pub fn of(&self, value: f64) -> f64 {
        (value - self.low) / self.width
    }
}

/// Collects the fields that a scene needs.
pub(super) struct FieldTable<'w, 'f> {
    pub scene: &'w KernelScene<'f>,
    own: Normal,
    /// Whether a volume shows it in this range.
    is_shown: bool,
    others: Vec<Normal>,
}

impl<'w, 'f> FieldTable<'w, 'f> {
    /// A table of the job's field only, which is the first one, normalised to this range.
    pub fn new(scene: &'w KernelScene<'f>, [low, high]: [f64; 2]) -> Self {
        let own = Normal { source: 0, low, width: high - low };
        let is_shown =
            scene.media.iter().any(|medium| [&medium.color, &medium.extinction].map(Normal::of_map).contains(&own));
        FieldTable { scene, own, is_shown, others: Vec::new() }
    }

    /// The field of a transfer function, normalised to the range of its knots.
    pub fn of_map(&mut self, map: &TransferMap) -> FieldId {
        let normal = Normal::of_map(map);
        if self.own == normal {
            return None;
        }
        let known = self.others.iter().position(|other| *other == normal);
        Some(known.unwrap_or_else(|| self.add(normal)))
    }

    /// A field in any range; `range` returns its least and greatest value.
    pub fn of_source(&mut self, source: usize, range: &impl Fn(usize) -> Option<[f64; 2]>) -> FieldId {
        if self.is_shown && self.own.source == source {
            return None;
        }
        let known = self.others.iter().position(|other| other.source == source);
        Some(known.unwrap_or_else(|| {
            let [low, high] = range(source).unwrap_or([0.0, 1.0]);
            let width = if high > low { high - low } else { low.abs().max(1.0) };
            self.add(Normal { source, low, width })
        }))
    }

    fn add(&mut self, normal: Normal) -> usize {
        self.others.push(normal);
        self.others.len() - 1
    }

    /// The range of a field.
    pub fn normal(&self, id: FieldId) -> &Normal {
        id.map_or(&self.own, |number| &self.others[number])
    }

    /// The fields beside that of the job, with the gradients of those that are lit.
    ///
    /// # Errors
    /// A [`FallbackReason`] where there are too many.
    pub fn fields(&self, is_lit: bool) -> Result<Vec<SceneField>, FallbackReason> {
        let KernelScene { grid, levels, sources, isosurfaces, media, .. } = self.scene;
        let (cells, layers, count) = (grid.cells(), levels.count(), self.others.len());
        if count > MAX_FIELDS {
            let reason = format!("the scene needs {count} fields beside the first, expected at most {MAX_FIELDS}");
            return Err(FallbackReason::new(reason));
        }
        let field = |normal: &Normal| {
            let source = &sources[normal.source];
            let has_light = is_lit
                && (isosurfaces.iter().any(|surface| surface.source == normal.source)
                    || media.iter().any(|medium| medium.extinction.source == normal.source));
            let gradients = if has_light { gradients(source, cells * layers) } else { Vec::new() };
            SceneField { values: values(source, cells, layers, normal), gradients }
        };
        Ok(self.others.iter().map(field).collect())
    }
}

fn values(source: &FieldSource, cells: usize, layers: usize, normal: &Normal) -> Vec<f32> {
    const MOST: f64 = <f32 as Real>::LARGEST;
    let value = |at: usize| {
        // A cell is a triangle of three equal corners.
        let value = normal.of(source.at([(at / layers) as u32; 3], at % layers)[0]);
        if value.is_finite() { value.clamp(-MOST, MOST) as f32 } else { ENDLESS }
    };
    (0..cells * layers).into_par_iter().map(value).collect()
}

fn gradients(source: &FieldSource, count: usize) -> Vec<[f32; 3]> {
    /// Bound of components: squares of larger ones overflow single precision.
    const MOST: f32 = 1e30;
    let gradients = source.gradients.values();
    let bounded = |x: f32| if x.is_nan() { 0.0 } else { x.clamp(-MOST, MOST) };
    (0..count).into_par_iter().map(|at| gradients.at(at).map_inline(bounded)).collect()
}
