//! Serves a page on which viewers look at a dataset.

use crate::dataset::Dataset;
use crate::drawing::{Drawing, NativeHeightCache};
use crate::field::FieldInfo;
use crate::layering::LayerSelection;
use crate::scene_fields::{Key, SceneFields};
use crate::series::Series;
use icoray::output::{Stamp, printed_units};
use icoray::{Error, ErrorKind, Field, Frame, Grid, Heights, Ranks, Renderer, Result, Scene, Script, View};
use icoray_live::{
    Description, FieldDescription, Histogram, LiveView, NamedScene, Probe, Question, Request, SceneReader,
};
use std::collections::BTreeMap;

/// The page's description of a dataset; `command` draws the same picture from a shell.
pub fn describe(dataset: &Dataset, command: String) -> Description {
    let fields = dataset.likely_fields().into_iter().map(|info| FieldDescription {
        name: info.name.clone(),
        long_name: info.description.long_name.clone(),
        units: units(info),
        layers: if info.is_2d() { 0 } else { info.layers },
    });
    let fields: Vec<FieldDescription> = fields.collect();
    let path = dataset.path();
    Description {
        title: path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        live: false,
        layers: fields.iter().map(|field| field.layers).max().unwrap_or(0),
        fields,
        times: dataset.times().iter().map(|date| date.clone().unwrap_or_default()).collect(),
        command,
    }
}

/// The typeset units of a field.
pub fn units(info: &FieldInfo) -> Option<String> {
    info.description.units.as_deref().and_then(printed_units)
}

/// Parses the text of scenes for a dataset: a scene without a field shows the likeliest one, and 2D fields are
/// surfaces.
pub fn reader(dataset: &Dataset) -> Box<SceneReader> {
    let first = dataset.first_field().map(|info| info.name.clone());
    let fields: Vec<FieldInfo> = dataset.fields().to_vec();
    Box::new(move |text| {
        let mut script = Script::parse(text)?;
        if script.lacks_field() {
            script.name_first_field(first.as_ref().map_err(Error::clone)?);
        }
        let info = |name: &str| fields.iter().find(|info| info.name == name);
        script.show_as_surfaces(|name| info(name).is_some_and(FieldInfo::is_2d));
        let scene_of = |view: &View| {
            let mut scenes = view.scenes();
            let (Some(scene), None) = (scenes.next(), scenes.next()) else {
                let why = "the scene file has a sweep, expected views that draw one picture each";
                return Err(Error::new(ErrorKind::Scene, why));
            };
            expect_fields(&scene, info)?;
            Ok(NamedScene { name: view.name().to_owned(), scene })
        };
        script.views().iter().map(scene_of).collect()
    })
}

/// Fails if the dataset lacks a field of the scene.
fn expect_fields<'f>(scene: &Scene, info: impl Fn(&str) -> Option<&'f FieldInfo>) -> Result<()> {
    match scene.model_fields().into_iter().find(|name| info(name).is_none()) {
        Some(name) => Err(Error::new(ErrorKind::Field, format!("{name}: there is no such field"))),
        None => Ok(()),
    }
}

/// A suggested scene from its first key on: the comment above describes this scene and time, which viewers change.
pub fn without_head(suggested: &str) -> &str {
    let mut text = suggested;
    while let Some((_, rest)) = text.split_once('\n').filter(|_| text.starts_with('#')) {
        text = rest;
    }
    text.trim_start()
}

/// Answers the page from a dataset, on the thread that calls [`Viewer::run`].
pub struct Viewer<'v> {
    dataset: &'v Dataset,
    renderer: &'v Renderer,
    grid: &'v Grid<'v>,
    layers_wanted: &'v LayerSelection,
    live: &'v LiveView,
    /// The last picture at rest, of its scene and time.
    at_rest: Option<(Scene, usize, Frame)>,
}

/// The data that requests share while they need the same.
struct Data<'d> {
    drawing: Drawing<'d>,
    fields: &'d BTreeMap<Key, Field<'d>>,
    heights: &'d NativeHeightCache,
    stamp: Stamp,
}

impl<'v> Viewer<'v> {
    /// A viewer of the dataset with this grid. Drawing ends early if the renderer has the page's [`LiveView::stop`].
    pub fn new(
        dataset: &'v Dataset,
        grid: &'v Grid<'v>,
        renderer: &'v Renderer,
        layers_wanted: &'v LayerSelection,
        live: &'v LiveView,
    ) -> Self {
        Viewer { dataset, renderer, grid, layers_wanted, live, at_rest: None }
    }

    /// Takes requests until there are no more.
    pub fn run(mut self) {
        let mut heights = NativeHeightCache::default();
        let mut next = self.live.next();
        while next.is_some() {
            if let Err(error) = self.serve(&mut next, &mut heights) {
                next.take().into_iter().for_each(|request| refuse(self.live, request, error.clone()));
                next = self.live.next();
            }
        }
    }

