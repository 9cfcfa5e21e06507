//! Between the server, which answers viewers, and the thread that draws.

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

/// Milliseconds that a frame may take while a hand moves: ten frames a second, and what is left for the rest.
const MOVING_MS: f64 = 80.0;
/// Largest picture while a hand moves, unless the page names another.
const MOVING_SIZE: [u32; 2] = [640, 480];
/// Pictures that take no longer (seconds) are drawn at once as they are at rest.
const QUICK_S: f64 = 0.1;
/// How long a hand may stay still before the picture is refined all the same: it may hold, or its page may be gone.
const STILL: Duration = Duration::from_secs(1);
/// Most questions that wait.
const MAX_QUESTIONS: usize = 32;

/// What a viewer asks of the data.
#[derive(Debug)]
pub enum Question {
    /// The histogram of a field at the time that is shown.
    Histogram {
        /// Name of the field.
        field: String,
        /// Takes the answer.
        reply: Reply<Histogram>,
    },
    /// What a ray of the picture shows, at a place from 0 to 1 from the left and from the top.
    Probe {
        /// The place.
        at: [f64; 2],
        /// Takes the answer.
        reply: Reply<Option<Probe>>,
    },
    /// The text of the scene in which the view that is looked at shows another field, in the look that is suggested for
    /// its values at the time that is shown.
    Look {
        /// What is wanted.
        look: Box<Look>,
        /// Takes the answer.
        reply: Reply<String>,
    },
    /// The picture at rest, as it is written to a file.
    Picture {
        /// Number of the time, in place of the one that is shown.
        time: Option<usize>,
        /// Takes the answer.
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
    /// As a completion, for a page whose viewers steer a program if it `is_steered`.
    pub fn completion(&self, is_steered: bool) -> Completion<'_> {
        Completion { text: &self.text, view: Some(&self.view), field: Some(&self.field), is_steered }
    }
}

/// Takes the answer to a question.
#[derive(Debug)]
pub struct Reply<T>(pub(crate) oneshot::Sender<icoray::Result<T>>);

impl<T> Reply<T> {
    /// Gives the answer; does nothing if the request has been dropped.
    pub fn send(self, answer: icoray::Result<T>) {
        // Whoever asked may have gone.
        let _ = self.0.send(answer);
    }

    /// Whether the request has been dropped.
    pub fn is_gone(&self) -> bool {
        self.0.is_closed()
    }
}

/// What viewers have set and asked.
#[derive(Debug, Default)]
pub struct Taken {
    /// The scene, if it is another.
    pub change: Option<Change>,
    /// What is asked of the data.
    pub questions: Vec<Question>,
    /// The name of the view that is looked at; empty for a scene without views.
    pub view: String,
}

/// Another scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Number of the scene's state.
    pub revision: u64,
    /// The text that holds from now on.
    pub text: String,
    /// The text that held before.
    pub before: String,
}

impl Change {
    /// Name of the file in which a scene that viewers have set is kept beside the pictures.
    pub const FILE: &str = "live.toml";

