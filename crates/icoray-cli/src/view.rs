//! `icoray view`: a page on which a file is looked at, turned and coloured.

mod rules;

use crate::failure::CommandResult;
use crate::render::{Drawing, FieldCache, Key, NativeHeightCache, SceneFields, Series};
use crate::selection::{Opened, Selection};
use crate::suggested;
use icoray::output::{Stamp, printed_units};
use icoray::{Error, ErrorKind, Field, Frame, Grid, Heights, Ranks, Result, Scene, Script};
use icoray_live::{Description, FieldDescription, Histogram, LiveView, Options, PictureSize, Probe, Question, Request};
use icoray_netcdf::FieldInfo;
use icoray_progress::Progress;
use std::collections::BTreeMap;
use std::io::Write;

/// What `icoray view` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    selection: Selection,
    /// Port on this machine's loopback address; another one if it is taken [default: 8750 or the next that is free]
    #[arg(long, value_name = "PORT", value_parser = clap::value_parser!(u16).range(1..))]
    port: Option<u16>,
}

/// Serves the page until the command is interrupted.
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    let progress = Progress::new();
    let selection = &args.selection;
    let Some(mut opened) = selection.open(&progress)? else {
        writeln!(out, "{}", selection.nothing())?;
        return Ok(());
    };
    let text = rules::text(selection, &opened, &progress)?;
    progress.stage("checking the grid");
    let grid = opened.renderer.run(|| opened.file.mesh().grid())?;
    progress.finish();
    let time = opened.times[opened.times.len() - 1];
    let reader = rules::reader(&opened.file);
    let is_suggested = selection.scene_options.scene.is_none();
    let size = match is_suggested && selection.overrides.size.is_none() {
        true => PictureSize::Viewer,
        false => PictureSize::SceneOrViewer,
    };
    let options = Options { port: args.port, size };
    let live = LiveView::open(&options, describe(selection, &opened), (text, time), reader)?;
    opened.renderer = opened.renderer.with_stop(live.stop());
    writeln!(out, "view      {}\n          ends with Ctrl-C", live.address())?;
    out.flush()?;
    Viewer { opened: &opened, selection, grid: &grid, live: &live, at_rest: None }.run();
    Ok(())
}

/// What the page is told of the file.
fn describe(selection: &Selection, opened: &Opened) -> Description {
    let file = &opened.file;
    let fields = file.likely_fields().into_iter().map(|info| FieldDescription {
        name: info.name.clone(),
        long_name: info.description.long_name.clone(),
        units: units(info),
        layers: if info.is_2d() { 0 } else { info.layers },
    });
    let fields: Vec<FieldDescription> = fields.collect();
    let path = file.path();
    Description {
        title: path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        live: false,
        layers: fields.iter().map(|field| field.layers).max().unwrap_or(0),
        fields,
        times: file.times().iter().map(|date| date.clone().unwrap_or_default()).collect(),
        command: suggested::command(selection, opened, None),
    }
}

/// The thread that has the file's data.
struct Viewer<'v> {
    opened: &'v Opened,
    selection: &'v Selection,
    grid: &'v Grid<'v>,
    live: &'v LiveView,
    /// The last picture at rest, of its scene and time.
    at_rest: Option<(Scene, usize, Frame)>,
}

/// What requests are answered from while they need the same data.
struct Data<'d> {
    drawing: Drawing<'d>,
    fields: &'d BTreeMap<Key, Field<'d>>,
    heights: &'d NativeHeightCache,
    stamp: Stamp,
}