    /// Reads the data of the `next` request and serves it and the following ones that need no more; `next` is then the
    /// first that does.
    ///
    /// # Errors
    /// Those of reading, before any request is served.
    fn serve(&mut self, next: &mut Option<Request>, heights: &mut NativeHeightCache) -> Result<()> {
        let Viewer { dataset, grid, renderer, layers_wanted, live, .. } = *self;
        let Some((scene, time)) = next.as_ref().map(Request::scene) else { return Ok(()) };
        let scene = scene.clone();
        let script = Script::from(scene.clone());
        let scene_fields = SceneFields::new(dataset, &script, layers_wanted, grid.cells())?;
        let drawing = Drawing { scene_fields: &scene_fields, grid, renderer };
        let (dates, seconds) = (dataset.times(), dataset.seconds());
        let series = Series { script: &script, dates, times: vec![time], is_scheduled: false, seconds };
        let (_, read) = series.views_of(&scene_fields, renderer, time)?;
        heights.get_ready(&scene_fields, grid, renderer, std::iter::once(scene.clone()), time)?;
        let fields = read.borrowed()?;
        let data = Data { drawing, fields: &fields, heights, stamp: series.stamp(time) };
        let needs = Needs::of(&scene, &scene_fields).ok();
        while let Some(request) = next.take_if(|request| {
            let (scene, its_time) = request.scene();
            its_time == time && Needs::of(scene, &scene_fields).ok() == needs
        }) {
            self.answer(request, &data);
            *next = live.next();
        }
        Ok(())
    }

    fn answer(&mut self, request: Request, data: &Data) {
        match request {
            Request::Draw(wanted) => {
                // Viewers are shown the error.
                if let Ok(Some(frame)) = self.live.publish(&wanted, |scene| data.frame(scene)) {
                    self.at_rest = Some((wanted.scene, wanted.time, frame));
                }
            }
            Request::Answer { question, scene, time } => self.reply(question, &scene, time, data),
        }
    }

    fn reply(&self, question: Question, scene: &Scene, time: usize, data: &Data) {
        let at_rest = self.at_rest.as_ref().filter(|(its, at, _)| its == scene && *at == time);
        let known = at_rest.map(|(_, _, frame)| frame);
        match question {
            Question::Histogram { field, reply } => {
                let at = (self.dataset, time);
                reply.send(histogram(&field, at, self.layers_wanted, data.fields, self.renderer));
            }
            Question::Probe { at, reply } => {
                let from = (data.fields, data.heights);
                reply.send(probe((scene, at), self.dataset, &data.drawing, from, known));
            }
            Question::Look { look, reply } => {
                let Viewer { dataset, grid, renderer, layers_wanted, .. } = self;
                reply.send(dataset.completed_scene(grid, renderer, &look.completion(false), time, layers_wanted));
            }
            Question::Picture { reply, .. } => {
                reply.send(known.map_or_else(|| data.frame(scene), |frame| Ok(frame.clone())));
            }
        }
    }
}

impl Data<'_> {
    fn frame(&self, scene: &Scene) -> Result<Frame> {
        let frame = self.drawing.frame(scene, self.fields, self.heights, &mut Ranks::alone())?;
        let mut frame =
            frame.ok_or_else(|| Error::new(ErrorKind::Internal, "a picture without other ranks is at another rank"))?;
        frame.stamp = self.stamp.clone();
        Ok(frame)
    }
}

/// The layers, fields and heights that a scene needs.
#[derive(PartialEq)]
struct Needs {
    layering: [String; 2],
    fields: Vec<Key>,
    heights: Heights,
}

impl Needs {
    fn of(scene: &Scene, scene_fields: &SceneFields) -> Result<Self> {
        let layering = scene_fields.layering(scene)?.key().map(str::to_owned);
        let fields = scene_fields.of(scene)?.iter().map(|field| field.key()).collect();
        Ok(Needs { layering, fields, heights: scene.scenery.heights })
    }
}

/// Reports to viewers that a request cannot be served.
fn refuse(live: &LiveView, request: Request, error: Error) {
    match request {
        // The error is shown instead of the picture.
        Request::Draw(wanted) => drop(live.publish(&wanted, |_| Err(error))),
        Request::Answer { question, .. } => question.refuse(error),
    }
}

/// The histogram of a field at a time; the field is read unless `read` contains it.
///
/// # Errors
/// As [`Dataset::read_layers`] and [`Renderer::histogram`].
pub fn histogram(
    name: &str,
    (dataset, time): (&Dataset, usize),
    layers_wanted: &LayerSelection,
    read: &BTreeMap<Key, Field>,
    renderer: &Renderer,
) -> Result<Histogram> {
    let info = dataset.field_info(name)?;
    let counted = |field: &Field| renderer.histogram(&mut Ranks::alone(), field, None, Histogram::FINE_BINS);
    let found = match read.iter().find(|((known, _), _)| known == name) {
        Some((_, field)) => counted(field)?,
        None => counted(&dataset.read_layers(name, time, layers_wanted.of(info)?)?.field()?)?,
    };
    Ok(Histogram::new(name, units(info), found))
}

/// The probe of a ray of a scene's picture at a place; `shown` is that picture.
///
/// # Errors
/// As [`Drawing::fields`] and [`Renderer::probe`].
pub fn probe(
    (scene, at): (&Scene, [f64; 2]),
    dataset: &Dataset,
    drawing: &Drawing,
    (fields, heights): (&BTreeMap<Key, Field>, &NativeHeightCache),
    shown: Option<&Frame>,
) -> Result<Option<Probe>> {
    let layers = drawing.scene_fields.layers(scene)?;
    let given = drawing.fields(scene, fields, heights)?;
    let found = drawing.renderer.probe(scene, drawing.grid, layers, given, at)?;
    Ok(found.map(|found| {
        let units = dataset.field_info(&found.field).ok().and_then(units);
        Probe::new(found, units, at, shown)
    }))
}
