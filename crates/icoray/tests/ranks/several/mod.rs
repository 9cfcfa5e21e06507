//! Scenes of several fields, surfaces, lines, cuts, derived fields and native heights: over ranks and in every mode of
//! the renderer.

use crate::common::{FAR, LIT, NEAR, at_centers, bits, count_beyond, difference, icosahedral, level_fastest};
use icoray::{
    Clip, Derivation, Field, Fields, Frame, Grid, Ground, Heights, How, IcosahedralMesh, Isosurface, Knot, Layers,
    Level, Lines, Location, LonLatBox, Paint, Pattern, Renderer, Scene, Surface, TransferFunction, Volume,
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

/// What a model has in one step over some cells and corners of a mesh, level-fastest.
struct Model {
    cells: usize,
    /// Midway between the interfaces.
    f: Vec<f32>,
    /// At the centres, on the interfaces.
    g: Vec<f64>,
    /// On the interfaces.
    h: Vec<f32>,
    heights: Vec<f64>,
    /// Where f and h are.
    location: Location,
}

impl Model {
    /// Over these cells and corners of `mesh`; f and h lie at the corners, or at the centres too.
    fn new(mesh: &IcosahedralMesh, step: usize, (cells, corners): (&[usize], &[usize]), location: Location) -> Self {
        let centers = crate::culled::directions(&mesh.lon_center_rad, &mesh.lat_center_rad);
        let triangles = crate::culled::directions(&mesh.lon_corner_rad, &mesh.lat_corner_rad);
        let phase = 0.4 * step as f64;
        let wave = |p: glam::DVec3, layer: usize, tilt: f64| {
            (4.0 * p.x + phase).sin() * (3.0 * p.y - tilt).cos() + p.z * tilt - 0.25 * layer as f64
        };
        let at = |rows: &[usize], at: &[glam::DVec3], count: usize, tilt: f64| -> Vec<f64> {
            rows.iter().flat_map(|row| (0..count).map(|layer| wave(at[*row], layer, tilt))).collect()
        };
        let (rows, places) = match location {
            Location::Corner => (corners, &triangles),
            Location::Center => (cells, &centers),
        };
        let narrow = |values: Vec<f64>| values.into_iter().map(|value| value as f32).collect();
        let lift = |cell: &usize| 2e3 * (9.0 * centers[*cell].x).sin() * (7.0 * centers[*cell].z).cos();
        let heights = cells.iter().flat_map(|cell| HEIGHT_M.map(|height| height + lift(cell)));
        Model {
            cells: cells.len(),
            f: narrow(at(rows, places, LAYERS, 0.3)),
            g: at(cells, &centers, INTERFACES, 1.1),
            h: narrow(at(rows, places, INTERFACES, 0.7)),
            heights: heights.collect(),
            location,
        }
    }

    fn whole(mesh: &IcosahedralMesh, step: usize, location: Location) -> Self {
        let all = |count: usize| -> Vec<usize> { (0..count).collect() };
        let (cells, corners) = (all(mesh.cells()), all(mesh.lon_corner_rad.len()));
        Model::new(mesh, step, (&cells, &corners), location)
    }

    /// Puts NaN into all columns but those of `rank`: at centres those of its cells, at corners those whose first cell
    /// is one of them.
    fn spoil(
        &mut self,
        mesh: &IcosahedralMesh,
        (cells, corners): (&[usize], &[usize]),
        location: Location,
        owner: impl Fn(usize) -> usize,
        rank: usize,
    ) {
        let first = |corner: &usize| owner(mesh.corner_cell[3 * corner] as usize);
        let owners: Vec<usize> = match location {
            Location::Corner => corners.iter().map(first).collect(),
            Location::Center => cells.iter().map(|cell| owner(*cell)).collect(),
        };
        for (column, _) in owners.iter().enumerate().filter(|(_, owner)| **owner != rank) {
            self.f[column * LAYERS..][..LAYERS].fill(f32::NAN);
            self.h[column * INTERFACES..][..INTERFACES].fill(f32::NAN);
        }
        for (column, _) in cells.iter().enumerate().filter(|(_, cell)| owner(**cell) != rank) {
            self.g[column * INTERFACES..][..INTERFACES].fill(f64::NAN);
            self.heights[column * INTERFACES..][..INTERFACES].fill(f64::NAN);
        }
    }

    fn fields(&self) -> Fields<'_> {
        let f = level_fastest(&self.f, LAYERS, self.location);
        let h = level_fastest(&self.h, INTERFACES, self.location);
        let g = at_centers(&self.g, INTERFACES);
        Fields::new([("h", h), ("f", f), ("g", g)]).with_heights(at_centers(&self.heights, INTERFACES))
    }
}

fn knot(value: f64, color: [f64; 3], extinction: f64) -> Knot {
    Knot { value, color, extinction }
}

fn transfer(knots: &[Knot]) -> TransferFunction {
    TransferFunction { knots: knots.to_vec(), unit_length: None }
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

/// The second of two frames, of the steps 0 and 1.
fn draw(renderer: &Renderer, grid: &Grid, scene: &Scene, steps: &[Model; 2]) -> Frame {
    let frames = [0, 1].map(|step| renderer.render(scene, grid, &layers(), steps[step].fields()).unwrap());
    let [_, second] = frames;
    second
}
