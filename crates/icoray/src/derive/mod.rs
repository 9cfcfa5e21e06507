//! Fields made of others before a frame is drawn: of those that a scene derives, the ones that it shows, and what these need.
//!
//! A derived field lies where its inputs do, level-fastest, in f32 unless one of them has f64; it is missing wherever one of
//! them is. Sums and lengths are taken in f64, and what is too large for the array is the largest number that it holds.
//!
//! Ranks with parts derive their own columns, halo included. Only zonal means need those of others; they are added up in
//! whole numbers, so that neither threads nor ranks change a bit of them.

mod first;
mod resolve;
mod run;
mod zonal;

use crate::error::{Error, ErrorKind, Result};
use crate::field::{Field, Location};
use crate::fields::Fields;
use crate::grid::{Grid, Reals};
use crate::ranks::{Part, Ranks};
use crate::scene::{How, Scene};
use crate::shape::Shape;
use crate::threads::Threads;
use first::Firsts;
use resolve::Needed;
use run::{Operation, fill};
use std::sync::{Mutex, PoisonError};
use zonal::Means;

/// What fields are derived of.
#[derive(Clone, Copy)]
pub(crate) struct Given<'g> {
    pub scene: &'g Scene,
    pub fields: &'g Fields<'g>,
    pub grid: &'g Grid<'g>,
    /// Whose cells count in means, where others have the rest.
    pub part: Option<&'g Part>,
    pub threads: &'g Threads,
}

/// What a renderer keeps from frame to frame: the fields of first frames, and memory.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    firsts: Firsts,
    memory: Mutex<Vec<Values>>,
}

/// The derived fields of a frame.
#[derive(Debug, Default)]
pub(crate) struct Made {
    fields: Vec<MadeField>,
    /// What the field without a name is called by those that are made of it.
    unnamed: Option<String>,
    /// Bytes of fields of first frames.
    remembered: usize,
}

#[derive(Debug)]
struct MadeField {
    name: String,
    values: Values,
    at: At,
}

/// Where a field's values lie, however they are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct At {
    location: Location,
    columns: usize,
    layers: usize,
}

/// Values, level-fastest; NaN where one is missing.
#[derive(Debug)]
enum Values {
    F32(Vec<f32>),
    F64(Vec<f64>),
}

impl At {
    fn of(field: &Field) -> Self {
        let Shape { columns, layers, .. } = *field.shape();
        At { location: field.location(), columns, layers }
    }

    /// The values as a field.
    fn field(self, values: &Values) -> Field<'_> {
        let samples = match values {
            Values::F32(values) => values.as_slice().into(),
            Values::F64(values) => values.as_slice().into(),
        };
        Field::new(samples, Shape::level_fastest(self.columns, self.layers), self.location, None)
            .expect("the values were made for this shape")
    }
}

impl Values {
    fn bytes(&self) -> usize {
        match self {
            Values::F32(values) => size_of_val(values.as_slice()),
            Values::F64(values) => size_of_val(values.as_slice()),
        }
    }
}

impl MadeField {
    fn field(&self) -> Field<'_> {
        self.at.field(&self.values)
    }
}

impl Made {
    /// The derived fields before those that they are made of.
    pub fn fields<'m>(&'m self, of: &Fields<'m>) -> Fields<'m> {
        let derived = self.fields.iter().map(|made| (made.name.clone(), made.field()));
        of.behind(derived.collect(), self.unnamed.as_deref())
    }

    /// Bytes that they take, and those that are remembered for them.
    pub fn bytes(&self) -> usize {
        self.fields.iter().map(|made| made.values.bytes()).sum::<usize>() + self.remembered
    }
}

impl Kept {
    /// Takes a frame's fields back, whose memory the next one's are made in.
    pub fn keep(&self, made: Made) {
        let values = made.fields.into_iter().map(|made| made.values).collect();
        *self.memory.lock().unwrap_or_else(PoisonError::into_inner) = values;
    }

