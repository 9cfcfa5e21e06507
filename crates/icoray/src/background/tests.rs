//! Frames drawn from copies: equal pictures, and failures.

use super::*;
use crate::common::{Array, icosahedral};
use crate::fields::Fields;
use crate::ranks::Decomposition;
use icoray_grid::{Field, Grid, Layers, Location, Shape};
use icoray_output::Frame;
use icoray_output::writer::WriterOptions;
use icoray_scene::{Derivation, Heights, How, Scene, Volume};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::mpsc::channel;

const SCENE: &str = "
field = 'q'
exaggeration = 50
image = { width = 40, height = 30 }
camera = { lon = 20, lat = 30, distance = 3 }
transfer = { map = 'viridis', range = [-1, 1], opacity = [[-1, 0.1], [1, 0.9]] }
output = { file = '{step}.exr' }";

mod ranks;

/// All that frames need, with a grid that lives for ever as a model's does.
struct Fixture {
    renderer: Arc<Renderer>,
    writer: Arc<Writer>,
    scene: Arc<Scene>,
    grid: Arc<Grid<'static>>,
    layers: Arc<Layers>,
    folder: tempfile::TempDir,
}

impl Fixture {
    fn new() -> Self {
        let (_, grid) = icosahedral(3);
        let folder = tempfile::tempdir().unwrap();
        Fixture {
            renderer: Arc::new(Renderer::new(2).unwrap()),
            writer: Arc::new(Writer::new(WriterOptions::new(folder.path())).unwrap()),
            scene: Arc::new(Scene::parse(SCENE).unwrap()),
            grid: Arc::new(grid),
            layers: Arc::new(Layers::from_heights(&[0.0, 30e3, 90e3], 6.371e6).unwrap()),
            folder,
        }
    }

    fn background(&self) -> Background {
        Background::new(Arc::clone(&self.renderer), Arc::clone(&self.writer)).unwrap()
    }

    /// The same, with another function that draws.
    fn drawing<D>(&self, draw: D) -> Background
    where
        D: FnMut(&mut Ranks, FrameSetup, &Copies, Accepted) -> Result<(FrameReport, Option<Stamp>)> + Send + 'static,
    {
        Background::with(self.renderer.clone(), self.writer.clone(), Ranks::alone(), None, draw).unwrap()
    }

    fn setup(&self, step: i64) -> FrameSetup {
        FrameSetup {
            view: String::new(),
            scene: Arc::clone(&self.scene),
            grid: Arc::clone(&self.grid),
            decomposition: None,
            layers: Arc::clone(&self.layers),
            descriptions: BTreeMap::new(),
            stamp: Stamp { step, ..Stamp::default() },
            notes: Vec::new(),
        }
    }

    /// Submits the frame of a step alone.
    fn submit<'f>(&self, background: &mut Background, step: i64, fields: impl Into<Fields<'f>>) -> Result<Accepted> {
        submit(background, &mut Ranks::alone(), FrameInputs { setup: self.setup(step), fields: fields.into() })
    }

    /// Values of a step, in another layout at each.
    fn values(&self, step: i64) -> Array {
        let (columns, location) = match step {
            3 => (self.grid.triangles(), Location::Corner),
            _ => (self.grid.cells(), Location::Center),
        };
        let shape = if step == 2 { Shape::cell_fastest } else { Shape::level_fastest }(columns, 3);
        let value = |column: usize, layer: usize| ((3 * column + layer) as f64 * 0.01 * step as f64).sin();
        Array::new(shape, true, location, None, value)
    }

    /// Bytes of the values of a step.
    fn bytes(&self, step: i64) -> u64 {
        self.values(step).values.bytes() as u64
    }

    /// The field of a step, in memory that is never given back.
    fn field(&self, step: i64) -> Field<'static> {
        Box::leak(Box::new(self.values(step))).field()
    }

    fn draw(&self, field: &Field) -> Frame {
        self.renderer.render(&self.scene, &self.grid, &self.layers, field).unwrap()
    }
}