    /// Writes the text to [`Self::FILE`] in a directory, in place of the one before.
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

/// A picture that is to be drawn.
#[derive(Debug, Clone)]
pub struct DrawRequest {
    /// The scene, of the size and within the time that it is to be drawn.
    pub scene: Scene,
    /// Number of the time.
    pub time: usize,
    /// Lines that the page draws over the picture.
    pub(crate) lines: Vec<Lines>,
    pub(crate) revision: u64,
    pub(crate) is_final: bool,
    pub(crate) is_moving: bool,
}

/// What the drawing thread is to do next.
#[derive(Debug)]
pub enum Request {
    /// Draw a picture and publish it.
    Draw(Box<DrawRequest>),
    /// Answer a question about this scene at this time.
    Answer {
        /// The question.
        question: Question,
        /// The scene as it is at rest.
        scene: Box<Scene>,
        /// Number of the time.
        time: usize,
    },
}

impl Request {
    /// The scene that the request is about, and the number of its time.
    pub fn scene(&self) -> (&Scene, usize) {
        match self {
            Request::Draw(wanted) => (&wanted.scene, wanted.time),
            Request::Answer { scene, time, .. } => (scene, *time),
        }
    }
}

impl Question {
    /// Answers with an error.
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
    /// Set where the picture at rest that is being drawn is out of date.
    pub stop: Arc<AtomicBool>,
    /// The last frame of a program that draws when it is time to.
    pub shown: Mutex<Option<Arc<Frame>>>,
}

pub(crate) struct State {
    pub session: Session,
    questions: VecDeque<Question>,
    /// The text that [`Hub::take`] has returned.
    taken: String,
    /// Why the last change that was taken is not drawn, until a picture says so.
    refusal: Option<String>,
    /// Revisions of the newest pictures: of any kind, and at rest.
    drawn: u64,
    at_rest: u64,
    /// Seconds that the last picture at rest took.
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

    /// What `look` sees of the session.
    pub fn look<R>(&self, look: impl FnOnce(&Session) -> R) -> R {
        look(&self.lock().session)
    }

    /// Changes the session; where that is done, a picture at rest that is being drawn is out of date.
    pub fn change(&self, change: impl FnOnce(&mut Session) -> Result<(), String>) -> Result<u64, String> {
        let mut state = self.lock();
        change(&mut state.session)?;
        self.wake(&state);
        Ok(state.session.revision())
    }

    /// Asks the drawing thread; false where too many questions wait.
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
        // Requests that wait get an error.
        state.questions.clear();
        self.wake(&state);
    }

    /// What is to be done next, which is waited for; `None` at the end.
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

    /// What viewers have set and asked since the last call; nothing while one of them is being served.
    pub fn take(&self) -> Taken {
        let Ok(mut state) = self.state.try_lock() else { return Taken::default() };
        let revision = state.session.revision();
        let text = Some(state.session.text()).filter(|text| *text != state.taken).map(str::to_owned);
        let change =
            text.map(|text| Change { revision, before: std::mem::replace(&mut state.taken, text.clone()), text });
        let view = state.session.view().to_owned();
        Taken { change, questions: std::mem::take(&mut state.questions).into(), view }
    }

    /// Waits until [`Self::take`] has something to return, at most so long.
    pub fn wait(&self, at_most: Duration) {
        let is_idle =
            |state: &mut State| state.questions.is_empty() && state.session.text() == state.taken && !state.has_ended;
        drop(self.changed.wait_timeout_while(self.lock(), at_most, is_idle));
    }

    /// Goes back to a scene from what viewers have set.
    pub fn refuse(&self, text: &str, why: &str) -> Change {
        let mut state = self.lock();
        state.refusal = Some(why.to_owned());
        let before = std::mem::replace(&mut state.taken, text.to_owned());
        // What viewers have set since then goes too. The text was read before.
        let _ = state.session.load(text);
        Change { revision: state.session.revision(), text: text.to_owned(), before }
    }

    pub fn take_refusal(&self) -> Option<String> {
        self.lock().refusal.take()
    }

    /// Notes a picture that was drawn; true if it is to be shown, false if it was given up.
    pub fn drawn(&self, request: &DrawRequest, seconds: f64) -> bool {
        let mut state = self.lock();
        state.is_drawing_at_rest = false;
        if request.is_final && self.stop.load(Relaxed) {
            return false;
        }
        state.drawn = request.revision;
        if request.is_final {
            (state.at_rest, state.rest_s) = (request.revision, seconds);
        }
        true
    }
}

impl State {
    fn next(&mut self) -> Option<Request> {
        let (session, time) = (&self.session, self.session.time());
        if let Some(question) = self.questions.pop_front() {
            let time = match question {
                Question::Picture { time: Some(asked), .. } => asked,
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
