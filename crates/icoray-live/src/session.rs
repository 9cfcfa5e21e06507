//! The state that viewers change: the scene, the time, and the history for undo.

use crate::document::{self, Change};
use icoray::{LabelPlace, Labels, Level, Lines, Pattern, Scene};
use serde::Deserialize;
use toml_edit::{DocumentMut, Item};

/// Maximum number of steps that can be undone, and of bytes of their texts.
const MAX_UNDO: usize = 200;
const MAX_UNDO_BYTES: usize = 32 << 20;
/// Maximum distance, in pixels of the picture at rest, of traced pixels while the user moves the picture.
const COARSEST: f64 = 8.0;
/// Maximum length of a scene's text, bytes: that of a request's body.
const MAX_TEXT: usize = 1 << 20;
/// Maximum number of pages whose sizes are stored.
const MAX_PAGES: usize = 64;

/// Parses the text of a scene file into the scenes of its views, at least one, with their data-dependent parts (the
/// name of the first field, the 2D fields).
pub type SceneReader = dyn Fn(&str) -> icoray::Result<Vec<NamedScene>> + Send;

/// The scene of a view.
#[derive(Debug, Clone)]
pub struct NamedScene {
    /// Name of the view; empty for a file without views.
    pub name: String,
    /// The scene.
    pub scene: Scene,
}

/// Source of the size of pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PictureSize {
    /// The scene if it has an `[image]`, else the viewer.
    #[default]
    SceneOrViewer,
    /// The viewer, until a scene with an `[image]` is loaded.
    Viewer,
    /// The scene.
    Scene,
}

impl PictureSize {
    /// That of a scene's text, which may be completed with an `[image]`: its own, or the viewer's if it has none.
    pub fn of(text: &str) -> Self {
        let scene = text.parse::<DocumentMut>().unwrap_or_default();
        let views = scene.get("views").and_then(Item::as_array_of_tables);
        let has_size =
            scene.contains_key("image") || views.is_some_and(|views| views.iter().any(|v| v.contains_key("image")));
        if has_size { PictureSize::SceneOrViewer } else { PictureSize::Viewer }
    }
}

/// The initial state of a session.
pub(crate) struct Start {
    pub text: String,
    /// Number of the displayed time, and of all times.
    pub time: usize,
    pub times: usize,
    pub size: PictureSize,
}

/// A change of one or several settings by a viewer.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ChangeRequest {
    #[serde(default)]
    changes: Vec<Change>,
    /// Number of the time to show.
    time: Option<usize>,
    /// Name of the view to show.
    view: Option<String>,
    /// Width and height of the page's room for the picture, pixels; zeros if the page is closed.
    size: Option<[u32; 2]>,
    /// The number of the page.
    #[serde(default)]
    page: u32,
    /// Whether the user is still moving the picture: the picture may be coarse, and the step is undone together with
    /// the next.
    #[serde(default)]
    is_moving: bool,
}

/// The state that viewers share.
pub(crate) struct Session {
    read: Box<SceneReader>,
    text: String,
    views: Vec<NamedScene>,
    /// Number of the displayed view.
    view: usize,
    time: usize,
    times: usize,
    size: PictureSize,
    /// Whether pictures have the size that viewers request.
    follows_size: bool,
    /// The sizes of the pages' rooms for the picture, by the pages' numbers.
    sizes: Vec<(u32, [u32; 2])>,
    moving_size: Option<[u32; 2]>,
    is_moving: bool,
    revision: u64,
    undo: Vec<String>,
    redo: Vec<String>,
    /// The text before a movement that has not ended.
    before: Option<String>,
}

impl Session {
    /// # Errors
    /// Those of `read` for the text.
    pub fn new(start: Start, read: Box<SceneReader>) -> icoray::Result<Self> {
        let Start { text, time, times, size } = start;
        let views = read(&text)?;
        let mut session = Session {
            read,
            text,
            views,
            view: 0,
            time,
            times,
            size,
            follows_size: size == PictureSize::Viewer,
            sizes: Vec::new(),
            moving_size: None,
            is_moving: false,
            revision: 1,
            undo: Vec::new(),
            redo: Vec::new(),
            before: None,
        };
        session.follows_size |= session.lacks_size();
        Ok(session)
    }

    /// Whether only the viewer sets the size of pictures.
    fn lacks_size(&self) -> bool {
        self.size != PictureSize::Scene && self.values().get("image").is_none()
    }

