//! The names of the pictures and of the maps of their errors.

use super::text::Text;
use crate::name::{NameTemplate, Output};
use icoray_grid::Result;
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawOutput {
    file: Option<Spanned<String>>,
    error: Option<Spanned<String>>,
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
