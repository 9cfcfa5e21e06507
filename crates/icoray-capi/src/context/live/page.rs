//! The page itself, on rank 0: its address, its scene, its questions.

use crate::boundary::{Failure, Outcome, caught};
use crate::context::inputs::Inputs;
use crate::context::viewer_message::ViewerMessage;
use crate::drawing::Drawing;
use crate::host::without_signals;
use icoray_core::output::{Stamp, printed_units};
use icoray_core::{Error, ErrorKind, Frame, Live, Result, Script};
use icoray_live::{
    Change, Description, FieldDescription, Histogram, LiveView, Options, PictureSize, Probe, Question, Reply,
    SharedSteered, Steered, steering_reader,
};
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, MutexGuard, PoisonError};

/// Name of the file with the page's address, in the output directory.
const ADDRESS: &str = "live.url";
/// Note of pictures whose scene a viewer has set: its revision.
const NOTE: &str = "live scene";

/// An open page.
pub(super) struct Page {
    view: Arc<LiveView>,
    address: PathBuf,
    steered: SharedSteered,
    /// What was taken and is not done yet: a call in which the ranks do not agree does nothing.
    change: Option<Change>,
    histograms: Vec<(String, Reply<Histogram>)>,
    probes: Vec<([f64; 2], Reply<Option<Probe>>)>,
}

impl Page {
    /// Serves the page and writes its address to a file that only the user can read.
    pub fn open(live: Live, text: &str, inputs: &Inputs, drawing: &Drawing) -> Outcome<Self> {
        let options = Options { port: live.port, size: PictureSize::Scene, is_framed: false };
        let fields = inputs.fields.keys().cloned().collect();
        let steered = SharedSteered::new(Steered { text: text.to_owned(), fields }.into());
        let reader = steering_reader(inputs.first.clone(), steered.clone());
        let view = without_signals(|| LiveView::open(&options, describe(inputs), (text.to_owned(), 0), reader))?;
        let address = drawing.directory().join(ADDRESS);
        written(&address, &view.address())?;
        let whole = view.address();
        let (place, _token) = whole.split_once('#').unwrap_or((&whole, ""));
        drawing.inform(&format!("live view at {place} of this machine; its whole address is in {}", address.display()));
        let view = Arc::new(view);
        let shows = Arc::downgrade(&view);
        drawing.pass_frames_on(Box::new(move |frame| {
            if let Some(view) = shows.upgrade() {
                let revision = revision_of(&frame);
                view.show(frame, revision);
            }
        }));
        let (change, histograms, probes) = (None, Vec::new(), Vec::new());
        Ok(Page { view, address, steered, change, histograms, probes })
    }

    fn steered(&self) -> MutexGuard<'_, Steered> {
        self.steered.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What viewers have sent and is not done yet.
    pub fn take(&mut self, inputs: &Inputs) -> ViewerMessage {
        let mut steered = self.steered();
        if steered.fields.len() != inputs.fields.len() {
            steered.fields.extend(inputs.fields.keys().cloned());
            self.view.describe(describe(inputs));
        }
        drop(steered);
        let taken = self.view.take();
        if let Some(new) = taken.change {
            let before = self.change.take().map_or(new.before, |known| known.before);
            self.change = Some(Change { before, ..new });
        }
        for question in taken.questions {
            match question {
                Question::Histogram { field, reply } => self.histograms.push((field, reply)),
                Question::Probe { at, reply } => self.probes.push((at, reply)),
                Question::Picture { reply, .. } => {
                    let shown = self.view.shown().map(|frame| Frame::clone(&frame));
                    reply.send(shown.ok_or_else(|| unanswered("no picture has been drawn yet")));
                }
            }
        }
        ViewerMessage {
            scene: self.change.as_ref().map(|change| change.text.clone()),
            histograms: self.histograms.iter().map(|(name, _)| name.clone()).collect(),
        }
    }

    /// All ranks have taken the scene that viewers have set, or none has. It is kept beside the pictures and named in the
    /// log.
    pub fn taken(&mut self, outcome: Outcome<()>, stamp: &Stamp, drawing: &mut Drawing) {
        let Some(change) = self.change.take() else { return };
        if let Err(failure) = outcome {
            drawing.warn(&format!("step {}: a viewer's scene cannot be drawn: {}", stamp.step, failure.message));
            self.view.refuse(&change, &failure.message);
            return;
        }
        drawing.set_note((NOTE, format!("{}, in {}", change.revision, Change::FILE)));
        let keys = change.keys().join(", ");
        drawing.inform(&format!("step {}: a viewer has set {keys}", stamp.step));
        if let Err(error) = change.keep(drawing.directory()) {
            drawing.warn(error.context());
        }
    }

    /// Answers the first request for the histogram of this field.
    pub fn answer_histogram(&mut self, name: &str, found: Outcome<icoray_core::Histogram>, inputs: &Inputs) {
        let Some(at) = self.histograms.iter().position(|(its, _)| its == name) else { return };
        let (_, reply) = self.histograms.remove(at);
        let histogram = found.map(|found| Histogram::new(name, units(inputs, name), found));
        reply.send(histogram.map_err(|failure| unanswered(&failure.message)));
    }

    /// Answers all probes from the data of this step.
    pub fn answer_probes(&mut self, script: &Script, stamp: &Stamp, inputs: &Inputs, drawing: &Drawing) {
        for (at, reply) in std::mem::take(&mut self.probes) {
            let found = caught(|| self.probe(at, script, stamp, inputs, drawing).map_err(Failure::from));
            reply.send(found.map_err(|failure| unanswered(&failure.message)));
        }
    }

    fn probe(
        &self,
        at: [f64; 2],
        script: &Script,
        stamp: &Stamp,
        inputs: &Inputs,
        drawing: &Drawing,
    ) -> Result<Option<Probe>> {
        let name = self.view.view();
        let view = script.views().iter().find(|view| view.name() == name);
        let shot = view.and_then(|view| view.shots(stamp).next()).ok_or_else(|| unanswered("the view is gone"))?;
        let given = inputs.frame_inputs(shot).map_err(|failure| unanswered(&failure.message))?;
        if given.held.is_some() {
            return Err(unanswered("a ray cannot be probed where each rank has its part of the grid"));
        }
        let found = drawing.renderer().probe(&given.scene, &given.grid, &given.layers, given.fields, at)?;
        let field = given.scene.field().to_owned();
        let units = units(inputs, &field);
        let shown = self.view.shown();
        let probe = |found| Probe::new(found, (field, units), at, shown.as_deref());
        Ok(found.map(|found| Probe { step: Some(stamp.step), ..probe(found) }))
    }

    /// Shows a scene that the model has set in place of what viewers have.
    pub fn load(&mut self, text: &str) {
        text.clone_into(&mut self.steered().text);
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
