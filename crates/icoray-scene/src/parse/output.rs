//! The names of the pictures and of the maps of their errors.

use super::text::Text;
use crate::keys::{Kind, keys, of};
use crate::name::{NameTemplate, Output};
use icoray_grid::Result;
use toml::Spanned;

keys! {
    pub(super) struct RawOutput {
        /// Name of the picture. Of a view `{view}_` stands before it, and swept keys after it.
        file: Option<Spanned<String>> = of(Kind::Text)
            .or_else("`\"{field}_{step:06}.png\"`, in a model `\"{field}_{when}.png\"`")
            .note("ends in `.png` or `.exr`"),
        /// Name of a map of errors.
        error: Option<Spanned<String>> = of(Kind::Text).note("ends in `.png`"),
    }
}

fn template(source: &Text, raw: &Spanned<String>, key: &str) -> Result<NameTemplate> {
    NameTemplate::new(raw.get_ref()).map_err(|e| source.bad(raw.span(), key, e.context()))
}

pub(super) fn output(source: &Text, raw: Option<&RawOutput>) -> Result<Output> {
    let (file, error) = raw.map_or((None, None), |o| (o.file.as_ref(), o.error.as_ref()));
    let file = match file {
        Some(raw) => template(source, raw, "output.file")?,
        None => NameTemplate::new("{field}_{step:06}.png")?,
    };
    let Some(raw) = error else { return Ok(file.into()) };
    let (text, key) = (raw.get_ref(), "output.error");
    let error = template(source, raw, key)?;
    if !text.ends_with(".png") {
        return Err(source.bad(raw.span(), key, format!("{text:?}: expected a name that ends in .png")));
    }
    if error == file {
        let what = "the same as output.file, expected another name";
        return Err(source.bad(raw.span(), key, format!("{text:?}: {what}")));
    }
    Ok(Output { error: Some(error), ..file.into() })
}
