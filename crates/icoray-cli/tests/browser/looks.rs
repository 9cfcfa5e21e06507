//! The page on a screen and on a phone: visibility, contrast, and touch.

use crate::browser::Browser;
use crate::page::{PHONE, SCREEN, Shown};
use serde_json::Value;

pub const TABS: [&str; 4] = ["colours", "scene", "probe", "files"];

/// Checks contrast and layout of what is shown now, and leaves a screenshot.
#[track_caller]
pub fn looks_right(browser: &Browser, name: &str) {
    browser.shot(name);
    let contrast = browser.js(include_str!("contrast.js"));
    assert!(contrast["count"].as_u64() > Some(10), "{name}: {contrast}");
    assert_eq!(contrast["low"], Value::Array(Vec::new()), "{name}");
    let layout = browser.js(include_str!("layout.js"));
    assert!(layout["count"].as_u64() > Some(0), "{name}: {layout}");
    assert_eq!(layout["wrong"], Value::Array(Vec::new()), "{name}");
}

/// The canvas is in sight, at least so large, and shows many colours.
#[track_caller]
fn has_picture(browser: &Browser, least: [f64; 2]) {
    let [_, _, width, height] = browser.rectangle("#picture");
    assert!(width >= least[0] && height >= least[1], "{width} {height}");
    let shades = browser.ask(
        "const { width, height } = canvas;
         const copy = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
         copy.drawImage(canvas, 0, 0);
         return new Set(new Uint32Array(copy.getImageData(0, 0, width, height).data.buffer)).size;",
    );
    assert!(shades.as_u64() > Some(1000), "{shades} colours");
}

/// Opens all sections of the scene's keys.
fn unfold(browser: &Browser) {
    browser.js("for (const details of document.querySelectorAll('#keys details')) details.open = true;");
}

#[test]
fn everything_is_in_sight_on_a_screen() {
    let Some(Shown { browser, .. }) = &Shown::start_with(SCREEN, false) else { return };
    has_picture(browser, [800.0, 600.0]);
    browser.click_at(browser.place([0.5, 0.5]), 1);
    browser.until_text("#panel-probe .value", " K");
    for tab in TABS {
        browser.click(&format!("#tab-{tab}"));
        looks_right(browser, &format!("screen-{tab}"));
    }
    browser.click("#tab-scene");
    unfold(browser);
    looks_right(browser, "screen-scene-unfolded");
    // A refused change, in words.
    browser.click("#find-key");
    browser.type_text("background");
    let input = "#keys .row:not([hidden]) input.text";
    browser.until("the key", &format!("return document.querySelector({input:?})?.checkVisibility();"));
    browser.click(input);
    browser.press(&["Ctrl a", "x", "Enter"]);
    browser.until("a refusal", "return document.querySelector('[aria-invalid], .is-refused') !== null;");
    looks_right(browser, "screen-refused");
    browser.press(&["Escape", "?"]);
    browser.until("the list of keys", "return document.getElementById('help').open;");
    looks_right(browser, "screen-help");
    assert_eq!(browser.log(), [""; 0]);
}

/// A stage that changed with the text below it would ask for pictures of other sizes for ever.
#[test]
fn the_picture_keeps_its_size_for_any_length_of_text() {
    let Some(Shown { browser, .. }) = &Shown::start() else { return };
    for (size, is_phone) in [(PHONE, true), ([800, 560], false), (SCREEN, false)] {
        browser.resize(size, is_phone);
        let height = |text: &str| {
            let facts = format!("const [quality, left_out, pending] = {text};");
            browser.ask(&format!(
                "{facts} const {{ emit }} = await import('/store.js');
                 emit('frame', {{ ...store.frame, quality, left_out, pending, revision: store.scene.revision }});
                 return document.getElementById('stage').offsetHeight;"
            ))
        };
        let short = height("['', [], false]");
        assert!(short.as_f64() > Some(250.0), "{short}");
        for text in
            ["['', [], true]", "['light off', ['gradients'], true]", "['word '.repeat(99), ['x'.repeat(999)], true]"]
        {
            assert_eq!(height(text), short, "{size:?}: {text}");
        }
    }
}

#[test]
fn everything_is_in_reach_on_a_phone() {
    let Some(Shown { browser, .. }) = &Shown::start_with(PHONE, true) else { return };
    assert_eq!(browser.js("return [innerWidth, innerHeight];"), serde_json::json!(PHONE));
    has_picture(browser, [390.0, 500.0]);
    looks_right(browser, "phone");
    let (start, picture) = (browser.camera(), browser.canvas_hash());
    let [from, goal] = [[0.5, 0.5], [0.7, 0.4]].map(|place| browser.place(place));
    browser.changed_by(|| browser.touch(&[[from, goal]]));
    let turned = browser.camera();
    assert!((turned[1] - start[1]).abs() > 1.0 && (turned[0] - start[0]).abs() < 1e-9, "{start:?} {turned:?}");
    assert_ne!(browser.canvas_hash(), picture);
    // Else fingers lifted in motion set off a scroll, and the next touch is lost on it.
    let is_scroll = "return canvas.dispatchEvent(new TouchEvent('touchmove', { bubbles: true, cancelable: true }));";
    assert_eq!(browser.ask(is_scroll), false);
    let fingers = [[[0.4, 0.5], [0.25, 0.5]], [[0.6, 0.5], [0.75, 0.5]]];
    let fingers = fingers.map(|ends| ends.map(|place| browser.place(place)));
    browser.changed_by(|| browser.touch(&fingers));
    assert!(
        browser.camera()[0] < 0.9 * turned[0],
        "two fingers that part come nearer: {turned:?} {:?}",
        browser.camera()
    );
    for tab in TABS {
        browser.tap(&format!("#tab-{tab}"));
        browser.until("the sheet", &format!("return document.getElementById('panel-{tab}').checkVisibility();"));
        browser.rests();
        has_picture(browser, [390.0, 150.0]);
        looks_right(browser, &format!("phone-{tab}"));
    }
    browser.tap("#tab-scene");
    unfold(browser);
    looks_right(browser, "phone-scene-unfolded");
    // A finger probes, and the sheet can be folded again.
    browser.tap("#picture");
    browser.until_text("#panel-probe .value", " K");
    looks_right(browser, "phone-probed");
    browser.tap("#grip");
    browser.until("a folded sheet", "return !document.getElementById('panels').checkVisibility();");
    browser.tap("#open-help");
    browser.until("the list of keys", "return document.getElementById('help').open;");
    looks_right(browser, "phone-help");
    browser.is_quiet();
}
