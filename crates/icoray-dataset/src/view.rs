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
            if let Some(name) = scene.model_fields().into_iter().find(|name| info(name).is_none()) {
                return Err(Error::new(ErrorKind::Field, format!("{name}: there is no such field")));
            }
            Ok(NamedScene { name: view.name().to_owned(), scene })
        };
        script.views().iter().map(scene_of).collect()
    })
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

/// The data of one time, from which its pictures are drawn and questions about it are answered.
pub struct Data<'d> {
    /// What draws the scenes.
    pub drawing: Drawing<'d>,
    /// The fields that the scenes need.
    pub fields: &'d BTreeMap<Key, Field<'d>>,
    /// The heights that the scenes need.
    pub heights: &'d NativeHeightCache,
    /// The time.
    pub time: usize,
    /// The stamp of the time.
    pub stamp: Stamp,
    /// Whether viewers steer a program.
    pub is_steered: bool,
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
        let scene_fields = SceneFields::new(dataset, &script, layers_wanted)?;
        let drawing = Drawing { scene_fields: &scene_fields, grid, renderer };
        let series = Series::of(dataset, &script, vec![time], false);
        let (_, read) = series.views_of(drawing, time)?;
        heights.get_ready(drawing, std::iter::once(scene.clone()), time)?;
        let fields = read.borrowed()?;
        let stamp = series.stamp(time);
        let data = Data { drawing, fields: &fields, heights, time, stamp, is_steered: false };
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
            Request::Answer { question, scene, time } => {
                let at_rest = self.at_rest.as_ref().filter(|(its, at, _)| *its == *scene && *at == time);
                data.answer(question, &scene, at_rest.map(|(_, _, frame)| frame));
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

    /// Answers a question about a scene; `shown` is its picture, if it is known.
    pub fn answer(&self, question: Question, scene: &Scene, shown: Option<&Frame>) {
        let Drawing { scene_fields, grid, renderer } = self.drawing;
        match question {
            Question::Histogram { field, reply } => reply.send(self.histogram(&field)),
            Question::Probe { at, reply } => reply.send(self.probe(scene, at, shown)),
            Question::Look { look, reply } => {
                let SceneFields { dataset, layers_wanted, .. } = scene_fields;
                let look = look.completion(self.is_steered);
                reply.send(dataset.completed_scene(grid, renderer, &look, self.time, layers_wanted));
            }
            Question::Picture { reply, .. } => {
                reply.send(shown.map_or_else(|| self.frame(scene), |frame| Ok(frame.clone())));
            }
        }
    }

    /// The histogram of a field, which is read unless the scenes need it.
    fn histogram(&self, name: &str) -> Result<Histogram> {
        let Drawing { scene_fields, renderer, .. } = self.drawing;
        let SceneFields { dataset, layers_wanted, .. } = scene_fields;
        let info = dataset.field_info(name)?;
        let counted = |field: &Field| renderer.histogram(&mut Ranks::alone(), field, None, Histogram::FINE_BINS);
        let found = match self.fields.iter().find(|((known, _), _)| known == name) {
            Some((_, field)) => counted(field)?,
            None => counted(&dataset.read_layers(name, self.time, layers_wanted.of(info)?)?.field()?)?,
        };
        Ok(Histogram::new(name, units(info), found))
    }

    /// The probe of a ray of a scene's picture at a place; `shown` is that picture.
    fn probe(&self, scene: &Scene, at: [f64; 2], shown: Option<&Frame>) -> Result<Option<Probe>> {
        let Drawing { scene_fields, grid, renderer } = self.drawing;
        let given = self.drawing.fields(scene, self.fields, self.heights)?;
        let found = renderer.probe(scene, grid, scene_fields.layers(scene)?, given, at)?;
        Ok(found.map(|found| {
            let units = scene_fields.dataset.field_info(&found.field).ok().and_then(units);
            Probe::new(found, units, at, shown)
        }))
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