    /// Empty values as precise as the most precise of `of`, in memory that is kept if there is some.
    fn room_for(&self, of: &[Field]) -> Values {
        let is_wide = of.iter().any(|field| matches!(field.samples(), Reals::F64(_)));
        let mut memory = self.memory.lock().unwrap_or_else(PoisonError::into_inner);
        let found = memory.iter().position(|values| matches!(values, Values::F64(_)) == is_wide);
        match (found, is_wide) {
            (Some(at), _) => memory.swap_remove(at),
            (None, true) => Values::F64(Vec::new()),
            (None, false) => Values::F32(Vec::new()),
        }
    }
}

/// Makes what the scene shows of derived fields; `None` where it derives none. Collective, and the same to the bit however the
/// grid is shared out.
///
/// # Errors
/// The same on all ranks: [`ErrorKind::Scene`] where a field is not there or a band of latitude has no width;
/// [`ErrorKind::Field`] where inputs lie at different places or do not fit the grid; [`ErrorKind::Mpi`] where ranks derive
/// different fields or the transport fails.
pub(crate) fn make(ranks: &mut Ranks, kept: &Kept, given: &Given) -> Result<Option<Made>> {
    if given.scene.scenery.derived.is_empty() {
        return Ok(None);
    }
    let needed = ranks.attempt(|| Needed::of(given.scene, given.fields));
    // Else some would wait for the means of others.
    let needed = ranks.of_one_mind(needed, |needed| vec![("derives", needed.to_string())])?;
    let mut made = Made { unnamed: needed.unnamed.clone(), ..Made::default() };
    for one in &needed.derivations {
        let (name, how) = (&one.derivation.name, &one.derivation.how);
        let of = made.fields(given.fields);
        let inputs = ranks.attempt(|| inputs(&of, how).map_err(|e| e.within(format!("{name:?}"))));
        let inputs = ranks.together(inputs)?;
        let means = match how {
            How::FromZonalMean { band_deg, .. } => Some(Means::of(ranks, given, &inputs[0], *band_deg)?),
            _ => None,
        };
        let at = At::of(&inputs[0]);
        let values = ranks.attempt(|| {
            let room = kept.room_for(&inputs);
            let fill = |inputs: &[Field], operation| Ok(given.threads.run(|| fill(room, inputs, &operation)));
            match how {
                How::Magnitude(_) => fill(&inputs, Operation::Magnitude),
                How::Combination(terms) => {
                    fill(&inputs, Operation::Sum(terms.iter().map(|(factor, _)| *factor).collect()))
                }
                How::FromZonalMean { .. } => {
                    fill(&inputs, Operation::FromMeans(means.as_ref().expect("found above")))
                }
                How::FromFirst(_) => {
                    let first = kept.firsts.of(&one.origin, &inputs[0], given.threads)?;
                    fill(&[inputs[0], at.field(&first)], Operation::Sum(vec![1.0, -1.0]))
                }
            }
        });
        let values = ranks.together(values)?;
        made.fields.push(MadeField { name: name.clone(), values, at });
    }
    made.remembered = kept.firsts.bytes();
    Ok(Some(made))
}

/// The fields of which one is made, which lie at the same places.
fn inputs<'f>(fields: &Fields<'f>, how: &How) -> Result<Vec<Field<'f>>> {
    let names = how.fields();
    let found = names.iter().map(|name| fields.get(name).copied()).collect::<Result<Vec<_>>>()?;
    let Some(first) = found.first() else {
        return Err(Error::new(ErrorKind::Scene, "made of 0 fields, expected at least 1"));
    };
    let told = |field: &Field| {
        let At { location, columns, layers } = At::of(field);
        format!("{columns} columns of {layers} layers at {location:?}")
    };
    if let Some(odd) = found.iter().position(|field| At::of(field) != At::of(first)) {
        let context = format!(
            "field {:?} has {}, expected {} as field {:?} has",
            names[odd],
            told(&found[odd]),
            told(first),
            names[0]
        );
        return Err(Error::new(ErrorKind::Field, context));
    }
    Ok(found)
}

#[cfg(test)]
mod tests;
