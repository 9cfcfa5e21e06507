//! The fields that a frame is drawn of, by name.

use crate::error::{Error, ErrorKind, Result};
use crate::field::Field;

/// Borrowed fields by name.
///
/// One field alone, `(&field).into()`, is the first one of any scene, whatever the scene calls it.
#[derive(Debug, Clone, Default)]
pub struct Fields<'f> {
    named: Vec<(String, Field<'f>)>,
    unnamed: Option<Field<'f>>,
}

impl<'f> Fields<'f> {
    /// Fields by name; of two with the same name the first counts.
    pub fn new<N: Into<String>>(named: impl IntoIterator<Item = (N, Field<'f>)>) -> Self {
        Fields { named: named.into_iter().map(|(name, field)| (name.into(), field)).collect(), unnamed: None }
    }

    /// The field that a scene calls `name`, where it is the scene's first.
    ///
    /// # Errors
    /// As [`Fields::get`].
    pub fn first(&self, name: &str) -> Result<&Field<'f>> {
        self.unnamed.as_ref().map_or_else(|| self.get(name), Ok)
    }

    /// The field called `name`.
    ///
    /// # Errors
    /// [`ErrorKind::Scene`] with the names that there are.
    pub fn get(&self, name: &str) -> Result<&Field<'f>> {
        let found = self.named.iter().find(|(known, _)| known == name);
        found.map(|(_, field)| field).ok_or_else(|| {
            let known: Vec<&str> = self.named.iter().map(|(name, _)| name.as_str()).collect();
            let known = if known.is_empty() { "only the first field".into() } else { format!("{known:?}") };
            Error::new(ErrorKind::Scene, format!("the scene shows field {name:?}, and there is {known}"))
        })
    }

    /// Names and fields.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Field<'f>)> {
        self.named.iter().map(|(name, field)| (name.as_str(), field))
    }
}

impl<'f> From<&Field<'f>> for Fields<'f> {
    fn from(field: &Field<'f>) -> Self {
        Fields { named: Vec::new(), unnamed: Some(*field) }
    }
}
