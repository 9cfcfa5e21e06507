//! Selects the layers of a field that are read and drawn.

use crate::field::FieldInfo;
use icoray::{Error, ErrorKind, Result};
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// A range of layers, counted from 0 and without the last, whose ends may be left out: `0..20`, `5..`, `..`.
///
/// ```
/// use icoray_dataset::LayerSelection;
///
/// assert!("..".parse::<LayerSelection>().unwrap().is_all());
/// assert_eq!("5..".parse::<LayerSelection>().unwrap().to_string(), "5..");
/// assert!("5".parse::<LayerSelection>().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LayerSelection {
    from: usize,
    to: Option<usize>,
}

impl FromStr for LayerSelection {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let ends = text.split_once("..").and_then(|(from, to)| {
            let from = if from.is_empty() { 0 } else { from.parse().ok()? };
            let to = if to.is_empty() { None } else { Some(to.parse().ok()?) };
            Some(LayerSelection { from, to })
        });
        ends.ok_or_else(|| "expected a range of layers such as 0..20 or 5..".to_owned())
    }
}

impl fmt::Display for LayerSelection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.from, self.to.map_or_else(String::new, |to| to.to_string()))
    }
}

impl LayerSelection {
    /// The selected layers of a field; of a 2D field those of the shell that shows it.
    ///
    /// # Errors
    /// [`ErrorKind::Argument`] if some layers of a 2D field are selected, fewer than 2, or any that the field does not
    /// have.
    pub fn of(&self, info: &FieldInfo) -> Result<Range<usize>> {
        if self.is_all() {
            return Ok(info.all_layers());
        }
        if info.is_2d() {
            let context = format!("layers {self}: {} is a 2D field, expected a field with layers", info.name);
            return Err(Error::new(ErrorKind::Argument, context));
        }
        let range = self.from..self.to.unwrap_or(info.layers);
        if range.len() < 2 || range.end > info.layers {
            let context = format!("layers {self}: expected at least 2 of the {} layers of {}", info.layers, info.name);
            return Err(Error::new(ErrorKind::Argument, context));
        }
        Ok(range)
    }

    /// Whether all layers are selected.
    pub fn is_all(&self) -> bool {
        *self == LayerSelection::default()
    }
}
