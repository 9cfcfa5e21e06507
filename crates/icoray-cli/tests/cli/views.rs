//! Scene files of several pictures: schedules, lists of pictures, and animations.

use crate::files::folder;
use crate::made::Made;
use crate::run::{fails, has, icoray, pictures, prints, says, scene, shows_something};
use std::collections::HashSet;
use std::fs;
use std::path::Path;

/// Views of three fields over the scene of theta, each with its own turn; times are a day apart.
const VIEWS: &str = r#"
[output]
concat = "{view}.ffconcat"
[[views]]
name = "theta"
[[views]]
name = "w"
field = "w"
at_times = [86400]
image = { width = 48, height = 40 }
[[views]]
name = "late"
field = "rho"
when = ["max(theta) > 1500", "mean(rho) > 0"]
[views.camera]
path = [{ step = 0, lon = 0, lat = 0 }, { step = 2, lon = 90, lat = 10, distance = 4 }]
"#;

#[test]
fn views_of_a_series_are_drawn_when_it_is_their_turn() {
    let folder = folder(&Made::history(), &(scene("theta", 0.0, 2042.0) + VIEWS));
    let text = folder.render("--time all -o out --size 32x32");
    let at = folder.at("out");
    let expected = [
        "late_rho_000002.png",
        "theta_theta_000000.png",
        "theta_theta_000001.png",
        "theta_theta_000002.png",
        "w_w_000001.png",
    ];
    assert_eq!(pictures(&at), expected);
    assert_eq!(text.matches("picture ").count(), 5, "{text}");
    has(&text, &["picture   out/w_w_000001.png (32 x 32)\nfield     w at cells, 5 layers, time 1"]);
    says(&at.join("late_rho_000002.png"), &[("field", "rho"), ("view", "late"), ("time_s", "172800")]);
    let list = "ffconcat version 1.0\n\
                file 'theta_theta_000000.png'\nduration 0.04\n\
                file 'theta_theta_000001.png'\nduration 0.04\n\
                file 'theta_theta_000002.png'\nduration 0.04\n";
    assert_eq!(folder.text("out/theta.ffconcat"), list);
    assert_eq!(folder.text("out/late.ffconcat").matches("file ").count(), 1);
    assert_eq!(folder.text("out/report.csv").lines().count(), 6);
    // A part of the series draws what the whole does, and a time by itself all views.
    folder.render("--time 1.. -o part --size 32x32");
    let part = folder.at("part");
    assert_eq!(pictures(&part), [expected[0], expected[2], expected[3], expected[4]]);
    let bytes = |folder: &Path, name: &str| fs::read(folder.join(name)).unwrap();
    assert!([0, 2, 3, 4].iter().all(|i| bytes(&at, expected[*i]) == bytes(&part, expected[*i])));
    folder.render("--time 0 -o alone");
    let alone = ["late_rho_000000.png", "theta_theta_000000.png", "w_w_000000.png"];
    assert_eq!(pictures(&folder.at("alone")), alone);
    shows_something(&folder.at("alone/w_w_000000.png"), 48, 40);
    shows_something(&folder.at("alone/late_rho_000000.png"), 96, 96);
    // Each view by its own plan.
    let plan = folder.prints("plan made.nc --scene scene.toml");
    let views: Vec<&str> = plan.lines().filter(|line| line.starts_with("view ")).collect();
    assert_eq!(views, ["view theta:", "view w:", "view late:"]);
}

#[test]
fn a_scene_that_is_never_due_prints_a_note() {
    for trigger in ["when = \"max(theta) > 9e9\"\n", "every = 5\n", "at_times = [1e9]\n"] {
        let folder = folder(&Made::history(), &(trigger.to_owned() + &scene("theta", 0.0, 2042.0)));
        for times in ["1..", "2.."] {
            let text = folder.render(&format!("--time {times} -o out"));
            assert_eq!(text, "note      nothing is drawn: these times are no view's turn\n", "{trigger}");
        }
    }
}

