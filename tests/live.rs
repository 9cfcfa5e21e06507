//! A running model that is watched: what viewers see, set and ask, on one process and over ranks.

use icoray_test_support::{PATIENCE, Random, count};
use icoray_tests::native::{command, compile_c, mpi_library, text};
use icoray_tests::ranks::FIRST;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::thread;
use std::time::Instant;
use tempfile::TempDir;

const SCENE: &str = "# A scene.\nfield = \"f\"\nexaggeration = 40\nimage = { width = 40, height = 30 }\n\
    camera = { lon = 20, lat = 35, distance = 3.2, fov = 45 } # from here\n\
    [transfer]\nmap = \"viridis\"\nrange = [-1.5, 1.5]\nopacity = [[-1.5, 0.8], [0, 0.1], [1.5, 0.9]]\n\
    [output]\nfile = \"frame_{step}.png\"\n";
/// A page whose viewers' pictures may take any time: other programs take theirs too.
const LIVE: &str = "[live]\ntime_budget_ms = 1e9\n";

/// A program that draws a step when it is told to.
struct Model {
    child: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
    log: Option<thread::JoinHandle<String>>,
    step: u32,
}

/// An answer of the page's server.
struct Answer {
    status: u16,
    body: Vec<u8>,
}

/// What a viewer has: the address of a model's page.
#[derive(Clone)]
struct Viewer {
    host: String,
    token: String,
}

impl Model {
    fn start(run: &mut Command) -> Self {
        let mut child = run.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let output = BufReader::new(child.stdout.take().unwrap());
        let mut errors = child.stderr.take().unwrap();
        let log = thread::spawn(move || {
            let mut log = String::new();
            errors.read_to_string(&mut log).unwrap();
            log
        });
        Model { input: child.stdin.take(), output, log: Some(log), child, step: 0 }
    }

    /// Draws the next step and returns its number.
    fn draw(&mut self) -> u32 {
        self.input.as_mut().unwrap().write_all(b"\n").unwrap();
        let mut line = String::new();
        self.output.read_line(&mut line).unwrap();
        if line.trim() != format!("step {}", self.step) {
            panic!("{line}\n{}", self.log());
        }
        self.step += 1;
        self.step - 1
    }

    /// Draws steps until a question is answered.
    fn draw_until<T>(&mut self, question: thread::JoinHandle<T>) -> T {
        while !question.is_finished() {
            assert!(self.step < 2000, "nobody answers");
            self.draw();
        }
        question.join().unwrap()
    }

    /// Ends its input and returns its log.
    fn log(&mut self) -> String {
        drop(self.input.take());
        self.log.take().map(|log| log.join().unwrap()).unwrap_or_default()
    }

    /// Ends it; returns its log.
    fn end(mut self) -> String {
        let log = self.log();
        let mut rest = String::new();
        self.output.read_to_string(&mut rest).unwrap();
        assert!(self.child.wait().unwrap().success() && rest.contains(", 0 failed"), "{rest}\n{log}");
        log
    }
}

