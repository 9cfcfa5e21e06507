//! Lists whose product is drawn: `[sweep]`.

use super::{MAX_PICTURES, section};
use crate::keys::{Key, Kind, keys, of};
use crate::parse::text::Text;
use crate::script::{Axis, Motion, Sweep};
use icoray_grid::Result;
use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

/// Keys of the section.
pub const KEYS: &[Key] = keys! {
    /// Longitudes of the camera.
    lon = of(NUMBERS).within(-360.0..=360.0),
    /// Latitudes of the camera.
    lat = of(NUMBERS).within(-90.0..=90.0),
    /// Distances of the camera.
    distance = of(NUMBERS).within(1e-6..=1e6),
    /// Exaggerations.
    exaggeration = of(NUMBERS).within(1e-6..=1e6),
    /// Fields of the volume; not with `[[volumes]]`.
    field = of(Kind::List(&Kind::Text)),
};

const NUMBERS: Kind = Kind::List(&Kind::Number);

/// The sweep of a view. The scene's own camera, exaggeration and field get the first values of lists where they are not
/// given.
pub fn sweep(source: &Text, root: &mut DeTable, motion: &Motion) -> Result<Sweep> {
    let Some(raw) = root.remove("sweep") else { return Ok(Sweep::default()) };
    let span = raw.span();
    let bad = |what: &str| source.bad(span.clone(), "sweep", what);
    let DeValue::Table(lists) = raw.into_inner() else { return Err(bad("expected a table of lists")) };
    let mut lists: Vec<_> = lists.into_iter().collect();
    lists.sort_by_key(|(key, _)| key.span().start);
    let mut axes = Vec::new();
    for (key, list) in lists {
        let name = key.get_ref().to_string();
        if matches!(name.as_str(), "lon" | "lat" | "distance") {
            expect_place(source, root, motion, &name, &list)?;
        }
        if name == "field" && root.contains_key("volumes") {
            let what = "is valid only with field and [transfer] of one volume, not with [[volumes]]";
            return Err(source.bad(list.span(), "sweep.field", what));
        }
        fill(root, &name, &list);
        axes.push(axis(source, &name, list)?);
    }
    if axes.is_empty() {
        return Err(bad("nothing, expected lists of lon, lat, distance, exaggeration or field"));
    }
    let sweep = Sweep { axes };
    if sweep.count() > MAX_PICTURES {
        return Err(bad(&format!("{} pictures of each step, expected at most {MAX_PICTURES}", sweep.count())));
    }
    Ok(sweep)
}

/// Refuses sweeps of the camera's place if eye, path or orbit define it.
fn expect_place(source: &Text, root: &mut DeTable, motion: &Motion, name: &str, list: &Spanned<DeValue>) -> Result<()> {
    let bad = |what: &str| Err(source.bad(list.span(), &format!("sweep.{name}"), what));
    if section(root, "camera").is_some_and(|camera| camera.contains_key("eye")) {
        return bad("is valid only with a camera above a place (lon, lat), not with eye");
    }
    match motion {
        Motion::Path(_) => bad("is not valid with camera.path, which places the camera"),
        Motion::Orbit(_) if name == "lon" => bad("is not valid with camera.orbit, which turns the camera"),
        _ => Ok(()),
    }
}

/// Inserts the first value of a sweep's list for a key that is absent.
fn fill<'t>(root: &mut DeTable<'t>, name: &str, list: &Spanned<DeValue<'t>>) {
    let Some(first) = list.get_ref().get(0) else { return };
    let key = Spanned::new(list.span(), std::borrow::Cow::Owned(name.to_owned()));
    let table = if matches!(name, "lon" | "lat" | "distance") { section(root, "camera") } else { Some(root) };
    if let Some(table) = table {
        let is_given = table.contains_key(name) || name == "distance" && table.contains_key("altitude");
        if !is_given {
            table.insert(key, first.clone());
        }
    }
}

fn axis(source: &Text, name: &str, list: Spanned<DeValue>) -> Result<Axis> {
    let (key, span) = (format!("sweep.{name}"), list.span());
    let refused = |e: toml::de::Error| source.refused(&e);
    let expect_some = |count: usize| match count {
        0 => Err(source.bad(span.clone(), &key, "an empty list, expected values")),
        _ => Ok(()),
    };
    if name == "field" {
        let names = Vec::<Spanned<String>>::deserialize(ValueDeserializer::from(list)).map_err(refused)?;
        expect_some(names.len())?;
        let is_bad = |name: &&Spanned<String>| name.get_ref().is_empty() || name.get_ref().contains(char::is_control);
        if let Some(bad) = names.iter().find(is_bad) {
            return Err(source.bad(bad.span(), &key, format!("{:?}, expected a name", bad.get_ref())));
        }
        return Ok(Axis::Field(names.into_iter().map(Spanned::into_inner).collect()));
    }
    let axis: fn(Vec<f64>) -> Axis = match name {
        "lon" => Axis::Lon,
        "lat" => Axis::Lat,
        "distance" => Axis::Distance,
        "exaggeration" => Axis::Exaggeration,
        _ => {
            let wish = "an unknown key, expected lon, lat, distance, exaggeration or field";
            return Err(source.bad(span, &key, wish));
        }
    };
    let numbers = Vec::<Spanned<f64>>::deserialize(ValueDeserializer::from(list)).map_err(refused)?;
    expect_some(numbers.len())?;
    let checked = numbers.iter().map(|number| source.number(Some(number), &key));
    checked.collect::<Result<Vec<f64>>>().map(axis)
}
