//! Suggests scenes for distributed fields.

use super::sample::Sample;
use super::{Options, Suggestion, of_sample};
use crate::fields::Fields;
use crate::ranks::{Decomposition, DistributedGrid, GatherInputs, Part, Ranks};
use crate::render::Renderer;
use icoray_grid::{Field, Grid, Result};

impl Renderer {
    /// The text of [`suggest::scene`](super::scene) for a field over a distributed grid; `None` if all values are
    /// missing. Collective; the text is equal on all ranks, and for any number of them to that of the whole field.
    /// Ranks with columns or parts gather the field as for a frame; if nodes have parts, rank 0 receives the sampled
    /// values, at most 8 MiB.
    ///
    /// # Errors
    /// Equal on all ranks: as [`suggest::scene`](super::scene), and as [`Self::render_decomposed`].
    pub fn suggest_decomposed(
        &self,
        ranks: &mut Ranks,
        data: DistributedGrid,
        (name, field): (&str, &Field),
        options: &Options,
    ) -> Result<Option<Suggestion>> {
        let DistributedGrid { grid, decomposition, layers } = data;
        let suggest = |ranks: &mut Ranks, grid: &Grid, part: Option<&Part>, field: &Field| {
            let of_parts = part.map(|part| Sample::of_parts(ranks, part, grid, field)).transpose()?;
            let is_root = ranks.is_root();
            let suggestion = ranks.attempt(|| {
                options.check()?;
                self.run(|| match of_parts {
                    _ if !is_root => Ok(None),
                    Some(sample) => of_sample(name, layers, &sample, options),
                    None => of_sample(name, layers, &Sample::of_whole(name, grid, field)?, options),
                })
            });
            ranks.agree_on(suggestion, Vec::new())
        };
        let Some(Decomposition::Columns(columns)) = decomposition else { return suggest(ranks, grid, None, field) };
        let inputs = GatherInputs { threads: &self.threads, grid, layers, derivation_inputs: Vec::new() };
        let gathered = columns.gather(ranks, &inputs, || Ok(Fields::new([(name, *field)])))?;
        let fields = ranks.collective(gathered.fields());
        let suggestion =
            fields.and_then(|fields| suggest(ranks, gathered.grid(grid), gathered.part(), fields.first(name)?));
        gathered.leave(ranks);
        suggestion
    }
}
