//! The pictures that a scene file describes: views, when each is drawn, how its camera moves, what it sweeps.
//!
//! A [`Scene`] is one picture. A [`Script`] selects the pictures that are due at a step; it has no state, so that
//! it says the same to every rank and after every restart.

mod aim;
mod condition;
mod motion;
mod path;
mod schedule;
mod sweep;

pub use condition::{Condition, Statistic, Summary};
pub(crate) use motion::{Clock, Motion, Orbit};
pub(crate) use path::{Path, PathError, PathKey};
pub(crate) use schedule::Schedule;
pub(crate) use sweep::{Axis, Sweep};

use crate::Heights;
use crate::name::{Cinema, Concat, NameTemplate, Series, Stamp};
use crate::scene::{Scene, each_once};
use crate::template::Template;
use icoray_grid::{Error, ErrorKind, Result};

/// All that a scene file asks for.
///
/// A file describes one picture, or several by `[[views]]`: tables with a `name` and the keys that differ from the
/// file's own. Tables are merged key by key, arrays are replaced; a key that goes instead of others (`eye` instead of
/// `lon` and `lat`, `knots` instead of `map`) takes their place.
///
/// Further keys say when a view is drawn (`every`, `at_steps`, `at_times`, `when`), how its camera moves
/// (`camera.orbit`, `camera.path`), what it sweeps (`[sweep]`), which series of pictures are kept (`output.cinema`,
/// `output.concat`), and what a running model is asked for (`async_render`, `[live]`).
#[derive(Debug, Clone, PartialEq)]
pub struct Script {
    pub(crate) views: Vec<View>,
    pub(crate) live: Option<Live>,
    pub(crate) is_async: bool,
}

/// `[live]`: a page, served by the model's first rank, that shows its pictures and changes the script.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Live {
    /// The port of the page; any without it.
    pub port: Option<u16>,
    /// Milliseconds that a picture may take whose scene viewers have set; without it twice what the last picture of the
    /// model's own scene took.
    pub time_budget_ms: Option<f64>,
}

/// One of the views of a script.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// `None` for a file without `[[views]]`.
    pub(crate) name: Option<String>,
    pub(crate) scene: Scene,
    pub(crate) schedule: Schedule,
    pub(crate) conditions: Vec<Condition>,
    pub(crate) motion: Motion,
    pub(crate) sweep: Sweep,
    /// Names of what is kept beside the pictures, with placeholders.
    pub(crate) cinema: Option<Template>,
    pub(crate) concat: Option<(Template, f64)>,
    /// Whether the file names its pictures.
    pub(crate) has_file: bool,
}

/// A picture that is due.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// Name of its view; empty for a file without `[[views]]`.
    pub name: String,
    /// The scene to draw; its file name lacks only field, step and date.
    pub scene: Scene,
}

impl Script {
    /// The page that a running model is asked for.
    pub fn live(&self) -> Option<Live> {
        self.live
    }

    /// Whether a running model is to render in the background (`async_render`).
    pub fn is_async(&self) -> bool {
        self.is_async
    }

    /// Puts the date, where a stamp has one, before the step into the names of pictures that the scene file leaves to
    /// icoray: for models, whose step numbers may begin again when they are restarted.
    ///
    /// ```
    /// use icoray_scene::{Script, name::Stamp};
    ///
    /// let mut script = Script::parse(
    ///     "field = 'theta'
    ///      camera = { lon = 0, lat = 45, distance = 3 }
    ///      transfer = { map = 'plasma', range = [300, 400], opacity = [[300, 0], [400, 0.9]] }",
    /// )?;
    /// script.name_by_date();
    /// let names = |date: Option<&str>| {
    ///     let stamp = Stamp { step: 5, date: date.map(String::from), ..Stamp::default() };
    ///     let shot = script.views()[0].shots(&stamp).next().unwrap();
    ///     shot.scene.output.names(&stamp, shot.scene.field())
    /// };
    /// assert_eq!(names(Some("2026-11-22_06:00:00"))?.file, "theta_2026-11-22_06.00.00_000005.png");
    /// assert_eq!(names(None)?.file, "theta_000005.png");
    /// # Ok::<(), icoray_grid::Error>(())
    /// ```
    pub fn name_by_date(&mut self) {
        for view in self.views.iter_mut().filter(|view| !view.has_file) {
            view.scene.output.file = view.default_file("{when}");
        }
    }

