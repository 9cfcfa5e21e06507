//! The keys of a view that no scene has: its schedule, its conditions and its series of pictures.

use super::{section, sweep, take};
use crate::keys::{Key, Kind, flag, integer, keys, number, of, section as table, sections_of};
use crate::parse::text::Text;
use crate::script::{Condition, Live, Schedule};
use crate::template::Template;
use icoray_grid::Result;
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;
use toml::de::DeTable;

/// Keys at the top of a file, beside those of a scene.
pub const KEYS: &[Key] = keys! {
    /// Draws these steps ([when a view is drawn](#when-a-view-is-drawn)).
    at_steps = of(Kind::List(&Kind::Integer)),
    /// Draws the first step at or after each of these times, seconds.
    at_times = of(Kind::List(&Kind::Number)).note("finite"),
    /// Conditions that must all hold: `min`, `max` or `mean` of a field, then `<`, `<=`, `>` or `>=`, then a number.
    when = of(Kind::Either(&Kind::Text, &Kind::List(&Kind::Text))),
    /// Each view has a `name` and any keys of a scene, which override those at the top of the file. Tables are merged
    /// key by key; a key that excludes others (`knots` and `map`, `eye` and `lon`) removes those of the file.
    views = sections_of(&[keys! {
        /// Name of the view.
        name = of(Kind::Text).required().note("distinct"),
    }]),
    /// Makes a running model serve a page that shows its pictures and changes the scene by hand ([the live
    /// view](view.md#in-the-running-model)). Only at the top of a file. Commands that read files ignore it.
    live = table(&[RawLive::KEYS]),
    /// Renders in the background: a model copies the fields that its pictures need and continues ([rendering while the
    /// model computes](first-model.md#rendering-while-the-model-computes-on)). Only at the top of a file. It stays on
    /// until the model closes its context; if the model requests it itself, `false` has no effect. Commands that read
    /// files ignore it.
    async_render = flag(false),
    /// Lists whose combinations are all drawn, at most 100,000 pictures of a step.
    sweep = table(&[sweep::KEYS]),
};

/// Keys of `[output]`, beside those that it has in a scene.
pub const OUTPUT_KEYS: &[Key] = keys! {
    /// Folder of a Cinema database of all pictures.
    cinema = of(Kind::Text).note("ends in `.cdb`, without step or date"),
    /// List of pictures for ffmpeg.
    concat = of(Kind::Text).note("ends in `.ffconcat`, without step or date"),
    /// With `concat`: pictures per second.
    fps = number(1e-3..=1e3).or(25.0),
};

/// The schedule but for `every`, which is a key of scenes.
pub fn schedule(source: &Text, root: &mut DeTable) -> Result<Schedule> {
    let steps = take::<Vec<i64>>(source, root, "at_steps")?;
    let times = take::<Vec<f64>>(source, root, "at_times")?;
    if let Some(steps) = steps.as_ref().filter(|steps| steps.get_ref().is_empty()) {
        return Err(source.bad(steps.span(), "at_steps", "an empty list, expected steps"));
    }
    if let Some(times) = times.as_ref() {
        if times.get_ref().is_empty() {
            return Err(source.bad(times.span(), "at_times", "an empty list, expected seconds"));
        }
        if let Some(bad) = times.get_ref().iter().find(|time| !time.is_finite()) {
            return Err(source.bad(times.span(), "at_times", format!("{bad}, expected finite seconds")));
        }
    }
    Ok(Schedule {
        every: None,
        steps: steps.map(Spanned::into_inner).unwrap_or_default(),
        times_s: times.map(Spanned::into_inner).unwrap_or_default(),
    })
}

keys! {
    struct RawLive {
        /// Port of the page on the machine of the first rank; another one if it is taken.
        port: Option<Spanned<i64>> = integer(1..=65535).or_else("8750 or the next that is free"),
        /// Milliseconds that a picture may take whose scene viewers have set; the quality is reduced to stay within it.
        /// Where that is not enough, the model's own scene is drawn again.
        time_budget_ms: Option<Spanned<f64>> =
            number(1.0..=1e9).or_else("twice what the last picture of the model's own scene took"),
    }
}

