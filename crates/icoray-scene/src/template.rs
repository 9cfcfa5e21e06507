//! Texts with placeholders: MPAS's `$Y-$M-$D_$h.$m.$s`, and words in braces.

use crate::name::Stamp;
use icoray_grid::{Error, ErrorKind, Result};

/// A text with placeholders, parsed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Template {
    parts: Vec<Segment>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Segment {
    Text(String),
    Step {
        width: usize,
    },
    /// The date where there is one, and the step.
    When,
    /// A word in braces other than the step.
    Word(&'static str),
    /// Index into the six numbers of a date.
    Date(usize),
}

impl Template {
    /// Words of names that a script has values for.
    pub const WORDS: [&str; 6] = ["field", "view", "lon", "lat", "distance", "exaggeration"];

    /// Parses `text`: `{step}`, `{step:06}` (zero-padded to 6), `{when}`, each of `words` in braces, `$Y $M $D $h $m
    /// $s`.
    ///
    /// # Errors
    /// [`ErrorKind::Scene`] names the part that is not understood.
    pub fn new(text: &str, words: &[&'static str]) -> Result<Self> {
        let bad = |what: String| Error::new(ErrorKind::Scene, format!("{text:?}: {what}"));
        let mut parts = Vec::new();
        let mut rest = text;
        while let Some(at) = rest.find(['{', '}', '$']) {
            if at > 0 {
                parts.push(Segment::Text(rest[..at].into()));
            }
            rest = &rest[at..];
            let (part, used) = match rest.as_bytes()[0] {
                b'$' => {
                    let letter = rest[1..].chars().next();
                    let place = letter.and_then(|l| "YMDhms".find(l));
                    let shown = letter.map_or_else(String::new, String::from);
                    let wish = || bad(format!("${shown}, expected $Y, $M, $D, $h, $m or $s"));
                    (Segment::Date(place.ok_or_else(wish)?), 2)
                }
                b'{' => {
                    let end = rest.find('}').ok_or_else(|| bad("a { without a closing }".into()))?;
                    let wish = || {
                        let last = words.iter().map(|word| format!("{{{word}}}")).collect::<Vec<_>>().join(" or ");
                        bad(format!("{}, expected {{step}}, {{step:06}}, {{when}} or {last}", &rest[..=end]))
                    };
                    (brace(&rest[1..end], words).ok_or_else(wish)?, end + 1)
                }
                _ => return Err(bad("a } without an opening {".into())),
            };
            parts.push(part);
            rest = &rest[used..];
        }
        if !rest.is_empty() {
            parts.push(Segment::Text(rest.into()));
        }
        Ok(Template { parts })
    }

    /// The words that stand in it.
    pub fn words(&self) -> impl Iterator<Item = &'static str> {
        self.parts.iter().filter_map(|part| match part {
            Segment::Word(word) => Some(*word),
            _ => None,
        })
    }

    /// Whether it is the same at every step.
    pub fn is_timeless(&self) -> bool {
        !self.parts.iter().any(|part| matches!(part, Segment::Step { .. } | Segment::When | Segment::Date(_)))
    }

    /// With these values for words, in which no folder begins.
    #[must_use]
    pub fn with(&self, values: &[(&'static str, String)]) -> Self {
        let mut filled = self.clone();
        for part in &mut filled.parts {
            let Segment::Word(word) = part else { continue };
            if let Some((_, value)) = values.iter().find(|(name, _)| name == word) {
                *part = Segment::Text(name_part(value));
            }
        }
        filled
    }

    /// The text of a template that is the same at every step and has values for all words.
    pub fn plain(&self) -> String {
        let texts = self.parts.iter().filter_map(|part| match part {
            Segment::Text(text) => Some(text.as_str()),
            _ => None,
        });
        texts.collect()
    }

    /// The text of a stamp; `word` has what stands for the words.
    ///
    /// # Errors
    /// [`ErrorKind::Argument`] when the template has a date and `stamp` has none, or one that is not understood.
    pub fn fill(&self, stamp: &Stamp, word: impl Fn(&str) -> String) -> Result<String> {
        let mut text = String::new();
        for part in &self.parts {
            match part {
                Segment::Text(plain) => text += plain,
                // Zero-padding puts a minus sign before the zeros.
                Segment::Step { width } => text += &format!("{:0width$}", stamp.step),
                Segment::When => text += &when(stamp),
                Segment::Word(name) => text += &word(name),
                Segment::Date(place) => text += date(stamp)?[*place],
            }
        }
        Ok(text)
    }
}

/// The step with six digits, after the date where the stamp has one that is understood.
fn when(stamp: &Stamp) -> String {
    let step = format!("{:06}", stamp.step);
    let Ok([year, month, day, hour, minute, second]) = date(stamp) else { return step };
    format!("{year}-{month}-{day}_{hour}.{minute}.{second}_{step}")
}

/// A value as a part of one file's name.
pub(super) fn name_part(value: &str) -> String {
    value.replace(['/', '\\'], "_")
}

fn brace(inside: &str, words: &[&'static str]) -> Option<Segment> {
    match inside.split_once(':') {
        None if inside == "step" => Some(Segment::Step { width: 0 }),
        None if inside == "when" => Some(Segment::When),
        None => words.iter().find(|word| **word == inside).map(|word| Segment::Word(word)),
        Some(("step", width)) => {
            let width = width.strip_prefix('0')?.parse().ok().filter(|w| (1..=20).contains(w))?;
            Some(Segment::Step { width })
        }
        _ => None,
    }
}

/// The six numbers of the stamp's date, as written.
///
/// # Errors
/// [`ErrorKind::Argument`] where there is no date, or one that is not understood.
pub fn date(stamp: &Stamp) -> Result<[&str; 6]> {
    let bad = |what| {
        Error::new(ErrorKind::Argument, format!("date {what}, expected YYYY-MM-DD_hh:mm:ss (the output name needs it)"))
    };
    let text = stamp.date.as_ref().ok_or_else(|| bad("is absent".to_owned()))?;
    let trimmed = text.trim().trim_end_matches('Z');
    let parts: Vec<&str> = trimmed.split(['-', '_', 'T', ':', ' ']).collect();
    let all_digits = |p: &&str| !p.is_empty() && p.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    let numbers: [&str; 6] = parts.try_into().map_err(|_| bad(format!("{text:?}")))?;
    if numbers.iter().all(all_digits) { Ok(numbers) } else { Err(bad(format!("{text:?}"))) }
}
