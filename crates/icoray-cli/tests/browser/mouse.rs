//! The mouse: turning, zooming, editing a knot, probing, playing.

use crate::page::{SMALL, Shown};
use crate::viewer::Json;
use icoray::{Renderer, Scene};
use std::collections::BTreeSet;

#[test]
fn the_mouse_turns_zooms_and_centres() {
    let Some(Shown { browser, viewer, .. }) = &Shown::start() else { return };
    let (first, start, picture) = (browser.text(), browser.camera(), browser.canvas_hash());
    let probe = |[x, y]: [f64; 2]| {
        let found = viewer.get(&format!("/api/probe?x={x:.5}&y={y:.5}")).json();
        ["lon", "lat"].map(|key| found[key].as_f64().unwrap())
    };
    let seen = probe([0.5, 0.5]);
    let [from, goal] = [[0.5, 0.5], [0.58, 0.44]].map(|place| browser.place(place));
    browser.changed_by(|| browser.drag(from, goal));
    let turned = browser.camera();
    assert!((turned[0] - start[0]).abs() < 1e-9, "{start:?} {turned:?}");
    assert_ne!(browser.canvas_hash(), picture);
    // What was under the mouse has followed it.
    let followed = probe([0.58, 0.44]);
    assert!(seen.iter().zip(followed).all(|(a, b)| (a - b).abs() < 6.0), "{seen:?} {followed:?}");

    browser.changed_by(|| browser.wheel(from, -240));
    let near = browser.camera();
    assert!(near[0] < turned[0] - 0.1 && (near[1] - turned[1]).abs() < 1e-9, "{turned:?} {near:?}");
    browser.changed_by(|| browser.wheel(from, 120));
    assert!(browser.camera()[0] > near[0] + 0.05);

    let wanted = probe([0.6, 0.4]);
    browser.changed_by(|| browser.click_at(browser.place([0.6, 0.4]), 2));
    let centred = browser.camera();
    let off = [centred[1] - wanted[0], centred[2] - wanted[1]].map(f64::abs);
    assert!(off.iter().all(|degrees| *degrees < 0.5), "{centred:?} {wanted:?}");

    // Each of them is a step.
    for _ in 0..4 {
        browser.changed_by(|| browser.click("#undo"));
    }
    assert_eq!((browser.text(), browser.canvas_hash()), (first, picture));
    browser.until_page("no more to undo", "return document.getElementById('undo').disabled;");
    browser.changed_by(|| browser.click("#redo"));
    assert_eq!(browser.camera(), turned);
    browser.is_quiet();
}

#[test]
fn a_knot_follows_the_mouse() {
    let Some(Shown { browser, .. }) = &Shown::start() else { return };
    let knots = || {
        let found = browser.ask("return store.scene.values.transfer.knots;");
        let part = |knot: &serde_json::Value, key: &str| knot[key].as_f64().unwrap();
        found.as_array().unwrap().iter().map(|knot| [part(knot, "value"), part(knot, "opacity")]).collect::<Vec<_>>()
    };
    let handle = |k: usize| format!(".handle.is-point[data-index='{k}']");
    browser.changed_by(|| {
        let button = "[...document.querySelectorAll('#colours button')].find((b) => b.textContent === 'Edit knots')";
        browser.js(&format!("{button}.id = 'edit-knots';"));
        browser.click("#edit-knots");
    });
    browser.until_text("#status", "now a list of knots");
    let (first, picture) = (knots(), browser.canvas_hash());
    assert!(first.len() > 2, "{first:?}");
    browser.until("the handles", &format!("return document.querySelectorAll('.handle').length === {};", first.len()));
    let last = first.len() - 1;
    let [x, y] = browser.middle(&handle(last));
    browser.changed_by(|| browser.drag([x, y], [x - 4.0, y + 63.0]));
    let moved = knots();
    // The curve is 126 pixels high.
    assert!((moved[last][1] - (first[last][1] - 0.5).max(0.0)).abs() < 0.02, "{first:?} {moved:?}");
    assert!(moved[last][0] < first[last][0] && moved[..last] == first[..last], "{first:?} {moved:?}");
    assert_ne!(browser.canvas_hash(), picture);

    // The same knot by keys: it has the focus.
    browser.changed_by(|| browser.press(&["Up", "Up", "Up"]));
    assert!((knots()[last][1] - moved[last][1] - 0.03).abs() < 1e-3);
    browser.changed_by(|| browser.press(&["Delete"]));
    assert_eq!(knots().len(), last);
    browser.changed_by(|| browser.press(&["Ctrl z"]));
    assert_eq!(knots().len(), first.len());

    // By the number in its row.
    browser.js(&format!("document.querySelector(\"{}\").focus();", handle(1)));
    let input = "#colours .point-row input.number";
    browser.until_page("the row of the point", &format!("return document.querySelector('{input}').checkVisibility();"));
    let wanted = 0.25 * first[0][0] + 0.75 * first[1][0];
    browser.click(input);
    browser.press(&["Ctrl a"]);
    browser.changed_by(|| {
        browser.type_text(&format!("{wanted:.2}"));
        browser.press(&["Enter"]);
    });
    assert!((knots()[1][0] - wanted).abs() < 0.01, "{wanted} {:?}", knots());
    browser.shot("knots");
    browser.is_quiet();
}

