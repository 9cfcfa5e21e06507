//! `icoray watch`: files that are written step by step, cut off, replaced, renamed and shared out while it runs.

mod live;
pub mod model;

use crate::made::{Made, RECORDS, Values, value};
use crate::made_icon::Angles;
use crate::run::{Folder, has, icoray, pictures, scene, shows_something};
use icoray_test_support::PATIENCE;
use model::{append, mark, records};
use netcdf::Options;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

/// Looks that follow fast, as the tests write fast.
const FAST: [&str; 2] = ["--poll", "0.02"];
const SETTLE: [&str; 2] = ["--settle", "0.2"];
const ONCE: &str = "watch run --scene scene.toml --once --poll 0.02 --settle 0.2";
const NAMED_BY_STEP: &str = "[output]\nfile = \"{step}.png\"\n";
const NAMED_BY_DATE: &str = "[output]\nfile = \"$Y-$M-$D.png\"\n";

/// A folder with `scene.toml`, the watched folder `run` and `finished.nc`.
fn folder(made: &Made, scene: &str) -> Folder {
    let folder = Folder::new();
    fs::create_dir(folder.at("run")).unwrap();
    folder.write("scene.toml", scene);
    made.write_to(&folder.at("finished.nc"), Options::_64BIT_OFFSET);
    folder
}

/// The pictures that `icoray render` draws of all times of a file, in the order of their names.
fn rendered(folder: &Folder, file: &str) -> Vec<Vec<u8>> {
    let to = format!("rendered_{file}").replace('.', "_");
    folder.prints(&format!("render {file} --scene scene.toml --time all -o {to}"));
    contents(&folder.at(to))
}

/// The contents of the pictures of a folder, in the order of their names.
fn contents(folder: &Path) -> Vec<Vec<u8>> {
    pictures(folder).iter().map(|name| fs::read(folder.join(name)).unwrap()).collect()
}

/// Checks that the watch has drawn the pictures of the finished file.
#[track_caller]
fn expect_all(folder: &Folder) {
    assert!(contents(&folder.at("out")) == rendered(folder, "finished.nc"), "not the pictures of the finished file");
}

/// A watch that runs, ended when it is dropped.
struct Watcher {
    child: Child,
    out: PathBuf,
    log: PathBuf,
    errors: PathBuf,
}

impl Watcher {
    fn start(folder: &Folder, more: &[&str]) -> Self {
        let [out, log, errors] = ["out", "log", "errors"].map(|name| folder.at(name));
        let mut command = icoray(folder.path());
        command.args(["watch", "run", "--scene", "scene.toml", "-o", "out"]).args(FAST).args(more);
        if !more.contains(&"--settle") {
            command.args(SETTLE);
        }
        // The command does this by itself.
        command.env_remove("HDF5_USE_FILE_LOCKING");
        let [to_log, to_errors] = [&log, &errors].map(|path| Stdio::from(fs::File::create(path).unwrap()));
        let child = command.stdout(to_log).stderr(to_errors).spawn().unwrap();
        let watcher = Watcher { child, out, log, errors };
        watcher.wait("the first look", || watcher.text().starts_with("watch "));
        watcher
    }

    fn text(&self) -> String {
        fs::read_to_string(&self.log).unwrap()
    }

