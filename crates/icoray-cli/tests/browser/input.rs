//! Input of users: keys, mouse, wheel and fingers, as the browser gets them from the system.

use crate::browser::Browser;
use fantoccini::actions::{
    Actions, InputSource, KeyAction, KeyActions, MOUSE_BUTTON_LEFT, MouseActions, PointerAction, TouchActions,
    WheelAction, WheelActions,
};
use fantoccini::key::Key;
use std::time::Duration;

/// A place in the window, CSS pixels.
pub type Place = [f64; 2];

const DOWN: PointerAction = PointerAction::Down { button: MOUSE_BUTTON_LEFT };
const UP: PointerAction = PointerAction::Up { button: MOUSE_BUTTON_LEFT };
/// Moves of which a drag consists.
const STEPS: u32 = 4;
const STEP: Duration = Duration::from_millis(20);

fn to([x, y]: Place, duration: Duration) -> PointerAction {
    PointerAction::MoveTo { duration: Some(duration), x, y }
}

/// The moves of a drag between two places, and the places between them.
fn drag(from: Place, goal: Place) -> Vec<PointerAction> {
    let part = |step: u32| [0, 1].map(|k| from[k] + (goal[k] - from[k]) * f64::from(step) / f64::from(STEPS));
    let moves = (1..=STEPS).map(|step| to(part(step), STEP));
    [to(from, Duration::ZERO), DOWN].into_iter().chain(moves).chain([UP]).collect()
}

/// The character by which WebDriver names a key.
fn key(name: &str) -> char {
    let special = match name {
        "Ctrl" => Key::Control,
        "Shift" => Key::Shift,
        "Tab" => Key::Tab,
        "Enter" => Key::Enter,
        "Escape" => Key::Escape,
        "Delete" => Key::Delete,
        "Home" => Key::Home,
        "End" => Key::End,
        "Left" => Key::Left,
        "Right" => Key::Right,
        "Up" => Key::Up,
        "Down" => Key::Down,
        _ => return name.chars().next().unwrap(),
    };
    special.into()
}

impl Browser {
    /// Presses keys one after the other, such as `["Tab", "Ctrl z", "?"]`; those of a word group are held together.
    pub fn press(&self, keys: &[&str]) {
        let mut actions = KeyActions::new("keys".to_owned());
        for chord in keys {
            let held: Vec<char> = if *chord == " " { vec![' '] } else { chord.split(' ').map(key).collect() };
            for &value in &held {
                actions = actions.then(KeyAction::Down { value });
            }
            for &value in held.iter().rev() {
                actions = actions.then(KeyAction::Up { value });
            }
        }
        self.perform(actions.into());
    }

    /// Types a text into what has the focus.
    pub fn type_text(&self, text: &str) {
        let letters: Vec<String> = text.chars().map(String::from).collect();
        self.press(&letters.iter().map(String::as_str).collect::<Vec<_>>());
    }

    fn perform(&self, actions: Actions) {
        self.wait(self.client().perform_actions(actions));
    }

    /// Drags with the mouse.
    pub fn drag(&self, from: Place, goal: Place) {
        let mouse = MouseActions::new("mouse".to_owned());
        self.perform(drag(from, goal).into_iter().fold(mouse, MouseActions::then).into());
    }

    /// Clicks a place, `times` at once.
    pub fn click_at(&self, place: Place, times: usize) {
        let mouse = MouseActions::new("mouse".to_owned()).then(to(place, Duration::ZERO));
        self.perform((0..times).fold(mouse, |mouse, _| mouse.then(DOWN).then(UP)).into());
    }

    /// Turns the wheel, by pixels that a page would scroll.
    pub fn wheel(&self, [x, y]: Place, pixels: i64) {
        let mut wheel = WheelActions::new("wheel".to_owned());
        wheel.push(WheelAction::Scroll {
            duration: Some(Duration::ZERO),
            x: x as i64,
            y: y as i64,
            delta_x: 0,
            delta_y: pixels,
        });
        self.perform(wheel.into());
    }

    /// Drags with fingers at once, each from one place to another.
    pub fn touch(&self, fingers: &[[Place; 2]]) {
        let mut all = Actions::default();
        for (k, &[from, goal]) in fingers.iter().enumerate() {
            let finger = TouchActions::new(format!("finger {k}"));
            all = all.and(drag(from, goal).into_iter().fold(finger, TouchActions::then));
        }
        self.perform(all);
    }

    /// Touches the middle of an element.
    pub fn tap(&self, selector: &str) {
        let finger = TouchActions::new("finger 0".to_owned());
        let finger = finger.then(to(self.middle(selector), Duration::ZERO)).then(DOWN).then(UP);
        self.perform(finger.into());
    }

    /// Left, top, width and height of an element in the window.
    pub fn rectangle(&self, selector: &str) -> [f64; 4] {
        let script = format!(
            "const box = document.querySelector({selector:?}).getBoundingClientRect(); \
             return [box.left, box.top, box.width, box.height];"
        );
        let found = self.js(&script);
        [0, 1, 2, 3].map(|k: usize| found[k].as_f64().unwrap())
    }

    pub fn middle(&self, selector: &str) -> Place {
        let [x, y, width, height] = self.rectangle(selector);
        [x + width / 2.0, y + height / 2.0]
    }
}
