//! The description of fields, keys and colour maps that the page reads.

use crate::steering::may_steer;
use icoray::keys::{ListedKey, Section, sections};
use icoray::{color_map_stops, color_maps};
use serde::Serialize;
use serde_json::{Value, json};
use std::ops::Bound;

/// Colours of a swatch.
const SWATCH: usize = 16;

/// Description of a program's data.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Description {
    /// The title, such as the file's name.
    pub title: String,
    /// Whether it is a running model: then keys of the model have no control.
    pub live: bool,
    /// The fields that can be shown.
    pub fields: Vec<FieldDescription>,
    /// Names of the times; empty for a time without a name.
    pub times: Vec<String>,
    /// Number of layers.
    pub layers: usize,
    /// The command that draws the scene once it is saved as `scene.toml`; `{time}` stands for the number of the time.
    #[serde(skip)]
    pub command: String,
}

/// A field that can be shown.
#[derive(Debug, Clone, Default, Serialize)]
pub struct FieldDescription {
    /// Its name.
    pub name: String,
    /// Its long name.
    pub long_name: Option<String>,
    /// Its units.
    pub units: Option<String>,
    /// Number of layers, 0 for a 2D field.
    pub layers: usize,
}

impl Description {
    /// The data that the page receives once.
    pub(crate) fn answer(&self) -> Value {
        let mut sections = sections();
        if self.live {
            // The page has controls for the described keys: none for keys of the model.
            for section in &mut sections {
                let path = |key: &str| {
                    if section.name.is_empty() { key.to_owned() } else { format!("{}.{key}", section.name) }
                };
                section.keys.retain(|key| may_steer(&path(&key.name)));
            }
            sections.retain(|section| !section.keys.is_empty());
        }
        let maps = color_maps().split(", ").map(str::trim).filter_map(|name| {
            let colors = color_map_stops(name, SWATCH)?.into_iter().map(hex).collect::<Vec<_>>();
            Some(json!({ "name": name, "colors": colors }))
        });
        let mut answer = json!(self);
        answer["program"] = concat!("icoray ", env!("CARGO_PKG_VERSION")).into();
        answer["sections"] = sections.iter().map(section_answer).collect();
        answer["maps"] = maps.collect();
        answer
    }
}

/// A colour in CSS notation.
pub(crate) fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn section_answer(section: &Section) -> Value {
    let keys = section.keys.iter().map(|ListedKey { name, key }| {
        json!({
            "name": name,
            "type": key.kind.to_string().replace('`', ""),
            "choices": key.choices(),
            "default": key.default.to_string(),
            "range": key.range_text(),
            "min": number(key.bounds.0),
            "max": number(key.bounds.1),
            "meaning": key.meaning,
        })
    });
    let keys = keys.collect::<Vec<_>>();
    json!({ "name": section.name, "is_list": section.is_list, "about": section.about, "keys": keys })
}

/// The number of a bound.
fn number(bound: Bound<f64>) -> Option<f64> {
    match bound {
        Bound::Included(number) | Bound::Excluded(number) => Some(number),
        Bound::Unbounded => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The entry of a list of tables that has a name.
    fn named<'a>(list: &'a Value, name: &str) -> Option<&'a Value> {
        list.as_array().unwrap().iter().find(|entry| entry["name"] == name)
    }

    #[test]
    fn all_maps_have_swatches_and_sections_their_keys() {
        let answer = Description { title: "a.nc".to_owned(), ..Description::default() }.answer();
        let maps = answer["maps"].as_array().unwrap();
        assert_eq!(maps.len(), 108);
        assert!(maps.iter().all(|map| map["colors"].as_array().unwrap().len() == SWATCH));
        let viridis = &named(&answer["maps"], "viridis").unwrap()["colors"];
        assert_eq!((&viridis[0], &viridis[15]), (&json!("#440154"), &json!("#fee825")));
        assert_eq!(answer["title"], "a.nc");
        assert_eq!(answer["sections"][0]["keys"][0]["name"], "field");
        assert!(named(&answer["sections"], "output").is_some());
        let opacity = answer["sections"][6]["keys"].as_array().unwrap().last().unwrap();
        assert_eq!((&opacity["name"], &opacity["type"]), (&json!("opacity"), &json!("number")));
        assert_eq!((&opacity["min"], &opacity["max"]), (&json!(0.0), &json!(1.0)));
    }

    #[test]
    fn keys_of_a_model_are_not_described() {
        let answer = Description { live: true, ..Description::default() }.answer();
        let section = |name: &str| named(&answer["sections"], name);
        assert!(["", "camera", "transfer", "isosurfaces", "clip"].iter().all(|name| section(name).is_some()));
        assert!(["image", "output", "derive"].iter().all(|name| section(name).is_none()));
        let top = section("").unwrap()["keys"].as_array().unwrap().iter().map(|key| key["name"].as_str().unwrap());
        assert_eq!(top.collect::<Vec<_>>(), ["field", "exaggeration", "background", "core"]);
        for (section_name, key) in [("clip", "half_space.towards"), ("transfer", "range.union")] {
            assert!(named(&section(section_name).unwrap()["keys"], key).is_some(), "{section_name}.{key}");
        }
    }
}
