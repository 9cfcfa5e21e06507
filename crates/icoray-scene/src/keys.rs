//! What a scene's keys are: the tables of the reference, which is the one description of them.
//!
//! `crates/icoray/tests/docs.rs` compares the reference with the keys that the parser knows, so that a new key is in both.

/// The reference of scene files.
const REFERENCE: &str = include_str!("../../../docs/src/scene-reference.md");

/// A section of scene files, such as `[camera]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Its name; empty for the keys at the top.
    pub name: &'static str,
    /// Whether a scene may have several (`[[surfaces]]`).
    pub is_list: bool,
    /// What it is for.
    pub about: String,
    /// Its keys, those of tables within as `range.union`.
    pub keys: Vec<Key>,
}

/// A key, in the words of the reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// Type of its value.
    pub kind: &'static str,
    /// What holds without it.
    pub default: &'static str,
    /// The values that it may have; empty where its type says all.
    pub range: &'static str,
    /// What it does.
    pub meaning: &'static str,
}

impl Key {
    /// The words that a string may be; empty where it may be any.
    pub fn choices(&self) -> Vec<&'static str> {
        if self.kind != "string" {
            return Vec::new();
        }
        self.range.split("`\"").skip(1).filter_map(|rest| rest.split("\"`").next()).collect()
    }

    /// Least and greatest number, as far as the reference has them as numbers.
    pub fn bounds(&self) -> [Option<f64>; 2] {
        let number = |text: &str| text.trim().parse().ok();
        let range = self.range.split(", ").next().unwrap_or_default();
        if let Some(least) = range.strip_prefix("from ").or(range.strip_prefix("above ")) {
            let greatest = self.range.split(", to ").nth(1).and_then(number);
            return [number(least), greatest];
        }
        match range.split_once(" to ") {
            Some((least, greatest)) => [number(least), greatest.split(';').next().and_then(number)],
            None => [None; 2],
        }
    }
}

/// All sections of a scene, in the order of the reference; not those of scripts (views, sweeps, live).
pub fn sections() -> Vec<Section> {
    REFERENCE.split("\n## ").skip(1).filter_map(section).collect()
}

fn section(text: &'static str) -> Option<Section> {
    let (heading, body) = text.split_once('\n')?;
    let name = heading.trim_matches(['`', '[', ']']);
    let is_section = heading.starts_with("`[") && !["views", "sweep", "live"].contains(&name);
    let name = match heading {
        "Top level" => "",
        _ if is_section => name,
        _ => return None,
    };
    let about = body.lines().skip_while(|line| line.is_empty()).take_while(|line| !line.is_empty());
    let about: Vec<&str> = about.filter(|line| !line.starts_with(['|', '`'])).collect();
    let (head, body) = body.split_once("\n|---")?;
    let has_range = head.lines().last()?.contains("| range |");
    // The first table alone: others are of placeholders, say.
    let rows = body.lines().skip(1).take_while(|line| line.starts_with('|'));
    let keys = rows.filter_map(|row| key(row, has_range)).collect();
    Some(Section { name, is_list: heading.starts_with("`[["), about: about.join(" "), keys })
}

fn key(row: &'static str, has_range: bool) -> Option<Key> {
    let mut cells = row.trim_matches('|').split('|').map(str::trim);
    let name = cells.next()?.trim_matches('`');
    let [kind, default] = [cells.next()?, cells.next()?];
    let range = if has_range { cells.next()? } else { "" };
    Some(Key { name, kind, default, range, meaning: cells.next()? })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key_of(name: &str, key: &str) -> Key {
        let sections = sections();
        let section = sections.iter().find(|section| section.name == name).unwrap();
        *section.keys.iter().find(|its| its.name == key).unwrap()
    }

    #[test]
    fn sections_are_those_of_scenes() {
        let sections = sections();
        let names: Vec<&str> = sections.iter().map(|section| section.name).collect();
        let expected = [
            "",
            "image",
            "camera",
            "transfer",
            "opacity",
            "volumes",
            "surfaces",
            "isosurfaces",
            "lines",
            "ground",
            "clip",
            "derive",
            "light",
            "labels",
            "output",
        ];
        assert_eq!(names, expected);
        let lists: Vec<&str> = sections.iter().filter(|section| section.is_list).map(|section| section.name).collect();
        assert_eq!(lists, ["volumes", "surfaces", "isosurfaces", "lines", "clip", "derive"]);
        assert!(sections.iter().all(|section| !section.keys.is_empty()));
    }

    #[test]
    fn keys_have_types_words_and_bounds() {
        assert_eq!(key_of("", "method").choices(), ["exact", "paper"]);
        assert_eq!(key_of("", "tolerance").bounds(), [Some(1e-12), Some(0.5)]);
        assert_eq!(key_of("camera", "lon").bounds(), [Some(-360.0), Some(360.0)]);
        assert_eq!(key_of("surfaces", "opacity").bounds(), [Some(0.0), Some(1.0)]);
        assert_eq!(key_of("ground", "land").kind, "colour");
        assert_eq!(key_of("clip", "half_space.distance").default, "0");
        assert_eq!(key_of("volumes", "field").bounds(), [None, None]);
        assert!(key_of("output", "file").choices().is_empty());
        assert!(key_of("transfer", "map").meaning.starts_with("Colour map"));
    }
}
