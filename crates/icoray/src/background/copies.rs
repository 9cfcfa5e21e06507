//! Copies of the fields of a step, from which its frames are rendered.

use super::snapshot::Snapshot;
use super::{FrameInputs, FrameSetup};
use crate::fields::Fields;
use crate::plan::Plan;
use crate::ranks::{Columns, Decomposition, GatherInputs, NodeFields, Ranks};
use crate::render::Renderer;
use icoray_grid::Result;
use std::fmt;
use std::mem::take;
use std::sync::Arc;

/// Copies of this rank's fields, and whole fields that the ranks of a node gathered from their columns.
#[derive(Default)]
pub(super) struct Copies {
    own: Snapshot,
    gathered: Vec<(Arc<Decomposition>, NodeFields)>,
}

impl Copies {
    /// Copies the fields of the frames, each once, and replaces the previous copies. Collective.
    ///
    /// # Errors
    /// Equal on all ranks: those of [`Columns::gather`].
    pub fn take(&mut self, ranks: &mut Ranks, renderer: &Renderer, frames: &[(usize, FrameInputs)]) -> Result<()> {
        for (_, gathered) in take(&mut self.gathered) {
            gathered.leave(ranks);
        }
        let mut own = Fields::default();
        let mut spread: Vec<(&Arc<Decomposition>, &Columns, GatherInputs, Fields)> = Vec::new();
        for (_, FrameInputs { setup, fields: needed }) in frames {
            let Some((decomposition, columns)) = setup.columns() else {
                own = own.with(needed.clone());
                continue;
            };
            let of_derived = setup.scene.derivation_inputs();
            match spread.iter_mut().find(|(known, ..)| Arc::ptr_eq(known, decomposition)) {
                Some((_, _, inputs, fields)) => {
                    inputs.derivation_inputs.extend(of_derived);
                    // The heights are those of the first picture that needs heights.
                    inputs.layers = if fields.heights().is_some() { inputs.layers } else { &setup.layers };
                    *fields = take(fields).with(needed.clone());
                }
                None => {
                    let (grid, layers, threads) = (&*setup.grid, &*setup.layers, &renderer.threads);
                    let inputs = GatherInputs { threads, grid, layers, derivation_inputs: of_derived.collect() };
                    spread.push((decomposition, columns, inputs, needed.clone()));
                }
            }
        }
        ranks.collective_work(|| {
            self.own.take(&own, renderer);
            Ok(())
        })?;
        for (decomposition, columns, inputs, fields) in spread {
            let gathered = columns.gather(ranks, &inputs, || Ok(fields))?;
            self.gathered.push((decomposition.clone(), gathered));
        }
        Ok(())
    }

    /// The gathered fields of a frame; `None` if it is rendered from this rank's own copies.
    pub fn gathered(&self, setup: &FrameSetup) -> Option<&NodeFields> {
        let (decomposition, _) = setup.columns()?;
        self.gathered.iter().find(|(known, _)| Arc::ptr_eq(known, decomposition)).map(|(_, gathered)| gathered)
    }

    /// Checks that a frame can be rendered from the gathered columns.
    pub fn check_gathered(&self, setup: &FrameSetup) -> Result<()> {
        let Some(gathered) = self.gathered(setup) else { return Ok(()) };
        let fields = gathered.fields()?;
        let FrameSetup { scene, grid, layers, .. } = setup;
        Plan::new(scene, gathered.grid(grid), layers, fields.first(scene.field())?).map(drop)
    }

    /// This rank's own copies.
    pub fn fields(&self) -> Fields<'_> {
        self.own.fields()
    }

    /// Bytes that this rank has copied.
    pub fn bytes(&self) -> u64 {
        let gathered = self.gathered.iter().map(|(_, gathered)| gathered.bytes_copied);
        self.own.bytes() + gathered.sum::<u64>()
    }
}

impl fmt::Debug for Copies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "copies of {} bytes", self.bytes())
    }
}
