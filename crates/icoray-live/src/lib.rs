//! Interactive pictures: a page that shows a renderer's pictures and changes its scene.
//!
//! A [`LiveView`] serves one page to browsers on this machine. Viewers change the text of a scene (`document.rs`),
//! which all of them share (`session.rs`). The program that has the data takes requests one by one, draws pictures and
//! answers questions (`hub.rs`); it decides on which thread and when. Out-of-date pictures are abandoned, never queued.
//! A program that draws at its own times, such as a running model, takes the viewers' changes ([`LiveView::take`]) and
//! shows its pictures ([`LiveView::show`]), and never waits for viewers.
//!
//! ```no_run
//! use icoray_live::{Description, LiveView, NamedScene, Options, Request};
//! use icoray::{Renderer, Scene};
//!
//! # fn draw(_: &Renderer, _: &Scene) -> icoray::Result<icoray::Frame> { unimplemented!() }
//! let text = "field = 'theta'".to_owned();
//! let read = |text: &str| Ok(vec![NamedScene { name: String::new(), scene: Scene::parse(text)? }]);
//! let live = LiveView::open(&Options::default(), Description::default(), text, 0, Box::new(read))?;
//! let renderer = Renderer::new(0)?.with_stop(live.stop());
//! println!("{}", live.address());
//! while let Some(request) = live.next() {
//!     match request {
//!         Request::Draw(wanted) => drop(live.publish(&wanted, |scene| draw(&renderer, scene))),
//!         Request::Answer { .. } => (),
//!     }
//! }
//! # Ok::<(), icoray::Error>(())
//! ```
#![forbid(unsafe_code)]

mod answers;
mod api;
mod describe;
mod document;
mod guard;
mod hub;
mod page;
mod picture;
mod server;
mod session;
mod steering;

pub use answers::{Histogram, Probe};
pub use describe::{Description, FieldDescription};
pub use hub::{Change, DrawRequest, Look, Question, Reply, Request, Taken};
pub use session::{NamedScene, PictureSize, SceneReader};
pub use steering::{SharedSteered, Steered, steering_reader};

use api::Api;
use hub::Hub;
use icoray::{Error, ErrorKind, Frame, Result, Scene};
use picture::Picture;
use server::Server;
use session::{Session, Start};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Options of serving the page.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The port on this machine's loopback address; another one if it is taken, and any if it is `None`.
    pub port: Option<u16>,
    /// Source of the size of pictures.
    pub size: PictureSize,
    /// Whether pages of this machine, such as a notebook's, may show the page in a frame.
    pub is_framed: bool,
}

/// A served page, until this is dropped.
pub struct LiveView {
    hub: Arc<Hub>,
    server: Server,
    description: Arc<Mutex<Description>>,
    token: String,
    numbers: AtomicU64,
}

impl LiveView {
    /// Serves a page with the scene of `text` at the time of number `time`. `read` parses texts into scenes.
    ///
    /// # Errors
    /// Those of `read` for the text, and [`ErrorKind::Io`] if no port is free.
    pub fn open(
        options: &Options,
        description: Description,
        text: String,
        time: usize,
        read: Box<SceneReader>,
    ) -> Result<Self> {
        let start = Start { text, time, times: description.times.len(), size: options.size };
        let (hub, token) = (Arc::new(Hub::new(Session::new(start, read)?)), token()?);
        let description = Arc::new(Mutex::new(description));
        let api = Api {
            hub: hub.clone(),
            description: description.clone(),
            token: token.clone(),
            is_framed: options.is_framed,
        };
        let server = Server::start(options.port, api)?;
        Ok(LiveView { hub, server, description, token, numbers: AtomicU64::new(0) })
    }

    /// Replaces the description of the data; pages read it when they are opened.
    pub fn describe(&self, description: Description) {
        *self.description.lock().unwrap_or_else(PoisonError::into_inner) = description;
    }

