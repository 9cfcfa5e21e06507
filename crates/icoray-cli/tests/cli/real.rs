//! Real files, if the test data are present.

use crate::run::{Folder, has, icoray, prints, says, scene, shows_something, software};
use std::fs;
use std::path::Path;

pub use icoray_test_support::data_file as data;

#[test]
fn fields_of_the_baroclinic_wave_are_rendered() {
    let Some(file) = data("mpas_jw_10242.nc") else { return };
    for (field, low, high) in [("theta", 250.0, 400.0), ("w", 0.004, 0.03), ("vorticity", 2e-5, 1e-4)] {
        let folder = Folder::new();
        folder.write("scene.toml", scene(field, low, high));
        for name in ["out.png", "out.exr"] {
            let mut render = icoray(folder.path());
            render.arg("render").arg(&file).args(["--scene", "scene.toml", "--time", "2", "-o", name]);
            let text = prints(&mut render);
            has(&text, &[&format!("field     {field} at "), "time 2 (0000-01-10_00:00:00)"]);
            assert_eq!(text.contains("vorticity is at corners"), field == "vorticity", "{text}");
            shows_something(&folder.at(name), 96, 96);
        }
        let date = "0000-01-10_00:00:00";
        says(&folder.at("out.png"), &[("Software", &software()), ("field", field), ("step", "2"), ("date", date)]);
    }
}

/// The scenes that come with icoray, made small.
#[test]
fn the_example_scenes_show_something() {
    let Some(file) = data("mpas_jw_10242.nc") else { return };
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes");
    for name in ["jw_theta", "jw_w", "jw_vorticity"] {
        let folder = Folder::new();
        let mut render = icoray(folder.path());
        // Labels are no part of what is shown, and may take rows of their own.
        let scene = fs::read_to_string(scenes.join(name).with_extension("toml")).unwrap();
        folder.write("scene.toml", scene.replace("[labels]", "[labels]\non = false"));
        render.arg("render").arg(&file).args(["--scene", "scene.toml"]);
        prints(render.args(["--time", "-1", "--size", "96x72", "-o", "out.png"]));
        shows_something(&folder.at("out.png"), 96, 72);
    }
}

/// A series of two times of ICON, without tables.
#[test]
fn temperatures_of_icon_are_rendered() {
    let Some(file) = data("psyplot_icon_test.nc") else { return };
    let folder = Folder::new();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes/icon.toml");
    let mut render = icoray(folder.path());
    render.arg("render").arg(&file).arg("--scene").arg(scene);
    let text = prints(render.args(["--time", "1979-01..1979-03", "--size", "96x72"]));
    has(
        &text,
        &[
            "note      t2m is at corners: averaged to cell centres",
            "note      lev gives pressures: rendered at the heights of the standard atmosphere",
            "picture   icon_t2m_1979-02-28.png (96 x 72)",
            "time 1 (1979-02-28_18:00:00)",
        ],
    );
    for date in ["1979-01-31", "1979-02-28"] {
        let picture = folder.at(format!("icon_t2m_{date}.png"));
        shows_something(&picture, 96, 72);
        says(&picture, &[("note", "lev gives pressures: rendered at the heights of the standard atmosphere")]);
    }
}

#[test]
fn info_and_plan_of_the_baroclinic_wave() {
    let Some(file) = data("mpas_jw_10242.nc") else { return };
    let folder = Folder::new();
    let text = prints(icoray(folder.path()).arg("info").arg(&file).arg("--ranges"));
    has(
        &text,
        &["10242 cells, 20480 corners, 30720 edges", "12 with 5 corners", "passes the check", "Potential temperature"],
    );
    folder.write("scene.toml", scene("theta", 250.0, 400.0));
    let mut plan = icoray(folder.path());
    has(&prints(plan.arg("plan").arg(&file).args(["--scene", "scene.toml"])), &["left out: table corner"]);
}
