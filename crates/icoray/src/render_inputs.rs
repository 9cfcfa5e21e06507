//! The inputs of rendering a frame.

use crate::fields::Fields;
use crate::ranks::Part;
use icoray_grid::{Grid, Layers};
use icoray_scene::Scene;

/// A scene and the data that it shows.
#[derive(Clone, Copy)]
pub(crate) struct RenderInputs<'f> {
    pub scene: &'f Scene,
    pub grid: &'f Grid<'f>,
    /// The rank's part of the grid; `None` is the whole grid.
    pub part: Option<&'f Part>,
    pub layers: &'f Layers,
    pub fields: &'f Fields<'f>,
}
