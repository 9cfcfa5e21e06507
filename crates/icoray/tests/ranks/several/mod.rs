//! Scenes of several fields, surfaces, lines, cuts, derived fields and native heights: over ranks and in every mode of
//! the renderer.

use crate::common::*;
use crate::culled::directions;
use crate::spread::Rows;
use icoray::{
    Clip, Derivation, Fields, Frame, Grid, Ground, Heights, How, IcosahedralMesh, Isosurface, Layers, Level, Lines,
    Location, LonLatBox, Paint, Pattern, Renderer, Scene, Shape, Surface, TransferFunction, Volume,
};
use icoray_test_support::count;

mod modes;
mod nodes;
mod ranks;

/// Layers of the first field, which lie midway between interfaces.
const LAYERS: usize = 4;
const INTERFACES: usize = LAYERS + 1;
const HEIGHT_M: [f64; INTERFACES] = [0.0, 3e3, 8e3, 14e3, 20e3];

fn layers() -> Layers {
    Layers::from_heights(&HEIGHT_M, 6371e3).unwrap()
}

/// What a model has in one step over some cells and corners of a mesh: f midway between the interfaces, g, h and
/// heights on them; g and heights at centres. Values that are not own are no numbers.
fn arrays(mesh: &IcosahedralMesh, step: usize, [cells, corners]: [&Rows; 2], location: Location) -> Arrays {
    let centers = directions(&mesh.lon_center_rad, &mesh.lat_center_rad);
    let triangles = directions(&mesh.lon_corner_rad, &mesh.lat_corner_rad);
    let phase = 0.4 * step as f64;
    let array = |location: Location, layers: usize, is_wide: bool, value: &dyn Fn(glam::DVec3, usize) -> f64| {
        let (rows, at) = if location == Location::Center { (cells, &centers) } else { (corners, &triangles) };
        let layout = |columns| Shape::level_fastest(columns, layers);
        rows.array(layout, (is_wide, location, None), |row, layer| value(at[row], layer), |_| f64::NAN)
    };
    let wave = |tilt: f64| {
        move |p: glam::DVec3, layer: usize| {
            (4.0 * p.x + phase).sin() * (3.0 * p.y - tilt).cos() + p.z * tilt - 0.25 * layer as f64
        }
    };
    let height = |p: glam::DVec3, layer: usize| HEIGHT_M[layer] + 2e3 * (9.0 * p.x).sin() * (7.0 * p.z).cos();
    vec![
        ("h", array(location, INTERFACES, false, &wave(0.7))),
        ("f", array(location, LAYERS, false, &wave(0.3))),
        ("g", array(Location::Center, INTERFACES, true, &wave(1.1))),
        ("heights", array(Location::Center, INTERFACES, true, &height)),
    ]
}

/// [`arrays`] over a whole mesh, of the steps 0 and 1.
fn steps(mesh: &IcosahedralMesh, location: Location) -> [Arrays; 2] {
    let all = [&Rows::all(mesh.cells()), &Rows::all(mesh.lon_corner_rad.len())];
    [0, 1].map(|step| arrays(mesh, step, all, location))
}

/// Red to yellow, denser towards the ends.
fn warm() -> TransferFunction {
    let ends = [knot(-2.0, [0.8, 0.1, 0.0], 1.5), knot(2.0, [1.0, 0.8, 0.1], 2.5)];
    transfer(&[ends[0], knot(-0.6, [0.9, 0.3, 0.0], 0.0), knot(0.2, [0.9, 0.5, 0.0], 0.3), ends[1]])
}

/// Two volumes, an isosurface, a coloured top with lines, a cut, land and sea; f lies at corners or centres, g and h on
/// one layer more.
fn scene(camera: &str, keys: &str, tables: &str) -> Scene {
    let image = count("width = 40\nheight = 34", "width = 56\nheight = 48");
    let mut scene = Scene::parse(&format!(
        "field = \"f\"\nexaggeration = 60\nprecision = \"f64\"\n{keys}\n[image]\n{image}\n[camera]\n{camera}\n\
         [transfer]\nmap = \"viridis\"\nrange = [-1.5, 1]\nopacity = [[-1.5, 0.5], [-0.5, 0.0], [0, 0.05], [1, 0.4]]\n{tables}\n"
    ))
    .unwrap();
    scene.volumes.push(Volume { field: "g".into(), transfer: warm(), coloring: None, opacity: None });
    let scenery = &mut scene.scenery;
    let blue = Paint::Plain([0.2, 0.4, 1.0]);
    scenery.isosurfaces = vec![Isosurface { field: "h".into(), value: -0.3, paint: blue, opacity: 0.5 }];
    let paint = |field: &str, by_cell| {
        let field = field.into();
        Paint::Field { field, transfer: warm(), coloring: None, by_cell }
    };
    scenery.surfaces = vec![
        Surface { at: Level::Top, paint: paint("g", true), opacity: 0.3 },
        Surface { at: Level::Layer(1), paint: paint("h", false), opacity: 0.4 },
    ];
    let lines = |pattern, on| {
        let (color, width_px, opacity) = ([1.0, 0.9, 0.8], 1.2, 0.6);
        Lines { pattern, on, color, width_px, opacity, region: None }
    };
    scenery.lines = vec![
        lines(Pattern::Cells, Level::Top),
        lines(Pattern::Graticule { spacing_deg: 10.0 }, Level::Top),
        lines(Pattern::Coast, Level::Ground),
    ];
    let region = LonLatBox { lon_deg: [0.0, 50.0], lat_deg: [10.0, 60.0] };
    let (region, layers, height_m, half_space) = (Some(region), None, None, None);
    scenery.clips = vec![Clip { cuts_inside: true, region, layers, height_m, half_space }];
    scenery.ground = Ground { land: Some([0.1, 0.6, 0.1]), ocean: Some([0.0, 0.1, 0.7]) };
    scene
}

/// The same of derived fields: how g differs from its zonal mean, and f from its first step.
fn of_derived(mut scene: Scene) -> Scene {
    let how = [How::FromZonalMean { field: "g".into(), band_deg: 7.0 }, How::FromFirst("f".into())];
    let names = ["anomaly", "change"];
    let derive = |(name, how): (&str, How)| Derivation { name: name.into(), how };
    scene.scenery.derived = names.into_iter().zip(how).map(derive).collect();
    scene.volumes[1].field = "anomaly".into();
    scene.volumes[0].field = "change".into();
    scene
}

/// Scenes with their names. Tolerances are far above what fragments lose in single precision.
fn scenes() -> Vec<(&'static str, Scene)> {
    let keys = "tolerance = 1e-4";
    let native = |mut scene: Scene| {
        scene.scenery.heights = Heights::Native;
        scene
    };
    let hollow = |mut scene: Scene| {
        (scene.core, scene.scenery.ground) = (None, Ground::default());
        scene.scenery.lines.retain(|lines| lines.on != Level::Ground);
        scene
    };
    vec![
        ("unlit", scene(FAR, keys, "")),
        ("lit", scene(NEAR, keys, LIT)),
        ("hollow", hollow(scene(NEAR, keys, LIT))),
        ("derived", of_derived(scene(FAR, keys, ""))),
        ("native", native(scene(NEAR, keys, ""))),
        ("native, hollow and derived", hollow(native(of_derived(scene(FAR, keys, LIT))))),
    ]
}

/// The second of two frames.
fn draw(renderer: &Renderer, grid: &Grid, scene: &Scene, steps: &[Arrays; 2]) -> Frame {
    let [_, second] = steps.each_ref().map(|step| renderer.render(scene, grid, &layers(), fields(step)).unwrap());
    second
}
