//! The page on rank 0: its address, its scene, and questions of viewers.

use super::time_budget::TimeBudget;
use crate::boundary::Outcome;
use crate::context::inputs::Inputs;
use crate::drawing::Drawing;
use crate::host::without_signals;
use crate::viewer_message::{LookRequest, ProbeRequest, ViewerMessage};
use icoray_core::output::{Stamp, printed_units};
use icoray_core::suggest::Suggestion;
use icoray_core::{Error, ErrorKind, Frame, Live, Result, Script};
use icoray_live::{
    Change, Description, FieldDescription, Histogram, LiveView, Look, Options, PictureSize, Probe, Question, Reply,
    SharedSteered, Steered, steering_reader,
};
use std::collections::BTreeMap;
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, MutexGuard, PoisonError};

/// Name of the file with the page's address, in the output directory.
const ADDRESS: &str = "live.url";
/// Note of pictures whose scene a viewer has set: its revision.
const NOTE: &str = "live scene";

pub(super) struct Page {
    view: Arc<LiveView>,
    address: PathBuf,
    steered: SharedSteered,
    budget: TimeBudget,
    /// The change that was taken and is not applied yet: a call in which the ranks do not agree applies none.
    change: Option<Change>,
    histograms: Vec<(String, Reply<Histogram>)>,
    looks: Vec<(Box<Look>, Reply<String>)>,
    probes: Vec<(ProbeRequest, Reply<Option<Probe>>)>,
}

impl Page {
    /// Serves the page and writes its address to a file that only the user can read.
    pub fn open(live: Live, text: &str, inputs: &Inputs, drawing: &mut Drawing) -> Outcome<Self> {
        let options = Options { port: live.port, size: PictureSize::Scene, is_framed: false };
        let fields = inputs.fields.keys().cloned().collect();
        let steered = SharedSteered::new(Steered { text: text.to_owned(), fields }.into());
        let reader = steering_reader(inputs.first.clone(), steered.clone());
        let view = without_signals(|| LiveView::open(&options, describe(inputs), text.to_owned(), 0, reader))?;
        let address = drawing.directory().join(ADDRESS);
        written(&address, &view.address())?;
        let whole = view.address();
        let (place, _token) = whole.split_once('#').unwrap_or((&whole, ""));
        drawing.warn(&format!("live view at {place} of this machine; its whole address is in {}", address.display()));
        let view = Arc::new(view);
        let shows = Arc::downgrade(&view);
        drawing.pass_frames_on(Some(Box::new(move |frame| {
            if let Some(view) = shows.upgrade() {
                let revision = revision_of(&frame);
                view.show(frame, revision);
            }
        })));
        let budget = TimeBudget::new(live.time_budget_ms);
        let (histograms, looks, probes) = (Vec::new(), Vec::new(), Vec::new());
        Ok(Page { view, address, steered, budget, change: None, histograms, looks, probes })
    }

    fn steered(&self) -> MutexGuard<'_, Steered> {
        self.steered.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts the time of pictures that were drawn; goes back to the model's own scene where viewers' takes too long.
    pub fn count_pictures(&mut self, drawing: &mut Drawing) {
        let mut ended = None;
        for picture in drawing.take_costs() {
            let step = picture.step;
            ended = ended.or(self.budget.count(picture).map(|why| (step, why)));
        }
        if let Some((step, why)) = ended {
            drawing.warn(&format!("step {step}: the viewers' scene takes too long: {why}"));
            let own = self.steered().text.clone();
            self.change = Some(self.view.refuse(&own, &why));
        }
    }

    /// Pending requests of viewers, while `script` of the text `current` is drawn: the scene and one question of each
    /// kind.
    pub fn take(&mut self, inputs: &Inputs, script: &Script, current: &str) -> ViewerMessage {
        let mut steered = self.steered();
        if steered.fields.len() != inputs.fields.len() {
            steered.fields.extend(inputs.fields.keys().cloned());
            self.view.describe(describe(inputs));
        }
        let own = steered.text.clone();
        drop(steered);
        let taken = self.view.take();
        if let Some(new) = taken.change {
            let before = self.change.take().map_or(new.before, |known| known.before);
            self.change = Some(Change { before, ..new });
        }
        for question in taken.questions {
            match question {
                Question::Histogram { field, reply } => self.histograms.push((field, reply)),
                Question::Look { look, reply } => self.looks.push((look, reply)),
                Question::Probe { at, reply } => {
                    self.probes.push((ProbeRequest { at, view: taken.view.clone() }, reply));
                }
                Question::Picture { reply, .. } => {
                    let shown = self.view.shown().map(|frame| Frame::clone(&frame));
                    reply.send(shown.ok_or_else(|| unanswered("no picture has been drawn yet")));
                }
            }
        }
        self.histograms.retain(|(_, reply)| !reply.is_gone());
        self.looks.retain(|(_, reply)| !reply.is_gone());
        self.probes.retain(|(_, reply)| !reply.is_gone());
        let scene = self.change.as_ref().map(|change| change.text.clone());
        let scene = scene.filter(|text| *text == own || self.budget.is_open());
        let is_own = scene.as_deref().unwrap_or(current) == own;
        ViewerMessage {
            scene,
            is_announced: false,
            budgets_ms: if is_own { BTreeMap::new() } else { self.budget.of_views(script) },
            histogram: self.histograms.first().map(|(name, _)| name.clone()),
            look: self.looks.first().map(|(look, _)| {
                let Look { text, view, field, .. } = &**look;
                LookRequest { text: text.clone(), view: view.clone(), field: field.clone() }
            }),
            probe: self.probes.first().map(|(request, _)| request.clone()),
        }
    }

