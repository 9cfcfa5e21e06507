//! Reading tables of scripts key by key.

use crate::parse::text::Text;
use icoray_grid::Result;
use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

/// Largest number of pictures of one step.
pub(super) const MAX_PICTURES: usize = 100_000;

/// Takes a key out of a table.
pub(super) fn take<T: DeserializeOwned>(source: &Text, table: &mut DeTable, key: &str) -> Result<Option<Spanned<T>>> {
    let Some(value) = table.remove(key) else { return Ok(None) };
    let span = value.span();
    let value = T::deserialize(ValueDeserializer::from(value)).map_err(|e| match e.span() {
        Some(_) => source.refused(&e),
        None => source.bad(span.clone(), key, e.message()),
    })?;
    Ok(Some(Spanned::new(span, value)))
}

/// A table of a table, where there is one.
pub(super) fn section<'t, 's>(table: &'s mut DeTable<'t>, key: &str) -> Option<&'s mut DeTable<'t>> {
    match table.get_mut(key)?.get_mut() {
        DeValue::Table(table) => Some(table),
        _ => None,
    }
}
