//! Prepares the fields that a scene shows: averages them to cell centres and moves them to the layers of the first.
//! Heights of columns are averaged to cell centres.

use super::RenderInputs;
use super::frame_cache::{FrameCache, MovedKey, SourceKey};
use super::renderer::Renderer;
use crate::fields::FieldLayout;
use crate::plan::Plan;
use crate::ranks::{ComputedValues, HAS_WHOLE, Ranks};
use icoray_grid::heights::check_corners;
use icoray_grid::{CornerColumns, Field, Grid, Location, Reals, Result, moved};
use icoray_scene::Heights;
use rayon::prelude::*;
use std::ops::Range;

/// Maximum number of values of a field that ranks compare in a frame.
const SAMPLES: usize = 4096;

/// A field that a scene shows, or the heights of its columns.
pub(super) struct PreparedField<'f> {
    name: String,
    given: Field<'f>,
    /// The average at the centres, if the field was given at corners.
    average: Option<ComputedValues>,
    /// The values on the layers of the first field, if this one has others.
    moved: Option<(MovedKey, ComputedValues)>,
}

impl<'f> PreparedField<'f> {
    /// A field at the centres, on the layers of the picture.
    pub fn at_centers(name: &str, field: Field<'f>) -> Self {
        PreparedField { name: name.to_owned(), given: field, average: None, moved: None }
    }
}

impl PreparedField<'_> {
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether it was averaged from corners.
    pub fn is_average(&self) -> bool {
        self.average.is_some()
    }

    /// The field at the centres, on the layers of the first.
    pub fn field(&self) -> Field<'_> {
        let moved = self.moved.as_ref().map(|(_, moved)| moved);
        moved.or(self.average.as_ref()).map_or(self.given, ComputedValues::field)
    }

    /// Identifies the values of [`Self::field`] between frames.
    pub fn source(&self, grid: &Grid) -> SourceKey {
        SourceKey::new(grid, &self.moved.as_ref().map_or(self.given, |(_, moved)| moved.field()))
    }

    /// The values as a fact that must be equal on ranks that have all of them.
    pub fn values_fact(&self) -> (&'static str, String) {
        (HAS_WHOLE, format!("{:?} with values of hash {:016x}", self.name, self.given.hash_of_samples(SAMPLES)))
    }

    /// Bytes of the average and the moved values.
    pub fn bytes(&self) -> usize {
        let moved = self.moved.as_ref().map(|(_, moved)| moved);
        self.average.iter().chain(moved).map(ComputedValues::reported_bytes).sum()
    }

    /// Stores average and moved values in the cache, and their memory, for the next frame.
    pub fn keep(self, ranks: &mut Ranks, cache: &FrameCache, grid: &Grid) {
        if let Some(average) = self.average {
            average.leave(ranks, |own| cache.averages.store(SourceKey::new(grid, &self.given), own));
        }
        if let Some((key, moved)) = self.moved {
            moved.leave(ranks, |own| cache.moved.store(key, own));
        }
    }
}

