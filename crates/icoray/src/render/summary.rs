//! What conditions ask of a field, on the renderer's threads and over all ranks.

use super::Renderer;
use crate::error::Result;
use crate::field::Field;
use crate::ranks::{Held, Ranks};
use crate::script::{Statistic, Summary};

impl Renderer {
    /// The statistics of a field that `asked` has, the same on all ranks to the last bit, so that what they decide by them
    /// is too. Of a field of which each rank has what `held` says, they are over the values of all ranks, each once; of one
    /// that every rank has whole they are rank 0's. Collective.
    ///
    /// # Errors
    /// The same on all ranks: [`ErrorKind::Field`](crate::ErrorKind::Field) where a field has not the columns that its rank
    /// has; [`ErrorKind::Mpi`](crate::ErrorKind::Mpi) when the transport fails.
    pub fn summary(
        &self,
        ranks: &mut Ranks,
        field: &Field,
        held: Option<&Held>,
        asked: &[Statistic],
    ) -> Result<Summary> {
        let mine = ranks.attempt(|| {
            let own = held.map(|held| held.own_columns(field)).transpose()?;
            Ok(self.run(|| Summary::of(field, own.as_deref().map(|own| own as _), asked)))
        });
        let mine = ranks.together(mine)?;
        Summary::of_all(&ranks.share(&mine.words(held.is_some()).0)?)
    }
}