#[test]
fn a_probe_shows_the_values_of_the_renderer() {
    let Some(Shown { browser, viewer, folder }) = &Shown::start() else { return };
    browser.click_at(browser.place([0.47, 0.56]), 1);
    let shown = browser.until_text("#panel-probe .value", " K");
    // The message about the probe lies below the middle of the picture, away from the title.
    let is_low = browser.js("const [said, stage] = ['.said', '#stage'].map((it) => document.querySelector(it));
         return said.offsetTop > stage.clientHeight / 2;");
    assert_eq!(is_low, true);
    // The place that the page has asked for.
    let asked = browser.js("const names = performance.getEntriesByType('resource').map((entry) => entry.name);
         const { searchParams } = new URL(names.filter((name) => name.includes('/api/probe')).at(-1));
         return ['x', 'y'].map((key) => Number(searchParams.get(key)));");
    let at = [0, 1].map(|k: usize| asked[k].as_f64().unwrap());
    assert!((at[0] - 0.47).abs() < 0.002 && (at[1] - 0.56).abs() < 0.002, "{at:?}");

    let file = icoray_netcdf::open(folder.at("made.nc")).unwrap();
    let scene = Scene::parse(&browser.text()).unwrap();
    let (grid, layers) = (file.mesh().grid().unwrap(), file.layers(scene.field()).unwrap());
    let values = file.read_field(scene.field(), browser.number("store.frame.time") as usize).unwrap();
    let renderer = Renderer::new(1).unwrap();
    let found = renderer.probe(&scene, &grid, &layers, &values.field().unwrap(), at).unwrap().unwrap();
    let [lon, lat] = found.lon_lat_deg;

    let answer = viewer.get(&format!("/api/probe?x={:.5}&y={:.5}", at[0], at[1])).json();
    // JSON is read to a unit in the last place.
    assert!((answer["value"].as_f64().unwrap() / found.value.unwrap() - 1.0).abs() < 1e-14, "{answer} {found:?}");
    let number = |text: &str| text.replace('−', "-").parse::<f64>().unwrap();
    let value = number(shown.strip_suffix(" K").unwrap());
    assert!((value / found.value.unwrap() - 1.0).abs() < 1e-4, "{shown} {found:?}");
    let facts = browser.js("return document.querySelector('#panel-probe dl').innerText;");
    let degrees = |value: f64, [positive, negative]: [char; 2]| {
        format!("{:.2}° {}", value.abs(), if value < 0.0 { negative } else { positive })
    };
    for wanted in [degrees(lon, ['E', 'W']), degrees(lat, ['N', 'S'])] {
        assert!(facts.as_str().unwrap().contains(&wanted), "{wanted} is not in {facts}");
    }
    assert_eq!(browser.js("return document.querySelectorAll('#panel-probe svg.plot').length;"), 2);
    let ticks = browser.js("const textOf = (e) => `${e.getAttribute('text-anchor')} ${e.textContent}`;
         return [...document.querySelectorAll('#panel-probe svg.plot')].flatMap((plot, i) =>
           [...plot.querySelectorAll('text[x]:not(.title)')].map((e) => `${i} ${textOf(e)}`));");
    let ticks: Vec<&str> = ticks.as_array().unwrap().iter().map(|tick| tick.as_str().unwrap()).collect();
    let distinct: BTreeSet<&str> = ticks.iter().copied().collect();
    assert!(ticks.len() > 8 && distinct.len() == ticks.len(), "{ticks:?}");
    browser.shot("probe");
    // Ends that differ in the last digit, as those of fields of 32 bits in 64: an axis without room for ticks.
    let few = browser.js("const { ticks } = await import('/plot.js');
         return [ticks(275.51560725007454, 275.5156072500746, 5), ticks(1e300, 1.1e300, 5)].map((all) => all.length);");
    assert!(few[0].as_u64() <= Some(12) && few[1].as_u64() >= Some(3), "{few}");

    browser.click_at(browser.place([0.01, 0.01]), 1);
    browser.until_text("#panel-probe", "shows the background");
    browser.is_quiet();
}

#[test]
fn times_are_played_until_a_hand_stops_them() {
    let Some(Shown { browser, .. }) = &Shown::start() else { return };
    browser.until_text("#time-label", "3/3");
    let last = browser.canvas_hash();
    browser.changed_by(|| browser.click("#earlier"));
    browser.until_text("#time-label", "2/3");
    assert_ne!(browser.canvas_hash(), last);
    // All times that are drawn from now on.
    browser.ask(
        "const { on } = await import('/store.js');
         window.drawn = []; on('frame', (frame) => window.drawn.push(frame.time));",
    );
    browser.click("#play");
    browser.until_page("two rounds", "return window.drawn.filter((time) => time === 0).length >= 2;");
    assert_eq!(browser.js("return document.getElementById('play').ariaLabel;"), "Stop playing");
    browser.click("#play");
    browser.rests();
    let drawn = browser.js("return window.drawn;");
    let drawn: Vec<i64> = drawn.as_array().unwrap().iter().map(|time| time.as_i64().unwrap()).collect();
    // Each time after the one before it; the last may be drawn again at rest.
    let is_next = |pair: &[i64]| pair[1] == (pair[0] + 1) % 3 || pair[1] == pair[0];
    assert!(drawn.windows(2).all(is_next), "{drawn:?}");
    let time = browser.number("store.scene.time");
    browser.until_text("#time-label", &format!("{}/3", time + 1.0));
    browser.until_page("no more refining", "return !document.querySelector('.is-pending');");
    browser.is_quiet();
}

/// Chooses a field in the colour panel.
const CHOOSE_W: &str = "const select = document.querySelector('#colours select[aria-label=Field]'); select.value = 'w';
     select.dispatchEvent(new Event('change'));";

#[test]
fn another_field_has_its_own_look() {
    let Some(Shown { browser, viewer, folder }) = &Shown::start() else { return };
    let first = viewer.get("/api/scene").json()["values"].clone();
    browser.changed_by(|| drop(browser.js(CHOOSE_W)));
    browser.until_text("#facts", "w");
    let values = viewer.get("/api/scene").json()["values"].clone();
    let alone = folder.view(&["--field", "w"]);
    let alone = alone.get("/api/scene").json()["values"].clone();
    assert_eq!([&values["field"], &values["transfer"]], [&alone["field"], &alone["transfer"]]);
    assert!(values["transfer"] != first["transfer"] && values["camera"] == first["camera"]);
    // Beside a second volume a choice changes that one alone.
    let volumes = r#"[{"field":"w","transfer":{"map":"magma"}},{"field":"rho","transfer":{"map":"viridis"}}]"#;
    let changes = format!(
        r#"{{"changes":[{{"path":["field"],"value":null}},{{"path":["transfer"],"value":null}},
        {{"path":["volumes"],"value":{volumes}}}]}}"#
    );
    assert_eq!(viewer.post("/api/change", &changes).status, 200);
    browser.until_page("two volumes", "return store.scene.values.volumes?.length === 2;");
    browser.js(&CHOOSE_W.replace("'w'", "'theta'"));
    browser.until_page("the choice", "return store.scene.values.volumes?.[0].field === 'theta';");
    assert_eq!(viewer.get("/api/scene").json()["values"]["volumes"][1]["field"], "rho");
    browser.is_quiet();
}

#[test]
fn an_isosurface_is_suggested_for_the_field_that_was_chosen() {
    let Some(Shown { browser, viewer, .. }) = &Shown::start() else { return };
    let range = viewer.get("/api/histogram?field=w").json()["range"].clone();
    // The histogram comes when the test lets it.
    browser.js("const own = window.fetch; const letGo = new Promise((resolve) => { window.letGo = resolve; });
         window.fetch = async (path, options) => {
           if (String(path).includes('histogram')) { window.isAsked = true; await letGo; }
           return own(path, options);
         };");
    browser.js(&format!(
        "{CHOOSE_W} [...document.querySelectorAll('#colours button')].find((b) => b.textContent === 'Add isosurface').click();"
    ));
    browser.until("the histogram is asked for", "return window.isAsked;");
    browser.js("window.letGo();");
    let added = browser.until_page("an isosurface", "return store.scene.values.isosurfaces?.[0];");
    let [low, high] = [0, 1].map(|k: usize| range[k].as_f64().unwrap());
    // That of the other tab is not of the values of a picture, which may be another field's.
    let other = browser.ask(
        "const { additionOf } = await import('/hints.js');
         store.frame = { ...store.frame, value_range: [1e9, 2e9] };
         return (await additionOf({ name: 'isosurfaces' })).at(-1).value;",
    );
    for added in [added, other] {
        assert_eq!(added["field"], "w");
        assert!(added["value"].as_f64().is_some_and(|value| (low..=high).contains(&value)), "{added} of {range}");
    }
    browser.is_quiet();
}

#[test]
fn the_line_below_a_picture_describes_its_surface() {
    let scene = "field = 'theta'\n[[surfaces]]\nlayer = 0\nfield = 'theta'\ntransfer = { map = 'magma' }\n";
    let Some(Shown { browser, viewer, .. }) = &Shown::begin(SMALL, false, scene) else { return };
    browser.open(viewer);
    browser.until_text("#facts", "theta");
    browser.until("the panel", "return document.querySelector('#colours select[aria-label=Field]');");
    browser.changed_by(|| drop(browser.js(CHOOSE_W)));
    let said = browser.ask(
        "const { values, field } = store.scene;
         return [values.field, values.surfaces[0].field, field, document.querySelector('#facts span span').textContent];",
    );
    assert!(said.as_array().unwrap().iter().all(|name| name.as_str().unwrap().starts_with('w')), "{said}");
    browser.is_quiet();
}