/// Submits one frame; the error is that for which it was refused.
fn submit(background: &mut Background, ranks: &mut Ranks, frame: FrameInputs) -> Result<Accepted> {
    let mut refused = Vec::new();
    let accepted = background.submit(ranks, vec![frame], &mut refused);
    refused.pop().map_or(accepted, |(_, error)| Err(error))
}

/// Red, green, blue, opacity of a picture on disk.
fn read(path: &Path) -> Vec<[f32; 4]> {
    image::open(path).unwrap().to_rgba32f().pixels().map(|p| p.0).collect()
}

#[test]
fn pictures_are_those_of_the_fields_when_they_were_handed_over() {
    let fixture = Fixture::new();
    let mut background = fixture.background();
    let mut expected = Vec::new();
    for step in 1..=4 {
        let mut array = fixture.values(step);
        expected.push(fixture.draw(&array.field()));
        let accepted = fixture.submit(&mut background, step, &array.field()).unwrap();
        assert_eq!(accepted.bytes_copied, fixture.bytes(step));
        assert!(accepted.copy_s > 0.0 && (step > 1 || accepted.waited_s == 0.0), "{accepted:?}");
        // The model computes on.
        array.fill(f64::NAN);
    }
    background.wait();
    assert_eq!(Arc::strong_count(&fixture.grid), 1, "the tables are the model's again");
    let drawn = background.take_outcomes().kept;
    fixture.writer.wait();
    assert_eq!((fixture.writer.take_outcomes().done(), drawn.len()), (4, 4));
    let report = std::fs::read_to_string(fixture.folder.path().join("report.csv")).unwrap();
    let mut lines = report.lines().map(|l| l.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap();
    for ((drawn, expected), line) in drawn.iter().zip(expected).zip(lines) {
        let step = drawn.stamp.step;
        assert!(read(&fixture.folder.path().join(format!("{step}.exr"))) == expected.pixels, "frame {step}");
        let report = drawn.result.as_ref().unwrap();
        assert_eq!((report.bytes_copied, expected.report.bytes_copied), (fixture.bytes(step), 0));
        assert_eq!((report.value_range, report.threads), (expected.report.value_range, 2));
        assert!(report.timing.copy_s > 0.0 && report.timing.render_s > 0.0);
        let cell = |column: &str| line[head.iter().position(|c| *c == column).unwrap()];
        assert_eq!(cell("step"), step.to_string());
        assert_eq!(cell("bytes_copied"), report.bytes_copied.to_string());
        let seconds: [f64; 2] = ["copy_s", "waited_s"].map(|column| cell(column).parse().unwrap());
        assert_eq!(seconds, [report.timing.copy_s, report.timing.waited_s]);
    }
}

#[test]
fn errors_of_a_frame_are_returned_at_once() {
    let fixture = Fixture::new();
    let mut background = fixture.background();
    let field = fixture.field(1);
    let few = Field::level_fastest(&[0.5; 15][..], 3, Location::Center).unwrap();
    assert_eq!(fixture.submit(&mut background, 1, &few).unwrap_err().kind(), ErrorKind::Field);
    fixture.submit(&mut background, 1, &field).unwrap();
    // Drawn, perhaps waiting to be written, perhaps written.
    assert_eq!(fixture.submit(&mut background, 1, &field).unwrap_err().kind(), ErrorKind::Exists);
    fixture.submit(&mut background, 2, &field).unwrap();
    background.wait();
    let steps: Vec<_> = background.take_outcomes().kept.iter().map(|d| d.stamp.step).collect();
    assert_eq!(steps, [1, 2]);
}

#[test]
fn a_frame_waits_for_the_one_before_and_a_panic_is_an_outcome() {
    let fixture = Fixture::new();
    let (gate, passed) = channel::<()>();
    let mut background = fixture.drawing(move |_, setup, copies, _| {
        passed.recv().unwrap();
        match setup.stamp.step {
            1 => panic!("bad luck"),
            2 => Err(Error::new(ErrorKind::Field, "no luck")),
            _ => Ok((FrameReport { missing_values: copies.bytes(), ..FrameReport::default() }, None)),
        }
    });
    let field = fixture.field(1);
    assert_eq!(fixture.submit(&mut background, 1, &field).unwrap().waited_s, 0.0);
    assert!(background.take_outcomes().kept.is_empty());
    for step in 2..=3 {
        gate.send(()).unwrap();
        assert!(fixture.submit(&mut background, step, &field).unwrap().waited_s > 0.0);
    }
    gate.send(()).unwrap();
    background.wait();
    background.wait();
    let outcomes = background.take_outcomes();
    let said: Vec<_> = outcomes.errors().map(ToString::to_string).collect();
    assert_eq!(said, ["internal error: bad luck", "bad field: no luck"]);
    assert_eq!(outcomes.kept[2].result.as_ref().unwrap().missing_values, fixture.bytes(1));
    assert_eq!(Arc::strong_count(&fixture.grid), 1, "a panic gives the tables back too");
    // The copy's memory came back from the thread, from a panic too, and serves the next one.
    assert_eq!(background.copies.bytes(), fixture.bytes(1));
}

/// A scene of three fields, one of them under a derived one, at the heights of their columns.
fn rich(scene: &Scene) -> Scene {
    let transfer = scene.volumes[0].transfer.clone();
    let volume = |field: &str| {
        let transfer = transfer.clone();
        Volume { field: field.into(), transfer, coloring: None, opacity: None }
    };
    let mut rich = scene.clone();
    let how = How::Magnitude(vec!["u".into(), "q".into()]);
    rich.scenery.derived = vec![Derivation { name: "speed".into(), how }];
    rich.volumes.extend([volume("speed"), volume("t")]);
    rich.scenery.heights = Heights::Native;
    rich
}

#[test]
fn all_that_a_scene_needs_is_copied_and_nothing_else() {
    let mut fixture = Fixture::new();
    fixture.scene = Arc::new(rich(&fixture.scene));
    let (sender, receiver) = channel();
    let mut background = fixture.drawing(move |_, _, copies, accepted| {
        let fields = copies.fields();
        let named = fields.iter().chain(fields.heights().map(|heights| ("heights", heights)));
        let seen = named.map(|(name, field)| (name.to_owned(), field.location(), field.range().0));
        sender.send((seen.collect::<Vec<_>>(), accepted.bytes_copied)).unwrap();
        Ok((FrameReport::default(), None))
    });
    let (cells, corners) = (fixture.grid.cells(), fixture.grid.triangles());
    for step in 1..=3 {
        let level = step as f64;
        let mut centers = Array::new(Shape::cell_fastest(cells, 3), true, Location::Center, None, |_, _| level);
        let mut at_corners = Array::new(Shape::level_fastest(corners, 3), false, Location::Corner, None, |_, _| -level);
        let (center, t) = (centers.field(), at_corners.field());
        let fields = Fields::new([("more", center), ("t", t), ("q", center), ("u", center)]).with_heights(center);
        fixture.submit(&mut background, step, fields).unwrap();
        // The model computes on.
        centers.fill(f64::NAN);
        at_corners.fill(f64::NAN);
        let center = |name: &str| (name.to_owned(), Location::Center, Some([level; 2]));
        let t = ("t".to_owned(), Location::Corner, Some([-level; 2]));
        let (seen, bytes) = receiver.recv().unwrap();
        assert_eq!(seen, [center("q"), center("u"), t, center("heights")]);
        assert_eq!(bytes, (3 * (3 * cells * 8) + 3 * corners * 4) as u64);
    }
}

#[test]
fn a_missing_field_is_an_error_at_once() {
    let mut fixture = Fixture::new();
    let field = fixture.field(1);
    fixture.scene = Arc::new(rich(&fixture.scene));
    let mut background = fixture.background();
    let mut refused = |fields: Fields| {
        let error = fixture.submit(&mut background, 1, fields).unwrap_err();
        (error.kind(), error.context().to_owned())
    };
    let two = Fields::new([("q", field), ("t", field)]);
    let lost = "the scene shows field \"u\", and there is [\"q\", \"t\"]";
    assert_eq!(refused(two.clone()), (ErrorKind::Scene, lost.into()));
    let all = || Fields::new(["q", "t", "u"].map(|name| (name, field)));
    let lost = "the scene has heights = \"native\", and no heights of columns are given";
    assert_eq!(refused(all()), (ErrorKind::Scene, lost.into()));
    assert_eq!(background.copies.bytes(), 0, "nothing is copied of what cannot be drawn");
}

#[test]
fn dropping_it_finishes_the_frame() {
    let fixture = Fixture::new();
    let field = fixture.field(1);
    let mut background = fixture.background();
    fixture.submit(&mut background, 1, &field).unwrap();
    drop(background);
    fixture.writer.wait();
    assert!(fixture.folder.path().join("1.exr").is_file());
}

#[test]
fn dropped_frames_of_the_writer_are_reported() {
    let fixture = Fixture::new();
    let field = fixture.field(1);
    let mut background = fixture.drawing(|_, setup, _, _| {
        Ok((FrameReport::default(), Some(Stamp { step: setup.stamp.step - 1, ..Stamp::default() })))
    });
    fixture.submit(&mut background, 8, &field).unwrap();
    background.wait();
    assert_eq!(background.take_outcomes().kept[0].dropped.as_ref().unwrap().step, 7);
}

/// Fields of a step are copied once for all of its frames, and an error of one does not prevent the others from being
/// drawn.
#[test]
fn frames_of_a_step_are_drawn_of_one_copy() {
    let fixture = Fixture::new();
    let field = fixture.field(1);
    let fields = || Fields::new(["q", "t", "u", "more"].map(|name| (name, field)));
    let frame = |shown: &str, file: &str| {
        let mut scene = (*fixture.scene).clone();
        scene.volumes[0].field = shown.into();
        scene.output.file = Scene::parse(&SCENE.replace("{step}", file)).unwrap().output.file;
        let setup = FrameSetup { scene: Arc::new(scene), ..fixture.setup(5) };
        FrameInputs { setup, fields: fields() }
    };
    let mut background = fixture.background();
    let frames = vec![frame("q", "a"), frame("lost", "b"), frame("t", "c"), frame("q", "d")];
    let mut refused = Vec::new();
    let accepted = background.submit(&mut Ranks::alone(), frames, &mut refused).unwrap();
    assert_eq!(accepted.bytes_copied, 2 * fixture.bytes(1));
    assert_eq!((refused.len(), refused[0].0, refused[0].1.kind()), (1, 1, ErrorKind::Scene));
    background.wait();
    fixture.writer.wait();
    for (file, there) in [("a", true), ("b", false), ("c", true), ("d", true)] {
        assert_eq!(fixture.folder.path().join(format!("{file}.exr")).is_file(), there, "{file}");
    }
    let drawn = background.take_outcomes().kept;
    let said: Vec<_> = drawn.iter().map(|d| (d.is_first, d.result.as_ref().unwrap().bytes_copied)).collect();
    assert_eq!(said, [(true, accepted.bytes_copied), (false, 0), (false, 0)]);
    // Names of the step before are taken; nothing is copied where nothing is left.
    let mut refused = Vec::new();
    let accepted = background.submit(&mut Ranks::alone(), vec![frame("q", "a")], &mut refused).unwrap();
    assert_eq!((accepted.bytes_copied, refused[0].1.kind()), (0, ErrorKind::Exists));
}
