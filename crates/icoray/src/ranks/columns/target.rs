//! The place of a field in a node's memory, beside this rank's columns of it.

use crate::ranks::Stored;
use icoray_grid::{Field, Location};

/// A field of which each rank has some columns, and the place of the gathered field.
pub(in crate::ranks) struct GatherTarget<'f> {
    /// This rank's columns.
    pub field: Field<'f>,
    /// The gathered field.
    pub whole: Stored,
}

impl GatherTarget<'_> {
    /// The layout, which must be equal on all ranks: otherwise they would overwrite each other's columns.
    pub fn facts(&self) -> [(&'static str, String); 3] {
        let (name, bits) = (display_name(&self.whole.name), if self.whole.is_f64 { 64 } else { 32 });
        let place = if self.field.location() == Location::Corner { "corners" } else { "centres" };
        [
            ("has", format!("{name} of {} layers of {bits} bits", self.whole.layers)),
            ("has", format!("{name} at {place}")),
            ("has", format!("{name} with missing values marked by {:?}", self.field.fill())),
        ]
    }
}

/// The name of a field, or of the heights, in messages.
pub fn display_name(name: &Option<String>) -> String {
    name.as_ref().map_or("heights".into(), |name| format!("{name:?}"))
}