    #[track_caller]
    fn wait(&self, what: &str, holds: impl Fn() -> bool) {
        let start = Instant::now();
        while !holds() {
            assert!(start.elapsed() < PATIENCE, "{what} did not come:\n{}", self.text());
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    #[track_caller]
    fn wait_for(&self, picture: &str) {
        self.wait(picture, || self.has(picture));
    }

    fn has(&self, picture: &str) -> bool {
        self.out.join(picture).exists()
    }

    fn drawn(&self) -> usize {
        self.text().lines().filter(|line| line.starts_with("picture ")).count()
    }

    /// Waits for as many pictures and checks that there are no more.
    #[track_caller]
    fn expect_drawn(&self, count: usize) {
        self.wait("a picture", || self.drawn() >= count);
        assert_eq!(self.drawn(), count, "{}", self.text());
    }

    /// Waits until the watch ends by itself, and returns what it printed.
    fn end(mut self) -> String {
        assert!(self.child.wait().unwrap().success(), "{}", self.text());
        self.expect_no_errors();
        self.text()
    }

    fn stop(mut self) {
        self.child.kill().unwrap();
        self.expect_no_errors();
    }

    fn expect_no_errors(&self) {
        assert_eq!(fs::read_to_string(&self.errors).unwrap(), "");
    }
}

impl Drop for Watcher {
    fn drop(&mut self) {
        // A watch that has ended cannot be killed.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What a watch prints that ends when all files have settled.
fn once(folder: &Folder, more: &str) -> String {
    folder.prints(&format!("{ONCE} -o out {more}"))
}

#[test]
fn each_time_is_drawn_once_and_whole_as_a_file_grows() {
    let made = Made::history();
    let folder = folder(&made, &(scene("theta", 0.0, 2042.0) + NAMED_BY_DATE));
    let finished = folder.bytes("finished.nc");
    records(&made, 0..2).write_to(&folder.at("two.nc"), Options::_64BIT_OFFSET);
    let record = finished.len() - fs::metadata(folder.at("two.nc")).unwrap().len() as usize;
    let header = finished.len() - RECORDS * record;
    // The first bytes of the file, which says that it has so many records.
    let write = |records: u32, bytes: usize| {
        let mut head = finished[..bytes].to_vec();
        head[4..8].copy_from_slice(&records.to_be_bytes());
        // It only grows: a file that is cut off meanwhile would be another one.
        let file = fs::OpenOptions::new().create(true).truncate(false).write(true).open(folder.at("run/history.nc"));
        file.unwrap().write_all(&head).unwrap();
    };
    let watcher = Watcher::start(&folder, &[]);
    write(0, header);
    // A part of theta, which follows the date.
    let part = 64 + 400;
    write(1, header + part);
    mark(&folder, 1);
    watcher.wait_for("2014-01-01.png");
    assert!(!watcher.has("2013-10-25.png"), "half a record was drawn");
    write(1, header + record);
    watcher.wait_for("2013-10-25.png");
    // The header may count a record before it is there, and all of them while a copy is going on.
    write(3, header + record + part);
    mark(&folder, 2);
    watcher.wait_for("2014-01-02.png");
    assert!(!watcher.has("2013-10-26.png"), "half a record was drawn");
    write(3, header + 2 * record);
    watcher.wait_for("2013-10-26.png");
    write(3, finished.len());
    watcher.wait_for("2013-10-27.png");
    watcher.expect_drawn(5);
    let text = watcher.text();
    watcher.stop();
    assert!(!text.contains("skipped") && !text.contains("not drawn"), "{text}");
    let drawn = contents(&folder.at("out"));
    assert!(drawn[..3] == rendered(&folder, "finished.nc")[..], "not the pictures of the finished file");
    shows_something(&folder.at("out/2013-10-25.png"), 96, 96);
}

#[test]
fn a_record_that_a_later_one_follows_need_not_settle() {
    let made = Made::history();
    let folder = folder(&made, &(scene("theta", 0.0, 2042.0) + NAMED_BY_STEP));
    let run = folder.at("run/history.nc");
    records(&made, 0..1).write_to(&run, Options::_64BIT_OFFSET);
    let watcher = Watcher::start(&folder, &["--settle", "1"]);
    watcher.wait_for("0.png");
    made.write_to(&folder.at(".all.nc"), Options::_64BIT_OFFSET);
    let all = folder.bytes(".all.nc");
    // The file never settles: it is written over and over, unless this process is delayed.
    let (start, mut last, mut longest) = (Instant::now(), Instant::now(), Duration::ZERO);
    while !watcher.has("1.png") {
        assert!(start.elapsed() < PATIENCE, "{}", watcher.text());
        let mut file = fs::OpenOptions::new().write(true).open(&run).unwrap();
        file.write_all(&all).unwrap();
        longest = longest.max(last.elapsed());
        last = Instant::now();
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(longest.as_millis() > 500 || !watcher.has("2.png"), "the last record may not be whole");
    watcher.wait_for("2.png");
    watcher.expect_drawn(3);
    watcher.stop();
    expect_all(&folder);
}

#[test]
fn a_model_that_holds_its_netcdf_4_file_open_is_not_disturbed() {
    let made = Made::history();
    let folder = folder(&made, &(scene("theta", 0.0, 2042.0) + NAMED_BY_STEP));
    let run = folder.at("run/history.nc");
    let watcher = Watcher::start(&folder, &[]);
    let mut file = made.declare(&run, Options::NETCDF4);
    made.put_fixed(&mut file);
    for record in 0..RECORDS {
        made.put_record(&mut file, record);
        file.sync().unwrap();
        watcher.wait_for(&format!("{record}.png"));
        if record == 0 {
            // A restart, while the watch goes on.
            file.close().unwrap();
            file = append(&run);
        }
    }
    file.close().unwrap();
    watcher.expect_drawn(RECORDS);
    watcher.stop();
    expect_all(&folder);
}

#[test]
fn bad_files_are_named_once_and_a_watch_that_is_started_again_goes_on() {
    let made = Made::history();
    let folder = folder(&made, &(scene("theta", 0.0, 2042.0) + NAMED_BY_STEP));
    folder.write("run/a_bad.nc", "no file of a model");
    folder.write("run/notes.txt", "no file that is looked at");
    records(&made, 0..2).write_to(&folder.at("run/history.nc"), Options::_64BIT_OFFSET);
    let text = Watcher::start(&folder, &["--until-idle", "1"]).end();
    assert_eq!(text.matches("skipped   run/a_bad.nc: ").count(), 1, "{text}");
    assert_eq!(text.matches("picture ").count(), 2, "{text}");
    fs::copy(folder.at("finished.nc"), folder.at("run/history.nc")).unwrap();
    fs::remove_file(folder.at("out/0.png")).unwrap();
    let text = once(&folder, "");
    has(&text, &["kept      1 times have their pictures already", "picture   out/0.png", "picture   out/2.png"]);
    assert_eq!(text.matches("picture ").count(), 2, "{text}");
    expect_all(&folder);
    assert_eq!(once(&folder, "--redraw").matches("picture ").count(), 3);
}

#[test]
fn times_of_a_replaced_file_are_drawn_again_and_those_of_a_renamed_one_are_not() {
    let made = Made::history();
    let folder = folder(&made, &(scene("theta", 0.0, 2042.0) + NAMED_BY_DATE));
    let run = |name: &str| folder.at("run").join(name);
    fs::copy(folder.at("finished.nc"), run("history.nc")).unwrap();
    let watcher = Watcher::start(&folder, &[]);
    watcher.wait_for("2013-10-27.png");
    fs::rename(run("history.nc"), run("history.old.nc")).unwrap();
    mark(&folder, 1);
    watcher.wait_for("2014-01-01.png");
    watcher.expect_drawn(4);
    let mut other = made.clone();
    other.f32s("theta").iter_mut().for_each(|value| *value = 2000.0 - *value);
    other.write_to(&folder.at("other.nc"), Options::_64BIT_OFFSET);
    fs::copy(folder.at("other.nc"), folder.at(".other.nc")).unwrap();
    fs::rename(folder.at(".other.nc"), run("history.old.nc")).unwrap();
    let expected = rendered(&folder, "other.nc");
    watcher.wait("the new pictures", || contents(&folder.at("out"))[..3] == expected[..]);
    watcher.expect_drawn(7);
}

#[test]
fn fields_of_several_files_are_joined_by_their_dates() {
    let surface = "[[surfaces]]\nlayer = \"bottom\"\nfield = \"surface_pressure\"\n\
                   transfer = { map = \"davos\", range = [0, 2042] }\n";
    let made = Made::history();
    let folder = folder(&made, &(scene("theta", 0.0, 2042.0) + surface + NAMED_BY_DATE));
    let without = |name: &str, range| {
        let mut made = records(&made, range);
        made.variables.retain(|variable| variable.name != name);
        made
    };
    without("surface_pressure", 0..3).write_to(&folder.at("run/history.nc"), Options::_64BIT_OFFSET);
    let text = once(&folder, "");
    let waits = "2013-10-25_00:00:00: surface_pressure is in none of the files that have it: run/history.nc";
    has(&text, &[&format!("waits     {waits}")]);
    assert!(!folder.at("out/2013-10-25.png").exists());
    // The other stream has fewer times, no mesh, and is of another format.
    let mut other = without("theta", 1..3);
    other.variables.retain(|v| v.name != "zgrid" && !v.name.ends_with("Cell") && !v.name.ends_with("Vertex"));
    other.write_to(&folder.at("run/surface.nc"), Options::NETCDF4);
    let text = once(&folder, "");
    assert_eq!(text.matches("picture ").count(), 2, "{text}");
    assert!(contents(&folder.at("out")) == rendered(&folder, "finished.nc")[1..]);
}

/// ICON writes fields of one kind into one file and those of another into another, without tables of the mesh.
#[test]
fn fields_of_icons_files_are_joined() {
    let surface = "[[surfaces]]\nlayer = \"bottom\"\nfield = \"ts\"\n\
                   transfer = { map = \"davos\", range = [0, 2080] }\n";
    let mut made = Made::icon_data(Angles::Radians);
    let triangles = made.dimension("ncells");
    let ts = (0..RECORDS * triangles).map(|i| value(i / triangles, i % triangles, 0) as f32).collect();
    made.add("ts", &["time", "ncells"], Values::F32(ts));
    let folder = folder(&made, &(scene("ta", 0.0, 2080.0) + surface + "[output]\nfile = \"$D_$h.png\"\n"));
    for (name, lacks) in [("atm_2d", &["ta", "lev", "clon_bnds", "clat_bnds"][..]), ("atm_3d", &["ts"])] {
        let mut one = made.clone();
        one.variables.retain(|variable| !lacks.contains(&variable.name));
        one.variable("clon").attributes.retain(|(name, _)| *name != "bounds");
        one.write_to(&folder.at(format!("run/{name}.nc")), Options::NETCDF4);
    }
    let text = once(&folder, "");
    assert_eq!(text.matches("picture ").count(), RECORDS, "{text}");
    expect_all(&folder);
}

#[test]
fn a_record_of_nothing_but_fill_is_not_written_yet() {
    let mut made = Made::history();
    let each = made.f32s("theta").len() / RECORDS;
    made.f32s("theta")[each..2 * each].fill(9.969_21e36);
    let folder = folder(&made, &(scene("theta", 0.0, 2042.0) + NAMED_BY_STEP));
    fs::copy(folder.at("finished.nc"), folder.at("run/history.nc")).unwrap();
    let text = once(&folder, "");
    has(&text, &["picture   out/2.png", "not drawn 2013-10-26_00:00:00: theta has no values yet"]);
    assert_eq!(text.matches("picture ").count(), 2, "{text}");
}

#[test]
fn the_mesh_may_be_in_a_file_of_its_own() {
    let made = Made::history();
    let folder = folder(&made, &scene("theta", 0.0, 2042.0));
    Made::mesh(true).write_to(&folder.at("mesh.nc"), Options::_64BIT_OFFSET);
    for day in 0..RECORDS {
        let mut one = records(&made, day..day + 1);
        one.variables.retain(|v| !v.name.ends_with("Cell") && !v.name.ends_with("Vertex"));
        one.write_to(&folder.at(format!("run/history.{day}.nc")), Options::_64BIT_OFFSET);
    }
    let text = once(&folder, "");
    has(&text, &["skipped   ", "history.0.nc: variable lonCell is missing"]);
    let text = once(&folder, "--mesh mesh.nc --files history.*.nc");
    // Steps are those of the files, so that dates name the pictures.
    has(&text, &["theta_2013-10-25_00.00.00_000000.png", "theta_2013-10-27_00.00.00_000000.png"]);
    assert_eq!(text.matches("picture ").count(), 3, "{text}");
}

#[test]
fn errors_of_all_files_end_the_watch() {
    let made = Made::history();
    let named = scene("theta", 0.0, 2042.0) + NAMED_BY_STEP;
    let folder = folder(&made, &named);
    let refused = |scene: &str, more: &str, parts: &[&str]| {
        folder.write("scene.toml", scene);
        folder.fails(&format!("{ONCE} {more}"), 1, parts);
    };
    refused(&named.replace("lon =", "long ="), "", &["scene.toml", "long"]);
    refused(&named, "-o one.png", &["-o one.png: expected a directory"]);
    refused(&named.replace("field = \"theta\"", ""), "", &["expected a field in the scene"]);
    for day in 0..2 {
        let one = records(&made, day..day + 1);
        one.write_to(&folder.at(format!("run/history.{day}.nc")), Options::_64BIT_OFFSET);
    }
    let both = "output.file names the pictures of 2013-10-25_00:00:00 and of 2013-10-26_00:00:00 both";
    refused(&named, "-o out", &[both, "0.png", "expected a date in it"]);
    folder.write("scene.toml", named.replace("\"theta\"", "\"thita\""));
    has(&once(&folder, ""), &["waits     thita is in none of the files of run so far"]);
    folder.fails("watch nowhere --scene scene.toml --once", 1, &["nowhere: cannot read"]);
}
