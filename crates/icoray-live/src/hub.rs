//! Connects the server, which answers viewers, and the thread that draws.

use crate::answers::{Histogram, Probe};
use crate::document;
use crate::picture::Picture;
use crate::session::Session;
use icoray::output::write_text;
use icoray::suggest::Completion;
use icoray::{Error, Frame, Lines, Scene};
use std::collections::VecDeque;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::{oneshot, watch};

/// Time budget in milliseconds of a frame while the user moves the picture: ten frames a second, and the rest for other
/// work.
const MOVING_MS: f64 = 80.0;
/// Maximum size of a picture while the user moves it, unless the page specifies another.
const MOVING_SIZE: [u32; 2] = [640, 480];
/// Pictures that take no longer than this (seconds) are drawn at rest at once.
const QUICK_S: f64 = 0.1;
/// Time after which the picture is refined although the user has not let go: the mouse may rest, or its page may be
/// closed.
const STILL: Duration = Duration::from_secs(1);
/// Maximum number of waiting questions.
const MAX_QUESTIONS: usize = 32;

/// A viewer's question about the data.
#[derive(Debug)]
pub enum Question {
    /// The histogram of a field at the displayed time.
    Histogram {
        /// Name of the field.
        field: String,
        /// Receives the answer.
        reply: Reply<Histogram>,
    },
    /// The probe of a ray of the picture, at a place from 0 to 1 from the left and from the top.
    Probe {
        /// The place.
        at: [f64; 2],
        /// Receives the answer.
        reply: Reply<Option<Probe>>,
    },
    /// The text of the scene in which the displayed view shows another field, with the look suggested for its values at
    /// the displayed time.
    Look {
        /// The field and the view.
        look: Box<Look>,
        /// Receives the answer.
        reply: Reply<String>,
    },
    /// The picture at rest, for a file.
    Picture {
        /// Number of the time, if not the displayed one.
        time: Option<usize>,
        /// Receives the answer.
        reply: Reply<Frame>,
    },
}

/// Another field in a view of a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Look {
    /// Name of the field.
    pub field: String,
    /// Name of the view; empty for a scene without views.
    pub view: String,
    /// The text of the scene.
    pub text: String,
}

impl Look {
    /// Converts to a completion, for a page whose viewers steer a program if it `is_steered`.
    pub fn completion(&self, is_steered: bool) -> Completion<'_> {
        Completion { text: &self.text, view: Some(&self.view), field: Some(&self.field), is_steered }
    }
}

/// Receives the answer to a question.
#[derive(Debug)]
pub struct Reply<T>(pub(crate) oneshot::Sender<icoray::Result<T>>);

impl<T> Reply<T> {
    /// Sends the answer; does nothing if the request has been dropped.
    pub fn send(self, answer: icoray::Result<T>) {
        // The request may have been dropped.
        let _ = self.0.send(answer);
    }

    /// Whether the request has been dropped.
    pub fn is_gone(&self) -> bool {
        self.0.is_closed()
    }
}

/// Changes and questions of viewers.
#[derive(Debug, Default)]
pub struct Taken {
    /// The scene, if it was changed.
    pub change: Option<Change>,
    /// Questions about the data.
    pub questions: Vec<Question>,
    /// The name of the displayed view; empty for a scene without views.
    pub view: String,
}

/// A change of the scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Number of the scene's state.
    pub revision: u64,
    /// The new text.
    pub text: String,
    /// The previous text.
    pub before: String,
}

impl Change {
    /// Name of the file beside the pictures in which a scene set by viewers is stored.
    pub const FILE: &str = "live.toml";

    /// Writes the text to [`Self::FILE`] in a directory, and replaces the previous one.
    ///
    /// # Errors
    /// [`Io`](icoray::ErrorKind::Io) names the file.
    pub fn keep(&self, directory: &Path) -> icoray::Result<()> {
        write_text(&directory.join(Self::FILE), "the viewers' scene", &self.text)
    }

