//! Overlays and surroundings of the picture: labels, values under the mouse, links, full screen, the light theme.

use crate::looks::{TABS, looks_right};
use crate::page::{SCREEN, Shown};
use crate::viewer::Json;
use serde_json::json;

/// Copies the upper left corner of the canvas, where the title is: its bytes, row by row.
const CORNER: &str = "const corner = () => {
       const copy = new OffscreenCanvas(300, 40).getContext('2d', { willReadFrequently: true });
       copy.drawImage(canvas, 0, 0);
       return [...copy.getImageData(0, 0, 300, 40).data];
     };";

#[test]
fn labels_and_lines_of_drafts_are_as_sharp_as_at_rest() {
    let Some(Shown { browser, viewer, .. }) = &Shown::start_with(SCREEN, false) else { return };
    browser.ask(&format!(
        "{CORNER} window.atRest = corner();
         const {{ on }} = await import('/store.js'); const {{ move }} = await import('/sender.js');
         on('frame', (frame) => {{
           if (!frame.is_moving || window.draft) return;
           const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', {{ willReadFrequently: true }});
           copy.drawImage(canvas, 0, 0);
           window.draft = {{ ...frame, corner: corner(), copy }};
         }});
         move([{{ path: ['camera', 'lon'], value: 33 }}], {{ stays: true }});"
    ));
    browser.until("a draft", "return window.draft;");
    let found = browser.ask(
        "const { atRest, draft } = window;
         const off = atRest.map((value, i) => Math.abs(value - draft.corner[i]));
         return [draft.width < canvas.width, draft.labels > 0, Math.max(...off), Math.max(...atRest.slice(0, -4))];",
    );
    // Rounding of the alpha that labels have.
    assert!(found[0] == true && found[1] == true && found[2].as_u64() <= Some(3), "{found}");
    assert!(found[3].as_u64() > Some(150), "the title is there: {found}");
    browser.shot("draft");
    browser.ask("(await import('/sender.js')).rest();");
    browser.rests();
    // Lines lie where the ground is, and are brighter than what is beside them.
    let found = browser.ask(
        "const { placeOn } = await import('/lines.js'); const { towards } = await import('/camera.js');
         const { overlay, copy } = window.draft; const { width, height } = canvas;
         const spacing = overlay.lines.find((lines) => lines.spacing !== null).spacing;
         const light = ({ x, y }) => {
           const { data } = copy.getImageData(Math.round(x * width) - 1, Math.round(y * height) - 1, 3, 3);
           return Math.max(...data.filter((_, i) => i % 4 === 0));
         };
         const lons = Array.from({ length: 27 }, (_, i) => 20 + i);
         const mean = (lat) => lons.reduce((sum, lon) =>
           sum + light(placeOn(overlay, width / height, towards(lon, lat))) / lons.length, 0);
         const at = placeOn(overlay, width / height, towards(30, 40));
         return { at: [at.x, at.y], on: mean(spacing), beside: mean(spacing + 4), count: overlay.lines.length };",
    );
    let [on, beside] = ["on", "beside"].map(|key| found[key].as_f64().unwrap());
    assert!(found["count"] == 2 && on > beside + 25.0, "{found}");
    let seen = viewer.get(&format!("/api/probe?x={}&y={}", found["at"][0], found["at"][1])).json();
    for (key, degrees) in [("lon", 30.0), ("lat", 40.0)] {
        assert!((seen[key].as_f64().unwrap() - degrees).abs() < 4.0, "{seen}");
    }
    browser.is_quiet();
}

