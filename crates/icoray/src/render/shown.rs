//! The fields that a scene shows, all at cell centres and on the layers of the first.

use super::spare::{MovedKey, Source, Spare};
use super::{Given, Renderer};
use crate::error::Result;
use crate::field::{CenterField, Field, Location};
use crate::grid::{Grid, Reals};
use crate::plan::Plan;
use crate::ranks::Ranks;
use crate::scene::Scene;

/// A field that a scene shows beside the first.
pub(super) struct Other<'f> {
    name: String,
    given: Field<'f>,
    /// What it is at the centres, where it was given at corners.
    average: Option<CenterField>,
    /// What it is on the layers of the first, where it has others.
    moved: Option<(MovedKey, CenterField)>,
}

impl Other<'_> {
    pub fn name(&self) -> &str {
        &self.name
    }

    fn center(&self) -> Field<'_> {
        self.average.as_ref().map_or(self.given, CenterField::field)
    }

    pub fn field(&self) -> Field<'_> {
        self.moved.as_ref().map_or_else(|| self.center(), |(_, moved)| moved.field())
    }

    /// Bytes that were made.
    pub fn bytes(&self) -> usize {
        let moved = self.moved.as_ref().map(|(_, moved)| moved);
        self.average.iter().chain(moved).map(CenterField::bytes).sum()
    }

    /// Leaves what was made to the next frame.
    pub fn leave(self, spare: &Spare, grid: &Grid) {
        if let Some(average) = self.average {
            spare.keep_average(Source::new(grid, &self.given), average);
        }
        if let Some((key, moved)) = self.moved {
            spare.keep_moved(key, moved);
        }
    }
}

impl Renderer {
    /// The fields of `scene` beside the first, of which `plan` is. Collective.
    pub(super) fn others<'f>(
        &self,
        ranks: &mut Ranks,
        scene: &Scene,
        given: &Given<'f>,
    ) -> Result<Vec<Other<'f>>> {
        let Given { grid, part, layers, fields } = *given;
        let first = fields.first(&scene.field)?.shape().layers;
        let mut others = Vec::new();
        for name in scene.shown_fields().into_iter().skip(1) {
            let found = ranks.attempt(|| {
                let given = *fields.get(name)?;
                Plan::check(name, grid, layers, &given)?;
                let average = || self.spare.average(&Source::new(grid, &given), grid, &given);
                let average =
                    (given.location() == Location::Corner).then(|| self.run(average)).transpose()?;
                Ok(Other { name: name.to_owned(), given, average, moved: None })
            });
            // Ranks whose fields lie elsewhere would wait for each other's halos for ever.
            let mut other = ranks.of_one_mind(found, |other| vec![("has", described(name, &other.given))])?;
            if let (Some(part), Some(average)) = (part, &mut other.average) {
                average.fill_halo(ranks, part)?;
            }
            let count = other.given.shape().layers;
            if count != first {
                let moved = ranks.attempt(|| {
                    let [own, wanted] = [layers.for_field(count)?, layers.for_field(first)?];
                    let [own, wanted] = [&own, &wanted].map(|layers| layers.radius_m().to_vec());
                    let key = MovedKey { source: Source::new(grid, &other.center()), own, wanted };
                    let make = |memory| CenterField::moved_in(&other.center(), &key.own, &key.wanted, memory);
                    let moved = self.run(|| self.spare.moved(&key, make));
                    Ok((key, moved))
                });
                other.moved = Some(ranks.together(moved)?);
            }
            others.push(other);
        }
        Ok(others)
    }
}

fn described(name: &str, field: &Field) -> String {
    let bits = if matches!(field.samples(), Reals::F32(_)) { 32 } else { 64 };
    let place = if field.location() == Location::Corner { "corners" } else { "centres" };
    format!("{name:?} of {} layers of {bits} bits at {place}", field.shape().layers)
}
