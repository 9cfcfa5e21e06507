//! The fields that a scene shows, all at cell centres and on the layers of the first.

use super::{Given, Renderer};
use crate::error::Result;
use crate::field::{CenterField, Field, Location};
use crate::plan::Plan;
use crate::ranks::Ranks;
use crate::scene::Scene;

/// A field that a scene shows beside the first.
pub(super) struct Other<'f> {
    name: String,
    given: Field<'f>,
    /// What it was made into, where it was given at corners or on other layers.
    made: Option<CenterField>,
}

impl Other<'_> {
    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn field(&self) -> Field<'_> {
        self.made.as_ref().map_or(self.given, CenterField::field)
    }

    /// Bytes that were made.
    pub fn bytes(&self) -> usize {
        self.made.as_ref().map_or(0, CenterField::bytes)
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
        let mut others = Vec::new();
        for name in scene.shown_fields().into_iter().skip(1) {
            let found = ranks.attempt(|| {
                let field = *fields.get(name)?;
                Plan::check(name, grid, layers, &field)?;
                let average = || CenterField::average(grid, &field);
                let made = (field.location() == Location::Corner).then(|| self.run(average)).transpose()?;
                Ok(Other { name: name.to_owned(), given: field, made })
            });
            // Ranks whose fields lie elsewhere would wait for each other's halos for ever.
            let mut other = ranks.of_one_mind(found, |other| {
                let place = if other.made.is_some() { "corners" } else { "centres" };
                vec![("has a field at", place.into())]
            })?;
            if let (Some(part), Some(made)) = (part, &mut other.made) {
                made.fill_halo(ranks, part)?;
            }
            let first = fields.first(&scene.field)?.shape().layers;
            let count = other.field().shape().layers;
            if count != first {
                let moved = ranks.attempt(|| {
                    let [own, wanted] = [layers.for_field(count)?, layers.for_field(first)?];
                    Ok(self.run(|| CenterField::moved(&other.field(), own.radius_m(), wanted.radius_m())))
                });
                other.made = Some(ranks.together(moved)?);
            }
            others.push(other);
        }
        Ok(others)
    }
}
