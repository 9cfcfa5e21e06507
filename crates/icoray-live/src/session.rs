//! What viewers have set: the scene, the time, and how far back they can go.

use crate::document::{self, Change};
use icoray::Scene;
use serde::Deserialize;

/// Most steps that can be undone.
const MAX_UNDO: usize = 200;

/// Turns the text of a scene into the scene that is drawn, with what depends on the data (the name of the first field,
/// which fields are 2D).
pub type SceneReader = dyn Fn(&str) -> icoray::Result<Scene> + Send;

/// What a viewer changes at once.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ChangeRequest {
    #[serde(default)]
    changes: Vec<Change>,
    /// Number of the time to show.
    time: Option<usize>,
    /// Width and height of the picture, pixels.
    size: Option<[u32; 2]>,
    /// Whether a hand is still moving: the picture may be coarse, and the step can be undone together with the next.
    #[serde(default)]
    is_moving: bool,
}

/// The state that viewers share.
pub(crate) struct Session {
    read: Box<SceneReader>,
    text: String,
    scene: Scene,
    time: usize,
    times: usize,
    /// Whether pictures have the size that viewers ask for; false where the scene says how large they are.
    follows_size: bool,
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
    pub fn new(
        (text, follows_size): (String, bool),
        time: usize,
        times: usize,
        read: Box<SceneReader>,
    ) -> icoray::Result<Self> {
        let scene = read(&text)?;
        let follows_size = follows_size || document::values(&text).get("image").is_none();
        Ok(Session {
            read,
            text,
            scene,
            time,
            times,
            follows_size,
            moving_size: None,
            is_moving: false,
            revision: 1,
            undo: Vec::new(),
            redo: Vec::new(),
            before: None,
        })
    }

    pub fn text(&self) -> &str {
        &self.text
    }