    /// The views, in the order of the file; at least one.
    pub fn views(&self) -> &[View] {
        &self.views
    }

    /// The views' scenes, to change what they have in common.
    pub fn scenes_mut(&mut self) -> impl Iterator<Item = &mut Scene> {
        self.views.iter_mut().map(|view| &mut view.scene)
    }

    /// Whether pictures may be on the model's own heights: those of a view are, or viewers may choose them.
    pub fn may_need_heights(&self) -> bool {
        self.live.is_some() || self.views.iter().any(|view| view.scene.scenery.heights == Heights::Native)
    }

    /// Whether a view shows a field that the script does not name: the first one that there is.
    pub fn lacks_field(&self) -> bool {
        self.views.iter().any(|view| view.scene.shown_fields().contains(&""))
    }

    /// Gives these fields the name `first`, as [`Scene::name_first_field`] does.
    pub fn name_first_field(&mut self, first: &str) {
        self.scenes_mut().for_each(|scene| scene.name_first_field(first));
    }

    /// Shows the first volume of each view as a surface where `is_2d` says that its field has one value per column, as
    /// [`Scene::show_as_surface`] does; views that sweep fields stay.
    pub fn show_as_surfaces(&mut self, is_2d: impl Fn(&str) -> bool) {
        let views = self.views.iter_mut().filter(|view| view.sweep.fields().is_empty());
        views.filter(|view| is_2d(view.scene.field())).for_each(|view| view.scene.show_as_surface());
    }

    /// The views whose turn the step is but for their conditions. Every step of a run is offered, `before` being the one
    /// offered before it. Where there is none, times of `at_times` before `now` are drawn if `now` is step 1 or
    /// earlier; a run that begins later goes on with another one, which drew them, but for what the one step to
    /// `now` has reached.
    pub fn scheduled<'s>(&'s self, now: &Stamp, before: Option<&Stamp>) -> impl Iterator<Item = &'s View> {
        self.views.iter().filter(move |view| view.schedule.is_due(now, before))
    }

    /// The names of the model's fields that any picture or condition needs, each once.
    pub fn model_fields(&self) -> Vec<String> {
        let of_view = |view: &View| {
            let conditions = view.conditions.iter().map(|condition| condition.field().to_owned());
            view.model_fields().into_iter().chain(conditions).collect::<Vec<String>>()
        };
        each_once(self.views.iter().flat_map(of_view))
    }
}

impl From<Scene> for Script {
    /// A script of one view, due at multiples of [`Scene::every`].
    fn from(scene: Scene) -> Self {
        let view = View {
            name: None,
            schedule: Schedule { every: Some(scene.every), ..Schedule::default() },
            scene,
            conditions: Vec::new(),
            motion: Motion::Still,
            sweep: Sweep::default(),
            cinema: None,
            concat: None,
            has_file: true,
        };
        Script { views: vec![view], live: None, is_async: false }
    }
}

impl View {
    /// Its name; empty for a file without `[[views]]`.
    pub fn name(&self) -> &str {
        self.name.as_deref().unwrap_or("")
    }

    /// Conditions that must hold at a step at which the view is due.
    pub fn conditions(&self) -> &[Condition] {
        &self.conditions
    }