    /// The keys in which the texts differ, as `camera.lon`.
    pub fn keys(&self) -> Vec<String> {
        document::differences(&self.before, &self.text)
    }
}

/// A picture to be drawn.
#[derive(Debug, Clone)]
pub struct DrawRequest {
    /// The scene with the size and time budget of the picture.
    pub scene: Scene,
    /// Number of the time.
    pub time: usize,
    /// Lines that the page draws over the picture.
    pub(crate) lines: Vec<Lines>,
    pub(crate) revision: u64,
    pub(crate) is_final: bool,
    pub(crate) is_moving: bool,
}

/// The next task of the drawing thread.
#[derive(Debug)]
pub enum Request {
    /// Draw a picture and publish it.
    Draw(Box<DrawRequest>),
    /// Answer a question about this scene at this time.
    Answer {
        /// The question.
        question: Question,
        /// The scene at rest.
        scene: Box<Scene>,
        /// Number of the time.
        time: usize,
    },
}

impl Request {
    /// The scene of the request, and the number of its time.
    pub fn scene(&self) -> (&Scene, usize) {
        match self {
            Request::Draw(wanted) => (&wanted.scene, wanted.time),
            Request::Answer { scene, time, .. } => (scene, *time),
        }
    }
}

impl Question {
    /// Replies with an error.
    pub fn refuse(self, error: Error) {
        match self {
            Question::Histogram { reply, .. } => reply.send(Err(error)),
            Question::Probe { reply, .. } => reply.send(Err(error)),
            Question::Look { reply, .. } => reply.send(Err(error)),
            Question::Picture { reply, .. } => reply.send(Err(error)),
        }
    }
}

/// The state that both threads share.
pub(crate) struct Hub {
    state: Mutex<State>,
    changed: Condvar,
    pub pictures: watch::Sender<Option<Arc<Picture>>>,
    /// Set when the picture at rest that is being drawn is out of date.
    pub stop: Arc<AtomicBool>,
    /// The last frame of a program that draws at its own times.
    pub shown: Mutex<Option<Arc<Frame>>>,
}

pub(crate) struct State {
    pub session: Session,
    questions: VecDeque<Question>,
    /// The text that [`Hub::take`] has returned.
    taken: String,
    /// Why the last change taken is not drawn, until a picture reports it.
    refusal: Option<String>,
    /// Revisions of the newest pictures: of any kind, and at rest.
    drawn: u64,
    at_rest: u64,
    /// Seconds of the last picture at rest.
    rest_s: f64,
    is_drawing_at_rest: bool,
    has_ended: bool,
}

