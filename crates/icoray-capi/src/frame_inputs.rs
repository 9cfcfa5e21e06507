//! Inputs of one frame: scene, grid, layers and fields.

use crate::boundary::{Failure, Outcome};
use crate::message::listed;
use crate::types::icoray_status;
use icoray_core::{ColumnCount, Fields, FrameSetup, Grid};

/// The inputs of one frame.
pub(crate) struct FrameInputs<'a> {
    /// Name of the view; empty if it has none.
    pub view: String,
    pub setup: FrameSetup,
    /// The fields that the scene needs, by name; with heights if it shows native ones.
    pub fields: Fields<'a>,
    /// The names of those that have one value per column.
    pub fields_2d: Vec<String>,
}

impl FrameInputs<'_> {
    /// Checks that the fields have as many columns as the whole grid, where several ranks render and no parts were set.
    pub fn check_whole(&self) -> Outcome<()> {
        if self.setup.decomposition.is_some() {
            return Ok(());
        }
        if self.setup.grid.cells() == 0 {
            let message = "0 cells, expected at least 1, or icoray_part_set where ranks have parts of a grid";
            return Err(Failure::new(icoray_status::ICORAY_ERR_GRID, message));
        }
        for (name, field) in self.fields.iter() {
            let (columns, expected) = (field.shape().columns, ColumnCount::new(&self.setup.grid, field.location()));
            if columns != expected.columns {
                let parts =
                    || "those of the whole grid; call icoray_part_set where ranks have some columns each".to_owned();
                let why = expected.explain(columns).unwrap_or_else(parts);
                let message = format!("field {name:?}: {columns} columns, expected {}, {why}", expected.columns);
                return Err(Failure::new(icoray_status::ICORAY_ERR_FIELD, message));
            }
        }
        Ok(())
    }

    /// The grid that the picture shows; `None` where each node draws a part of it.
    pub fn drawn_grid(&self) -> Option<&Grid<'_>> {
        self.setup
            .decomposition
            .as_ref()
            .map_or(Some(&*self.setup.grid), |decomposition| decomposition.drawn_grid(&self.setup.grid))
    }

    /// The 2D fields as a fact that must be equal on all ranks, which show them as surfaces.
    pub fn fields_2d(&self) -> (&'static str, String) {
        ("has fields of one layer:", listed(self.fields_2d.iter().map(String::as_str)))
    }

    /// This rank's grid as a fact that must be equal on all ranks: the verb of the error message, and the description.
    pub fn grid_description(&self) -> (&'static str, String) {
        const NAME: &str = "has a grid";
        if self.setup.decomposition.is_some() {
            return (NAME, "in parts of icoray_part_set".into());
        }
        let (cells, corners, center) =
            (self.setup.grid.cells(), self.setup.grid.triangles(), self.setup.grid.tables().center);
        let place = if cells == 0 { [f64::NAN; 2] } else { [center.lon_rad.get(0), center.lat_rad.get(0)] };
        let [lon, lat] = place.map(f64::to_degrees);
        let whole = format!("of {cells} cells and {corners} corners, the first at {lon:.3} E {lat:.3} N");
        (NAME, whole + ", without icoray_part_set")
    }
}
