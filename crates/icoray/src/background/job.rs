//! Jobs for background rendering, and their outcomes.

use crate::ranks::{Decomposition, DistributedGrid};
use icoray_grid::{Description, Error, Grid, Layers, Result};
use icoray_output::FrameReport;
use icoray_output::outcomes::Outcome;
use icoray_scene::Scene;
use icoray_scene::name::Stamp;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What a frame shows, without the values of its fields.
#[derive(Debug, Clone)]
pub struct FrameSetup {
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
}

impl FrameSetup {
    /// The grid with its distribution over ranks and its layers.
    pub fn distributed_grid(&self) -> DistributedGrid<'_> {
        DistributedGrid { grid: &self.grid, decomposition: self.decomposition.as_deref(), layers: &self.layers }
    }
}

/// A frame to draw, without its fields.
#[derive(Debug, Clone)]
pub struct Job {
    /// What it shows.
    pub setup: FrameSetup,
    /// The model's step and time.
    pub stamp: Stamp,
    /// Further text entries of the picture's file: key and text.
    pub notes: Vec<(&'static str, String)>,
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
    /// The note `view` of its job.
    pub view: Option<String>,
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