    /// The keys of the displayed view.
    pub fn values(&self) -> serde_json::Value {
        document::values(&self.text, self.number_of_view())
    }

    /// The number of the view among those of the text; `None` for a text without views.
    fn number_of_view(&self) -> Option<usize> {
        (!self.view().is_empty()).then_some(self.view)
    }

    /// Name of the displayed view; empty for a text without views.
    pub fn view(&self) -> &str {
        &self.views[self.view].name
    }

    /// Names of all views; empty for a text without views.
    pub fn views(&self) -> Vec<&str> {
        self.views.iter().map(|view| view.name.as_str()).filter(|name| !name.is_empty()).collect()
    }

    /// Shows the views of a text in a new revision: the view of the same name, or else the first.
    fn show(&mut self, text: String, views: Vec<NamedScene>) {
        self.view = views.iter().position(|view| view.name == self.view()).unwrap_or(0);
        self.text = text;
        self.views = views;
        self.revision += 1;
    }

    /// As [`Self::show`], and ends a movement without a step of its own.
    fn show_at_rest(&mut self, text: String, views: Vec<NamedScene>) {
        self.show(text, views);
        self.before = None;
        self.is_moving = false;
    }

    pub fn text(&self) -> &str {
        &self.text
    }

    /// The scene for pictures at rest.
    pub fn scene(&self) -> &Scene {
        &self.views[self.view].scene
    }

    pub fn time(&self) -> usize {
        self.time
    }

    pub fn revision(&self) -> u64 {
        self.revision
    }

    pub fn is_moving(&self) -> bool {
        self.is_moving
    }

    /// Whether there are steps to undo, and to redo.
    pub fn history(&self) -> [bool; 2] {
        [&self.undo, &self.redo].map(|steps| !steps.is_empty())
    }

    /// Permits refining the picture although the user has not let go.
    pub fn hold_still(&mut self) {
        self.is_moving = false;
    }

    /// The lines that the page draws over pictures that the user moves, which are too small for them: coasts and
    /// graticule on the ground, if labels lie over the picture too.
    pub fn lines_over(&self) -> Vec<Lines> {
        let scene = self.scene();
        let has_labels = scene.labels.as_ref().is_some_and(|labels| labels.place != LabelPlace::Below);
        scene.scenery.lines.iter().filter(|lines| has_labels && is_over(lines)).cloned().collect()
    }

    /// The scene for a frame while the user moves the picture: small, within a time budget, one ray per pixel, without
    /// [`Self::lines_over`] and without a note on its error, as drafts are coarse, unless the scene requests it.
    pub fn moving_scene(&self, budget_ms: f64, max_size: [u32; 2]) -> Scene {
        let (scene, over) = (self.scene(), self.lines_over());
        let mut scenery = scene.scenery.clone();
        scenery.lines.retain(|lines| !over.contains(lines));
        let [width, height] = [scene.width, scene.height].map(f64::from);
        let max_size = self.moving_size.unwrap_or(max_size).map(f64::from);
        let part = (max_size[0] / width).min(max_size[1] / height).min(1.0);
        let side = |size: f64| ((part * size).round() as u32).max(1);
        let noted = |labels: Labels| Labels { error_note: labels.error_note.or(Some(false)), ..labels };
        Scene {
            width: side(width),
            height: side(height),
            time_budget_ms: Some(scene.time_budget_ms.map_or(budget_ms, |own| own.min(budget_ms))),
            samples: 1,
            antialias: false,
            scenery,
            labels: scene.labels.clone().map(noted),
            largest_step: ((part * COARSEST) as u32).max(1),
            ..scene.clone()
        }
    }