/// A scene with a size of its own is shown in another: its labels have the pixels of the screen all the same.
#[test]
fn labels_of_scaled_pictures_have_the_pixels_of_the_screen() {
    let scene = "field = 'theta'\nimage = { width = 200, height = 160 }\n[labels]\ntitle = 'A title'\n";
    let Some(Shown { browser, viewer, .. }) = &Shown::begin(SCREEN, false, scene) else { return };
    browser.go(&viewer.address());
    browser.rests();
    // The bitmap that is drawn last, on the picture, and where.
    browser.js("const { prototype } = CanvasRenderingContext2D; const own = prototype.drawImage;
         prototype.drawImage = function (image, ...place) {
           window.drawn = { size: [image.width, image.height], place };
           return own.call(this, image, ...place);
         };");
    for size in [[1000, 700], SCREEN] {
        browser.resize(size, false);
        let sized = "const { pictureBox } = await import('/view.js'); const { width, height } = pictureBox();
             const size = [width, height].map(Math.round).join();
             return store.frame.width === 200 && width > 400 && window.drawn?.size.join() === size &&
               window.drawn.place.slice(2).join() === size;";
        browser.until_page("labels of the size of the picture", sized);
    }
    browser.is_quiet();
}

#[test]
fn the_value_under_the_mouse_is_shown_until_it_is_another() {
    let Some(Shown { browser, viewer, .. }) = &Shown::start() else { return };
    let [x, y] = browser.place([0.47, 0.56]);
    let hover = |[x, y]: [f64; 2], buttons: u32| {
        browser.ask(&format!(
            "canvas.dispatchEvent(new PointerEvent('pointermove',
               {{ pointerType: 'mouse', clientX: {x}, clientY: {y}, buttons: {buttons}, bubbles: true }}));"
        ));
    };
    hover([x, y], 0);
    browser.until("the value", "return document.getElementById('hover').checkVisibility();");
    let said = browser.until_text("#hover", " K ");
    let found = viewer.get("/api/probe?x=0.47&y=0.56").json();
    let value: f64 = said.split(' ').nth(1).unwrap().replace('−', "-").parse().unwrap();
    assert!((value - found["value"].as_f64().unwrap()).abs() < 1.0, "{said} {found}");
    browser.shot("hover");
    let is_hidden = "return document.getElementById('hover').hidden;";
    hover([x, y], 1);
    assert_eq!(browser.js(is_hidden), true, "a button is down");
    hover([x, y], 0);
    browser.until("the value again", "return document.getElementById('hover').checkVisibility();");
    browser.changed_by(|| browser.click("#earlier"));
    assert_eq!(browser.js(is_hidden), true, "another picture");
    browser.is_quiet();
}

#[test]
fn a_copied_link_shows_the_same_picture() {
    let Some(Shown { browser, viewer, .. }) = &Shown::start() else { return };
    browser.changed_by(|| browser.press(&["Shift Right", "Shift Up", "+"]));
    browser.changed_by(|| browser.click("#earlier"));
    let (camera, time) = (browser.camera(), browser.number("store.scene.time"));
    browser.js("navigator.clipboard.writeText = async (text) => { window.copied = text; };");
    browser.click("#tab-files");
    browser.click("#copy-link");
    browser.until_text("#status", "The link is copied");
    let link = browser.js("return window.copied;").as_str().unwrap().to_owned();
    assert!(link.starts_with(&viewer.address()), "{link}");
    browser.changed_by(|| browser.press(&["Escape", "Home", "Shift Left", "Shift Left", "-"]));
    assert!(browser.camera() != camera && browser.number("store.scene.time") != time);
    browser.go(&link);
    browser.until_page("the time of the link", &format!("return store.scene?.time === {time};"));
    browser.rests();
    assert_eq!(browser.camera(), camera);
    assert_eq!(browser.js("return location.hash;"), "", "the token is not left in the address");
    browser.is_quiet();
    // What is no link of this page is said, and the page shows its picture.
    browser.go(&format!("{}&camera=x", viewer.address()));
    browser.until_text("#alert", "The link cannot be followed");
    browser.rests();
}

