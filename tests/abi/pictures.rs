//! Pictures that C programs draw, against each other and against Rust's.

use super::{VIEWS, compile_all};
use icoray::output::write_picture;
use icoray::{Field, Fields, Grid, IcosahedralMesh, Layers, Location, LonLat, Renderer, Scene};
use icoray_tests::native::{checked, command, compile_c};
use icoray_tests::pictures::{count_colors, groups, rows};
use image::RgbaImage;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

fn read(path: &Path) -> RgbaImage {
    image::open(path).unwrap().into_rgba8()
}

/// Mean difference of the channels.
fn distance(one: &RgbaImage, other: &RgbaImage) -> f64 {
    assert_eq!(one.dimensions(), other.dimensions());
    let sum: u64 = one.iter().zip(other.iter()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / one.len() as f64
}

/// The files below a directory that fit a pattern, sorted.
fn files(directory: &Path, pattern: &str) -> Vec<PathBuf> {
    let paths = glob::glob(&format!("{}/**/{pattern}", directory.display())).unwrap().map(Result::unwrap);
    let mut files: Vec<_> = paths.filter(|path| path.is_file()).collect();
    files.sort();
    files
}

/// Fails unless the report of a directory lists just its pictures, with what all have in common.
fn assert_reported(directory: &Path, pictures: &[PathBuf]) {
    let mut listed = Vec::new();
    for row in rows(&directory.join("report.csv")) {
        assert!(["f", "g", "corner", "thick f", "thick g", "flat g"].contains(&&*row["field"]), "{row:?}");
        assert!(row["file"].ends_with(&format!("_{}.png", row["step"])), "{row:?}");
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        let [max, mean, p999] = ["error_max", "error_mean", "error_p999"].map(number);
        assert!(0.0 < mean && mean <= max && 0.0 < p999 && p999 <= max && max <= 1e-3, "{row:?}");
        assert!(["true", "false"].contains(&&*row["error_is_bound"]), "{row:?}");
        assert_eq!((number("tolerance"), number("pixel_step")), (1e-3, 1.0));
        assert_eq!(number("pixels_over_tolerance"), 0.0);
        assert!(["off", "full"].contains(&&*row["lights"]), "{row:?}");
        assert_eq!(["ranks", "balance", "gather_s", "bytes_received"].map(number), [1.0, 1.0, 0.0, 0.0]);
        assert!(number("tiles") >= 1.0, "{row:?}");
        let may_copy =
            directory.components().any(|c| ["background", "at_once"].map(OsStr::new).contains(&c.as_os_str()));
        assert!(may_copy || number("bytes_copied") == 0.0, "{row:?}");
        listed.push(directory.join(&row["file"]));
    }
    listed.sort();
    assert_eq!(listed, pictures, "{}", directory.display());
}

/// Columns of four values, level-fastest.
fn field(values: &[f32], location: Location) -> Field<'_> {
    Field::level_fastest(values, 4, location).unwrap()
}

/// The picture of `pictures_fields.c`, drawn without the ABI.
fn two_fields_in_rust(to: &Path) -> RgbaImage {
    const RADIUS: [f64; 4] = [6_371_220.0, 6_375_220.0, 6_380_220.0, 6_391_220.0];
    let mesh = IcosahedralMesh::new(3).unwrap();
    let tables = mesh.tables();
    let grid = Grid::new(mesh.tables()).unwrap();
    let layers = Layers::new(RADIUS.to_vec(), RADIUS[0]).unwrap();
    let values = |at: &LonLat| -> Vec<f32> {
        let value = |column: usize, layer: f64| {
            let [lon, lat] = [at.lon_rad.get(column), at.lat_rad.get(column)];
            let wave = (3.0 * lon + 0.4 * layer).sin() * lat.cos() + 0.3 * (5.0 * lat).sin();
            (wave * (1.0 + 0.2 * layer)) as f32
        };
        let columns = 0..at.lon_rad.len();
        columns.flat_map(|column| (0..4).map(move |layer| value(column, f64::from(layer)))).collect()
    };
    let (f, v) = (values(&tables.center), values(&tables.corner));
    let scene = Scene::parse(
        r#"
        exaggeration = 40
        backend = "cpu"
        image = { width = 64, height = 64 }
        camera = { lon = 20, lat = 35, distance = 3.2, fov = 45 }
        [[volumes]]
        field = "f"
        transfer = { map = "viridis", range = [-1.5, 1.5], opacity = [[-1.5, 0.8], [0, 0.1], [1.5, 0.9]] }
        [[volumes]]
        field = "v"
        transfer = { map = "magma", range = [-1, 1], opacity = [[-1, 0.0], [0, 0.0], [1, 0.9]] }
        "#,
    );
    let fields = Fields::new([("f", field(&f, Location::Center)), ("v", field(&v, Location::Corner))]);
    let frame = Renderer::new(1).unwrap().render(&scene.unwrap(), &grid, &layers, fields).unwrap();
    write_picture(to, &frame).unwrap();
    read(to)
}