    /// Applies all changes, or none.
    ///
    /// # Errors
    /// A sentence that names the key and the expected value.
    pub fn change(&mut self, request: &ChangeRequest) -> Result<(), String> {
        let ChangeRequest { changes, time, view, size, page, is_moving } = request;
        if let Some(time) = time.filter(|time| *time >= self.times.max(1)) {
            return Err(format!("time {time}, expected 0 to {}", self.times.saturating_sub(1)));
        }
        let mut text = document::changed(&self.text, changes, self.number_of_view())?;
        let mut sizes = self.sizes.clone();
        if let (Some(size), false) = (size, *is_moving) {
            sizes.retain(|(its, _)| its != page);
            sizes.extend((*size != [0, 0]).then_some((*page, *size)));
            sizes.drain(..sizes.len().saturating_sub(MAX_PAGES));
        }
        // A page shows a picture of any size, and a small one would spoil that of a large page.
        let largest =
            sizes.iter().map(|(_, size)| *size).max_by_key(|[width, height]| u64::from(*width) * u64::from(*height));
        if let (Some([width, height]), Some(_), true, false) = (largest, size, self.follows_size, *is_moving) {
            let sides = [("width", width), ("height", height)].map(|(key, side)| Change::of(&["image", key], side));
            text = document::changed(&text, &sides, self.number_of_view())?;
        }
        let views = if text == self.text { self.views.clone() } else { self.read(&text)? };
        let number = view.as_ref().map(|name| number_of(name, &views)).transpose()?;
        if text != self.text && !changes.is_empty() {
            self.before.get_or_insert_with(|| self.text.clone());
        }
        if !is_moving && let Some(before) = self.before.take() {
            self.push_undo(before);
        }
        self.sizes = sizes;
        self.moving_size = size.filter(|_| *is_moving);
        self.show(text, views);
        self.view = number.unwrap_or(self.view);
        self.is_moving = *is_moving;
        self.time = time.unwrap_or(self.time);
        Ok(())
    }

    /// Loads another text, such as that of a file.
    ///
    /// # Errors
    /// As [`Self::change`].
    pub fn load(&mut self, text: &str) -> Result<(), String> {
        self.replace(text)?;
        self.follows_size = self.lacks_size();
        Ok(())
    }

    /// As [`Self::load`], for pictures of the same size.
    ///
    /// # Errors
    /// As [`Self::change`].
    pub fn replace(&mut self, text: &str) -> Result<(), String> {
        let views = self.read(text)?;
        self.push_undo(self.text.clone());
        self.show_at_rest(text.to_owned(), views);
        Ok(())
    }

    /// Undoes or redoes a step; does nothing without one.
    ///
    /// # Errors
    /// As [`Self::change`].
    pub fn step(&mut self, is_back: bool) -> Result<(), String> {
        let steps = if is_back { &self.undo } else { &self.redo };
        let Some(text) = steps.last().cloned() else { return Ok(()) };
        let views = self.read(&text)?;
        let (from, to) = if is_back { (&mut self.undo, &mut self.redo) } else { (&mut self.redo, &mut self.undo) };
        from.pop();
        to.push(self.text.clone());
        self.show_at_rest(text, views);
        Ok(())
    }

    fn push_undo(&mut self, text: String) {
        self.redo.clear();
        self.undo.push(text);
        let mut bytes = 0;
        let kept = self.undo.iter().rev().take(MAX_UNDO).take_while(|text| {
            bytes += text.len();
            bytes <= MAX_UNDO_BYTES
        });
        let kept = kept.count();
        self.undo.drain(..self.undo.len() - kept);
    }

    fn read(&self, text: &str) -> Result<Vec<NamedScene>, String> {
        if text.len() > MAX_TEXT {
            return Err(format!("a scene of {} bytes, expected at most {MAX_TEXT}", text.len()));
        }
        (self.read)(text).map_err(|e| e.to_string())
    }
}

fn is_over(lines: &Lines) -> bool {
    let is_fixed = matches!(lines.pattern, Pattern::Coast | Pattern::Graticule { .. });
    is_fixed && lines.on == Level::Ground && lines.region.is_none()
}

fn number_of(name: &str, views: &[NamedScene]) -> Result<usize, String> {
    let names = || views.iter().map(|view| format!("{:?}", view.name)).collect::<Vec<_>>().join(", ");
    let found = views.iter().position(|view| view.name == name);
    found.ok_or_else(|| format!("view {name:?}, expected one of {}", names()))
}

/// Reads texts without views or with them, for tests.
#[cfg(test)]
pub(crate) fn plain_reader() -> Box<SceneReader> {
    Box::new(|text| {
        let script = icoray::Script::parse(text)?;
        let views = script.views().iter();
        let scenes = views.flat_map(|view| view.scenes().map(|scene| (view.name().to_owned(), scene)));
        Ok(scenes.map(|(name, scene)| NamedScene { name, scene }).collect())
    })
}

#[cfg(test)]
mod tests;
