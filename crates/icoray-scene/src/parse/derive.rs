//! Fields that are made of others.

use super::each;
use super::text::Text;
use crate::keys::{Kind, keys, number, of, word};
use crate::scenery::{Derivation, How};
use icoray_grid::Result;
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

keys! {
    pub(super) struct RawDerivation {
        /// Name of the new field.
        name: Option<Spanned<String>> = of(Kind::Text).required().note("not derived before"),
        /// Length of the vector with these components.
        magnitude: Option<Spanned<Vec<Spanned<String>>>> = of(Kind::List(&Kind::Text)).count(2, 3),
        /// Sum of fields times factors.
        sum: Option<Spanned<BTreeMap<String, Spanned<f64>>>> = of(Kind::NumbersByName).note("finite factors"),
        /// Field from which a reference is subtracted.
        anomaly: Option<Spanned<String>> = of(Kind::Text),
        /// The mean along latitude bands, or the first step that is drawn.
        from: Option<Spanned<Reference>> = word(&["zonal mean", "first"]).or_else("required with `anomaly`"),
        /// With `"zonal mean"`: degrees of latitude per band.
        band: Option<Spanned<f64>> = number(1e-3..=180.0).or(2.0),
    }
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
enum Reference {
    #[serde(rename = "zonal mean")]
    ZonalMean,
    #[serde(rename = "first")]
    First,
}

/// All of them. Each may be made of those above it, none of itself or of those below it.
pub(super) fn derivations(source: &Text, raw: &[Spanned<RawDerivation>]) -> Result<Vec<Derivation>> {
    let derived = each(source, "derive", raw, derivation)?;
    let names: Vec<&str> = derived.iter().map(|derived| derived.name.as_str()).collect();
    for (i, derived) in derived.iter().enumerate() {
        let name = &derived.name;
        let later = derived.how.fields().into_iter().find(|field| names[i..].contains(field));
        let what = match later {
            _ if names[..i].contains(&names[i]) => format!("{name:?} is derived above already, expected another name"),
            Some(own) if own == name => format!("{own:?} is also what it is made of, expected another name"),
            Some(later) => format!("{name:?} is made of {later:?}, which is derived below; expected it above"),
            None => continue,
        };
        let span = raw[i].get_ref().name.as_ref().map_or(raw[i].span(), Spanned::span);
        return Err(source.bad(span, "derive.name", what));
    }
    Ok(derived)
}

fn derivation(source: &Text, raw: &Spanned<RawDerivation>) -> Result<Derivation> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let Some(name) = &raw.name else { return Err(source.bad(span, "name", "is absent, expected a name")) };
    let name = source.name(name, "name")?;
    let how = match (&raw.magnitude, &raw.sum, &raw.anomaly) {
        (Some(fields), None, None) => magnitude(source, fields)?,
        (None, Some(terms), None) => sum(source, terms)?,
        (None, None, Some(field)) => return Ok(Derivation { name, how: anomaly(source, raw, field)? }),
        _ => return Err(source.bad(span, "name", "expected one of magnitude, sum and anomaly beside it")),
    };
    let strays = [("from", raw.from.as_ref().map(Spanned::span)), ("band", raw.band.as_ref().map(Spanned::span))];
    match strays.into_iter().find_map(|(key, span)| Some((key, span?))) {
        Some((key, span)) => Err(source.bad(span, key, "is valid only with anomaly")),
        None => Ok(Derivation { name, how }),
    }
}

fn magnitude(source: &Text, raw: &Spanned<Vec<Spanned<String>>>) -> Result<How> {
    let fields = raw.get_ref().iter().map(|field| source.name(field, "magnitude"));
    let fields = fields.collect::<Result<Vec<String>>>()?;
    source.expect_count(fields.len(), raw.span(), "magnitude")?;
    Ok(How::Magnitude(fields))
}

/// The terms in the order of the file: sums that are rounded depend on it.
fn sum(source: &Text, raw: &Spanned<BTreeMap<String, Spanned<f64>>>) -> Result<How> {
    let mut terms: Vec<_> = raw.get_ref().iter().collect();
    terms.sort_by_key(|(_, factor)| factor.span().start);
    if terms.is_empty() {
        return Err(source.bad(raw.span(), "sum", "no fields, expected { NAME = factor, ... }"));
    }
    let term = |(field, factor): (&String, &Spanned<f64>)| {
        if field.is_empty() {
            return Err(source.bad(factor.span(), "sum", "an empty name"));
        }
        Ok((source.finite(factor, "sum")?, field.clone()))
    };
    Ok(How::Combination(terms.into_iter().map(term).collect::<Result<_>>()?))
}

fn anomaly(source: &Text, raw: &RawDerivation, field: &Spanned<String>) -> Result<How> {
    let name = source.name(field, "anomaly")?;
    let Some(from) = &raw.from else {
        return Err(source.bad(field.span(), "anomaly", "expected from = \"zonal mean\" or \"first\" beside it"));
    };
    match (from.get_ref(), &raw.band) {
        (Reference::ZonalMean, band) => {
            let band_deg = source.number(band.as_ref(), "band")?;
            Ok(How::FromZonalMean { field: name, band_deg })
        }
        (Reference::First, None) => Ok(How::FromFirst(name)),
        (Reference::First, Some(band)) => {
            Err(source.bad(band.span(), "band", "is valid only with from = \"zonal mean\""))
        }
    }
}
