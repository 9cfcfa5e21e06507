//! Files that are drawn without a scene, and scenes that are changed by options.

use crate::files::folder;
use crate::made::Made;
use crate::real::data;
use crate::run::{Folder, has, says, scene, shows_something};
use std::collections::BTreeMap;
use std::fs;

#[test]
fn a_file_alone_is_drawn() {
    let folder = Folder::of(&Made::history());
    let text = folder.render_alone("");
    let parts = [
        "scene     suggested for theta, the first field with layers; --field also takes w, vorticity, rho, surface_pressure\n",
        // The last time.
        "picture   theta_2013-10-27_00.00.00_000002.png (96 x 72)",
        "time 2 (2013-10-27_00:00:00)",
    ];
    has(&text, &parts);
    shows_something(&folder.at("theta_2013-10-27_00.00.00_000002.png"), 96, 72);
    let text = folder.render_alone("--field vorticity --time 0");
    let parts = ["scene     suggested for vorticity\n", "picture   vorticity_2013-10-25_00.00.00_000000.png", "time 0"];
    has(&text, &parts);
}

#[test]
fn the_saved_scene_draws_the_same_picture() {
    let folder = Folder::of(&Made::history());
    let take_drawn = || {
        let files = fs::read_dir(folder.at("out")).unwrap().map(|entry| entry.unwrap().path());
        let pictures = files.filter(|path| path.extension().is_some_and(|ending| ending != "csv"));
        let drawn: BTreeMap<_, _> = pictures.map(|path| (path.clone(), fs::read(path).unwrap())).collect();
        fs::remove_dir_all(folder.at("out")).unwrap();
        assert!(!drawn.is_empty());
        drawn
    };
    for (more, to) in [
        ("", "out/a.exr"),
        ("--field w --time 1 --lon -120.5 --lat -30 --distance 3.25", "out/a.exr"),
        ("--field vorticity --exaggeration 33 --cmap plasma --range 2000..2050", "out/a.png"),
        ("--surface 1 --tolerance 1e-5 --backend cpu", "out/a.exr"),
        ("--layers 1..4 --time all", "out"),
    ] {
        let text = folder.render_alone(&format!("{more} --save-scene s.toml -o {to}"));
        has(&text, &["; saved as s.toml\n"]);
        let (drawn, saved) = (take_drawn(), folder.text("s.toml"));
        let command = saved.lines().next().unwrap().strip_prefix("# icoray ").unwrap();
        folder.prints(&format!("{command} -o {to}"));
        assert!(take_drawn() == drawn, "{more}: {command} draws another picture");
        if more.is_empty() {
            folder.prints(&format!("made.nc --scene s.toml -o {to}"));
            assert!(take_drawn() == drawn, "without --time it is the last one too");
        }
    }
}

#[test]
fn a_scene_that_names_a_field_alone_is_the_suggestion() {
    let folder = Folder::of(&Made::history());
    let draw = |scene: &str, more: &str| {
        folder.write("own.toml", scene);
        folder.prints(&format!("made.nc --scene own.toml -o own.exr {more}"));
        folder.bytes("own.exr")
    };
    for field in ["w", "vorticity", "surface_pressure"] {
        folder.render_alone(&format!("--field {field} -o a.exr --save-scene saved.toml"));
        let suggested = folder.bytes("a.exr");
        let image = "image = { width = 96, height = 72 }";
        assert!(draw(&format!("field = '{field}'\n{image}"), "") == suggested, "{field}");
        // Keys of its own go first.
        let moved = format!("field = '{field}'\n{image}\ncamera = {{ lon = 100 }}");
        assert!(draw(&moved, "") != suggested, "{field}: the camera stays");
        // A saved scene shows other fields in their own look.
        let other = draw(&folder.text("saved.toml"), "--field rho");
        has(&folder.prints("plan made.nc --scene own.toml --field rho"), &["rho"]);
        assert!(other != suggested, "{field}: --field changes nothing");
    }
    // Each view that names a field alone has its look, beside one with a look of its own.
    let image = "image = { width = 96, height = 72 }\ncore = 'transparent'\noutput.file = '{view}.exr'\n";
    let views = "[[views]]\nname = 'a'\nfield = 'w'\n[[views]]\nname = 'b'\nvolumes = [{ field = 'vorticity' }]\n\
                 [[views]]\nname = 'c'\nfield = 'w'\ntransfer = { map = 'magma' }\n";
    folder.write("views.toml", format!("{image}{views}"));
    folder.prints("render made.nc --scene views.toml -o views");
    let pixels = |name: &str| image::open(folder.at(name)).unwrap().to_rgba32f();
    for (view, field) in [("a", "w"), ("b", "vorticity")] {
        draw(&format!("field = '{field}'\n{}", image.replace("output.file = '{view}.exr'\n", "")), "");
        assert!(pixels(&format!("views/{view}.exr")) == pixels("own.exr"), "{view}");
    }
    assert!(pixels("views/c.exr") != pixels("views/a.exr"));
    // A look of its own stays.
    let own = scene("theta", 0.0, 42.0);
    assert!(draw(&own, "") != draw("field = 'theta'", "--size 96x96"), "the look of the scene is not its own");
}

