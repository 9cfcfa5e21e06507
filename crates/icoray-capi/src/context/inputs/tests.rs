//! The inputs of the renderer, against those of the model.

use super::super::test_array::centers;
use super::*;
use crate::types::{ICORAY_CORNER, ICORAY_F32, icoray_array};
use icoray_core::{Derivation, How, IcosahedralMesh, Renderer, Script, Volume};
use std::ffi::CString;

const LAYERS: usize = 3;

const SCENE: &str = r##"
field = "q"
[image]
width = 8
height = 8
[camera]
lon = 20
lat = 30
distance = 3
[transfer]
map = "viridis"
range = [-1, 1]
opacity = [[-1, 0.1], [1, 0.9]]
"##;

/// Grid, layers, and the fields q and t: at centres in 64 bits, at corners in 32.
struct Model {
    inputs: Inputs,
    q: Vec<f64>,
    t: Vec<f32>,
    heights: Vec<f64>,
}

impl Model {
    fn new() -> Self {
        let mesh: &'static IcosahedralMesh = Box::leak(Box::new(IcosahedralMesh::new(1).unwrap()));
        let grid = Arc::new(Grid::new(mesh.tables()).unwrap());
        let layers = Arc::new(Layers::from_heights(&[0.0, 1e3, 3e3], 6.371e6).unwrap());
        let (cells, corners) = (grid.cells(), grid.triangles());
        let mut inputs = Inputs::default();
        for name in ["", "other"] {
            inputs.grids.insert(name.into(), GridInput { grid: Arc::clone(&grid), decomposition: None, tables: None });
            inputs.layers.insert(name.into(), Arc::clone(&layers));
        }
        let (q, t) = (vec![1.0; cells * LAYERS], vec![2.0; corners * LAYERS]);
        let mut model = Model { inputs, q, t, heights: vec![500.0; cells * LAYERS] };
        model.give("q", &centers(&model.q, LAYERS));
        let corners = icoray_array {
            data: model.t.as_ptr().cast(),
            r#type: ICORAY_F32,
            location: ICORAY_CORNER,
            columns: corners as i64,
            ..centers(&model.q, LAYERS)
        };
        model.give("t", &corners);
        model
    }

    fn give(&mut self, name: &str, array: &icoray_array) {
        let given = ArrayInput::new(array, false).unwrap();
        self.inputs.fields.insert(name.into(), given);
    }

    fn frame_inputs(&self, scene: Scene) -> Outcome<FrameInputs<'_>> {
        self.inputs.frame_inputs(Shot { name: String::new(), scene }, &Stamp::default())
    }

    fn refused(&self, scene: &Scene) -> (icoray_status, String) {
        let failure = self.frame_inputs(scene.clone()).unwrap_err();
        (failure.status, failure.message)
    }
}

/// The scene that shows the fields `others` beside q.
fn scene(others: &[&str]) -> Scene {
    let mut scene = Scene::parse(SCENE).unwrap();
    let volume = |field: &&str| Volume {
        field: (*field).into(),
        transfer: scene.volumes[0].transfer.clone(),
        coloring: None,
        opacity: None,
    };
    let others: Vec<Volume> = others.iter().map(volume).collect();
    scene.volumes.extend(others);
    scene
}

#[test]
fn a_scene_is_given_its_fields_in_place_and_no_others() {
    let mut model = Model::new();
    model.give("more", &centers(&model.q, LAYERS));
    let described = |text: &str| Description { long_name: Some(text.into()), units: None };
    for name in ["t", "q", "more", "speed"] {
        model.inputs.descriptions.insert(name.into(), described(name));
    }
    let mut speed = scene(&["t", "speed"]);
    let how = How::Magnitude(vec!["q".into(), "v".into()]);
    speed.scenery.derived = vec![Derivation { name: "speed".into(), how }];
    model.give("v", &centers(&model.heights, LAYERS));
    let frame_inputs = model.frame_inputs(speed).unwrap();
    let names: Vec<&str> = frame_inputs.fields.iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["q", "t", "v"]);
    let at = |name: &str| match frame_inputs.fields.get(name).unwrap().samples() {
        icoray_core::Reals::F32(values) => values.as_ptr().cast::<u8>(),
        icoray_core::Reals::F64(values) => values.as_ptr().cast(),
    };
    let places = [model.q.as_ptr().cast(), model.t.as_ptr().cast(), model.heights.as_ptr().cast()];
    assert_eq!(["q", "t", "v"].map(at), places, "read where the model has them");
    assert_eq!(frame_inputs.fields.get("t").unwrap().location(), Location::Corner);
    assert!(frame_inputs.fields.heights().is_none());
    assert_eq!(
        frame_inputs.setup.descriptions,
        ["q", "t", "speed"].map(|name| (name.to_owned(), described(name))).into()
    );
}