impl Viewer<'_> {
    /// Takes requests until there are no more.
    fn run(mut self) {
        let mut heights = NativeHeightCache::default();
        let mut next = self.live.next();
        while let Some(request) = next {
            next = match self.serve(request, &mut heights) {
                Ok(next) => next,
                Err((request, error)) => {
                    refuse(self.live, request, error);
                    self.live.next()
                }
            };
        }
    }

    /// Reads what a request needs and serves it and all that follow and need no more; returns the first that does.
    fn serve(
        &mut self,
        first: Request,
        heights: &mut NativeHeightCache,
    ) -> std::result::Result<Option<Request>, (Request, Error)> {
        let (scene, time) = first.scene();
        let (scene, file, renderer) = (scene.clone(), &self.opened.file, &self.opened.renderer);
        let script = Script::from(scene.clone());
        let mut read = || {
            let scene_fields = SceneFields::new(file, &script, &self.selection.layers_wanted, self.grid.cells())?;
            let (dates, seconds) = (file.times(), file.seconds());
            let series = Series { script: &script, dates, times: vec![time], is_scheduled: false, seconds };
            let (_, read) = series.views_of(file, time, renderer, &scene_fields)?;
            let from = (file, self.grid, renderer);
            heights.get_ready(from, &scene_fields, std::iter::once(scene.clone()), time)?;
            Ok((series.stamp(time), scene_fields, read))
        };
        let (stamp, scene_fields, read) = match read() {
            Ok(read) => read,
            Err(error) => return Err((first, error)),
        };
        let fields = match FieldCache::borrowed(&read) {
            Ok(fields) => fields,
            Err(error) => return Err((first, error)),
        };
        let drawing = Drawing { scene_fields: &scene_fields, grid: self.grid, renderer };
        let data = Data { drawing, fields: &fields, heights, stamp };
        let needs = Needs::of(&scene, &scene_fields).ok();
        let mut request = first;
        loop {
            self.answer(request, &data);
            let Some(next) = self.live.next() else { return Ok(None) };
            let (scene, its_time) = next.scene();
            if its_time != time || Needs::of(scene, &scene_fields).ok() != needs {
                return Ok(Some(next));
            }
            request = next;
        }
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
            Question::Histogram { field, reply } => reply.send(self.histogram(&field, time, data)),
            Question::Probe { at, reply } => reply.send(self.probe(scene, at, known, data)),
            Question::Picture { reply, .. } => {
                reply.send(known.map_or_else(|| data.frame(scene), |frame| Ok(frame.clone())));
            }
        }
    }

    fn histogram(&self, name: &str, time: usize, data: &Data) -> Result<Histogram> {
        let file = &self.opened.file;
        let info = file.field_info(name)?;
        let units = units(info);
        let renderer = &self.opened.renderer;
        let counted = |field: &Field| renderer.histogram(&mut Ranks::alone(), field, None, Histogram::FINE_BINS);
        let found = match data.fields.iter().find(|((known, _), _)| known == name) {
            Some((_, field)) => counted(field)?,
            None => counted(&file.read_layers(name, time, self.selection.layers_wanted.of(info)?)?.field()?)?,
        };
        Ok(Histogram::new(name, units, found))
    }

    fn probe(&self, scene: &Scene, at: [f64; 2], shown: Option<&Frame>, data: &Data) -> Result<Option<Probe>> {
        let Data { drawing, fields, heights, .. } = data;
        let layers = drawing.scene_fields.layers(scene)?;
        let fields = drawing.fields(scene, fields, heights)?;
        let found = drawing.renderer.probe(scene, drawing.grid, layers, fields, at)?;
        let field = scene.field().to_owned();
        let units = self.opened.file.field_info(&field).ok().and_then(units);
        Ok(found.map(|found| Probe::new(found, (field, units), at, shown)))
    }
}

impl Data<'_> {
    fn frame(&self, scene: &Scene) -> Result<Frame> {
        let frame = self.drawing.frame(scene, self.fields, self.heights, &mut Ranks::alone())?;
        let mut frame = frame.ok_or_else(|| Error::new(ErrorKind::Internal, "who draws alone is rank 0"))?;
        frame.stamp = self.stamp.clone();
        Ok(frame)
    }
}

/// The units of a field, as print has them.
fn units(info: &FieldInfo) -> Option<String> {
    info.description.units.as_deref().and_then(printed_units)
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

/// Tells viewers that a request cannot be served.
fn refuse(live: &LiveView, request: Request, error: Error) {
    match request {
        // The error is shown in place of the picture.
        Request::Draw(wanted) => drop(live.publish(&wanted, |_| Err(error))),
        Request::Answer { question, .. } => question.refuse(error),
    }
}
