//! The text of a scene file with other keys.

use super::merge::merge;
use super::section::take;
use crate::did_you_mean;
use crate::parse::text::Text;
use crate::script::Script;
use icoray_grid::{Error, ErrorKind, Result};
use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

impl Script {
    /// The text of a scene file in which the keys of `over`, TOML too, stand in place of its own, as those of a view
    /// would: tables are merged key by key, arrays are replaced. With the name of a `view` of the file, the text has that
    /// view alone. Comments of the file are not kept.
    ///
    /// ```
    /// use icoray_scene::Script;
    ///
    /// let text = "field = 'q'
    ///             camera = { eye = [3, 0, 0] }
    ///             [[views]]
    ///             name = 'a'
    ///             [[views]]
    ///             name = 'b'
    ///             tolerance = 0.01";
    /// let text = Script::text_with(text, Some("b"), "camera = { lon = 10, lat = 20 }")?;
    /// let table: toml::Table = text.parse().unwrap();
    /// assert_eq!(table["tolerance"].as_float(), Some(0.01));
    /// assert_eq!(table["camera"].as_table().unwrap().len(), 2, "lon and lat go in place of eye");
    /// # Ok::<(), icoray_grid::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`ErrorKind::Scene`] for texts that are not TOML, and for a view that the file does not have.
    pub fn text_with(text: &str, view: Option<&str>, over: &str) -> Result<String> {
        let source = &Text::new(text);
        let mut base = source.table()?;
        if let Some(name) = view {
            let over = named_view(source, base.get_mut(), name)?;
            merge(base.get_mut(), over);
        }
        merge(base.get_mut(), Text::new(over).table()?.into_inner());
        let mut table = toml::Table::deserialize(toml::Deserializer::from(base)).map_err(|e| source.refused(&e))?;
        if let Some(name) = view {
            // It keeps its name, which names of files may have.
            let name = toml::Table::from_iter([("name".to_owned(), name.into())]);
            table.insert("views".into(), toml::Value::Array(vec![name.into()]));
        }
        toml::to_string(&table).map_err(|e| Error::new(ErrorKind::Scene, format!("cannot write the scene: {e}")))
    }
}

/// Takes the views out of a file and returns the keys of one.
fn named_view<'t>(source: &Text, base: &mut DeTable<'t>, name: &str) -> Result<DeTable<'t>> {
    let mut names = Vec::new();
    if let Some(DeValue::Array(views)) = base.remove("views").map(Spanned::into_inner) {
        for view in views {
            let DeValue::Table(mut keys) = view.into_inner() else { continue };
            let its = take::<String>(source, &mut keys, "name")?.map(Spanned::into_inner).unwrap_or_default();
            if its == name {
                return Ok(keys);
            }
            names.push(its);
        }
    }
    let known =
        if names.is_empty() { "the scene has no [[views]]".into() } else { format!("expected one of {names:?}") };
    let hint = did_you_mean(name, names.iter().map(String::as_str));
    Err(Error::new(ErrorKind::Scene, format!("view {name:?}{hint}, {known}")))
}
