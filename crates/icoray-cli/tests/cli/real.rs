//! Real files, if the test data are present.

use crate::run::{Folder, has, says, shows_something};
use std::fs;

/// The path of a file of the test data. If it is not there, skips the test.
pub fn data(name: &str) -> Option<String> {
    icoray_test_support::data_file(name).map(|path| path.into_os_string().into_string().unwrap())
}

/// The path of a scene that comes with icoray.
pub fn example(name: &str) -> String {
    format!("{}/../../examples/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

/// The scenes that come with icoray, made small.
#[test]
fn the_example_scenes_show_something() {
    let Some(file) = data("mpas_jw_10242.nc") else { return };
    for name in ["jw_theta", "jw_w", "jw_vorticity"] {
        let folder = Folder::new();
        // Labels are no part of what is shown, and may take rows of their own.
        let scene = fs::read_to_string(example(name)).unwrap();
        folder.write("scene.toml", scene.replace("[labels]", "[labels]\non = false"));
        folder.prints(&format!("render {file} --scene scene.toml --time -1 --size 96x72 -o out.png"));
        shows_something(&folder.at("out.png"), 96, 72);
    }
}

/// A series of two times of ICON, without tables.
#[test]
fn temperatures_of_icon_are_rendered() {
    let Some(file) = data("psyplot_icon_test.nc") else { return };
    let folder = Folder::new();
    let scene = example("icon");
    let text = folder.prints(&format!("render {file} --scene {scene} --time 1979-01..1979-03 --size 96x72"));
    let parts = [
        "note      t2m is at corners: averaged to cell centres",
        "note      lev gives pressures: rendered at the heights of the standard atmosphere",
        "picture   icon_t2m_1979-02-28.png (96 x 72)",
        "time 1 (1979-02-28_18:00:00)",
    ];
    has(&text, &parts);
    for date in ["1979-01-31", "1979-02-28"] {
        let picture = folder.at(format!("icon_t2m_{date}.png"));
        shows_something(&picture, 96, 72);
        says(&picture, &[("note", "lev gives pressures: rendered at the heights of the standard atmosphere")]);
    }
}
