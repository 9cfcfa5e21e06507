//! Scenes that name fields alone: they have the look of the first values that they show, on any number of ranks.

use super::super::PartInput;
use super::super::test_array::centers;
use super::*;
use crate::borrow::ArrayInput;
use crate::boundary::tests::config;
use crate::types::icoray_config;
use icoray_core::ranks::on_local_nodes;
use icoray_core::{Field, Grid, IcosahedralMesh, Layers, Location, Owned, PartCells, Ranks};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

const HEIGHT_M: [f64; 3] = [0.0, 4e3, 9e3];
const EARTH_M: f64 = 6.371e6;
const STEPS: i64 = 5;
const SCENE: &str = "image = { width = 48, height = 40 }
camera = { lon = 30 }
[[views]]
name = 'wave'
field = 'f'
[[views]]
name = 'rain'
volumes = [{ field = 'r' }]
at_steps = [3, 4]
core = 'transparent'
[[views]]
name = 'own'
field = 'f'
transfer = { map = 'magma', unit_length = 0.1 }
";

/// The values of a field at a step, level-fastest; the wave grows, has none at the first step, and is flat at the next.
fn values(mesh: &IcosahedralMesh, field: &str, step: i64) -> Vec<f64> {
    let of = |cell: usize, layer: usize| match field {
        "f" if step == 0 => f64::NAN,
        "f" if step == 1 => layer as f64,
        "f" => step as f64 * (3.0 * mesh.lon_center_rad[cell]).sin() * (1.0 + layer as f64),
        _ => (4.0 * (mesh.lon_center_rad[cell] - 0.3 * step as f64).cos()).exp(),
    };
    let layers = layers_of(field);
    (0..mesh.cells() * layers).map(|at| of(at / layers, at % layers)).collect()
}

fn layers_of(field: &str) -> usize {
    if field == "f" { HEIGHT_M.len() } else { 1 }
}

/// The pictures of a scene, by name; each rank has some of the cells, and rank 0 all where there is no other.
fn pictures(
    mesh: &'static IcosahedralMesh,
    nodes: &[usize],
    text: &str,
    in_background: bool,
) -> BTreeMap<String, Vec<u8>> {
    let folder = std::env::temp_dir().join(format!(
        "icoray-look-{}-{}-{}-{in_background}",
        std::process::id(),
        text.len(),
        nodes.len() + 10 * nodes.last().unwrap_or(&9)
    ));
    let run = |ranks: Ranks| {
        let config = icoray_config { async_render: in_background.into(), ..config() };
        let (rank, size) = (ranks.rank(), ranks.size());
        let mut context = Context::new(&config, folder.to_str().unwrap(), &ranks, 1).unwrap();
        context.join(ranks).unwrap();
        let layers = Layers::from_heights(&HEIGHT_M, EARTH_M).unwrap();
        context.set_grid("", Ok(mesh.tables())).unwrap();
        context.set_layers("", Ok(layers.radius_m()), EARTH_M).unwrap();
        if size > 1 {
            let global: Vec<i64> = (0..mesh.cells() as i64).collect();
            let marks: Vec<i32> = (0..mesh.cells()).map(|cell| (cell % size == rank).into()).collect();
            let cells = PartCells { global: global.as_slice().into(), owned: Owned::Marked(&marks) };
            context.set_part(|| Ok(PartInput { grid: "", cells, corners: None })).unwrap();
        }
        context.describe_field("r", "rain rate", "mm h-1").unwrap();
        context.set_scene("icoray_scene_text", || Ok(SceneSource::Text(text))).unwrap();
        for step in 0..STEPS {
            let given = ["f", "r"].map(|field| (field, values(mesh, field, step)));
            for (field, values) in &given {
                let array = centers(values, layers_of(field));
                let given = ArrayInput::new(&array, context.is_shared());
                context.set_field(field, given).unwrap();
            }
            context.execute(Ok(Stamp { step, time_s: 60.0 * step as f64, date: None })).unwrap();
            context.wait().unwrap();
        }
        context.finish().unwrap();
    };
    match nodes {
        [] => run(Ranks::alone()),
        nodes => drop(on_local_nodes(nodes, |team| run(Ranks::new(team)))),
    }
    let files = read(&folder);
    fs::remove_dir_all(&folder).unwrap();
    files
}

fn read(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = fs::read_dir(folder).unwrap().map(|file| file.unwrap());
    let files = files.map(|file| (file.file_name().into_string().unwrap(), fs::read(file.path()).unwrap()));
    files.filter(|(name, _)| name.ends_with(".png")).collect()
}

/// The scene with the look that a file of the first values would have.
fn expected(mesh: &IcosahedralMesh) -> String {
    let grid = Grid::new(mesh.tables()).unwrap();
    let layers = Layers::from_heights(&HEIGHT_M, EARTH_M).unwrap();
    let wanted = Completion { text: SCENE, ..Default::default() };
    let text = suggest::completed(&wanted, &mut |field, options| {
        let values = values(mesh, field, if field == "f" { 2 } else { 3 });
        let given = Field::level_fastest(&values, layers_of(field), Location::Center)?.on_layers(layers.count());
        let options = if field == "f" { options } else { options.for_2d() };
        suggest::scene(field, &grid, &layers, &given, &options).map(Some)
    });
    text.unwrap().unwrap()
}

#[test]
fn views_that_name_a_field_alone_keep_the_look_of_its_first_values() {
    let mesh: &IcosahedralMesh = Box::leak(Box::new(IcosahedralMesh::new(3).unwrap()));
    let text = expected(mesh);
    let count = |key: &str| text.matches(key).count();
    assert_eq!((count("coolwarm_bright"), count("[[views.surfaces]]"), count("magma")), (1, 1, 1), "{text}");
    let whole = pictures(mesh, &[], &text, false);
    let names: Vec<&str> = whole.keys().map(String::as_str).collect();
    let of = |view: &str, steps: &[i32]| steps.iter().map(|step| format!("{view}_{step:06}.png")).collect::<Vec<_>>();
    let all = [of("own_f", &[0, 1, 2, 3, 4]), of("rain_r", &[3, 4]), of("wave_f", &[0, 1, 2, 3, 4])].concat();
    assert_eq!(names, all);
    for in_background in [false, true] {
        for nodes in [&[][..], &[0], &[0, 0], &[0, 0, 0, 0]] {
            let mut found = pictures(mesh, nodes, SCENE, in_background);
            // Without values, or with those of the layers alone, there is no look to keep.
            for early in ["wave_f_000000.png", "wave_f_000001.png"] {
                assert!(found.insert(early.into(), whole[early].clone()).is_some_and(|own| own != whole[early]));
            }
            let differ: Vec<&String> = whole.keys().filter(|name| found.get(*name) != whole.get(*name)).collect();
            assert!(
                differ.is_empty(),
                "{nodes:?}, in the background {in_background}: {differ:?} of {:?}",
                found.keys()
            );
        }
    }
}