#[test]
fn a_scene_that_states_a_part_of_a_look_gets_the_rest_of_the_suggestion() {
    let folder = Folder::of(&Made::history());
    let draw = |scene: &str, to: &str| {
        folder.write("own.toml", format!("{scene}\n[image]\nwidth = 96\nheight = 72\n"));
        folder.prints(&format!("made.nc --scene own.toml -o {to}"));
        folder.bytes(to)
    };
    let lines = "[[lines]]\npattern = \"cells\"\n";
    for (field, scene, options) in [
        ("w", "[transfer]\nmap = \"magma\"\nrange = [-1, 1.5]", "--cmap magma --range -1..1.5"),
        ("surface_pressure", "[transfer]\nmap = \"magma\"", "--cmap magma"),
        ("theta", "[[isosurfaces]]\nvalue = 2020", "--isosurface 2020"),
        ("vorticity", "[[surfaces]]\nlayer = \"top\"", "--surface top"),
    ] {
        folder.render_alone(&format!("--field {field} -o a.png {options}"));
        let own = draw(&format!("field = \"{field}\"\n{scene}"), "b.png");
        assert!(own == folder.bytes("a.png"), "{field}: {scene}");
    }
    // Lines of its own are in place of coasts and graticule.
    folder.render_alone("--field w --save-scene saved.toml -o a.png");
    let saved = folder.text("saved.toml");
    let [before, after] = ["[[lines]]", "[labels]"].map(|section| saved.find(section).unwrap());
    folder.write("saved.toml", format!("{}{lines}{}", &saved[..before], &saved[after..]));
    folder.prints("render made.nc --scene saved.toml -o c.png");
    assert!(draw(&format!("field = \"w\"\n{lines}"), "b.png") == folder.bytes("c.png"), "lines");
    // Lines alone, and surfaces with labels, are as they are written.
    for scene in [lines, "field = \"w\"\n[labels]\n[[surfaces]]\n", "field = \"w\"\n[transfer]\n"] {
        draw(scene, "b.exr");
        let corner = image::open(folder.at("b.exr")).unwrap().to_rgba32f().get_pixel(0, 0).0;
        assert_eq!(corner, [0.0, 0.0, 0.0, 1.0], "{scene}: the background of the suggestion");
    }
}

#[test]
fn options_change_the_looks_of_a_scene() {
    let given = scene("theta", 0.0, 42.0);
    let folder = folder(&Made::history(), &given);
    let edited = given.replace("lon = 190", "lon = -35").replace("lat = 45", "lat = 10");
    let edited = edited.replace("distance = 3", "distance = 4").replace("exaggeration = 50", "exaggeration = 20");
    folder.write("edited.toml", edited);
    let draw = |scene: &str, more: &str| {
        folder.prints(&format!("made.nc --scene {scene} -o a.png {more}"));
        folder.bytes("a.png")
    };
    let changed = draw("scene.toml", "--lon -35 --lat 10 --distance 4 --exaggeration 20");
    assert!(changed == draw("edited.toml", ""), "the pictures differ");
    let plain = draw("scene.toml", "");
    assert!(changed != plain, "the options change nothing");
    for (key, value, options) in [
        ("\"#101820\"", "\"white\"", "--background white"),
        ("kind = \"headlight\"", "kind = \"none\"", "--light none"),
        ("kind = \"headlight\"", "kind = \"sun\"\nlon = -10\nlat = 20", "--light -10,20"),
    ] {
        folder.write("edited.toml", given.replace(key, value));
        let changed = draw("scene.toml", options);
        assert!(changed != plain && changed == draw("edited.toml", ""), "{options}");
    }
    let borders = "[[lines]]\npattern = \"borders\"\nwidth = 0.8\nopacity = 0.5\n";
    folder.write("edited.toml", given.clone() + borders);
    let bordered = draw("edited.toml", "");
    assert!(bordered != plain && bordered == draw("scene.toml", "--borders"), "borders differ");
    assert!(bordered == draw("edited.toml", "--borders"), "borders are drawn twice");
    folder.write("edited.toml", format!("core = \"transparent\"\n{given}"));
    let hollow = "render made.nc --scene edited.toml --borders -o a.exr";
    folder.fails(hollow, 1, &["--borders: borders lie on the ground", "on = \"top\""]);
    folder.write("edited.toml", given.clone() + "[labels]\n");
    assert!(draw("edited.toml", "") != draw("edited.toml", "--no-labels"), "labels stay");
}