#[test]
fn a_sweep_becomes_a_cinema_database() {
    let sweep = "[output]\nfile = \"image/{step}_{lon}_{field}.png\"\ncinema = \"q.cdb\"\n\
                 [sweep]\nfield = [\"theta\", \"w\"]\nlon = [0, 120.5]\n";
    let folder = folder(&Made::history(), &(scene("theta", 0.0, 2042.0) + sweep));
    let mut expected = "step,time,field,lon,FILE\n".to_owned();
    for (step, time) in [(0, "0.0"), (1, "86400.0")] {
        for field in ["theta", "w"] {
            for (lon, cell) in [("0", "0.0"), ("120.5", "120.5")] {
                expected += &format!("{step},{time},{field},{cell},image/{step}_{lon}_{field}.png\n");
            }
        }
    }
    for run in 0..2 {
        let text = folder.render("--time 0..2 -o out --size 24x24");
        assert_eq!(text.matches("picture ").count(), 8, "{text}");
        assert_eq!(folder.text("out/q.cdb/data.csv"), expected, "run {run}");
    }
    let images = folder.at("out/q.cdb/image");
    assert_eq!(pictures(&images).len(), 8);
    let distinct: HashSet<Vec<u8>> =
        pictures(&images).iter().map(|name| image::open(images.join(name)).unwrap().into_bytes()).collect();
    assert_eq!(distinct.len(), 8, "no two pictures are the same");
    // What is there is not modified where that is asked for, the database's pictures too.
    let parts = ["q.cdb/image/0_0_theta.png", "is there already"];
    folder.render_fails("--time 0 -o out --existing never-modify", 1, &parts);
    // A database of other parameters is not added to, which is known before the first ray.
    folder.write("out/q.cdb/data.csv", "step,FILE\n");
    let parts = ["q.cdb/data.csv: its first line is not \"step,time,field,lon,FILE\""];
    folder.render_fails("-o out", 1, &parts);
}

/// Two volumes of two fields, and a view of one that is made of them; nothing else of the file is read.
#[test]
fn a_scene_of_several_fields_reads_these() {
    let volume = |field: &str, map: &str| {
        let transfer = format!("map = \"{map}\"\nrange = [0, 42]\nopacity = [[0, 0.0], [42, 0.8]]\n");
        format!("[[views.volumes]]\nfield = \"{field}\"\n[views.volumes.transfer]\n{transfer}")
    };
    let rest = format!(
        "[[derive]]\nname = \"both\"\nmagnitude = [\"theta\", \"rho\"]\n[[views]]\nname = \"one\"\n\
         [[views]]\nname = \"made\"\nfield = \"both\"\n[[views]]\nname = \"two\"\n{}{}",
        volume("theta", "viridis"),
        volume("rho", "magma")
    );
    let folder = folder(&Made::history(), &(scene("theta", 0.0, 42.0) + &rest));
    let text = folder.render("--time 0 -o out --size 48x48");
    let fields = |view: &str| {
        let block = text.split("picture ").find(|block| block.contains(&format!("view      {view}\n")));
        let line = block.unwrap().lines().find_map(|line| line.strip_prefix("field     "));
        line.unwrap().split("; ").map(|line| line.split(' ').next().unwrap()).collect::<Vec<_>>().join(" ")
    };
    assert_eq!([fields("two"), fields("one"), fields("made")], ["theta rho", "theta", "theta rho"]);
    let picture = |name: &str| image::open(folder.at("out").join(name)).unwrap().into_bytes();
    let [two, one, made] = ["two_theta", "one_theta", "made_both"].map(|n| picture(&format!("{n}_000000.png")));
    assert!(two != one && one != made && two != made);
    let plan = folder.prints("plan made.nc --scene scene.toml");
    assert_eq!(plan.matches("drawn on ").count(), 3, "{plan}");
}

#[test]
fn pictures_become_an_animation() {
    let orbit = scene("theta", 0.0, 2042.0).replace("fov = 45", "fov = 45\norbit.degrees_per_step = 30");
    let folder = folder(&Made::history(), &orbit);
    folder.render("--time all -o . --size 40x30");
    let names = pictures(folder.path());
    let animate = |more: &[&'static str]| {
        let mut command = icoray(folder.path());
        command.arg("animate").args(&names).args(more);
        command
    };
    let text = prints(&mut animate(&["-o", "film.png", "--fps", "5"]));
    let film = folder.at("film.png");
    let bytes = film.metadata().unwrap().len();
    assert_eq!(text, format!("animation film.png (40 x 30, 3 pictures, 5 per second, {bytes} bytes)\n"));
    let reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(&film).unwrap())).read_info().unwrap();
    assert_eq!(reader.info().animation_control.unwrap().num_frames, 3);
    shows_something(&film, 40, 30);
    folder.render("-o large.png");
    let sizes = "large.png: is 96 x 96 pixels, expected all pictures to be as large as theta_000000.png, 40 x 30";
    fails(&mut animate(&["large.png", "-o", "film2.png"]), 1, &[sizes]);
}