impl Hub {
    pub fn new(session: Session) -> Self {
        let state = State {
            taken: session.text().to_owned(),
            refusal: None,
            session,
            questions: VecDeque::new(),
            drawn: 0,
            at_rest: 0,
            rest_s: f64::INFINITY,
            is_drawing_at_rest: false,
            has_ended: false,
        };
        Hub {
            state: Mutex::new(state),
            changed: Condvar::new(),
            pictures: watch::Sender::new(None),
            stop: Arc::default(),
            shown: Mutex::default(),
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Calls `look` with the session.
    pub fn look<R>(&self, look: impl FnOnce(&Session) -> R) -> R {
        look(&self.lock().session)
    }

    /// Changes the session; on success, a picture at rest that is being drawn is out of date.
    pub fn change(&self, change: impl FnOnce(&mut Session) -> Result<(), String>) -> Result<u64, String> {
        let mut state = self.lock();
        change(&mut state.session)?;
        self.wake(&state);
        Ok(state.session.revision())
    }

    /// Queues a question for the drawing thread; false if too many questions wait.
    pub fn ask(&self, question: Question) -> bool {
        let mut state = self.lock();
        if state.questions.len() >= MAX_QUESTIONS || state.has_ended {
            return false;
        }
        state.questions.push_back(question);
        self.wake(&state);
        true
    }

    fn wake(&self, state: &State) {
        self.stop.store(state.is_drawing_at_rest, Relaxed);
        self.changed.notify_all();
    }

    /// Ends [`Self::next`].
    pub fn end(&self) {
        let mut state = self.lock();
        state.has_ended = true;
        // Waiting requests get an error.
        state.questions.clear();
        self.wake(&state);
    }

    /// Waits for the next task; `None` at the end.
    pub fn next(&self) -> Option<Request> {
        let mut state = self.lock();
        loop {
            if state.has_ended {
                return None;
            }
            self.stop.store(false, Relaxed);
            if let Some(request) = state.next() {
                return Some(request);
            }
            state = if state.session.is_moving() {
                let waited = self.changed.wait_timeout(state, STILL).unwrap_or_else(PoisonError::into_inner);
                let (mut state, is_still) = (waited.0, waited.1.timed_out());
                if is_still {
                    state.session.hold_still();
                }
                state
            } else {
                self.changed.wait(state).unwrap_or_else(PoisonError::into_inner)
            };
        }
    }

    /// The changes and questions of viewers since the last call; none while one of them is being served.
    pub fn take(&self) -> Taken {
        let Ok(mut state) = self.state.try_lock() else { return Taken::default() };
        let revision = state.session.revision();
        let text = Some(state.session.text()).filter(|text| *text != state.taken).map(str::to_owned);
        let change =
            text.map(|text| Change { revision, before: std::mem::replace(&mut state.taken, text.clone()), text });
        let view = state.session.view().to_owned();
        Taken { change, questions: std::mem::take(&mut state.questions).into(), view }
    }

    /// Waits until [`Self::take`] has something to return, at most for this time.
    pub fn wait(&self, timeout: Duration) {
        let is_idle =
            |state: &mut State| state.questions.is_empty() && state.session.text() == state.taken && !state.has_ended;
        drop(self.changed.wait_timeout_while(self.lock(), timeout, is_idle));
    }

    /// Replaces the scene set by viewers by this one.
    pub fn refuse(&self, text: &str, why: &str) -> Change {
        let mut state = self.lock();
        state.refusal = Some(why.to_owned());
        let before = std::mem::replace(&mut state.taken, text.to_owned());
        // Later changes of viewers are dropped too. The text was read before.
        let _ = state.session.load(text);
        Change { revision: state.session.revision(), text: text.to_owned(), before }
    }

    pub fn take_refusal(&self) -> Option<String> {
        self.lock().refusal.take()
    }

    /// Records a drawn picture; true if it is to be shown, false if it was abandoned.
    pub fn drawn(&self, request: &DrawRequest, seconds: f64) -> bool {
        let mut state = self.lock();
        state.is_drawing_at_rest = false;
        if request.is_final && self.stop.load(Relaxed) {
            return false;
        }
        state.drawn = request.revision;
        if request.is_final {
            state.at_rest = request.revision;
            state.rest_s = seconds;
        }
        true
    }
}

impl State {
    fn next(&mut self) -> Option<Request> {
        let (session, time) = (&self.session, self.session.time());
        if let Some(question) = self.questions.pop_front() {
            let time = match question {
                Question::Picture { time: Some(time), .. } => time,
                _ => time,
            };
            return Some(Request::Answer { question, scene: Box::new(session.scene().clone()), time });
        }
        let (revision, is_moving) = (session.revision(), session.is_moving());
        let request = |scene, is_final| {
            let lines = if is_final { Vec::new() } else { session.lines_over() };
            Some(Request::Draw(Box::new(DrawRequest { scene, time, lines, revision, is_final, is_moving })))
        };
        let is_new = self.drawn < revision;
        if is_new && (is_moving || self.rest_s > QUICK_S) {
            return request(session.moving_scene(MOVING_MS, MOVING_SIZE), false);
        }
        if !is_moving && self.at_rest < revision {
            self.is_drawing_at_rest = true;
            return request(session.scene().clone(), true);
        }
        None
    }
}

#[cfg(test)]
mod hostile;
#[cfg(test)]
mod tests;
