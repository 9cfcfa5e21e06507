//! The page that follows a watch: it shows each picture, and the last time again where viewers change the scene.

use super::plan::Moment;
use icoray::{Frame, Result, Script};
use icoray_live::{
    Change, Description, FieldDescription, LiveView, Options, PictureSize, Question, SharedSteered, Steered,
    steering_reader,
};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, PoisonError};

pub struct Page {
    pub view: Arc<LiveView>,
    title: String,
    steered: SharedSteered,
    /// The revision of the scene that is drawn.
    revision: Arc<AtomicU64>,
    questions: Vec<Question>,
    /// A scene that was taken and has not been drawn yet.
    pub change: Option<Change>,
    /// The time that was drawn last.
    pub last: Option<Moment>,
}

impl Page {
    /// Serves the page for a directory.
    pub fn open(directory: &Path, port: Option<u16>, text: String, script: &Script) -> Result<Self> {
        let options = Options { port, size: PictureSize::Scene, is_framed: false };
        let fields = script.model_fields().into_iter().collect();
        let steered = SharedSteered::new(Steered { text: text.clone(), fields }.into());
        let title = directory.display().to_string();
        let description = describe(&title, script.model_fields());
        let reader = steering_reader(None, steered.clone());
        let view = Arc::new(LiveView::open(&options, description, text, 0, reader)?);
        let revision = Arc::new(AtomicU64::new(1));
        Ok(Page { view, title, steered, revision, questions: Vec::new(), change: None, last: None })
    }

    /// Takes the viewers' changes and questions; whether the last time is to be drawn for them again.
    pub fn hear(&mut self, fields: BTreeSet<String>) -> bool {
        let mut steered = self.steered.lock().unwrap_or_else(PoisonError::into_inner);
        if fields.iter().any(|name| !steered.fields.contains(name)) {
            steered.fields.extend(fields);
            self.view.describe(describe(&self.title, steered.fields.iter().cloned()));
        }
        // The page's thread holds its session while it reads what is locked here.
        drop(steered);
        let taken = self.view.take();
        self.questions.extend(taken.questions);
        if let Some(new) = taken.change {
            if self.last.is_some() {
                self.change = Some(new);
            } else {
                self.view.refuse(&new.before, "no time has been drawn yet");
            }
        }
        self.last.is_some() && (self.change.is_some() || !self.questions.is_empty())
    }

    /// The questions, to be answered from the last time.
    pub fn take_questions(&mut self) -> Vec<Question> {
        std::mem::take(&mut self.questions)
    }

    /// Names of the fields of the viewers' scene and questions.
    pub fn requested_fields(&self) -> Vec<String> {
        let of_questions = self.questions.iter().filter_map(|question| match question {
            Question::Histogram { field, .. } => Some(field.clone()),
            Question::Look { look, .. } => Some(look.field.clone()),
            _ => None,
        });
        let set = self.change.iter().filter_map(|change| Script::parse(&change.text).ok());
        of_questions.chain(set.flat_map(|script| script.model_fields())).collect()
    }

    /// The scene of the last change is drawn from now on.
    pub fn accept(&mut self) -> Option<Change> {
        let change = self.change.take()?;
        self.revision.store(change.revision, Relaxed);
        Some(change)
    }

    /// The scene of the last change cannot be drawn.
    pub fn refuse(&mut self, why: &str) {
        if let Some(change) = self.change.take() {
            self.view.refuse(&change.before, why);
        }
    }

    /// Shows a picture of the scene that is drawn.
    pub fn show(&self, frame: Frame) {
        self.view.show(frame, self.revision.load(Relaxed));
    }

    /// Shows pictures once they are written.
    pub fn shows(&self) -> Box<dyn FnMut(Frame) + Send> {
        let (view, revision) = (self.view.clone(), self.revision.clone());
        Box::new(move |frame| view.show(frame, revision.load(Relaxed)))
    }
}

fn describe(title: &str, fields: impl IntoIterator<Item = String>) -> Description {
    let field = |name: String| FieldDescription { name, ..FieldDescription::default() };
    let fields = fields.into_iter().map(field).collect();
    Description { title: title.to_owned(), live: true, fields, ..Description::default() }
}
