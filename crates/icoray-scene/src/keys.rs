//! The schema of scene files: the keys of each section with their types, defaults, bounds and meanings.
//!
//! The structs that the parser reads are declared by `keys!`, which makes an entry of the schema of each field, so that
//! no key is in one and not in the other. The parser takes bounds, choices and numeric defaults from the schema; the
//! page of `icoray view` makes its controls of it; `docs/src/scene-reference.md` has its tables, which a test writes.

use crate::parse::{FILE, SCENE};
use icoray_grid::numbers;
use std::fmt;
use std::ops::{Bound, RangeBounds, RangeInclusive};

/// Type of a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// `true` or `false`.
    Boolean,
    /// An integer.
    Integer,
    /// An integer or a float.
    Number,
    /// Any string.
    Text,
    /// One of these strings.
    Word(&'static [&'static str]),
    /// An opaque CSS colour, or one of these strings.
    Color(&'static [&'static str]),
    /// The number of a layer, or one of these strings.
    Layer(&'static [&'static str]),
    /// A list of numbers with these names.
    Vector(&'static [&'static str]),
    /// Numbers by names that the scene chooses.
    NumbersByName,
    /// A list of values of one kind.
    List(&'static Kind),
    /// A value of either kind.
    Either(&'static Kind, &'static Kind),
    /// A table, whose keys are [`Key::parts`]; they are listed with those of the section around it.
    Table,
    /// A table, whose keys are [`Key::parts`]; they are listed as a section.
    Section,
}

/// The value of an absent key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DefaultValue {
    /// No value.
    None,
    /// The key must be given.
    Required,
    /// A number.
    Number(f64),
    /// A boolean.
    Flag(bool),
    /// A string.
    Word(&'static str),
    /// Another value, as TOML.
    Toml(&'static str),
    /// A value that depends on others, in words.
    Described(&'static str),
}

/// A key. `keys!` takes name and meaning from the declaration; a constructor for each kind and a method for each other
/// property make the rest, so that a property of few keys is stated at these alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// Its meaning, in Markdown.
    pub meaning: &'static str,
    /// Type of its value.
    pub kind: Kind,
    /// The value of an absent key.
    pub default: DefaultValue,
    /// Valid numbers; of a list or vector, those of each element.
    pub bounds: (Bound<f64>, Bound<f64>),
    /// Least and greatest number of a list's elements.
    pub count: [usize; 2],
    /// Further restrictions of valid values, in Markdown.
    pub note: &'static str,
    /// The keys of a table.
    pub parts: &'static [&'static [Key]],
}

/// A section of a scene file, such as `[camera]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Its path, such as `camera.orbit`; empty for the keys at the top.
    pub name: String,
    /// Whether a scene may have several (`[[surfaces]]`).
    pub is_list: bool,
    /// Its purpose, in Markdown.
    pub about: &'static str,
    /// Its keys, a table's own after the table.
    pub keys: Vec<ListedKey>,
}

/// A key in the list of a section.
#[derive(Debug, Clone, PartialEq)]
pub struct ListedKey {
    /// Its name in the section: `range.union` for a key of a table.
    pub name: String,
    /// The key.
    pub key: &'static Key,
}