#[test]
fn a_2d_field_has_its_values_on_all_layers_and_is_shown_as_a_surface() {
    let mut model = Model::new();
    let cells = model.q.len() / LAYERS;
    let values: Vec<f64> = (0..cells).map(|cell| cell as f64 / cells as f64).collect();
    // As a model without columns would have it, the stride of the one layer means nothing.
    model.give("ps", &icoray_array { columns: cells as i64, layers: 1, column_stride: 1, ..centers(&values, LAYERS) });
    let volume = SCENE.replace("opacity = [[-1, 0.1], [1, 0.9]]", "");
    let shot = |text: &str| {
        let script = model.inputs.named(&Arc::new(Script::parse(text).unwrap()));
        let stamp = Stamp { step: 1, ..Stamp::default() };
        script.views()[0].shots(&stamp).next().unwrap()
    };
    let drawn = |text: &str| {
        let given = model.frame_inputs(shot(text).scene).unwrap();
        let FrameSetup { scene, grid, layers, .. } = &given.setup;
        let fields_2d = model.inputs.fields_2d(scene).join(", ");
        let renderer = Renderer::new(1).unwrap();
        (renderer.render(scene, grid, layers, given.fields).unwrap().pixels, fields_2d)
    };
    let (surface, fields_2d) = drawn(&volume.replace("\"q\"", "\"ps\""));
    assert_eq!(fields_2d, "ps");
    let color = "transfer = { map = \"viridis\", range = [-1, 1] }";
    let clear = "opacity = [[-1, 0.0], [1, 0.0]]";
    let explicit =
        format!("{}\n{clear}\n[[surfaces]]\nlayer = 0\nfield = \"ps\"\n{color}", volume.replace("\"q\"", "\"ps\""));
    assert!(surface == drawn(&explicit).0 && surface.iter().any(|pixel| pixel[3] > 0.9));
    // One with an opacity is a volume, as is one with layers.
    assert!(shot(&SCENE.replace("\"q\"", "\"ps\"")).scene.scenery.surfaces.is_empty());
    assert!(shot(&volume).scene.scenery.surfaces.is_empty());
    assert_eq!(drawn(SCENE).1, "");
}

#[test]
fn fields_of_one_scene_are_over_one_grid_and_its_layers() {
    let mut model = Model::new();
    let other = CString::new("other").unwrap();
    let q = centers(&model.q, LAYERS);
    let fit = |what: &str| {
        let message = format!("field \"r\": {what} \"other\", expected \"\" as of field \"q\" in the same scene");
        (icoray_status::ICORAY_ERR_FIELD, message)
    };
    model.give("r", &icoray_array { grid_name: other.as_ptr(), ..q });
    assert_eq!(model.refused(&scene(&["r"])), fit("grid"));
    model.give("r", &icoray_array { layers_name: other.as_ptr(), ..q });
    assert_eq!(model.refused(&scene(&["r"])), fit("layers"));
    // Other scenes have nothing to do with it.
    model.frame_inputs(scene(&["t"])).unwrap();
    let mut other_scene = scene(&[]);
    other_scene.volumes[0].field = "r".into();
    model.frame_inputs(other_scene).unwrap();
    model.inputs.heights = Some(ArrayInput::new(&icoray_array { grid_name: other.as_ptr(), ..q }, false).unwrap());
    model.frame_inputs(scene(&[])).unwrap();
    let mut native = scene(&[]);
    native.scenery.heights = Heights::Native;
    let message = "heights: grid \"other\", expected \"\" as of field \"q\" in the same scene";
    assert_eq!(model.refused(&native), (icoray_status::ICORAY_ERR_FIELD, message.into()));
}

#[test]
fn conditions_take_fields_of_the_grid_only() {
    let mut model = Model::new();
    assert!(model.inputs.condition_field("q").is_ok() && model.inputs.condition_field("t").is_ok());
    for (columns, why) in [(120, " (120 columns are the grid's edges: fields at edges are not drawn"), (41, "")] {
        let values = vec![1.0; columns * LAYERS];
        model.give("e", &centers(&values, LAYERS));
        let failure = model.inputs.condition_field("e").err().expect("a failure");
        let words =
            format!("field \"e\": bad field: {columns} columns, expected 42, one per cell or corner of the grid{why}");
        assert!(failure.message.starts_with(&words), "{}", failure.message);
        assert_eq!(failure.status, icoray_status::ICORAY_ERR_FIELD);
    }
}
