//! Derived fields: computed before a frame is drawn, if the scene shows them or a shown field depends on them.
//!
//! A derived field has the location and the layers of its inputs. It is stored level-fastest, in f32 unless an input
//! has f64, and is missing where an input is. Sums and lengths are computed in f64 and limited to the largest number of
//! the array's type.
//!
//! Ranks that read the same fields in their node's memory derive fields there, each some columns, halo included. Only
//! zonal means need columns of other ranks; they are summed in integers, so the result does not depend on threads or
//! ranks, to the bit.

mod resolve;
mod run;
mod zonal;

use crate::fields::{FieldLayout, Fields};
use crate::ranks::{ComputedValues, Ranks};
use crate::render::RenderInputs;
use icoray_grid::threads::Threads;
use icoray_grid::{ComputedField, Error, ErrorKind, Field, OwnedReals, Reals, Result, Shape, memory};
use icoray_scene::{Derivation, How, Scene};
use resolve::needed_derivations;
use run::{Operation, fill};
use std::sync::{Arc, Mutex, PoisonError};
use zonal::Means;

/// Maximum number of stored first frames: bounds the memory if a host generates ever new names.
const MAX_FIRSTS: usize = 64;

/// The renderer's state between frames: fields of first frames, and buffers to reuse.
#[derive(Debug, Default)]
pub(crate) struct DerivedFieldCache {
    firsts: Mutex<Vec<FirstFrame>>,
    memory: Mutex<Vec<ComputedField>>,
}

/// A field as it was in the first frame that requested it. Identified by the definition of the field, down to the
/// model's names, and by its shape: each shape has a first frame of its own.
#[derive(Debug)]
struct FirstFrame {
    origin: String,
    values: Arc<ComputedValues>,
}

/// The derived fields of a frame.
#[derive(Debug, Default)]
pub(crate) struct DerivedFields {
    fields: Vec<DerivedField>,
    /// Bytes of stored fields of first frames.
    remembered: usize,
}

#[derive(Debug)]
struct DerivedField {
    name: String,
    values: ComputedValues,
}

impl DerivedFields {
    /// The derived fields, followed by the given ones.
    pub fn fields<'m>(&'m self, of: &Fields<'m>) -> Fields<'m> {
        let made = self.fields.iter().map(|made| (made.name.as_str(), made.values.field()));
        Fields::new(made).with(of.clone())
    }

    /// Bytes of the derived fields and of those stored for them.
    pub fn bytes(&self) -> usize {
        self.fields.iter().map(|made| made.values.reported_bytes()).sum::<usize>() + self.remembered
    }
}

impl DerivedFieldCache {
    /// Stores the buffers of a frame's fields for the next frame that derives any.
    pub fn keep(&self, ranks: &mut Ranks, made: DerivedFields) {
        if made.fields.is_empty() {
            return;
        }
        let mut own = Vec::new();
        made.fields.into_iter().for_each(|made| made.values.leave(ranks, |values| own.push(values)));
        *self.memory.lock().unwrap_or_else(PoisonError::into_inner) = own;
    }

    /// Checks that the derived fields of a scene, once in a number of `mates`, fit into `limit` or, in each of a number of
    /// processes, into the system's free memory, beside those of the previous frame. Each is assumed to be as large as
    /// the first of `fields`.
    fn require(
        &self,
        scene: &Scene,
        fields: &Fields,
        limit: Option<u64>,
        [processes, mates]: [usize; 2],
    ) -> Result<()> {
        let held =
            self.memory.lock().unwrap_or_else(PoisonError::into_inner).iter().map(ComputedField::bytes).sum::<usize>();
        // A frame without fields is refused where fields are read.
        let needed = fields.first("").map_or(0, |field| bytes(scene, field).div_ceil(mates as u64));
        let missing = needed.saturating_sub((held + self.first_bytes()) as u64);
        memory::require_each("derived fields", missing, limit, processes)
    }

    /// The values of a field of this layout in the first frame, if they are stored.
    fn first(&self, origin: &str, at: FieldLayout) -> Result<Option<Arc<ComputedValues>>> {
        let all = self.firsts.lock().unwrap_or_else(PoisonError::into_inner);
        let is_it = |first: &&FirstFrame| FieldLayout::of(&first.values.field()) == at && first.origin == origin;
        match all.iter().find(is_it) {
            None if all.len() == MAX_FIRSTS => {
                let context = format!("fields of {MAX_FIRSTS} first steps are stored already, expected no further one");
                Err(Error::new(ErrorKind::Scene, context))
            }
            found => Ok(found.map(|first| first.values.clone())),
        }
    }

    /// Stores the values of the first frame.
    fn store_first(&self, origin: &str, values: Arc<ComputedValues>) {
        let mut all = self.firsts.lock().unwrap_or_else(PoisonError::into_inner);
        all.push(FirstFrame { origin: origin.to_owned(), values });
    }

    fn first_bytes(&self) -> usize {
        let all = self.firsts.lock().unwrap_or_else(PoisonError::into_inner);
        all.iter().map(|first| first.values.reported_bytes()).sum()
    }

    /// A stored field in f64, or in f32, if there is one: its memory is free.
    fn room(&self, is_f64: bool) -> Option<ComputedField> {
        let mut memory = self.memory.lock().unwrap_or_else(PoisonError::into_inner);
        let is_it = |made: &ComputedField| matches!(made.field().samples(), Reals::F64(_)) == is_f64;
        let found = memory.iter().position(is_it);
        found.map(|at| memory.swap_remove(at))
    }
}