    /// The address of the page, with the token that every request needs.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/#{}", self.server.port, self.token)
    }

    /// Set while the picture that is being drawn is out of date, for
    /// [`Renderer::with_stop`](icoray::Renderer::with_stop).
    pub fn stop(&self) -> Arc<AtomicBool> {
        self.hub.stop.clone()
    }

    /// Waits for the next task; `None` once [`Self::end`] was called.
    pub fn next(&self) -> Option<Request> {
        self.hub.next()
    }

    /// Makes [`Self::next`] return `None`, and refuses further questions.
    pub fn end(&self) {
        self.hub.end();
    }

    /// Draws a requested picture and shows it, or the error. Returns the picture at rest, if it is one.
    ///
    /// # Errors
    /// Those of `draw`; viewers see them, and [`Self::next`] continues.
    pub fn publish(&self, request: &DrawRequest, draw: impl FnOnce(&Scene) -> Result<Frame>) -> Result<Option<Frame>> {
        let start = Instant::now();
        let drawn = draw(&request.scene);
        let seconds = start.elapsed().as_secs_f64();
        if !self.hub.drawn(request, seconds) {
            return Ok(None);
        }
        let number = self.next_number();
        let picture = match &drawn {
            Ok(frame) => Picture::new(number, frame.clone(), request, seconds),
            Err(error) => Picture::failed(number, request, error),
        };
        self.hub.pictures.send_replace(Some(Arc::new(picture)));
        drawn.map(|frame| Some(frame).filter(|_| request.is_final))
    }

    fn next_number(&self) -> u64 {
        self.numbers.fetch_add(1, Relaxed) + 1
    }

    /// The changes and questions of viewers since the last call, for a program that draws at its own times. Does not
    /// wait.
    pub fn take(&self) -> Taken {
        self.hub.take()
    }

    /// Waits until viewers have made changes or questions that [`Self::take`] has not returned, at most for this time.
    pub fn wait(&self, timeout: Duration) {
        self.hub.wait(timeout);
    }

    /// Shows a picture that the program has drawn of the displayed view, from the scene of this revision; pictures of
    /// other views are not shown.
    pub fn show(&self, frame: Frame, revision: u64) {
        let view = frame.notes.iter().find(|(key, _)| *key == "view").map_or("", |(_, name)| name.as_str());
        if self.hub.look(|session| session.view() != view) {
            return;
        }
        let frame = Arc::new(frame);
        let picture = Picture::of_step(self.next_number(), frame.clone(), revision, self.hub.take_refusal());
        *self.hub.shown.lock().unwrap_or_else(PoisonError::into_inner) = Some(frame);
        self.hub.pictures.send_replace(Some(Arc::new(picture)));
    }

    /// Replaces the viewers' scene, which cannot be drawn, by one that can; the next picture states why. Returns the
    /// change, which [`Self::take`] does not.
    pub fn refuse(&self, text: &str, why: &str) -> Change {
        self.hub.refuse(text, why)
    }

    /// The last picture that [`Self::show`] has shown.
    pub fn shown(&self) -> Option<Arc<Frame>> {
        self.hub.shown.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Loads the text of another scene from the program, as if a viewer had loaded it.
    ///
    /// # Errors
    /// A sentence that names the key and the expected value.
    pub fn load(&self, text: &str) -> std::result::Result<(), String> {
        self.hub.change(|session| session.load(text)).map(|_| ())
    }

    /// The text of the scene with the viewers' changes.
    pub fn scene_text(&self) -> String {
        self.hub.look(|session| session.text().to_owned())
    }

    /// The name of the displayed view; empty for a scene without views.
    pub fn view(&self) -> String {
        self.hub.look(|session| session.view().to_owned())
    }
}

impl Drop for LiveView {
    /// Ends the answering of questions.
    fn drop(&mut self) {
        self.hub.end();
    }
}

/// 128 random bits, as hexadecimal digits.
fn token() -> Result<String> {
    let mut bytes = [0u8; 16];
    let failed = |e| Error::new(ErrorKind::Io, format!("cannot read random numbers for the live view's token: {e}"));
    getrandom::fill(&mut bytes).map_err(failed)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
