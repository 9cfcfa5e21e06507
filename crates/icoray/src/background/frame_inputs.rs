//! The inputs of a frame, and the outcomes of frames in the background.

use crate::fields::Fields;
use crate::plan::Plan;
use crate::ranks::{Columns, Decomposition, DistributedGrid};
use icoray_grid::{Description, Error, Grid, Layers, Result};
use icoray_output::outcomes::Outcome;
use icoray_output::{Frame, FrameReport};
use icoray_scene::Scene;
use icoray_scene::name::Stamp;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What a frame shows and what its file states, without the values of its fields.
#[derive(Debug, Clone)]
pub struct FrameSetup {
    /// Name of the view; empty if it has none.
    pub view: String,
    /// The scene to draw.
    pub scene: Arc<Scene>,
    /// The grid.
    pub grid: Arc<Grid<'static>>,
    /// The rank's part of the grid or columns of the fields; `None` if it has the whole grid and whole fields.
    pub decomposition: Option<Arc<Decomposition>>,
    /// The layers.
    pub layers: Arc<Layers>,
    /// Descriptions of the scene's fields, by name.
    pub descriptions: BTreeMap<String, Description>,
    /// The model's step and time.
    pub stamp: Stamp,
    /// Further text entries of the picture's file: key and text.
    pub notes: Vec<(&'static str, String)>,
}

/// A frame to draw and its fields.
#[derive(Debug, Clone)]
pub struct FrameInputs<'f> {
    /// All but the fields.
    pub setup: FrameSetup,
    /// The fields, with heights if the scene shows native ones. They may be more than the scene needs.
    pub fields: Fields<'f>,
}

impl FrameSetup {
    /// The grid with its distribution over ranks and its layers.
    pub fn distributed_grid(&self) -> DistributedGrid<'_> {
        DistributedGrid { grid: &self.grid, decomposition: self.decomposition.as_deref(), layers: &self.layers }
    }

    /// The grid that the picture shows; `None` if each node draws a part of it.
    pub fn drawn_grid(&self) -> Option<&Grid<'_>> {
        let decomposition = self.decomposition.as_deref();
        decomposition.map_or(Some(&self.grid), |decomposition| decomposition.drawn_grid(&self.grid))
    }

    /// The columns of the fields that this rank has; `None` if it has whole fields.
    pub(super) fn columns(&self) -> Option<(&Arc<Decomposition>, &Columns)> {
        let decomposition = self.decomposition.as_ref()?;
        match &**decomposition {
            Decomposition::Columns(columns) => Some((decomposition, columns)),
            Decomposition::Whole => None,
        }
    }

    /// Adds the view, the descriptions of fields and the notes to a rendered frame.
    pub fn describe(&self, frame: &mut Frame) {
        frame.descriptions.clone_from(&self.descriptions);
        let view = (!self.view.is_empty()).then(|| ("view", self.view.clone()));
        frame.notes.extend(view.into_iter().chain(self.notes.iter().cloned()));
    }
}

impl FrameInputs<'_> {
    /// Reduces the fields to those that the scene needs, if these suffice to render it. For ranks with columns,
    /// gathering checks that.
    pub(super) fn reduce_to_needed(&mut self) -> Result<()> {
        let FrameSetup { scene, grid, layers, .. } = &self.setup;
        self.fields = self.fields.needed_by(scene)?;
        if let (Some((_, first)), None) = (self.fields.iter().next(), self.setup.columns()) {
            Plan::new(scene, grid, layers, first)?;
        }
        Ok(())
    }
}

/// Cost of submitting frames.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Accepted {
    /// Seconds spent waiting for the frames before.
    pub waited_s: f64,
    /// Seconds of copying the fields.
    pub copy_s: f64,
    /// Bytes copied.
    pub bytes_copied: u64,
}

/// Outcome of a submitted frame.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// Step and time of the frame.
    pub stamp: Stamp,
    /// Name of its view; empty if it has none.
    pub view: String,
    /// Whether it is the first of the frames that were submitted together.
    pub is_first: bool,
    /// The frame's report, or the reason why it was not drawn. `write_s` is 0, as the frame has yet to be written; the
    /// [`Writer`](icoray_output::writer::Writer) reports the outcome of that.
    pub result: Result<FrameReport>,
    /// The frame that the writer dropped for this one.
    pub dropped: Option<Stamp>,
    /// Whether all ranks have the same result or the same error. False only for a panic outside of the phases of a
    /// frame, which other ranks receive as a frame that was broken off.
    pub is_of_all: bool,
}

impl Outcome for Drawn {
    fn error(&self) -> Option<&Error> {
        self.result.as_ref().err()
    }
}
