//! The pictures of a file with ICON's output: those that the plugin draws while ICON runs.

use super::direct_with;
use icoray::output::rgba8;
use icoray::{Ranks, Renderer, Script};
use icoray_dataset::{Drawing, FieldInfo, LayerSelection, NativeHeightCache, SceneFields, Series};
use icoray_tests::native::{command, compile_to, root, succeeded, text};
use icoray_tests::pictures::{Pictures, assert_same};
use icoray_tests::ranks::FIRST;
use std::path::Path;
use std::process::Command;

/// The compiler's options for the NetCDF library.
pub fn netcdf() -> Option<Vec<String>> {
    let output = Command::new("pkg-config").args(["--cflags", "--libs", "netcdf"]).output().ok()?;
    let options = text(&output.stdout).split_whitespace().map(str::to_owned).collect();
    output.status.success().then_some(options)
}

/// As the command `icoray render` draws all times of the file.
fn rendered(path: &Path, mut script: Script) -> Pictures {
    let (dataset, renderer) = (icoray_netcdf::open(path).unwrap(), Renderer::new(1).unwrap());
    script.show_as_surfaces(|name| dataset.field_info(name).is_ok_and(FieldInfo::is_2d));
    let script = &script;
    let (grid, all) = (dataset.mesh().grid().unwrap(), LayerSelection::default());
    let scene_fields = &SceneFields::new(&dataset, script, &all).unwrap();
    let series = Series::of(&dataset, script, (0..dataset.times().len()).collect(), true);
    let drawing = Drawing { scene_fields, grid: &grid, renderer: &renderer };
    let mut heights = NativeHeightCache::default();
    let mut pictures = Pictures::new();
    for time in series.times.iter().copied() {
        let stamp = series.stamp(time);
        let (views, read) = series.views_of(drawing, time).unwrap();
        let scenes = || views.iter().flat_map(|view| view.shots(&stamp)).map(|shot| shot.scene);
        heights.get_ready(drawing, scenes(), time).unwrap();
        let fields = read.borrowed().unwrap();
        for scene in scenes() {
            let frame = drawing.frame(&scene, &fields, &heights, &mut Ranks::alone()).unwrap().unwrap();
            let name = scene.output.names(&stamp, scene.field()).unwrap().file;
            let pixels = image::RgbaImage::from_raw(frame.width, frame.height, rgba8(&frame)).unwrap();
            pictures.insert(name, pixels);
        }
    }
    pictures
}

#[test]
fn the_pictures_of_the_file_are_those_of_the_running_model() {
    let Some(directory) = FIRST.directory() else { return };
    let netcdf = netcdf().expect("the library that icoray-netcdf links");
    let directory = directory.path();
    let (writer, path) = (directory.join("file"), directory.join("icon.nc"));
    let netcdf: Vec<&str> = netcdf.iter().map(String::as_str).collect();
    compile_to(&writer, "cc", &[], &["comin/file", "comin/icon"], &netcdf);
    succeeded(command(&writer, directory).arg(&path).arg("3"));
    let scene = std::fs::read_to_string(root().join("tests/c/comin/scene.toml")).unwrap();
    let drawn = rendered(&path, Script::parse(&scene).unwrap());
    // View, field, date and step; the files of a file's times are named without a date.
    let without_date = |name: String| {
        let parts: Vec<&str> = name.split('_').collect();
        [parts[0], parts[1], parts[parts.len() - 1]].join("_")
    };
    // The pixels alone are compared, without labels.
    let expected = direct_with(directory, |scene| scene.replace("[labels]\ntitle = \"{name} ({units})\"\n", ""));
    let expected: Pictures = expected.into_iter().map(|(name, picture)| (without_date(name), picture)).collect();
    assert_eq!(expected.len(), 8);
    assert_same(&drawn, &expected, "the file");
}
