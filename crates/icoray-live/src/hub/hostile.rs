//! Random requests to the page of a model, whatever they ask for: what is the model's stays as it was.

use super::*;
use crate::session::{ChangeRequest, PictureSize, Start};
use crate::steering::{Steered, steering_reader};
use icoray::Script;
use icoray::keys::{Key, Kind, section_at};
use icoray::output::Stamp;
use icoray_test_support::{Random, count};
use serde_json::{Value as Json, json};

const PLAIN: &str = "field = 'q'\nevery = 3\nat_steps = [7]\nwhen = 'max(q) > 0'\nsamples = 2\ntolerance = 1e-4\n\
    [live]\nport = 9000\n[image]\nwidth = 64\nheight = 48\n[output]\nfile = 'a_{step}.png'\ncinema = 'a.cdb'\n\
    [[derive]]\nname = 'd'\nmagnitude = ['q', 'w']\n[camera]\nlon = 3\nlat = 4\ndistance = 3\n[[clip]]\nlat = [0, 9]\n";
const VIEWS: &str = "field = 'q'\nheights = 'native'\n[live]\n[[views]]\nname = 'a'\nat_times = [100]\n\
    output.file = 'a_{step}.png'\n[[views]]\nname = 'b'\nevery = 5\nwhen = 'mean(w) > 1'\n\
    output.file = 'b_{step}.png'\n[views.camera]\nlon = 7\nlat = 1\n";
/// Sections of a file; the first are viewers'.
const SECTIONS: [&str; 16] = [
    "",
    "camera",
    "transfer",
    "opacity",
    "volumes",
    "surfaces",
    "isosurfaces",
    "lines",
    "ground",
    "clip",
    "light",
    "labels",
    "image",
    "output",
    "derive",
    "views",
];
const TEXTS: [&str; 12] =
    ["q", "w", "d", "z", "", "../x.png", "/etc/passwd", "red", "viridis", "a_{step}.png", "\0\n", "[live]"];
const NUMBERS: [f64; 12] = [0.0, 1.0, -1.0, 0.5, 3.0, 45.0, 1e9, 1e300, -1e-300, 8.0, 300.0, 1e-4];

fn one<'a, T>(random: &mut Random, of: &'a [T]) -> &'a T {
    &of[random.below(of.len())]
}

/// A value of a key's kind, or now and then another.
fn value(random: &mut Random, kind: Kind, key: &Key) -> Json {
    if random.below(12) == 0 {
        return one(random, &[Json::Null, json!({}), json!([[]]), json!("x"), json!(-1), json!(true)]).clone();
    }
    match kind {
        Kind::Boolean => json!(random.below(2) == 0),
        Kind::Integer | Kind::Layer(_) => json!(*one(random, &NUMBERS) as i64),
        Kind::Number => json!(one(random, &NUMBERS)),
        Kind::Word(words) | Kind::Color(words) if !words.is_empty() && random.below(3) > 0 => json!(one(random, words)),
        Kind::Text | Kind::Word(_) | Kind::Color(_) => json!(one(random, &TEXTS)),
        Kind::Vector(names) => names.iter().map(|_| json!(one(random, &NUMBERS))).collect(),
        Kind::NumbersByName => json!({ "q": 1, "w": 2 }),
        Kind::List(of) => (0..random.below(12)).map(|_| value(random, *of, key)).collect(),
        Kind::Either(first, second) => {
            let of = if random.below(2) == 0 { first } else { second };
            value(random, *of, key)
        }
        Kind::Table | Kind::Section => {
            let keys: Vec<&Key> = key.keys().collect();
            let some =
                (0..random.below(4)).filter(|_| !keys.is_empty()).map(|_| **one(random, &keys)).collect::<Vec<_>>();
            Json::Object(some.iter().map(|key| (key.name.to_owned(), value(random, key.kind, key))).collect())
        }
    }
}

/// A change of a key of the schema, or of nothing that there is.
fn change_of(random: &mut Random) -> Json {
    let count = if random.below(4) == 0 { SECTIONS.len() } else { 12 };
    let name = *one(random, &SECTIONS[..count]);
    let section = section_at(name).unwrap();
    let listed = one(random, &section.keys);
    let mut path: Vec<Json> = name.split('.').filter(|part| !part.is_empty()).map(|part| json!(part)).collect();
    path.extend(section.is_list.then(|| json!(random.below(10))));
    path.extend(listed.name.split('.').map(|part| json!(part)));
    match random.below(20) {
        0 => path.truncate(random.below(path.len())),
        1 => path.extend((0..random.below(3000)).map(|_| json!("a"))),
        _ => (),
    }
    json!({ "path": path, "value": value(random, listed.key.kind, listed.key) })
}

/// A text like one that is there.
fn text_like(random: &mut Random, text: &str, own: &str) -> String {
    let line =
        *one(random, &["", "[output]", "every = 9", "samples = 64", "[[derive]]", "field = 'w'", "lon = 8", "\0"]);
    let mut lines: Vec<&str> = if random.below(3) == 0 { own } else { text }.lines().collect();
    match random.below(4) {
        0 => lines.truncate(random.below(lines.len())),
        1 => lines.insert(random.below(lines.len()), line),
        2 => lines.push(line),
        _ => (),
    }
    lines.join("\n") + "\n"
}

/// All that is the model's of a scene: when it draws what, where it goes, what it costs.
fn models_own(text: &str) -> String {
    let script = Script::parse(text).unwrap();
    let (mut own, mut before) = (format!("{:?}\n", script.live()), None);
    for view in script.views() {
        own += &format!("{:?} {:?}\n", view.name(), view.conditions());
    }
    for step in 0..12 {
        let now = Stamp { step, time_s: 30.0 * step as f64, date: None };
        for shot in script.scheduled(&now, before.as_ref()).flat_map(|view| view.shots(&now)) {
            let Scene { output, width, height, tolerance, samples, antialias, time_budget_ms, precision, .. } =
                &shot.scene;
            let Scene { method, ranks, backend, device, scenery, .. } = &shot.scene;
            own += &format!(
                "{step} {:?} {:?} {output:?} {width} {height} {tolerance} {samples} {antialias} {time_budget_ms:?} \
                 {precision:?} {method:?} {ranks:?} {backend:?} {device:?} {:?} {:?}\n",
                shot.name,
                output.names(&now, "f").unwrap(),
                scenery.derived,
                scenery.heights
            );
        }
        before = Some(now);
    }
    own
}

#[test]
fn random_requests_change_nothing_of_the_models() {
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
                    let text = hub.look(|session| text_like(&mut random, session.text(), own));
                    hub.change(|session| session.load(&text))
                }
                _ => {
                    let changes: Vec<Json> = (0..1 + random.below(3)).map(|_| change_of(&mut random)).collect();
                    let view = *one(&mut random, &["a", "b", "c", ""]);
                    let mut request = json!({ "changes": changes, "is_moving": random.below(3) == 0 });
                    if random.below(5) == 0 {
                        request["view"] = json!(view);
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