impl Viewer {
    fn of(directory: &Path) -> Self {
        let file = directory.join("live.url");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600, "others may not read the token");
        let address = fs::read_to_string(file).unwrap();
        let (host, token) = address.trim().strip_prefix("http://").unwrap().split_once("/#").unwrap();
        Viewer { host: host.to_owned(), token: token.to_owned() }
    }

    fn ask(&self, request: &str, body: &str) -> Answer {
        let Viewer { host, token } = self;
        let mut stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let length = body.len();
        write!(
            stream,
            "{request} HTTP/1.1\r\nHost: {host}\r\nAuthorization: Bearer {token}\r\nContent-Length: {length}\r\n\
             Connection: close\r\n\r\n{body}"
        )
        .unwrap();
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).unwrap();
        let split = bytes.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
        let head = text(&bytes[..split]);
        Answer { status: head.split(' ').nth(1).unwrap().parse().unwrap(), body: bytes[split + 4..].to_vec() }
    }

    fn get(&self, path: &str) -> Answer {
        self.ask(&format!("GET {path}"), "")
    }

    /// A question, which the model answers when it draws.
    fn asks(&self, path: &'static str) -> thread::JoinHandle<Answer> {
        let viewer = self.clone();
        thread::spawn(move || viewer.get(path))
    }

    fn set(&self, changes: &str) -> Answer {
        self.ask("POST /api/change", &format!("{{\"changes\":[{changes}]}}"))
    }

    /// Facts and pixels of the next picture after one.
    fn picture(&self, after: u64) -> (Value, Vec<u8>) {
        let answer = self.get(&format!("/api/frame?after={after}"));
        assert_eq!(answer.status, 200);
        let (length, rest) = answer.body.split_first_chunk().unwrap();
        let (facts, png) = rest.split_at(u32::from_le_bytes(*length) as usize);
        let pixels = if png.is_empty() { Vec::new() } else { pixels(png) };
        (serde_json::from_slice(facts).unwrap(), pixels)
    }
}

impl Answer {
    fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|e| panic!("{e}: {}", text(&self.body)))
    }
}

fn pixels(png: &[u8]) -> Vec<u8> {
    image::load_from_memory(png).unwrap().into_rgba8().into_raw()
}

fn drawn(directory: &Path, step: u32) -> Vec<u8> {
    pixels(&fs::read(directory.join(format!("frame_{step}.png"))).unwrap())
}

/// Writes a scene and gives the path.
fn written(directory: &Path, name: &str, scene: &str) -> PathBuf {
    let path = directory.join(name);
    fs::write(&path, scene).unwrap();
    path
}

