//! Sessions: changes, undoing and the scenes of pictures.

use super::*;
use serde_json::json;

const TEXT: &str = "field = \"q\"\ncamera = { lon = 1 }\n";

fn session(text: &str) -> Session {
    let start = Start { text: text.to_owned(), time: 0, times: 3, size: PictureSize::default() };
    Session::new(start, plain_reader()).unwrap()
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
fn refused_changes_change_nothing() {
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
fn sizes_follow_the_viewer_unless_the_scene_sets_them() {
    let mut session = session(TEXT);
    let sized = |size: [u32; 2], is_moving: bool| request(json!({ "size": size, "is_moving": is_moving }));
    session.change(&sized([900, 600], false)).unwrap();
    assert!(Scene::parse(session.text()).is_ok_and(|scene| (scene.width, scene.height) == (900, 600)));
    assert_eq!(session.history(), [false, false], "a size is no step");
    session.change(&sized([640, 480], true)).unwrap();
    assert_eq!((session.scene().width, session.scene().height), (900, 600));
    let moving = session.moving_scene(80.0, [640, 480]);
    assert_eq!((moving.width, moving.height, moving.time_budget_ms), (640, 427, Some(80.0)));
    let lines = "[[lines]]\npattern = \"coast\"\n[[lines]]\npattern = \"cells\"\n";
    for (labels, traced) in [("", 2), ("[labels]\n", 1), ("[labels]\nplace = \"below\"\n", 2)] {
        let session = self::session(&format!("{TEXT}[transfer]\n{lines}{labels}"));
        let draft = session.moving_scene(80.0, [640, 480]);
        let notes = [&draft, session.scene()].map(|scene| scene.labels.as_ref().map(|labels| labels.error_note));
        assert_eq!(notes, if labels.is_empty() { [None; 2] } else { [Some(Some(false)), Some(None)] }, "{labels}");
        let found = draft.scenery.lines.len();
        assert_eq!((found, session.lines_over().len()), (traced, 2 - traced), "{labels}");
    }
    // 5 of its pixels are 7 of those at rest.
    assert_eq!(moving.largest_step, 5);
    let own = "field = \"q\"\nimage = { width = 40, height = 30 }\n";
    session.load(own).unwrap();
    session.change(&sized([900, 600], false)).unwrap();
    assert_eq!((session.scene().width, session.text()), (40, own));
    assert!(session.change(&sized([0, 5], true)).is_ok());
}

#[test]
fn pictures_have_the_size_of_the_largest_page() {
    let mut session = session(TEXT);
    let mut size_with = |page: u32, size: [u32; 2]| {
        session.change(&request(json!({ "size": size, "page": page }))).unwrap();
        [session.scene().width, session.scene().height]
    };
    assert_eq!(size_with(1, [900, 600]), [900, 600]);
    assert_eq!(size_with(2, [400, 700]), [900, 600], "the picture of the first is not shrunk");
    assert_eq!(size_with(1, [300, 200]), [400, 700], "it has become the smaller one itself");
    assert_eq!(size_with(2, [0, 0]), [300, 200], "the larger one is closed");
    assert_eq!(size_with(1, [0, 0]), [300, 200], "no page is open");
    for page in 0..200 {
        size_with(page, [100, 100]);
    }
    assert_eq!(session.sizes.len(), MAX_PAGES);
}

#[test]
fn texts_and_their_history_have_a_bound() {
    let mut session = session(TEXT);
    let long = |fill: &str| format!("{TEXT}# {}\n", fill.repeat(MAX_TEXT - TEXT.len() - 3));
    let error = session.load(&format!("{}\n", long("x"))).unwrap_err();
    assert_eq!(error, format!("a scene of {} bytes, expected at most {MAX_TEXT}", MAX_TEXT + 1));
    for fill in ["a", "b"].into_iter().cycle().take(40) {
        session.load(&long(fill)).unwrap();
    }
    assert_eq!(session.undo.len(), MAX_UNDO_BYTES / MAX_TEXT);
    session.step(true).unwrap();
    assert!(session.text() == long("a") && session.history() == [true, true]);
    for number in 0..MAX_UNDO + 40 {
        session.load(&format!("{TEXT}# {number}\n")).unwrap();
    }
    assert_eq!(session.undo.len(), MAX_UNDO);
}

#[test]
fn views_are_chosen_by_name_and_stay_chosen() {
    let text = format!("{TEXT}[[views]]\nname = \"a\"\n[[views]]\nname = \"b\"\ncamera.lon = 9\n");
    let mut session = session(&text);
    assert_eq!((session.views(), session.view()), (vec!["a", "b"], "a"));
    let error = session.change(&request(json!({ "view": "c" }))).unwrap_err();
    assert_eq!(error, "view \"c\", expected one of \"a\", \"b\"");
    session.change(&request(json!({ "view": "b" }))).unwrap();
    session.change(&lon(12.0, false)).unwrap();
    assert_eq!((session.view(), session.values()["camera"]["lon"].as_f64()), ("b", Some(12.0)));
    assert!(session.text().contains("lon = 1 ") && session.text().contains("lon = 12"), "{}", session.text());
    session.change(&request(json!({ "changes": [{ "path": ["views", 0], "value": null }] }))).unwrap();
    assert_eq!((session.views(), session.view()), (vec!["b"], "b"));
    session.step(true).unwrap();
    assert_eq!((session.views(), session.view()), (vec!["a", "b"], "b"));
    session.load(TEXT).unwrap();
    assert!(session.views().is_empty());
}