#[test]
fn the_picture_fills_the_screen_and_comes_back() {
    let Some(Shown { browser, .. }) = &Shown::start() else { return };
    browser.click("#full-screen");
    browser.until("a full screen", "return document.fullscreenElement?.id === 'main';");
    browser.until("a pressed button", "return document.getElementById('full-screen').ariaPressed === 'true';");
    browser.press(&["f"]);
    browser.until("the page", "return !document.fullscreenElement;");
    browser.until("a button", "return document.getElementById('full-screen').ariaPressed === 'false';");
    browser.rests();
    browser.is_quiet();
}

#[test]
fn the_page_is_dark_or_light_as_the_reader_wants_it() {
    let Some(Shown { browser, .. }) = &Shown::start_with(SCREEN, false) else { return };
    browser.click_at(browser.place([0.5, 0.5]), 1);
    browser.until_text("#panel-probe .value", " K");
    for (scheme, expected) in [("dark", "rgb(17, 21, 26)"), ("light", "rgb(246, 248, 250)")] {
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        browser.cdp("Emulation.setEmulatedMedia", json!({ "features": features }));
        let ground = browser.js("return getComputedStyle(document.getElementById('panel')).backgroundColor;");
        assert_eq!(ground, expected, "{scheme}");
        for tab in TABS {
            browser.click(&format!("#tab-{tab}"));
            looks_right(browser, &format!("{scheme}-{tab}"));
        }
    }
    browser.is_quiet();
}

#[test]
fn the_page_shows_progress_until_there_is_a_picture() {
    let Some(Shown { browser, viewer, .. }) = &Shown::start() else { return };
    // Pictures come when the test lets them.
    let source = "const own = window.fetch; const letGo = new Promise((resolve) => { window.letGo = resolve; });
         window.fetch = async (path, options) => {
           if (String(path).includes('/api/frame')) { window.isAsked = true; await letGo; }
           return own(path, options);
         };";
    browser.cdp("Page.addScriptToEvaluateOnNewDocument", json!({ "source": source }));
    browser.go("about:blank");
    browser.go(&viewer.address());
    browser.until("a picture is asked for", "return window.isAsked;");
    assert_eq!(browser.js("return document.getElementById('drawing').checkVisibility();"), true);
    browser.shot("drawing");
    browser.js("window.letGo();");
    browser.rests();
    assert_eq!(browser.js("return document.getElementById('drawing').checkVisibility();"), false);
}

#[test]
fn keys_that_few_need_are_in_a_group_of_their_own() {
    let Some(Shown { browser, .. }) = &Shown::start() else { return };
    browser.click("#tab-scene");
    let row = |name: &str| {
        format!("[...document.querySelectorAll('#keys .row')].find((row) => row.dataset.find.startsWith(' {name} '))")
    };
    let is_seen = |name: &str| browser.js(&format!("return {}.checkVisibility();", row(name)));
    assert_eq!([is_seen("tolerance"), is_seen("precision")], [json!(true), json!(false)]);
    browser.click("#find-key");
    browser.type_text("precision");
    browser.until("the key", &format!("return {}.checkVisibility();", row("precision")));
    assert_eq!(is_seen("tolerance"), false);
    browser.is_quiet();
}

#[test]
fn saved_scenes_describe_the_shown_picture() {
    let Some(Shown { browser, .. }) = &Shown::start() else { return };
    // The comment about the field, the time and the command of the suggestion.
    assert!(browser.text().starts_with("field = \"theta\""), "{}", browser.text());
    browser.changed_by(|| {
        browser.ask(
            "const { move, rest } = await import('/sender.js'); const { turned, changesOf } = await import('/camera.js');
             const camera = { kind: 'globe', lon: 0, lat: 0, distance: 4, fov: 30, keys: { distance: 'distance', drops: [] } };
             const goal = turned({ ...camera, lon: 175 }, -30, 0);
             move(changesOf(goal, camera)); rest();",
        );
    });
    assert_eq!(browser.ask("return store.scene.values.camera.lon;"), -155.0);
}