/// A model, run by `run` with a directory and a scene, is watched, steered and asked.
fn watch(run: impl Fn(&Path, &Path) -> Command) {
    let Watched { folder, to, mut model, viewer } = Watched::run(&format!("{SCENE}{LIVE}"), &run);
    let folder = folder.path();
    let described = viewer.get("/api/describe").json();
    assert_eq!((&described["live"], &described["fields"][0]["units"]), (&Value::from(true), &Value::from("K")));

    // Who watches sees the picture that is written, and at which step.
    let (facts, shown) = viewer.picture(0);
    assert_eq!((&facts["step"], &facts["revision"]), (&Value::from(0), &Value::from(1)));
    assert!(shown == drawn(&to, 0) && !to.join("live.toml").exists());

    // What is set holds from the next picture, on all ranks.
    let answer = viewer.set(r#"{"path":["camera","lon"],"value":-70},{"path":["transfer","map"],"value":"plasma"}"#);
    let revision = answer.json()["revision"].as_u64().unwrap();
    assert_eq!(viewer.get("/api/scene").json()["revision"].as_u64(), Some(revision));
    let step = model.draw();
    let (facts, shown) = viewer.picture(facts["number"].as_u64().unwrap());
    assert_eq!((facts["step"].as_u64(), facts["revision"].as_u64()), (Some(1), Some(revision)));
    assert!(shown == drawn(&to, step) && shown != drawn(&to, 0));
    let kept = fs::read_to_string(to.join("live.toml")).unwrap();
    assert!(kept.contains("# A scene.") && kept.contains("lon = -70") && kept.contains("# from here"), "{kept}");

    // What is the model's is not a viewer's, nor what it cannot draw.
    let deep = format!(r#"{{"path":[{}],"value":1}}"#, [r#""a""#; 3000].join(","));
    for (change, wanted) in [
        (deep.as_str(), "a key 3000 steps from the top, expected at most 16"),
        (r#"{"path":["output","cinema"],"value":"/tmp/viewer.cdb"}"#, "output.cinema is the model's"),
        (r#"{"path":["every"],"value":1000000000}"#, "every is the model's"),
        (r#"{"path":["samples"],"value":64}"#, "samples is the model's"),
        (r#"{"path":["output","file"],"value":"../b.png"}"#, "output"),
        (r#"{"path":["output","file"],"value":"b_{step}.png"}"#, "the model's, which a viewer cannot change"),
        (r#"{"path":["image","width"],"value":9000}"#, "the model's, which a viewer cannot change"),
        (r#"{"path":["field"],"value":"zzz"}"#, "field \"zzz\", expected one of f"),
    ] {
        let answer = viewer.set(change);
        let error = answer.json()["error"].as_str().unwrap_or_default().to_owned();
        assert!(answer.status == 400 && error.contains(wanted), "{error}");
    }
    assert_eq!(viewer.set(r#"{"path":["surfaces"],"value":[{"layer":77,"color":"red"}]}"#).status, 200);
    let before = drawn(&to, 1);
    let step = model.draw();
    assert!(drawn(&to, step) == before, "the scene before holds");
    let (facts, _) = viewer.picture(facts["number"].as_u64().unwrap());
    assert!(facts["refused"].as_str().is_some_and(|why| why.contains("77")), "{facts}");
    assert!(!viewer.get("/api/scene").json()["text"].as_str().unwrap().contains("77"));

    // Questions are answered when the model draws.
    let histogram = model.draw_until(viewer.asks("/api/histogram?field=f")).json();
    let known = histogram["counts"].as_array().unwrap().iter().map(|count| count.as_u64().unwrap()).sum::<u64>();
    assert_eq!(known, 642 * 4, "each value once, on however many ranks");
    let unknown = model.draw_until(viewer.asks("/api/histogram?field=zzz"));
    assert!(unknown.status == 422 && text(&unknown.body).contains("zzz"), "{}", text(&unknown.body));
    let probe = model.draw_until(viewer.asks("/api/probe?x=0.5&y=0.5")).json();
    assert!(probe["value"].is_f64() && probe["step"].as_u64() < Some(model.step.into()), "{probe}");
    let [lon, lat] = ["lon", "lat"].map(|key| probe[key].as_f64().unwrap());
    assert!((lon + 70.0).abs() < 1e-6 && (lat - 35.0).abs() < 1e-6, "what the camera looks down on: {probe}");
    let exr = viewer.get("/api/picture?format=exr");
    assert!(exr.status == 200 && exr.body.starts_with(&[0x76, 0x2f, 0x31, 0x01]));

    let last = model.draw();
    let log = model.end();
    assert!(log.contains("live view at http://127.0.0.1:") && !log.contains(&viewer.token), "{log}");
    assert!(log.contains("step 1: a viewer has set camera.lon, transfer.map"), "{log}");
    assert!(!to.join("live.url").exists());

    // The scene that was kept draws the same without anybody who watches; one that nobody watches does as without [live].
    for (name, scene, step) in [("kept", kept.replace(LIVE, ""), last), ("plain", SCENE.to_owned(), 0)] {
        let scene = written(folder, &format!("{name}.toml"), &scene);
        let alone = folder.join(name);
        let mut model = Model::start(&mut run(&alone, &scene));
        while model.draw() < step {}
        assert!(!alone.join("live.url").exists());
        model.end();
        assert!(drawn(&alone, step) == drawn(&to, step), "{name}");
    }
}

#[test]
fn a_model_alone_is_watched_and_steered() {
    let program = compile_c(&["live", "host_common", "check"]);
    for way in ["", "async"] {
        let run = |to: &Path, scene: &Path| {
            let mut run = command(&program, to.parent().unwrap());
            run.arg(to).arg(scene).arg(way);
            run
        };
        watch(run);
    }
}

#[test]
fn a_model_over_ranks_is_watched_and_steered() {
    if !FIRST.is_there() {
        return;
    }
    let program = FIRST.compile(mpi_library(), "mpi_live");
    for (ranks, way) in [(1, ""), (3, ""), (3, "async"), (3, "parts"), (1, "parts")] {
        let run = |to: &Path, scene: &Path| {
            let mut run = FIRST.on_ranks(ranks, &program, to.parent().unwrap());
            run.arg(to).arg(scene).arg(way);
            run
        };
        watch(run);
    }
    let run = |to: &Path, scene: &Path| {
        let mut run = FIRST.on_ranks(3, &program, to.parent().unwrap());
        run.arg(to).arg(scene).arg("wants");
        run
    };
    // The other ranks hear of another field in the call after which it is wanted.
    choose_fields(run, 1);
}

/// Viewers of a model that computes the fields that are wanted choose another one and go back; either is drawn `late`
/// steps later, from values of its own step.
fn choose_fields(run: impl Fn(&Path, &Path) -> Command, late: u32) {
    let Watched { folder, to, mut model, viewer } = Watched::run(&format!("{SCENE}{LIVE}"), &run);
    let folder = folder.path();
    let mut shown = [0; 2];
    let draw = |model: &mut Model, wait: u32| {
        for _ in 0..wait {
            let step = model.draw();
            assert!(viewer.get("/api/scene").json()["revision"] != viewer.picture(step.into()).0["revision"]);
        }
        model.draw()
    };
    // All fields are known once they were set.
    assert_eq!(viewer.set(r#"{"path":["field"],"value":"g"}"#).status, 200);
    shown[0] = draw(&mut model, late);
    // While both are drawn, the camera turns at once.
    viewer.set(r#"{"path":["camera","lon"],"value":50}"#);
    let turned = draw(&mut model, 0);
    viewer.ask("POST /api/undo", "");
    viewer.ask("POST /api/undo", "");
    shown[1] = draw(&mut model, late);
    model.end();
    for (name, scene, step) in [
        ("g", SCENE.replace("\"f\"", "\"g\""), shown[0]),
        ("turned", SCENE.replace("\"f\"", "\"g\"").replace("lon = 20", "lon = 50"), turned),
        ("f", SCENE.to_owned(), shown[1]),
    ] {
        let scene = written(folder, &format!("{name}.toml"), &scene);
        let alone = folder.join(name);
        let mut model = Model::start(&mut run(&alone, &scene));
        while model.draw() < step {}
        model.end();
        assert!(drawn(&alone, step) == drawn(&to, step), "{name}");
    }
}

#[test]
fn fields_that_viewers_choose_are_wanted_before_they_are_drawn() {
    let program = compile_c(&["live", "host_common", "check"]);
    let run = |to: &Path, scene: &Path| {
        let mut run = command(&program, to.parent().unwrap());
        run.arg(to).arg(scene).arg("wants");
        run
    };
    choose_fields(run, 0);
}

/// Isosurfaces as a viewer sets them, so many of them.
fn isosurfaces(count: u32) -> String {
    let all = (0..count).map(|k| format!(r#"{{"value":{},"color":"red","opacity":0.2}}"#, 0.1 * f64::from(k)));
    format!(r#"{{"path":["isosurfaces"],"value":[{}]}}"#, all.collect::<Vec<_>>().join(","))
}

/// A lone model that is watched, once it has drawn its first step.
struct Watched {
    folder: TempDir,
    /// Where it draws.
    to: PathBuf,
    model: Model,
    viewer: Viewer,
}

impl Watched {
    /// A model of a scene that `run` starts, with a directory and the scene's file.
    fn run(scene: &str, run: impl Fn(&Path, &Path) -> Command) -> Self {
        let folder = TempDir::new().unwrap();
        let scene = written(folder.path(), "scene.toml", scene);
        let to = folder.path().join("watched");
        let mut model = Model::start(&mut run(&to, &scene));
        model.draw();
        Watched { viewer: Viewer::of(&to), folder, to, model }
    }

    /// A model of a way of `live.c`.
    fn start(way: &str, scene: &str) -> Self {
        let program = compile_c(&["live", "host_common", "check"]);
        Self::run(scene, |to, scene| {
            let mut command = command(&program, to.parent().unwrap());
            command.arg(to).arg(scene).arg(way);
            command
        })
    }
}

/// A picture of eight isosurfaces among 1.3 million values takes more than a millisecond, however few pixels it has.
#[test]
fn what_takes_too_long_gets_coarser_and_ends() {
    let Watched { folder: _kept, to, mut model, viewer } =
        Watched::start("large", &format!("{SCENE}[live]\ntime_budget_ms = 1\n"));
    assert_eq!(viewer.set(&isosurfaces(8)).status, 200);
    model.draw();
    let (facts, shown) = viewer.picture(1);
    assert!(facts["quality"].as_str().is_some_and(|quality| quality.contains("one of 32 x 32 pixels")), "{facts}");
    assert!(shown == drawn(&to, 1) && shown != drawn(&to, 0));
    model.draw();
    let (facts, _) = viewer.picture(2);
    let why = facts["refused"].as_str().unwrap_or_default();
    assert!(why.contains("expected at most 1 ms; the model's own scene is drawn again"), "{facts}");
    assert!(drawn(&to, 2) == drawn(&to, 0), "the model's own scene is drawn, with all of its pixels");
    // Nothing else is drawn until the time is made up for.
    let answer = viewer.set(r#"{"path":["camera","lon"],"value":-70}"#);
    let revision = answer.json()["revision"].as_u64();
    model.draw();
    assert!(drawn(&to, 3) == drawn(&to, 0));
    let start = Instant::now();
    while viewer.picture(u64::from(model.step) - 1).0["revision"].as_u64() != revision {
        assert!(start.elapsed() < PATIENCE, "it is never made up for");
        model.draw();
    }
    let log = model.end();
    assert!(log.contains("step 1: the viewers' scene takes too long: a picture of the fewest pixels took"), "{log}");
}

/// Eight lit volumes and isosurfaces, where the model's own scene shows one without light.
#[test]
fn what_takes_too_much_memory_is_refused_with_the_bytes() {
    let Watched { folder: _kept, to, mut model, viewer } = Watched::start("large", &format!("{SCENE}{LIVE}"));
    let volumes = [r#"{"field":"f"}"#; 8].join(",");
    let changes = format!(
        r#"{{"path":["field"]}},{{"path":["transfer"]}},{{"path":["volumes"],"value":[{volumes}]}},{},
           {{"path":["light"],"value":{{"kind":"headlight"}}}}"#,
        isosurfaces(8)
    );
    let answer = viewer.set(&changes);
    assert_eq!(answer.status, 200, "{}", text(&answer.body));
    model.draw();
    let (facts, _) = viewer.picture(1);
    let why = facts["refused"].as_str().unwrap_or_default();
    assert!(why.contains("bytes of memory, expected at most") && why.contains("4 times"), "{facts}");
    assert!(drawn(&to, 1) == drawn(&to, 0));
    model.end();
}

/// Keys that random requests set, and values of which each key takes some.
const PATHS: &str = "field camera.lon camera.distance transfer.map transfer.range surfaces.0 surfaces.0.layer \
    clip.0.lat isosurfaces.0.value light.kind every output.file output.cinema output.concat image.width derive.0 live samples";
const VALUES: &str = r#"["f", "g", 3, -70, 1e9, "magma", [-1, 1], { "layer": 1, "color": "red" }, null, "headlight",
    "../x.png", "x.cdb", "x.ffconcat", { "name": "d", "magnitude": ["f", "g"] }, {}]"#;

/// Random requests to a model in the pattern of costly diagnostics: its fields stay (`live.c` looks), each step is
/// drawn, and nothing is written beside its pictures.
#[test]
fn random_requests_leave_a_model_as_it_is() {
    let own = format!("{SCENE}{LIVE}");
    let Watched { folder, to, mut model, viewer } = Watched::start("wants", &own);
    let (paths, values): (Vec<&str>, Vec<Value>) = (PATHS.split(' ').collect(), serde_json::from_str(VALUES).unwrap());
    let mut random = Random::new(0);
    let mut taken = 0;
    for _ in 0..count(150, 500) {
        let answer = match random.below(8) {
            0 => viewer.ask("POST /api/undo", ""),
            1 => viewer.ask("POST /api/redo", ""),
            2 => {
                let line = ["lines = [{}]\n", "every = 7\n", "", "when = \"max(f) > 9\"\n"][random.below(4)];
                viewer.ask("POST /api/load", &format!("{line}{own}"))
            }
            _ => {
                let steps = paths[random.below(paths.len())].split('.');
                let path: Vec<Value> = steps.map(|step| step.parse::<u64>().map_or(step.into(), Value::from)).collect();
                let value = &values[random.below(values.len())];
                viewer.set(&serde_json::json!({ "path": path, "value": value }).to_string())
            }
        };
        assert!([200, 400].contains(&answer.status), "{}", text(&answer.body));
        taken += u32::from(answer.status == 200);
        if random.below(3) == 0 {
            model.draw();
        }
    }
    assert!(taken > 20, "{taken}");
    assert_eq!(viewer.ask("POST /api/load", &own).status, 200);
    let last = model.draw();
    model.end();
    let names = |directory: &Path| {
        let all = fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        all.collect::<BTreeSet<_>>()
    };
    assert_eq!(names(folder.path()), ["scene.toml", "watched"].map(str::to_owned).into());
    let pictures = (0..=last).map(|step| format!("frame_{step}.png"));
    assert_eq!(names(&to), pictures.chain(["report.csv", "live.toml"].map(str::to_owned)).collect());
    let Watched { folder: _kept, to: alone, mut model, .. } = Watched::start("wants", &own);
    while model.draw() < last {}
    model.end();
    assert!(drawn(&alone, last) == drawn(&to, last));
}

#[test]
fn two_viewers_and_hostile_ones_leave_the_model_as_it_is() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let program = compile_c(&["live", "host_common", "check"]);
    let start = |to: &Path, scene: &str| {
        let scene = written(folder, "scene.toml", scene);
        Model::start(command(&program, folder).arg(to).arg(&scene))
    };
    let to = folder.join("watched");
    let mut model = start(&to, &format!("{SCENE}{LIVE}"));
    model.draw();
    let viewer = Viewer::of(&to);
    let stalled: Vec<TcpStream> = (0..20)
        .map(|_| {
            let mut stream = TcpStream::connect(&viewer.host).unwrap();
            stream.write_all(b"GET /api/frame?after=0 HTTP/1.1\r\nHost: ").unwrap();
            stream
        })
        .collect();
    for garbage in [&b"\0\xff\xfe\r\n\r\n"[..], b"GET / HTTP/9.9\r\n\r\n", b"POST /api/change HTTP/1.1\r\n\r\n{"] {
        let mut stream = TcpStream::connect(&viewer.host).unwrap();
        stream.write_all(garbage).unwrap();
    }
    let wrong = Viewer { token: "0".repeat(32), ..viewer.clone() };
    assert_eq!(wrong.set(r#"{"path":["camera","lon"],"value":1}"#).status, 401);
    for _ in 0..100 {
        drop(TcpStream::connect(&viewer.host).unwrap());
    }
    // Two viewers steer against each other: the last one holds.
    let steer = |side: f64| {
        let viewer = viewer.clone();
        thread::spawn(move || {
            for turn in 0..20 {
                let change = format!(r#"{{"path":["camera","lon"],"value":{}}}"#, side * f64::from(turn));
                assert_eq!(viewer.set(&change).status, 200);
            }
        })
    };
    let (left, right) = (steer(-1.0), steer(1.0));
    model.draw_until(left);
    model.draw_until(right);
    viewer.set(r#"{"path":["camera","lon"],"value":20}"#);
    let last = model.draw();
    drop(stalled);
    model.end();
    let alone = folder.join("alone");
    let mut model = start(&alone, SCENE);
    while model.draw() < last {}
    model.end();
    assert!(drawn(&alone, last) == drawn(&to, last) && drawn(&alone, 0) == drawn(&to, 0));
}