/// `[live]`, which is of the file and not of its views.
pub fn live(source: &Text, root: &mut DeTable) -> Result<Option<Live>> {
    let Some(raw) = take::<RawLive>(source, root, "live")? else { return Ok(None) };
    let RawLive { port, time_budget_ms } = raw.into_inner();
    let port = port.map(|port| source.count(Some(&port), "live.port")).transpose()?;
    let time_budget_ms = source.optional_number(time_budget_ms.as_ref(), "live.time_budget_ms")?;
    Ok(Some(Live { port: port.map(|port| port as u16), time_budget_ms }))
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "expected a condition such as \"max(theta) > 300\", or a list of such")]
enum RawConditions {
    One(String),
    All(Vec<String>),
}

/// All of `when`.
pub fn conditions(source: &Text, root: &mut DeTable) -> Result<Vec<Condition>> {
    let Some(raw) = take::<RawConditions>(source, root, "when")? else { return Ok(Vec::new()) };
    let span = raw.span();
    let texts = match raw.into_inner() {
        RawConditions::One(text) => vec![text],
        RawConditions::All(texts) => texts,
    };
    let parse = |text: &String| Condition::parse(text).map_err(|what| source.bad(span.clone(), "when", what));
    texts.iter().map(parse).collect()
}

/// The series of a view in `[output]`: a Cinema database, and a list with its pictures per second.
type SeriesTemplates = (Option<Template>, Option<(Template, f64)>);

pub fn series(source: &Text, root: &mut DeTable) -> Result<SeriesTemplates> {
    let Some(output) = section(root, "output") else { return Ok((None, None)) };
    let mut named = |key: &str, ending: &str| -> Result<Option<Template>> {
        let raw = take::<String>(source, output, key)?;
        raw.map(|raw| template(source, &raw, &format!("output.{key}"), ending)).transpose()
    };
    let (cinema, concat) = (named("cinema", ".cdb")?, named("concat", ".ffconcat")?);
    let fps = take::<f64>(source, output, "fps")?;
    let rate = source.number(fps.as_ref(), "output.fps")?;
    match (fps, concat) {
        (Some(fps), None) => Err(source.bad(fps.span(), "output.fps", "is valid only with output.concat")),
        (_, concat) => Ok((cinema, concat.map(|template| (template, rate)))),
    }
}

/// A name that is the same at every step.
fn template(source: &Text, raw: &Spanned<String>, key: &str, ending: &str) -> Result<Template> {
    let text = raw.get_ref();
    let bad = |what: String| source.bad(raw.span(), key, format!("{text:?}: {what}"));
    if !text.ends_with(ending) || text.contains(char::is_control) {
        return Err(bad(format!("expected a name that ends in {ending}")));
    }
    let template = Template::new(text, &Template::WORDS).map_err(|e| source.bad(raw.span(), key, e.context()))?;
    if !template.is_timeless() {
        return Err(bad("it is one for all steps, expected neither step nor date in its name".into()));
    }
    Ok(template)
}

/// Where the keys of `[output]` stand in the text.
pub struct Names {
    given: Vec<(String, Range<usize>)>,
    /// The view that they are of.
    view: Range<usize>,
}

impl Names {
    pub fn of(table: &Spanned<DeTable>) -> Self {
        let output = table.get_ref().get("output").and_then(|output| output.get_ref().as_table());
        let given = output.into_iter().flatten().map(|(key, name)| (format!("output.{}", key.get_ref()), name.span()));
        Names { given: given.collect(), view: table.span() }
    }

    pub fn has(&self, key: &str) -> bool {
        self.given.iter().any(|(given, _)| given == key)
    }

    /// Where the name of a key stands, or else the view.
    pub fn span(&self, key: &str) -> Range<usize> {
        let found = self.given.iter().find(|(given, _)| given == key);
        found.map_or(&self.view, |(_, span)| span).clone()
    }
}
