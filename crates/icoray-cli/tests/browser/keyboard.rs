//! The keyboard alone.

use crate::browser::Browser;
use crate::page::Shown;
use serde_json::{Value, json};

/// What the Tab key should reach, in a list `wanted`: each control in sight, of radio buttons the one that is chosen.
const WANTED: &str = "
    const named = (e) =>
      `${e.tagName.toLowerCase()} ${e.id || e.ariaLabel || e.value || e.textContent.trim().slice(0, 30)}`;
    const all = [...document.querySelectorAll('button, input, select, textarea, summary, a[href], [tabindex]')];
    const isStop = (e) => e.tabIndex >= 0 && !e.disabled && e.checkVisibility({ visibilityProperty: true }) &&
      !(e.type === 'radio' && !e.checked);
    const wanted = all.filter(isStop);";

/// Goes through the whole page with the Tab key: how many stops there should be, which are missed, and which do not
/// show that they have the focus.
fn stops(browser: &Browser) -> (usize, Value, Value) {
    let count = browser.js(&format!(
        "{WANTED} window.stops = []; window.unmarked = [];
         window.listener ??= document.addEventListener('focusin', ({{ target }}) => {{
           window.stops.push(target);
           const isMarked = (e) => {{
             const style = getComputedStyle(e);
             return style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) >= 2;
           }};
           const handle = target.closest('.handle')?.querySelector('.reach');
           const isOutlined = handle ? parseFloat(getComputedStyle(handle).strokeWidth) >= 2 &&
               getComputedStyle(handle).stroke !== 'none'
             : isMarked(target) || (target.type === 'radio' && isMarked(target.nextElementSibling));
           if (!isOutlined) window.unmarked.push(named(target));
         }}) ?? true;
         return wanted.length;"
    ));
    let count = count.as_u64().unwrap() as usize;
    let mut found = Value::Null;
    // More than once around: some controls are shown when others get the focus.
    for _ in 0..4 {
        browser.press(&vec!["Tab"; count / 2]);
        found = browser.js(&format!(
            "{WANTED} const missed = wanted.filter((e) => !window.stops.includes(e)).map(named);
             return [missed, [...new Set(window.unmarked)]];"
        ));
        if found[0] == json!([]) {
            break;
        }
    }
    (count, found[0].clone(), found[1].clone())
}

#[test]
fn the_tab_key_reaches_all_controls() {
    let Some(Shown { browser, .. }) = &Shown::start() else { return };
    browser.click_at(browser.place([0.5, 0.5]), 1);
    browser.until_text("#panel-probe .value", " K");
    for (key, tab, least) in [("1", "colours", 20), ("2", "scene", 30), ("3", "probe", 8), ("4", "files", 12)] {
        browser.press(&["Escape", key]);
        browser.until("the tab", &format!("return document.getElementById('panel-{tab}').checkVisibility();"));
        let (count, missed, unmarked) = stops(browser);
        assert!(count >= least, "{tab}: {count} stops");
        assert_eq!((missed, unmarked), (json!([]), json!([])), "{tab}");
    }
    // The arrow keys go from tab to tab.
    browser.press(&["Escape", "1", "Right"]);
    assert_eq!(browser.js("return document.activeElement.id;"), "tab-scene");
    browser.is_quiet();
}

#[test]
fn keys_alone_steer_the_page() {
    let Some(Shown { browser, .. }) = &Shown::start() else { return };
    // Without a click: the keys of the picture work from the start.
    browser.changed_by(|| browser.press(&["Left"]));
    browser.until_text("#time-label", "2/3");
    browser.changed_by(|| browser.press(&["Home"]));
    browser.until_text("#time-label", "1/3");
    browser.changed_by(|| browser.press(&["End"]));
    browser.until_text("#time-label", "3/3");

    let (start, picture) = (browser.camera(), browser.canvas_hash());
    browser.changed_by(|| browser.press(&["Shift Right", "Shift Right", "Shift Up"]));
    let turned = browser.camera();
    assert!(turned[1] > start[1] + 1.0 && turned[2] > start[2] + 0.5, "{start:?} {turned:?}");
    assert_ne!(browser.canvas_hash(), picture);
    browser.changed_by(|| browser.press(&["+", "+", "+"]));
    let near = browser.camera();
    assert!(near[0] < turned[0] - 0.1, "{turned:?} {near:?}");
    browser.changed_by(|| browser.press(&["-"]));
    assert!(browser.camera()[0] > near[0] + 0.05);
    browser.changed_by(|| browser.press(&["Ctrl z"]));
    browser.changed_by(|| browser.press(&["Ctrl Shift z"]));

    // The list of all keys takes them until it is closed.
    browser.press(&["?"]);
    browser.until("the list of keys", "return document.getElementById('help').open;");
    let listed = browser.js("return document.getElementById('help').innerText;");
    for part in ["Shift + arrows", "Space", "Ctrl + Z", "probe", "this list"] {
        assert!(listed.as_str().unwrap().contains(part), "{part} is not in {listed}");
    }
    let focus = "return document.getElementById('help').contains(document.activeElement);";
    assert_eq!(browser.js(focus), true);
    browser.press(&["Left", "Escape"]);
    browser.until("no list of keys", "return !document.getElementById('help').open;");
    browser.until_text("#time-label", "3/3");

    // The cross probes, and centres what it is on.
    browser.press(&["p", "Right", "Right", "Shift Down", "Enter"]);
    browser.until_text("#panel-probe .value", " K");
    assert_eq!(browser.js("return document.activeElement.id;"), "picture");
    let cross = browser.js("return document.getElementById('cross').checkVisibility();");
    assert_eq!(cross, true);
    let before = browser.camera();
    browser.changed_by(|| browser.press(&["c"]));
    let centred = browser.camera();
    assert!(centred[1] > before[1] + 0.2 && centred[2] < before[2] - 0.2, "{before:?} {centred:?}");
    browser.press(&["Escape"]);
    browser.until("no cross", "return document.getElementById('cross').hidden;");

    browser.press(&["h"]);
    browser.until("no panel", "return !document.getElementById('panel').checkVisibility();");
    browser.press(&["h"]);
    browser.until("the panel", "return document.getElementById('panel').checkVisibility();");
    browser.rests();
    browser.press(&[" "]);
    browser.until("playing", "return document.getElementById('play').ariaLabel === 'Stop playing';");
    browser.until_text("#time-label", "1/3");
    browser.until_text("#time-label", "2/3");
    browser.press(&[" "]);
    browser.until("not playing", "return document.getElementById('play').ariaLabel === 'Play through the times';");
    browser.rests();
    browser.is_quiet();
}