impl Renderer {
    /// The fields that the scene shows, the first one first; [`Plan::new`] has checked that one. If `has_whole`, each
    /// rank has all values, and they are compared. Collective.
    pub(super) fn prepare_fields<'f>(
        &self,
        ranks: &mut Ranks,
        given: &RenderInputs<'f>,
        has_whole: bool,
    ) -> Result<Vec<PreparedField<'f>>> {
        let RenderInputs { scene, grid, mates, layers, fields, .. } = *given;
        let mut prepared: Vec<PreparedField> = Vec::new();
        for name in scene.shown_fields() {
            let is_first = prepared.is_empty();
            let check = || {
                let field = fields.get(name)?;
                Plan::check(name, grid, layers, field)?;
                Ok(field)
            };
            // Ranks with fields at different locations would wait for each other's halos for ever.
            let facts = |field: &PreparedField| {
                let layout = (!is_first).then(|| ("has", described(&format!("{name:?}"), &field.given)));
                layout.into_iter().chain(has_whole.then(|| field.values_fact())).collect()
            };
            let mut field = self.prepare(ranks, given, name, check, facts)?;
            let count = field.given.shape().layers;
            let wanted = prepared.first().map_or(count, |first| first.given.shape().layers);
            if count != wanted {
                let key = ranks.collective_work(|| {
                    let [own, wanted] = [layers.for_field(count)?, layers.for_field(wanted)?];
                    let [own, wanted] = [&own, &wanted].map(|layers| layers.radius_m().to_vec());
                    Ok(MovedKey { source: SourceKey::new(grid, &field.field()), own, wanted })
                })?;
                let moved = {
                    let (center, layers) = (field.field(), [&key.own[..], &key.wanted[..]]);
                    let cached = || Ok(self.frame_cache.moved.take(&key));
                    let make = |columns, memory| moved(&center, layers, columns, memory);
                    let at = at_centers(grid, &center, wanted);
                    ComputedValues::compute(ranks, mates, &self.threads, at, cached, make)?
                };
                field.moved = Some((key, moved));
            }
            prepared.push(field);
        }
        Ok(prepared)
    }

    /// The heights of columns, if the scene requests native ones: those at corners are checked there and averaged.
    /// Collective.
    pub(super) fn prepare_heights<'f>(
        &self,
        ranks: &mut Ranks,
        given: &RenderInputs<'f>,
    ) -> Result<Option<PreparedField<'f>>> {
        let RenderInputs { scene, grid, part, layers, fields, .. } = *given;
        if scene.scenery.heights == Heights::Mean {
            return Ok(None);
        }
        let check = || {
            let heights = fields.heights().expect("a scene's needed fields include its heights");
            if heights.location() == Location::Corner {
                let owns = |cell: usize| part.is_none_or(|part| part.owns(cell));
                self.run(|| check_corners(grid, heights, layers, owns))?;
            }
            Ok(heights)
        };
        // Only ranks with averages exchange their halos.
        let facts = |heights: &PreparedField| match heights.given.location() {
            Location::Corner => vec![("has", described("heights", &heights.given))],
            Location::Center => vec![("has", "heights at centres".to_owned())],
        };
        self.prepare(ranks, given, "heights", check, facts).map(Some)
    }

    /// The field that `check` returns, averaged to cell centres if it is at corners; its `facts` are equal on all
    /// ranks. Collective.
    fn prepare<'f>(
        &self,
        ranks: &mut Ranks,
        RenderInputs { grid, part, mates, .. }: &RenderInputs<'f>,
        name: &str,
        check: impl FnOnce() -> Result<&'f Field<'f>>,
        facts: impl FnOnce(&PreparedField) -> Vec<(&'static str, String)>,
    ) -> Result<PreparedField<'f>> {
        let found = ranks.attempt(|| Ok(PreparedField::at_centers(name, *check()?)));
        let mut field = ranks.agree_all(found, facts)?;
        if field.given.location() == Location::Corner {
            let given = field.given;
            let corners = CornerColumns::new(given);
            let cached = || Ok(self.frame_cache.averages.take(&SourceKey::new(grid, &given)));
            let make = |cells: Range<usize>, memory| {
                corners.averages(grid, (cells.start as u32..cells.end as u32).into_par_iter(), memory)
            };
            let at = at_centers(grid, &given, given.shape().layers);
            let mut average = ComputedValues::compute(ranks, *mates, &self.threads, at, cached, make)?;
            if let Some(part) = part {
                average.fill_halo(ranks, part)?;
            }
            field.average = Some(average);
        }
        Ok(field)
    }
}

/// The layout at the centres of a field made of `field`, and whether it is in f64.
fn at_centers(grid: &Grid, field: &Field, layers: usize) -> (FieldLayout, bool) {
    let at = FieldLayout { location: Location::Center, columns: grid.cells(), layers };
    (at, matches!(field.samples(), Reals::F64(_)))
}

fn described(name: &str, field: &Field) -> String {
    let bits = if matches!(field.samples(), Reals::F32(_)) { 32 } else { 64 };
    let place = if field.location() == Location::Corner { "corners" } else { "centres" };
    format!("{name} of {} layers of {bits} bits at {place}", field.shape().layers)
}