    /// Whether all conditions hold. `statistic` is asked for fields of [`Condition::field`], as long as the conditions
    /// before hold; `None` says that all values are missing, and no condition on them holds.
    ///
    /// # Errors
    /// Those that `statistic` returns.
    pub fn holds(&self, statistic: &mut dyn FnMut(&str, Statistic) -> Result<Option<f64>>) -> Result<bool> {
        for condition in &self.conditions {
            if !condition.holds(statistic(condition.field(), condition.statistic())?) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Its pictures, one or a sweep's, as they are at a step.
    pub fn shots(&self, now: &Stamp) -> impl Iterator<Item = Shot> {
        self.sweep.combinations().map(move |numbers| {
            let mut scene = self.scene.clone();
            self.sweep.apply(&mut scene, &numbers);
            scene.camera = self.motion.camera(&scene.camera, now);
            self.name_files(&mut scene, &numbers);
            Shot { name: self.name().to_owned(), scene }
        })
    }

    /// How many pictures it has at a step.
    pub fn pictures(&self) -> usize {
        self.sweep.count()
    }

    /// Its scene, once for each field that it sweeps: all that differ in what they need.
    pub fn scenes(&self) -> impl Iterator<Item = Scene> {
        let swept = self.sweep.fields();
        (0..swept.len().max(1)).map(move |number| {
            let mut scene = self.scene.clone();
            if let Some(field) = swept.get(number) {
                scene.volumes[0].field.clone_from(field);
            }
            scene
        })
    }

    /// The names of the model's fields that its pictures need, each once.
    pub fn model_fields(&self) -> Vec<String> {
        let of_scene = |scene: Scene| scene.model_fields().into_iter().map(str::to_owned).collect::<Vec<String>>();
        each_once(self.scenes().flat_map(of_scene))
    }

    /// Puts the values of a combination into the files' names.
    fn name_files(&self, scene: &mut Scene, numbers: &[usize]) {
        let named = self.name.iter().map(|name| ("view", name.clone()));
        let values: Vec<_> = named.clone().chain(self.sweep.values(numbers, |value| value.to_string())).collect();
        // With a point in all numbers, so that those of a list are of one type.
        let parameters = named.chain(self.sweep.values(numbers, |value| format!("{value:?}"))).collect();
        let field = [("field", scene.field().to_owned())];
        let output = &mut scene.output;
        output.file = output.file.with(&values);
        output.error = output.error.as_ref().map(|error| error.with(&values));
        let named = |template: &Template| template.with(&values).with(&field).plain();
        output.series = Series {
            concat: self.concat.as_ref().map(|(file, fps)| Concat { file: named(file), fps: *fps }),
            cinema: self.cinema.as_ref().map(|folder| Cinema { folder: named(folder), parameters }),
        };
    }

    /// The name of pictures that the file leaves to icoray, with a placeholder for the step.
    pub(crate) fn default_file(&self, moment: &str) -> NameTemplate {
        let view = self.name.iter().map(|_| "{view}".to_owned());
        let always = ["{field}".to_owned(), moment.to_owned()];
        let swept = self.sweep.axes.iter().map(|axis| axis.name()).filter(|name| *name != "field");
        let swept = swept.map(|name| format!("{name}{{{name}}}"));
        let words: Vec<String> = view.chain(always).chain(swept).collect();
        NameTemplate::new(&format!("{}.png", words.join("_"))).expect("its words are placeholders of names")
    }

    /// Refuses placeholders that stand for nothing here, and names that two pictures of a step would share.
    pub(crate) fn check_words(&self, template: &Template) -> Result<()> {
        let stands = |word: &str| match word {
            "field" => true,
            "view" => self.name.is_some(),
            word => self.sweep.has(word),
        };
        let Some(word) = template.words().find(|word| !stands(word)) else { return Ok(()) };
        let there: Vec<String> =
            Template::WORDS.iter().filter(|word| stands(word)).map(|word| format!("{{{word}}}")).collect();
        let what = format!("{{{word}}} is no placeholder here, expected one of {}", there.join(", "));
        Err(Error::new(ErrorKind::Scene, what))
    }
}

#[cfg(test)]
mod tests;
