//! The description of fields, keys and colour maps that the page reads.

use crate::steering::may_steer;
use icoray::keys::{ListedKey, Section, sections};
use icoray::{color_map_stops, color_maps};
use serde::Serialize;
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

/// The data that the page receives once.
#[derive(Serialize)]
pub(crate) struct DescribeAnswer<'d> {
    program: &'static str,
    #[serde(flatten)]
    description: &'d Description,
    sections: Vec<SectionAnswer>,
    maps: Vec<MapAnswer>,
}

#[derive(Serialize)]
struct SectionAnswer {
    name: String,
    is_list: bool,
    about: &'static str,
    keys: Vec<KeyAnswer>,
}

#[derive(Serialize)]
struct KeyAnswer {
    name: String,
    #[serde(rename = "type")]
    kind: String,
    choices: &'static [&'static str],
    default: String,
    range: String,
    min: Option<f64>,
    max: Option<f64>,
    meaning: &'static str,
}

#[derive(Serialize)]
struct MapAnswer {
    name: &'static str,
    colors: Vec<String>,
}

impl<'d> DescribeAnswer<'d> {
    pub fn new(description: &'d Description) -> Self {
        let mut sections: Vec<_> = sections().into_iter().map(SectionAnswer::from).collect();
        if description.live {
            // The page has controls for the described keys: none for keys of the model.
            for section in &mut sections {
                let path = |key: &str| {
                    if section.name.is_empty() { key.to_owned() } else { format!("{}.{key}", section.name) }
                };
                section.keys.retain(|key| may_steer(&path(&key.name)));
            }
            sections.retain(|section| !section.keys.is_empty());
        }
        let names = color_maps().split(", ").map(str::trim);
        let maps = names.filter_map(|name| {
            let colors = color_map_stops(name, SWATCH)?;
            Some(MapAnswer { name, colors: colors.into_iter().map(hex).collect() })
        });
        DescribeAnswer {
            program: concat!("icoray ", env!("CARGO_PKG_VERSION")),
            description,
            sections,
            maps: maps.collect(),
        }
    }
}

/// A colour in CSS notation.
pub(crate) fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

impl From<Section> for SectionAnswer {
    fn from(section: Section) -> Self {
        let keys = section.keys.into_iter().map(|ListedKey { name, key }| KeyAnswer {
            name,
            kind: key.kind.to_string().replace('`', ""),
            choices: key.choices(),
            default: key.default.to_string(),
            range: key.range_text(),
            min: number(key.bounds.0),
            max: number(key.bounds.1),
            meaning: key.meaning,
        });
        let keys = keys.collect();
        SectionAnswer { name: section.name, is_list: section.is_list, about: section.about, keys }
    }
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

    #[test]
    fn all_maps_have_swatches_and_sections_their_keys() {
        let description = Description { title: "a.nc".to_owned(), ..Description::default() };
        let answer = DescribeAnswer::new(&description);
        assert_eq!(answer.maps.len(), 108);
        assert!(answer.maps.iter().all(|map| map.colors.len() == SWATCH && map.colors[0].len() == 7));
        let viridis = answer.maps.iter().find(|map| map.name == "viridis").unwrap();
        assert_eq!((viridis.colors[0].as_str(), viridis.colors[15].as_str()), ("#440154", "#fee825"));
        let text = serde_json::to_value(&answer).unwrap();
        assert_eq!(text["title"], "a.nc");
        assert_eq!(text["sections"][0]["keys"][0]["name"], "field");
        assert!(sections_of(&answer).contains(&"output"));
        let opacity = text["sections"][6]["keys"].as_array().unwrap().last().unwrap();
        assert_eq!((&opacity["name"], &opacity["type"]), (&"opacity".into(), &"number".into()));
        assert_eq!((opacity["min"].as_f64(), opacity["max"].as_f64()), (Some(0.0), Some(1.0)));
    }

    fn sections_of<'a>(answer: &'a DescribeAnswer) -> Vec<&'a str> {
        answer.sections.iter().map(|section| section.name.as_str()).collect()
    }

    #[test]
    fn keys_of_a_model_are_not_described() {
        let description = Description { live: true, ..Description::default() };
        let answer = DescribeAnswer::new(&description);
        let names = sections_of(&answer);
        assert!(["", "camera", "transfer", "isosurfaces", "clip"].iter().all(|name| names.contains(name)), "{names:?}");
        assert!(["image", "output", "derive"].iter().all(|name| !names.contains(name)), "{names:?}");
        let keys = |name: &str| {
            let section = answer.sections.iter().find(|section| section.name == name).unwrap();
            section.keys.iter().map(|key| key.name.as_str()).collect::<Vec<_>>()
        };
        assert_eq!(keys(""), ["field", "exaggeration", "background", "core"]);
        assert!(keys("clip").contains(&"half_space.towards") && keys("transfer").contains(&"range.union"));
    }
}