#[test]
fn an_isosurface_is_saved_and_one_off_the_values_is_reported() {
    let folder = Folder::of(&Made::history());
    let said = |options: &str| folder.render_alone(&format!("--field theta -o a.exr {options}"));
    let text = said("--isosurface 2020 --background white --light 10,20 --save-scene iso.toml");
    assert!(!text.contains("theta is "), "{text}");
    folder.prints("made.nc --scene iso.toml -o b.exr");
    assert!(folder.bytes("a.exr") == folder.bytes("b.exr"), "the saved scene draws another picture");
    let text = said("--isosurface 5000");
    has(&text, &["note      theta is 2000 to 2041.375: it has no isosurface of 5000\n"]);
    let text = said("--range 1000..1500");
    has(&text, &["note      theta is 2000 to 2041.375: colours from 1000 to 1500 show no difference of it\n"]);
}

#[test]
fn errors_of_files_without_a_field_state_the_remedy() {
    let folder = Folder::of(&Made::mesh(false));
    let parts = ["made.nc: a mesh without a field, expected a history", "icoray render HISTORY.nc --mesh made.nc"];
    folder.fails("render made.nc", 1, &parts);
    let mut made = Made::history();
    made.variables.retain(|v| !["theta", "w", "vorticity", "rho", "surface_pressure"].contains(&v.name));
    let folder = Folder::of(&made);
    let parts = ["no variable looks like a physical field", "expected the name of one of zgrid", "--field NAME, or"];
    folder.fails("render made.nc", 1, &parts);
}

#[test]
fn a_field_without_values_is_an_error_and_a_constant_one_is_drawn() {
    let mut made = Made::history();
    made.f32s("theta").fill(f32::NAN);
    made.f64s("w").fill(0.0);
    let folder = Folder::of(&made);
    folder.fails("render made.nc", 1, &["theta: all values are missing"]);
    has(&folder.render_alone("--field w"), &["picture   w_2013-10-27_00.00.00_000002.png"]);
}

#[test]
fn plan_takes_the_options_of_render() {
    let folder = folder(&Made::history(), &scene("theta", 0.0, 42.0));
    let all = "--time 1 --layers 0..3 --threads 1 --backend cpu --size 64x48 --tolerance 1e-2 -o out.png --error map.png \
               --existing never-modify --lon 10 --lat 20 --distance 3 --exaggeration 40";
    let with_scene = format!("{all} --scene scene.toml");
    let without = format!("{all} --field w --colormap vik --range 0..2000 --surface top");
    for words in [&with_scene, &without] {
        let text = folder.prints(&format!("plan made.nc {words}"));
        has(&text, &["read: ", "left out: ", "picture: out.png (64 x 48), time 1\n"]);
        assert_eq!(folder.count(), 2, "plan draws nothing");
        folder.prints(&format!("render made.nc {words}"));
        fs::remove_file(folder.at("out.png")).unwrap();
        fs::remove_file(folder.at("map.png")).unwrap();
    }
    let text = folder.prints("plan made.nc --save-scene saved.toml");
    let parts =
        ["scene     suggested for theta", "saved as saved.toml", "picture: theta_2013-10-27_00.00.00_000002.png"];
    has(&text, &parts);
    assert!(folder.at("saved.toml").exists());
}

#[test]
fn real_files_are_drawn_without_a_scene() {
    let folder = Folder::new();
    for (name, fields) in
        [("mpas_jw_10242.nc", ["theta", "w", "vorticity"]), ("psyplot_icon_test.nc", ["t2m", "u", "v"])]
    {
        let Some(file) = data(name) else { continue };
        for (i, field) in fields.iter().enumerate() {
            let chosen = if i > 0 { format!("--field {field}") } else { String::new() };
            let text = folder.prints(&format!("render {file} --size 120x90 -o out.png {chosen}"));
            has(&text, &[&format!("suggested for {field}")]);
            shows_something(&folder.at("out.png"), 120, 90);
            says(&folder.at("out.png"), &[("field", field)]);
        }
    }
    for (name, part) in [
        ("favba_planar_mesh.nc", "on_a_sphere is NO"),
        ("mesh.QU.1920km.151026.nc", "no variable looks like a physical field, expected the name of one of areaCell"),
        ("spherical_grid_500km_landculled.nc", "icoray render HISTORY.nc --mesh"),
    ] {
        let Some(file) = data(name) else { continue };
        folder.fails(&format!("render {file}"), 1, &[name, part]);
    }
}