/// The samples of the field of highest precision.
fn widest<'f>(of: &[Field<'f>]) -> Reals<'f> {
    of.iter().find(|field| matches!(field.samples(), Reals::F64(_))).unwrap_or(&of[0]).samples()
}

/// Computes the derived fields that the scene needs. Collective; the result does not depend on the decomposition of the
/// grid, to the bit.
///
/// # Errors
/// The same on all ranks: [`ErrorKind::Memory`] if they do not fit into `limit`, or into the system's free memory;
/// [`ErrorKind::Scene`] where a field is not there or a band of latitude has no width;
/// [`ErrorKind::Field`] where inputs lie at different places or do not fit the grid; [`ErrorKind::Mpi`] where ranks
/// derive different fields or the transport fails.
pub(crate) fn make(
    ranks: &mut Ranks,
    kept: &DerivedFieldCache,
    threads: &Threads,
    given: &RenderInputs,
    limit: Option<u64>,
) -> Result<DerivedFields> {
    if given.scene.scenery.derived.is_empty() {
        return Ok(DerivedFields::default());
    }
    let require = |processes, mates| kept.require(given.scene, given.fields, limit, [processes, mates]);
    let mates = given.mates.map_or(1, |mates| mates.mates().len());
    let has_room = ranks.attempt(|| require(ranks.node_size(), mates));
    let needed = needed_derivations(given.scene);
    let described = needed.iter().map(|(derivation, _)| format!("{:?} = {:?}", derivation.name, derivation.how));
    // Otherwise the collective calls of zonal means would not match.
    ranks.agree_all(has_room, |()| vec![("derives", described.collect::<Vec<_>>().join(", "))])?;
    let compute = |ranks: &mut Ranks, inputs: &[Field], operation: &Operation| {
        let (at, widest) = (FieldLayout::of(&inputs[0]), widest(inputs));
        let make = |columns, room| fill(OwnedReals::buffer(widest, room), inputs, operation, columns);
        let (is_f64, processes) = (matches!(widest, Reals::F64(_)), ranks.node_size());
        let cached = || {
            if given.mates.is_some() {
                // The node has no memory to share.
                require(processes, 1)?;
            }
            Ok(Err(kept.room(is_f64)))
        };
        ComputedValues::compute(ranks, given.mates, threads, (at, is_f64), cached, make)
    };
    let mut made = DerivedFields::default();
    for (Derivation { name, how }, origin) in &needed {
        let of = made.fields(given.fields);
        let inputs = ranks.collective_work(|| inputs(&of, how).map_err(|e| e.within(format!("{name:?}"))))?;
        let values = match how {
            How::Magnitude(_) => compute(ranks, &inputs, &Operation::Magnitude)?,
            How::Combination(terms) => {
                compute(ranks, &inputs, &Operation::Sum(terms.iter().map(|(factor, _)| *factor).collect()))?
            }
            How::FromZonalMean { band_deg, .. } => {
                let means = Means::of(ranks, threads, given, &inputs[0], *band_deg)?;
                compute(ranks, &inputs, &Operation::FromMeans(&means))?
            }
            How::FromFirst(_) => {
                let stored = ranks.collective_work(|| kept.first(origin, FieldLayout::of(&inputs[0])))?;
                let first = match stored {
                    Some(first) => first,
                    None => {
                        let first = Arc::new(compute(ranks, &inputs, &Operation::Sum(vec![1.0]))?);
                        kept.store_first(origin, first.clone());
                        first
                    }
                };
                compute(ranks, &[inputs[0], first.field()], &Operation::Sum(vec![1.0, -1.0]))?
            }
        };
        made.fields.push(DerivedField { name: name.clone(), values });
    }
    made.remembered = kept.first_bytes();
    Ok(made)
}

/// Bytes of the derived fields that a scene needs, each of which is as large as `field`.
pub(crate) fn bytes(scene: &Scene, field: &Field) -> u64 {
    let value_bytes = if matches!(field.samples(), Reals::F32(_)) { size_of::<f32>() } else { size_of::<f64>() };
    let Shape { columns, layers, .. } = *field.shape();
    // A first frame is stored too.
    let arrays = |(derived, _): &(&Derivation, String)| if matches!(derived.how, How::FromFirst(_)) { 2 } else { 1 };
    let arrays: usize = needed_derivations(scene).iter().map(arrays).sum();
    (arrays * columns * layers * value_bytes) as u64
}

/// The inputs of a derivation, all at the same location.
fn inputs<'f>(fields: &Fields<'f>, how: &How) -> Result<Vec<Field<'f>>> {
    let names = how.fields();
    let found = names.iter().map(|name| fields.get(name).copied()).collect::<Result<Vec<_>>>()?;
    let Some(first) = found.first() else {
        return Err(Error::new(ErrorKind::Scene, "made of 0 fields, expected at least 1"));
    };
    let layout = |field: &Field| {
        let FieldLayout { location, columns, layers } = FieldLayout::of(field);
        format!("{columns} columns of {layers} layers at {location:?}")
    };
    if let Some(odd) = found.iter().position(|field| FieldLayout::of(field) != FieldLayout::of(first)) {
        let context = format!(
            "field {:?} has {}, expected {} as field {:?} has",
            names[odd],
            layout(&found[odd]),
            layout(first),
            names[0]
        );
        return Err(Error::new(ErrorKind::Field, context));
    }
    Ok(found)
}

#[cfg(test)]
mod tests;