/// Layouts, types, numberings, contexts and threads make no difference to a picture; values do.
#[test]
fn pictures_depend_on_values_and_nothing_else() {
    let directory = TempDir::new().unwrap();
    let program = compile_all("pictures", compile_c);
    checked(command(program, directory.path()).arg("out").args(["3", "64"]), "pictures", 3000);
    let paths = files(&directory.path().join("out"), "*.png");
    let mut directories: BTreeMap<_, Vec<PathBuf>> = BTreeMap::new();
    paths.iter().for_each(|path| directories.entry(path.parent().unwrap()).or_default().push(path.clone()));
    directories.iter().for_each(|(directory, pictures)| assert_reported(directory, pictures));
    let groups = groups(paths);
    let sizes: Vec<_> = groups.iter().map(|(name, group)| (name.as_str(), group.count)).collect();
    let expected = [
        ("averaged", 8),
        ("coarse", 5),
        ("corner", 47),
        ("flat", 1),
        ("hills", 12),
        ("lit", 44),
        ("litcorner", 2),
        ("midway", 45),
        ("missing", 4),
        ("near corner", 1),
        ("near plain", 3),
        ("nothing", 1),
        ("plain", 115),
        ("thick", 3),
        ("thick coarse", 3),
        ("turned", 5),
        ("two", 6),
    ];
    assert_eq!(sizes, expected);
    let rust = two_fields_in_rust(&directory.path().join("rust.png"));
    let picture = |name: &str| &groups[name].picture;
    assert!(*picture("two") == rust, "two fields: {}", distance(picture("two"), &rust));
    for near in groups.keys() {
        let Some(name) = near.strip_prefix("near ") else { continue };
        let distance = distance(picture(near), picture(name));
        assert!(distance < 0.05, "{near}: {distance}");
    }
    let mut different = groups.keys().filter(|name| !name.starts_with("near "));
    while let Some(name) = different.next() {
        let colors = count_colors(picture(name));
        assert!(name == "nothing" || colors > 50, "{name}: {colors} colours");
        for other in different.clone() {
            let distance = distance(picture(name), picture(other));
            assert!(distance > 0.5, "{name} and {other}: {distance}");
        }
    }
}

/// The files of a directory, reports left out, with those of directories in it.
fn names_in(directory: &Path) -> Vec<String> {
    let files = files(directory, "*").into_iter().filter(|path| !path.ends_with("report.csv"));
    let mut names: Vec<_> = files.map(|path| path.strip_prefix(directory).unwrap().display().to_string()).collect();
    names.sort();
    names
}

/// Views at their own steps, under their own names, with what is kept of a series; drawn in the call or of copies.
#[test]
fn all_views_of_a_scene_file_are_drawn() {
    let directory = TempDir::new().unwrap();
    let program = compile_c(&VIEWS);
    checked(command(program, directory.path()).arg(directory.path()), "views", 300);
    let at = |run: &str| directory.path().join(run);
    let mut expected = vec!["once_6.png".to_owned(), "sides.cdb/data.csv".into(), "two.ffconcat".into()];
    expected.extend([0, 2, 4, 6].map(|step| format!("two_{step}.png")));
    expected.extend([0, 3, 6].map(|step| format!("around_{step}.png")));
    let places = [20, 70].map(|lat| [70, 160, 310].map(|lon| (lat, lon))).concat();
    expected.extend(places.iter().map(|(lat, lon)| format!("sides.cdb/5_{lat}_{lon}.png")));
    expected.sort();
    for run in ["call", "background"] {
        assert_eq!(names_in(&at(run)), expected, "{run}");
        let table = rows(&at(run).join("sides.cdb/data.csv"));
        let said: Vec<_> =
            table.iter().map(|row| ["step", "time", "lat", "lon", "FILE"].map(|name| row[name].clone())).collect();
        let listed = |(lat, lon): &(i32, i32)| {
            let file = format!("5_{lat}_{lon}.png");
            ["5".into(), "300.0".into(), format!("{lat}.0"), format!("{lon}.0"), file]
        };
        assert_eq!(said, places.iter().map(listed).collect::<Vec<[String; 5]>>(), "{run}");
        let list = std::fs::read_to_string(at(run).join("two.ffconcat")).unwrap();
        assert_eq!(list.matches("file ").count(), 4, "{list}");
    }
    let picture = |name: &str| read(&at("call").join(name));
    for name in expected.iter().filter(|name| name.ends_with(".png")) {
        let (drawn, copied) = (picture(name), read(&at("background").join(name)));
        assert!(drawn == copied, "{name}: {}", distance(&drawn, &copied));
        assert!(count_colors(&drawn) > 50, "{name}");
    }
    // The camera that stands still, and the one that goes about.
    assert!(picture("two_0.png") == picture("two_4.png") && picture("two_0.png") == picture("around_0.png"));
    for (one, other) in [
        ("around_0.png", "around_3.png"),
        ("around_3.png", "around_6.png"),
        ("sides.cdb/5_20_70.png", "sides.cdb/5_70_70.png"),
        ("sides.cdb/5_20_70.png", "sides.cdb/5_20_160.png"),
    ] {
        let distance = distance(&picture(one), &picture(other));
        assert!(distance > 0.5, "{one} and {other}: {distance}");
    }
    for run in ["bad_call", "bad_background"] {
        let drawn = ["fine_9.png", "good_9.png", "new_9.png", "other_10.png"];
        assert_eq!(names_in(&at(run)), drawn, "{run}");
    }
}
