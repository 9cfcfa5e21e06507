//! Checks of a frame's inputs where several ranks render it.

use crate::boundary::{Failure, Outcome};
use crate::types::icoray_status;
use icoray_core::{ColumnCount, FrameInputs, FrameSetup};

/// Checks that the fields have as many columns as the whole grid, where several ranks render and no parts were set.
pub(crate) fn check_whole(FrameInputs { setup, fields }: &FrameInputs) -> Outcome<()> {
    if setup.decomposition.is_some() {
        return Ok(());
    }
    if setup.grid.cells() == 0 {
        let message = "0 cells, expected at least 1, or icoray_part_set where ranks have parts of a grid";
        return Err(Failure::new(icoray_status::ICORAY_ERR_GRID, message));
    }
    for (name, field) in fields.iter() {
        let (columns, expected) = (field.shape().columns, ColumnCount::new(&setup.grid, field.location()));
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

/// This rank's grid as a fact that must be equal on all ranks: the verb of the error message, and the description.
pub(crate) fn grid_fact(FrameSetup { grid, decomposition, .. }: &FrameSetup) -> (&'static str, String) {
    const NAME: &str = "has a grid";
    if decomposition.is_some() {
        return (NAME, "in parts of icoray_part_set".into());
    }
    let (cells, corners, center) = (grid.cells(), grid.triangles(), grid.tables().center);
    let place = if cells == 0 { [f64::NAN; 2] } else { [center.lon_rad.get(0), center.lat_rad.get(0)] };
    let [lon, lat] = place.map(f64::to_degrees);
    let whole = format!("of {cells} cells and {corners} corners, the first at {lon:.3} E {lat:.3} N");
    (NAME, whole + ", without icoray_part_set")
}