/// Declares the keys of a table: `name = properties` each, after its meaning as a doc comment; or `name: type =
/// properties` in a struct, which has `KEYS` beside the fields and is read from TOML with those keys and no others.
macro_rules! keys {
    ($vis:vis struct $name:ident { $($(#[doc = $doc:literal])* $key:ident: $type:ty = $properties:expr,)* }) => {
        #[derive(serde::Deserialize, Default)]
        #[serde(default, deny_unknown_fields)]
        $vis struct $name { $($(#[doc = $doc])* $key: $type,)* }

        impl $name {
            pub const KEYS: &'static [crate::keys::Key] =
                crate::keys::keys! { $($(#[doc = $doc])* $key = $properties,)* };
        }
    };
    ($($(#[doc = $doc:literal])* $key:ident = $properties:expr,)*) => {
        &[$(crate::keys::Key {
            name: stringify!($key),
            meaning: concat!($($doc),*).trim_ascii_start(),
            ..$properties
        }),*]
    };
}
pub(crate) use keys;

/// A key of a kind without a default.
pub(crate) const fn of(kind: Kind) -> Key {
    Key {
        name: "",
        meaning: "",
        kind,
        default: DefaultValue::None,
        bounds: (Bound::Unbounded, Bound::Unbounded),
        count: [0, usize::MAX],
        note: "",
        parts: &[],
    }
}

pub(crate) const fn flag(default: bool) -> Key {
    Key { default: DefaultValue::Flag(default), ..of(Kind::Boolean) }
}

pub(crate) const fn integer(valid: RangeInclusive<u32>) -> Key {
    of(Kind::Integer).within(*valid.start() as f64..=*valid.end() as f64)
}

pub(crate) const fn number(valid: RangeInclusive<f64>) -> Key {
    of(Kind::Number).within(valid)
}

/// A string that is one of `words`.
pub(crate) const fn word(words: &'static [&'static str]) -> Key {
    of(Kind::Word(words))
}

/// The number of a layer, from 0, or one of `words`.
pub(crate) const fn layer(words: &'static [&'static str]) -> Key {
    Key { bounds: (Bound::Included(0.0), Bound::Unbounded), note: "the innermost", ..of(Kind::Layer(words)) }
}

/// A table whose keys are listed with those around it.
pub(crate) const fn table(parts: &'static [&'static [Key]]) -> Key {
    Key { parts, ..of(Kind::Table) }
}

/// A table whose keys are a section.
pub(crate) const fn section(parts: &'static [&'static [Key]]) -> Key {
    Key { parts, ..of(Kind::Section) }
}

/// A list of tables whose keys are a section.
pub(crate) const fn sections_of(parts: &'static [&'static [Key]]) -> Key {
    Key { parts, ..of(Kind::List(&Kind::Section)) }
}

impl Key {
    pub(crate) const fn required(self) -> Key {
        Key { default: DefaultValue::Required, ..self }
    }

    pub(crate) const fn or(self, default: f64) -> Key {
        Key { default: DefaultValue::Number(default), ..self }
    }

    pub(crate) const fn or_word(self, default: &'static str) -> Key {
        Key { default: DefaultValue::Word(default), ..self }
    }

    pub(crate) const fn or_toml(self, default: &'static str) -> Key {
        Key { default: DefaultValue::Toml(default), ..self }
    }

    /// With a default in words.
    pub(crate) const fn or_else(self, default: &'static str) -> Key {
        Key { default: DefaultValue::Described(default), ..self }
    }

    pub(crate) const fn within(self, valid: RangeInclusive<f64>) -> Key {
        Key { bounds: (Bound::Included(*valid.start()), Bound::Included(*valid.end())), ..self }
    }

    /// Excludes the lower bound.
    pub(crate) const fn above(self, low: f64) -> Key {
        Key { bounds: (Bound::Excluded(low), self.bounds.1), ..self }
    }

    /// Excludes the upper bound.
    pub(crate) const fn below(self, high: f64) -> Key {
        Key { bounds: (self.bounds.0, Bound::Excluded(high)), ..self }
    }

    pub(crate) const fn count(self, min: usize, max: usize) -> Key {
        Key { count: [min, max], ..self }
    }

    pub(crate) const fn note(self, note: &'static str) -> Key {
        Key { note, ..self }
    }

    /// The keys of a table.
    pub fn keys(&self) -> impl Iterator<Item = &'static Key> + use<> {
        self.parts.iter().copied().flatten()
    }

    /// The strings that a value may be; with [`Kind::Word`] it is one of them.
    pub fn choices(&self) -> &'static [&'static str] {
        match self.kind {
            Kind::Word(words) | Kind::Color(words) | Kind::Layer(words) => words,
            _ => &[],
        }
    }

    /// The value of an absent key whose default is a number.
    ///
    /// # Panics
    /// If its default is not a number.
    pub(crate) fn default_number(&self) -> f64 {
        match self.default {
            DefaultValue::Number(number) => number,
            other => panic!("the default of {} is {other}, expected a number", self.name),
        }
    }

    /// Whether `value` is within the bounds.
    pub fn contains(&self, value: f64) -> bool {
        self.bounds.contains(&value)
    }

    /// The bounds in words: `from 0 to 1`, `above 0 and at most 1`; empty where there are none.
    pub fn bounds_text(&self) -> String {
        let low = match self.bounds.0 {
            Bound::Included(low) => format!("from {}", short(low)),
            Bound::Excluded(low) => format!("above {}", short(low)),
            Bound::Unbounded => return String::new(),
        };
        match self.bounds {
            (Bound::Excluded(_), Bound::Included(high)) => format!("{low} and at most {}", short(high)),
            (_, Bound::Included(high)) => format!("{low} to {}", short(high)),
            (_, Bound::Excluded(high)) => format!("{low} to below {}", short(high)),
            (_, Bound::Unbounded) => low,
        }
    }

    /// Valid values in Markdown; empty where the type states them.
    pub fn range_text(&self) -> String {
        let words = match self.kind {
            Kind::Word(words) => words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(", "),
            _ => String::new(),
        };
        let count = match self.count {
            [0, usize::MAX] => String::new(),
            [min, max] => format!("{min} to {max} entries"),
        };
        let parts = [words, count, self.bounds_text(), self.note.to_owned()];
        parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(", ")
    }

    /// Whether its keys, or those of each element, are a section.
    fn is_section(&self) -> bool {
        matches!(self.kind, Kind::Section | Kind::List(Kind::Section))
    }

    /// Itself and, of a table, its keys, with names that begin with `prefix`.
    fn listed(&'static self, prefix: &str) -> Vec<ListedKey> {
        let own = ListedKey { name: format!("{prefix}{}", self.name), key: self };
        let within = format!("{}.", own.name);
        let parts = self.keys().filter(|_| !self.is_section()).flat_map(|key| key.listed(&within));
        std::iter::once(own).chain(parts).collect()
    }

    /// Its keys as a section of this name. Sections at the top are not among the keys of the top.
    fn section(&'static self, name: &str) -> Section {
        let keys = self.keys().filter(|key| !(name.is_empty() && key.is_section()));
        Section {
            name: name.to_owned(),
            is_list: matches!(self.kind, Kind::List(_)),
            about: self.meaning,
            keys: keys.flat_map(|key| key.listed("")).collect(),
        }
    }
}

/// All sections of a scene; those of scripts (views, sweep, live) are not among them.
pub fn sections() -> Vec<Section> {
    let own = SCENE.keys().filter(|key| key.is_section()).map(|key| key.section(key.name));
    std::iter::once(SCENE.section("")).chain(own).collect()
}

/// The keys at a path of a scene file: at the top, which is the empty path, or of a table such as `camera.orbit`.
pub fn section_at(path: &str) -> Option<Section> {
    if path.is_empty() { Some(FILE.section("")) } else { Some(find(path)?.section(path)) }
}

/// The key at a path such as `volumes.transfer.range.union`, without indices of lists.
pub fn find(path: &str) -> Option<&'static Key> {
    path.split('.').try_fold(&FILE, |table, name| table.keys().find(|key| key.name == name))
}

/// A bound as a text, with an exponent where that is much shorter: `1e6`.
fn short(bound: f64) -> String {
    let [plain, scientific] = [numbers::text(bound), format!("{bound:e}")];
    if scientific.len() + 2 < plain.len() { scientific } else { plain }
}

/// A string in Markdown.
fn quoted(word: &str) -> String {
    format!("`\"{word}\"`")
}

/// A list whose last item follows an "or".
pub(crate) fn alternatives(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [others @ .., last] => format!("{} or {last}", others.join(", ")),
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let or_words = |kind: &str, words: &[&str]| {
            let words = words.iter().map(|word| quoted(word));
            alternatives(&std::iter::once(kind.to_owned()).chain(words).collect::<Vec<_>>())
        };
        match self {
            Kind::Boolean => f.write_str("boolean"),
            Kind::Integer => f.write_str("integer"),
            Kind::Number => f.write_str("number"),
            Kind::Text | Kind::Word(_) => f.write_str("string"),
            Kind::Color(words) => f.write_str(&or_words("colour", words)),
            Kind::Layer(words) => f.write_str(&or_words("integer", words)),
            Kind::Vector(names) => write!(f, "`[{}]`", names.join(", ")),
            Kind::NumbersByName => f.write_str("table of numbers"),
            Kind::List(Kind::Vector(names)) => write!(f, "list of `[{}]`", names.join(", ")),
            Kind::List(of) => write!(f, "list of {of}s"),
            Kind::Either(one, other) => write!(f, "{one} or {other}"),
            Kind::Table | Kind::Section => f.write_str("table"),
        }
    }
}

impl fmt::Display for DefaultValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DefaultValue::None => f.write_str("none"),
            DefaultValue::Required => f.write_str("required"),
            DefaultValue::Number(number) => f.write_str(&numbers::text(*number)),
            DefaultValue::Flag(flag) => write!(f, "{flag}"),
            DefaultValue::Word(word) => f.write_str(&quoted(word)),
            DefaultValue::Toml(value) => write!(f, "`{value}`"),
            DefaultValue::Described(words) => f.write_str(words),
        }
    }
}

#[cfg(test)]
mod tests;