    /// All ranks have taken the scene that viewers have set, or none has; `is_steered` where another scene than the
    /// model's own is drawn now. It is kept beside the pictures and named in the log.
    pub fn taken(&mut self, outcome: Outcome<()>, is_steered: bool, stamp: &Stamp, drawing: &mut Drawing) {
        let Some(change) = self.change.take() else { return };
        if let Err(failure) = outcome {
            drawing.warn(&format!("step {}: a viewer's scene cannot be drawn: {}", stamp.step, failure.message));
            self.view.refuse(&change.before, &failure.message);
            return;
        }
        self.budget.begin(is_steered, stamp.step);
        drawing.note = Some((NOTE, format!("{}, in {}", change.revision, Change::FILE)));
        let what = match is_steered {
            true => format!("a viewer has set {}", change.keys().join(", ")),
            false => "the model's own scene is drawn again".to_owned(),
        };
        drawing.warn(&format!("step {}: {what}", stamp.step));
        if let Err(error) = change.keep(drawing.directory()) {
            drawing.warn(error.context());
        }
    }

    /// Answers all who have asked for the histogram of this field.
    pub fn answer_histogram(&mut self, name: &str, found: Outcome<icoray_core::Histogram>, inputs: &Inputs) {
        let histogram = found.map(|found| Histogram::new(name, units(inputs, name), found));
        let histogram = histogram.map_err(|failure| unanswered(&failure.message));
        for (_, reply) in self.histograms.extract_if(.., |(its, _)| its == name) {
            reply.send(histogram.clone());
        }
    }

    /// Answers the first who has asked for the look of a field.
    pub fn answer_look(&mut self, found: Outcome<Option<Suggestion>>) {
        if self.looks.is_empty() {
            return;
        }
        let (look, reply) = self.looks.remove(0);
        let missing = || unanswered(&format!("{}: all values are missing, expected some to draw", look.field));
        let text = found.map_err(|failure| unanswered(&failure.message));
        reply.send(text.and_then(|found| found.map(|found| found.text).ok_or_else(missing)));
    }

    /// Answers the first probe.
    pub fn answer_probe(&mut self, found: Outcome<Option<icoray_core::Probe>>, stamp: &Stamp, inputs: &Inputs) {
        if self.probes.is_empty() {
            return;
        }
        let (ProbeRequest { at, .. }, reply) = self.probes.remove(0);
        let shown = self.view.shown();
        let answer = |found: icoray_core::Probe| {
            let units = units(inputs, &found.field);
            Probe { step: Some(stamp.step), ..Probe::new(found, units, at, shown.as_deref()) }
        };
        let probe = found.map(|found| found.map(answer));
        reply.send(probe.map_err(|failure| unanswered(&failure.message)));
    }

    /// Shows a scene that the model has set in place of what viewers have.
    pub fn load(&mut self, live: Live, text: &str, drawing: &mut Drawing) {
        text.clone_into(&mut self.steered().text);
        // Pictures of the scene before say nothing of this one.
        self.budget = TimeBudget::new(live.time_budget_ms);
        drawing.take_costs();
        // The reader refuses what a page cannot show; the scene is drawn all the same.
        let _ = self.view.load(text);
        let taken = self.view.take();
        self.change = None;
        for question in taken.questions {
            question.refuse(unanswered("the model has set another scene meanwhile; ask again"));
        }
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        // A file that is gone already is as good.
        let _ = fs::remove_file(&self.address);
    }
}

/// Why a question has no answer.
fn unanswered(why: &str) -> Error {
    Error::new(ErrorKind::Argument, why)
}

/// The revision of the scene from which a picture was drawn.
fn revision_of(frame: &Frame) -> u64 {
    let note = frame.notes.iter().find(|(key, _)| *key == NOTE);
    let digits = note.and_then(|(_, text)| text.split(',').next());
    digits.and_then(|digits| digits.parse().ok()).unwrap_or(1)
}

/// Writes a file that only this user can read, in place of one that an earlier run has left.
fn written(path: &Path, text: &str) -> Result<()> {
    let failed = |e: std::io::Error| Error::new(ErrorKind::Io, format!("{}: cannot be written: {e}", path.display()));
    // The first picture makes the directory otherwise.
    path.parent().map_or(Ok(()), fs::create_dir_all).map_err(failed)?;
    match fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(failed(error)),
        _ => (),
    }
    let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(path).map_err(failed)?;
    writeln!(file, "{text}").map_err(failed)
}

/// The page's description of the model.
fn describe(inputs: &Inputs) -> Description {
    let field = |name: &String| {
        let known = inputs.descriptions.get(name).cloned().unwrap_or_default();
        FieldDescription {
            name: name.clone(),
            long_name: known.long_name,
            units: units(inputs, name),
            layers: inputs.layers_of(name),
        }
    };
    let fields: Vec<FieldDescription> = inputs.fields.keys().map(field).collect();
    let program = std::env::current_exe().ok();
    let name = program.as_deref().and_then(Path::file_name);
    Description {
        title: name.map_or_else(|| "model".to_owned(), |name| name.to_string_lossy().into_owned()),
        live: true,
        layers: fields.iter().map(|field| field.layers).max().unwrap_or(0),
        fields,
        times: Vec::new(),
        command: String::new(),
    }
}

fn units(inputs: &Inputs, name: &str) -> Option<String> {
    inputs.descriptions.get(name)?.units.as_deref().and_then(printed_units)
}
