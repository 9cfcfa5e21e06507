//! Random requests of any kind to the page of a model: the model's own settings stay unchanged.

use super::*;
use crate::session::{ChangeRequest, PictureSize, Start};
use crate::steering::{Steered, steering_reader};
use icoray::Script;
use icoray::keys::section_at;
use icoray::output::Stamp;
use icoray_test_support::{Random, count};
use serde_json::{Value as Json, json};

const PLAIN: &str = "field = 'q'\nevery = 3\nat_steps = [7]\nwhen = 'max(q) > 0'\nsamples = 2\ntolerance = 1e-4\n\
    [live]\nport = 9000\n[image]\nwidth = 64\nheight = 48\n[output]\nfile = 'a_{step}.png'\ncinema = 'a.cdb'\n\
    [[derive]]\nname = 'd'\nmagnitude = ['q', 'w']\n[camera]\nlon = 3\nlat = 4\ndistance = 3\n[[clip]]\nlat = [0, 9]\n";
const VIEWS: &str = "field = 'q'\nheights = 'native'\n[live]\n[[views]]\nname = 'a'\nat_times = [100]\n\
    output.file = 'a_{step}.png'\n[[views]]\nname = 'b'\nevery = 5\nwhen = 'mean(w) > 1'\n\
    output.file = 'b_{step}.png'\n[views.camera]\nlon = 7\nlat = 1\n";
/// Sections of a file with a blank between them, the keys at the top first.
const SECTIONS: &str =
    " camera transfer opacity volumes surfaces isosurfaces lines ground clip light labels image output derive";
/// Values of which each key takes some.
const VALUES: &str = r#"[null, true, false, 0, 1, -1, 3, 9, 1e9, 1e300, 0.5, 45, "q", "w", "d", "z", "", "../x.png",
    "red", "viridis", "log", "top", "cells", "headlight", "a_{step}.png", [0, 9], [-1, 1], [0, 0, 1], [[0, 0], [1, 0.5]],
    [1, 2, 3], [1, 2, 3, 4, 5, 6, 7, 8, 9], {}, { "lon": 3, "lat": 5 }, { "field": "w", "value": 2, "color": "blue" },
    { "map": "magma" }, { "percentile": [2, 98] }, [{ "layer": 1, "color": "red" }], [[]]]"#;

fn one<'a, T>(random: &mut Random, of: &'a [T]) -> &'a T {
    &of[random.below(of.len())]
}

/// A change of a key of the schema, or of nothing that there is.
fn change_of(random: &mut Random, values: &[Json]) -> Json {
    let sections: Vec<&str> = SECTIONS.split(' ').collect();
    let section = section_at(sections[random.below(sections.len())]).unwrap();
    let mut path: Vec<Json> = section.name.split('.').filter(|part| !part.is_empty()).map(Json::from).collect();
    path.extend(section.is_list.then(|| json!(random.below(10))));
    if random.below(5) > 0 {
        path.extend(one(random, &section.keys).name.split('.').map(Json::from));
    }
    if random.below(20) == 0 {
        path.resize(random.below(3000), json!("a"));
    }
    json!({ "path": path, "value": one(random, values) })
}

/// A text like one that is there.
fn text_like(random: &mut Random, text: &str) -> String {
    let line =
        *one(random, &["", "[output]", "every = 9", "samples = 64", "[[derive]]", "field = 'w'", "lon = 8", "\0"]);
    let mut lines: Vec<&str> = text.lines().collect();
    let at = random.below(lines.len());
    match random.below(3) {
        0 => lines.truncate(at),
        1 => lines.insert(at, line),
        _ => lines[at] = line,
    }
    lines.join("\n") + "\n"
}

/// The model's own settings of a scene: times, contents, destination and cost of its pictures.
fn models_own(text: &str) -> String {
    let (script, plain) = (Script::parse(text).unwrap(), Scene::parse("field = 'q'").unwrap());
    let (mut own, mut before) = (format!("{:?}\n", script.live()), None);
    for view in script.views() {
        own += &format!("{:?} {:?}\n", view.name(), view.conditions());
    }
    for step in 0..12 {
        let now = Stamp { step, time_s: 30.0 * step as f64, date: None };
        for shot in script.scheduled(&now, before.as_ref()).flat_map(|view| view.shots(&now)) {
            // The settings that viewers may change are made equal; the rest is compared.
            let Scene { camera, volumes, exaggeration, background, core, lighting, labels, .. } = plain.clone();
            let mut scene = Scene { camera, volumes, exaggeration, background, core, lighting, labels, ..shot.scene };
            let scenery = &mut scene.scenery;
            (scenery.surfaces, scenery.isosurfaces, scenery.lines, scenery.clips) = Default::default();
            scenery.ground = Default::default();
            own += &format!("{step} {:?} {scene:?}\n", shot.name);
        }
        before = Some(now);
    }
    own
}

#[test]
fn random_requests_change_nothing_of_the_models() {
    let values: Vec<Json> = serde_json::from_str(VALUES).unwrap();
    let requests = count(2000, 100_000);
    for (seed, own) in [PLAIN, VIEWS].into_iter().enumerate() {
        let mut random = Random::new(seed as u64);
        let fields = ["q", "w"].map(str::to_owned).into();
        let steered = Arc::new(Mutex::new(Steered { text: own.to_owned(), fields }));
        let start = Start { text: own.to_owned(), time: 0, times: 0, size: PictureSize::Scene };
        let hub = Hub::new(Session::new(start, steering_reader(Some("q".to_owned()), steered)).unwrap());
        let expected = models_own(own);
        let (mut taken, mut drawn, mut checked) = (0, 0, String::new());
        for _ in 0..requests / 2 {
            let done = match random.below(10) {
                0 => hub.change(|session| session.step(true)),
                1 => hub.change(|session| session.step(false)),
                2 => {
                    let text = hub.look(|session| text_like(&mut random, session.text()));
                    hub.change(|session| session.load(&text))
                }
                3 => hub.change(|session| session.load(own)),
                _ => {
                    let changes: Vec<Json> =
                        (0..1 + random.below(2)).map(|_| change_of(&mut random, &values)).collect();
                    let mut request = json!({ "changes": changes, "is_moving": random.below(3) == 0 });
                    if random.below(5) == 0 {
                        request["view"] = json!(one(&mut random, &["a", "b", "c", ""]));
                        request["size"] = json!([random.below(9000), 100]);
                    }
                    let request: ChangeRequest = serde_json::from_value(request).unwrap();
                    hub.change(|session| session.change(&request))
                }
            };
            taken += usize::from(done.is_ok());
            if let (0, Some(change)) = (random.below(3), hub.take().change) {
                drawn += 1;
                if random.below(4) == 0 {
                    hub.refuse(&change.before, "it cannot be drawn");
                }
            }
            let text = hub.look(|session| session.text().to_owned());
            if text != checked {
                assert_eq!(models_own(&text), expected, "{text}");
                checked = text;
            }
        }
        assert!(taken > requests / 20 && drawn > requests / 100, "{taken} taken, {drawn} drawn of {requests}");
    }
}