    /// The scene as it is drawn at rest.
    pub fn scene(&self) -> &Scene {
        &self.scene
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

    /// Whether there are steps to undo, and to do again.
    pub fn history(&self) -> [bool; 2] {
        [&self.undo, &self.redo].map(|steps| !steps.is_empty())
    }

    /// The scene for a frame while a hand moves: small, within a time, each pixel one ray.
    pub fn moving_scene(&self, budget_ms: f64, most: [u32; 2]) -> Scene {
        let [width, height] = [self.scene.width, self.scene.height].map(f64::from);
        let most = self.moving_size.unwrap_or(most).map(f64::from);
        let part = (most[0] / width).min(most[1] / height).min(1.0);
        let side = |size: f64| ((part * size).round() as u32).max(1);
        Scene {
            width: side(width),
            height: side(height),
            time_budget_ms: Some(self.scene.time_budget_ms.map_or(budget_ms, |own| own.min(budget_ms))),
            samples: 1,
            antialias: false,
            ..self.scene.clone()
        }
    }

    /// Takes all changes, or none.
    ///
    /// # Errors
    /// A sentence that names the key and what was expected.
    pub fn change(&mut self, request: &ChangeRequest) -> Result<(), String> {
        let ChangeRequest { changes, time, size, is_moving } = request;
        if let Some(time) = time.filter(|time| *time >= self.times.max(1)) {
            return Err(format!("time {time}, expected 0 to {}", self.times.saturating_sub(1)));
        }
        let mut text = document::changed(&self.text, changes)?;
        if let (Some([width, height]), true, false) = (size, self.follows_size, *is_moving) {
            let sides = [("width", width), ("height", height)];
            text = document::changed(&text, &sides.map(|(key, side)| Change::of(&["image", key], *side)))?;
        }
        let scene = if text == self.text { self.scene.clone() } else { self.read(&text)? };
        if text != self.text && !changes.is_empty() {
            self.before.get_or_insert_with(|| self.text.clone());
        }
        if !is_moving && let Some(before) = self.before.take() {
            self.push_undo(before);
        }
        self.moving_size = size.filter(|_| *is_moving);
        (self.text, self.scene, self.is_moving) = (text, scene, *is_moving);
        self.time = time.unwrap_or(self.time);
        self.revision += 1;
        Ok(())
    }

    /// Takes another text, such as that of a file.
    ///
    /// # Errors
    /// As [`Self::change`].
    pub fn load(&mut self, text: &str) -> Result<(), String> {
        let scene = self.read(text)?;
        let before = std::mem::replace(&mut self.text, text.to_owned());
        self.push_undo(before);
        (self.scene, self.before, self.is_moving) = (scene, None, false);
        self.follows_size = document::values(text).get("image").is_none();
        self.revision += 1;
        Ok(())
    }

    /// Goes back a step, or forward again; without steps nothing happens.
    ///
    /// # Errors
    /// As [`Self::change`].
    pub fn step(&mut self, is_back: bool) -> Result<(), String> {
        let (from, to) = if is_back { (&mut self.undo, &mut self.redo) } else { (&mut self.redo, &mut self.undo) };
        let Some(text) = from.pop() else { return Ok(()) };
        to.push(std::mem::replace(&mut self.text, text));
        (self.before, self.is_moving) = (None, false);
        self.scene = self.read(&self.text)?;
        self.revision += 1;
        Ok(())
    }

    fn push_undo(&mut self, text: String) {
        self.redo.clear();
        self.undo.push(text);
        let beyond = self.undo.len().saturating_sub(MAX_UNDO);
        self.undo.drain(..beyond);
    }

    fn read(&self, text: &str) -> Result<Scene, String> {
        (self.read)(text).map_err(|e| e.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const TEXT: &str = "field = \"q\"\ncamera = { lon = 1 }\n";

    fn session(text: &str) -> Session {
        Session::new((text.to_owned(), false), 0, 3, Box::new(Scene::parse)).unwrap()
    }

    fn request(request: serde_json::Value) -> ChangeRequest {
        serde_json::from_value(request).unwrap()
    }

    fn lon(lon: f64, is_moving: bool) -> ChangeRequest {
        request(json!({ "changes": [{ "path": ["camera", "lon"], "value": lon }], "is_moving": is_moving }))
    }

    #[test]
    fn a_movement_is_one_step_back() {
        let mut session = session(TEXT);
        for (degrees, is_moving) in [(5.0, true), (7.0, true), (9.0, false)] {
            session.change(&lon(degrees, is_moving)).unwrap();
        }
        let moved = session.text().to_owned();
        assert!(moved.contains("lon = 9"), "{moved}");
        session.step(true).unwrap();
        assert_eq!((session.text(), session.history()), (TEXT, [false, true]));
        session.step(true).unwrap();
        session.step(false).unwrap();
        assert_eq!((session.text(), session.history()), (moved.as_str(), [true, false]));
        let revision = session.revision();
        // The end of a movement, without a change of its own.
        session.change(&lon(11.0, true)).unwrap();
        session.change(&request(json!({ "is_moving": false }))).unwrap();
        assert_eq!(session.revision(), revision + 2);
        session.step(true).unwrap();
        assert_eq!(session.text(), moved);
    }

    #[test]
    fn what_is_wrong_changes_nothing() {
        let mut session = session(TEXT);
        for (bad, wanted) in [
            (
                json!({ "changes": [{ "path": ["camera", "lat"], "value": 3 },
                                 { "path": ["camera", "lon"], "value": 500 }], "time": 2 }),
                "camera.lon",
            ),
            (json!({ "changes": [{ "path": ["zzz"], "value": 1 }] }), "zzz"),
            (json!({ "time": 3 }), "time 3, expected 0 to 2"),
        ] {
            let error = session.change(&request(bad)).unwrap_err();
            assert!(error.contains(wanted), "{error}");
        }
        assert!(session.load("nothing = 1").is_err());
        assert_eq!((session.text(), session.time(), session.revision()), (TEXT, 0, 1));
        assert_eq!(session.history(), [false, false]);
    }

    #[test]
    fn sizes_follow_the_viewer_unless_the_scene_says_them() {
        let mut session = session(TEXT);
        let sized = |size: [u32; 2], is_moving: bool| request(json!({ "size": size, "is_moving": is_moving }));
        session.change(&sized([900, 600], false)).unwrap();
        assert!(Scene::parse(session.text()).is_ok_and(|scene| (scene.width, scene.height) == (900, 600)));
        assert_eq!(session.history(), [false, false], "a size is no step");
        session.change(&sized([640, 480], true)).unwrap();
        assert_eq!((session.scene().width, session.scene().height), (900, 600));
        let moving = session.moving_scene(80.0, [640, 480]);
        assert_eq!((moving.width, moving.height, moving.time_budget_ms), (640, 427, Some(80.0)));
        let own = "field = \"q\"\nimage = { width = 40, height = 30 }\n";
        session.load(own).unwrap();
        session.change(&sized([900, 600], false)).unwrap();
        assert_eq!((session.scene().width, session.text()), (40, own));
        assert!(session.change(&sized([0, 5], true)).is_ok());
    }
}
