//! Answers the requests of the page.

use crate::describe::{Description, hex};
use crate::hub::{Hub, Look, Question, Reply};
use crate::picture::Picture;
use crate::session::{ChangeRequest, Session};
use crate::{guard, page};
use http_body_util::{BodyExt, Full, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::header::{self, HeaderValue};
use hyper::{Method, Request, Response, StatusCode};
use icoray::output::{exr_bytes, png_bytes};
use icoray::{Frame, Scene, coast_runs, did_you_mean, srgb8};
use serde::Serialize;
use serde_json::json;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::oneshot;
use tokio::time::timeout;

/// Largest body of a request, bytes: a scene with many knots is far smaller.
const MAX_BODY: usize = 1 << 20;
/// Time limit for a request to arrive.
const ARRIVES: Duration = Duration::from_secs(10);
/// Time for which a request waits for the next picture.
const NEXT_PICTURE: Duration = Duration::from_secs(20);
/// Time for which a question waits for its answer: a picture at rest of a large grid may take long.
const ANSWER: Duration = Duration::from_secs(600);

macro_rules! policy {
    ($frames:literal) => {
        concat!(
            "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; ",
            "base-uri 'none'; form-action 'none'; frame-ancestors ",
            $frames
        )
    };
}

/// Sources that the page may load. No site may show it in a frame, so that nothing can be laid over it.
const UNFRAMED: &str = policy!("'none'");
/// As [`UNFRAMED`], but for pages of this machine.
const FRAMED: &str = policy!("'self' http://localhost:* http://127.0.0.1:* vscode-webview:");

/// The data from which requests are answered.
pub(crate) struct Api {
    pub hub: Arc<Hub>,
    pub description: Arc<Mutex<Description>>,
    pub token: String,
    pub is_framed: bool,
}

pub(crate) type Answer = Response<Full<Bytes>>;

/// A refusal: a status and a sentence.
struct Refusal(StatusCode, String);

type Outcome = Result<Answer, Refusal>;

impl Api {
    /// Answers a request.
    pub async fn answer(&self, request: Request<Incoming>) -> Answer {
        let mut answer = match self.dispatch(request).await {
            Ok(answer) => answer,
            Err(Refusal(status, error)) => with_status(status, json_answer(&json!({ "error": error }))),
        };
        for (name, value) in [
            (header::CACHE_CONTROL, "no-store"),
            (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
            (header::REFERRER_POLICY, "no-referrer"),
            (header::CONTENT_SECURITY_POLICY, if self.is_framed { FRAMED } else { UNFRAMED }),
        ] {
            answer.headers_mut().insert(name, HeaderValue::from_static(value));
        }
        answer
    }

    async fn dispatch(&self, request: Request<Incoming>) -> Outcome {
        if !guard::is_local(request.headers()) {
            let why = "expected a request from this machine to localhost or 127.0.0.1";
            return Err(Refusal(StatusCode::FORBIDDEN, why.to_owned()));
        }
        let path = request.uri().path().to_owned();
        let Some(call) = path.strip_prefix("/api/") else {
            return match (page::file(&path), request.method()) {
                (Some(file), &Method::GET) => Ok(typed(file.media_type(), Bytes::from_static(file.bytes))),
                (Some(_), _) => Err(wrong_method()),
                (None, _) => Err(nothing_here()),
            };
        };
        if !guard::has_token(request.headers(), &self.token) {
            let why = "the address lacks its token, which is behind the # of the address that was printed";
            return Err(Refusal(StatusCode::UNAUTHORIZED, why.to_owned()));
        }
        let query = request.uri().query().unwrap_or_default().to_owned();
        match (call, request.method()) {
            ("describe", &Method::GET) => Ok(json_answer(&self.description().answer())),
            ("scene", &Method::GET) => Ok(json_answer(&self.hub.look(|session| self.scene(session)))),
            ("coast", &Method::GET) => Ok(typed("application/octet-stream", Bytes::from_static(coast_runs()))),
            ("frame", &Method::GET) => self.frame(&query).await,
            ("histogram", &Method::GET) => self.histogram(&query).await,
            ("probe", &Method::GET) => self.probe(&query).await,
            ("picture", &Method::GET) => self.picture(&query).await,
            ("look", &Method::POST) => self.look(&query).await,
            ("change", &Method::POST) => {
                let change: ChangeRequest = serde_json::from_slice(&body(request).await?).map_err(bad)?;
                self.changed(|session| session.change(&change))
            }
            ("load", &Method::POST) => {
                let text = String::from_utf8(body(request).await?.into()).map_err(bad)?;
                self.changed(|session| session.load(&text))
            }
            ("undo", &Method::POST) => self.changed(|session| session.step(true)),
            ("redo", &Method::POST) => self.changed(|session| session.step(false)),
            (
                "describe" | "scene" | "coast" | "frame" | "histogram" | "probe" | "picture" | "look" | "change"
                | "load" | "undo" | "redo",
                _,
            ) => Err(wrong_method()),
            _ => Err(nothing_here()),
        }
    }

    fn changed(&self, change: impl FnOnce(&mut Session) -> Result<(), String>) -> Outcome {
        let revision = self.hub.change(change).map_err(bad)?;
        Ok(json_answer(&json!({ "revision": revision })))
    }

    /// The scene in all its forms.
    fn scene(&self, session: &Session) -> serde_json::Value {
        let scene = session.scene();
        let ([forward, _, up], half_height) = scene.camera.frame();
        let eye = scene.camera.eye();
        let target = [0, 1, 2].map(|k: usize| eye[k] + forward[k]);
        let [can_undo, can_redo] = session.history();
        let picture = self.hub.pictures.borrow().clone();
        json!({
            "revision": session.revision(),
            "text": session.text(),
            "values": session.values(),
            "view": session.view(),
            "views": session.views(),
            "time": session.time(),
            "camera": {
                "eye": eye,
                "target": target,
                "up": up,
                "fov": 2.0 * half_height.atan().to_degrees(),
            },
            "field": scene.field(),
            "transfer": transfer(scene, picture.and_then(|picture| picture.color_range)),
            "command": self.command(session),
            "can_undo": can_undo,
            "can_redo": can_redo,
        })
    }

    fn description(&self) -> MutexGuard<'_, Description> {
        self.description.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The command that draws the scene; empty for a running model, whose scene file replaces it.
    fn command(&self, session: &Session) -> String {
        self.description().command.replace("{time}", &session.time().to_string())
    }

    /// The next picture after the given one, as soon as there is one.
    async fn frame(&self, query: &str) -> Outcome {
        let after: u64 = number(query, "after")?;
        // The page's canvas.
        let room = number(query, "width").ok().zip(number(query, "height").ok()).map(<[f64; 2]>::from);
        let mut pictures = self.hub.pictures.subscribe();
        let is_next = |picture: &Option<Arc<Picture>>| picture.as_ref().is_some_and(|picture| picture.number > after);
        match timeout(NEXT_PICTURE, pictures.wait_for(is_next)).await {
            Ok(Ok(picture)) => {
                let bytes = picture.as_ref().map(|picture| picture.bytes(room));
                Ok(typed("application/octet-stream", bytes.unwrap_or_default()))
            }
            _ => Ok(with_status(StatusCode::NO_CONTENT, Answer::default())),
        }
    }

    async fn histogram(&self, query: &str) -> Outcome {
        let field = parameter(query, "field").ok_or_else(|| missing("field"))?;
        let histogram = self.ask(|reply| Question::Histogram { field, reply }).await?;
        Ok(json_answer(&histogram))
    }

    async fn probe(&self, query: &str) -> Outcome {
        let at = [number(query, "x")?, number(query, "y")?];
        if !at.iter().all(|place: &f64| (0.0..=1.0).contains(place)) {
            return Err(bad(format!("x = {}, y = {}, expected 0 to 1", at[0], at[1])));
        }
        let probe = self.ask(|reply| Question::Probe { at, reply }).await?;
        Ok(json_answer(&probe.map_or_else(|| json!({ "hit": false }), |probe| probe.answer())))
    }

    /// Shows another field with its suggested look.
    async fn look(&self, query: &str) -> Outcome {
        let field = parameter(query, "field").ok_or_else(|| missing("field"))?;
        let names: Vec<String> = self.description().fields.iter().map(|field| field.name.clone()).collect();
        if !names.contains(&field) {
            let hint = did_you_mean(&field, names.iter().map(String::as_str));
            return Err(bad(format!("there is no field {field:?}{hint}")));
        }
        loop {
            let (text, view) = self.hub.look(|session| (session.text().to_owned(), session.view().to_owned()));
            let look = Box::new(Look { field: field.clone(), view, text: text.clone() });
            let found = self.ask(|reply| Question::Look { look, reply }).await?;
            let mut is_same = true;
            let answer = self.changed(|session| {
                is_same = session.text() == text;
                if is_same { session.replace(&found) } else { Ok(()) }
            });
            // If another viewer has changed the scene meanwhile, the changed scene is to show the field.
            if is_same {
                return answer;
            }
        }
    }

    async fn picture(&self, query: &str) -> Outcome {
        let format = parameter(query, "format").unwrap_or_default();
        let media_type = match format.as_str() {
            "png" => "image/png",
            "exr" => "image/x-exr",
            _ => return Err(bad(format!("format {format:?}, expected png or exr"))),
        };
        let time = parameter(query, "time").map(|_| number(query, "time")).transpose()?;
        let times = self.description().times.len();
        if let Some(time) = time.filter(|time| *time >= times) {
            return Err(bad(format!("time {time}, expected less than {times}")));
        }
        let shown = self.hub.shown.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let other = time.filter(|time| *time != self.hub.look(Session::time));
        let frame = match (shown, other) {
            (Some(frame), _) => frame,
            (None, Some(time)) => Arc::new(self.ask(|reply| Question::Picture { time: Some(time), reply }).await?),
            (None, None) => self.at_rest().await?,
        };
        let bytes = if format == "png" { png_bytes(&frame) } else { exr_bytes(&frame) };
        let mut answer = typed(media_type, bytes.map_err(failed)?.into());
        let name = HeaderValue::from_str(&format!("attachment; filename=\"picture.{format}\"")).map_err(bad)?;
        answer.headers_mut().insert(header::CONTENT_DISPOSITION, name);
        Ok(answer)
    }

    /// The displayed picture at rest, once it is drawn.
    async fn at_rest(&self) -> Result<Arc<Frame>, Refusal> {
        let revision = self.hub.look(Session::revision);
        let mut pictures = self.hub.pictures.subscribe();
        let is_it = |picture: &Option<Arc<Picture>>| picture.as_ref().is_some_and(|its| its.is_at_rest(revision));
        let found = match timeout(ANSWER, pictures.wait_for(is_it)).await {
            Ok(Ok(picture)) => picture.as_ref().map(|picture| picture.drawn.clone()),
            _ => None,
        };
        match found {
            Some(drawn) => drawn.map_err(|why| Refusal(StatusCode::UNPROCESSABLE_ENTITY, why)),
            None => Err(unanswered()),
        }
    }

    async fn ask<T>(&self, question: impl FnOnce(Reply<T>) -> Question) -> Result<T, Refusal> {
        let (reply, answer) = oneshot::channel();
        if !self.hub.ask(question(Reply(reply))) {
            let why = "too many questions wait for the program that draws";
            return Err(Refusal(StatusCode::SERVICE_UNAVAILABLE, why.to_owned()));
        }
        match timeout(ANSWER, answer).await {
            Ok(Ok(answer)) => answer.map_err(failed),
            _ => Err(unanswered()),
        }
    }
}

/// The first volume's transfer function as knots, over its range in the last picture.
fn transfer(scene: &Scene, range: Option<[f64; 2]>) -> serde_json::Value {
    let first = &scene.volumes[0];
    let transfer = match (&first.coloring, range) {
        (Some(coloring), Some(range)) if coloring.fixed().is_none() => coloring.transfer(range),
        _ => first.transfer.clone(),
    };
    let knots: Vec<_> = transfer
        .knots
        .iter()
        .map(|knot| {
            let color = hex(srgb8(knot.color));
            json!({ "value": knot.value, "color": color, "opacity": -(-knot.extinction).exp_m1() })
        })
        .collect();
    let range = transfer.range();
    match knots.iter().any(|knot| knot["opacity"] != 0.0) {
        true => json!({ "knots": knots, "range": range, "is_map": first.coloring.is_some() }),
        false => serde_json::Value::Null,
    }
}

async fn body(request: Request<Incoming>) -> Result<Bytes, Refusal> {
    let whole = timeout(ARRIVES, Limited::new(request.into_body(), MAX_BODY).collect());
    let whole = whole.await.map_err(|_| Refusal(StatusCode::REQUEST_TIMEOUT, "the request stalled".to_owned()))?;
    let too_large = |e| Refusal(StatusCode::PAYLOAD_TOO_LARGE, format!("the request's body: {e}"));
    Ok(whole.map_err(too_large)?.to_bytes())
}

/// The value of a key of the query, with its escapes.
fn parameter(query: &str, key: &str) -> Option<String> {
    form_urlencoded::parse(query.as_bytes()).find(|(name, _)| name == key).map(|(_, value)| value.into_owned())
}

fn number<T: std::str::FromStr>(query: &str, key: &str) -> Result<T, Refusal> {
    let text = parameter(query, key).ok_or_else(|| missing(key))?;
    text.parse().map_err(|_| bad(format!("{key} = {text:?}, expected a number")))
}

fn missing(key: &str) -> Refusal {
    bad(format!("expected {key} in the address"))
}

fn bad(error: impl std::fmt::Display) -> Refusal {
    Refusal(StatusCode::BAD_REQUEST, error.to_string())
}

fn failed(error: icoray::Error) -> Refusal {
    Refusal(StatusCode::UNPROCESSABLE_ENTITY, error.to_string())
}

fn unanswered() -> Refusal {
    Refusal(StatusCode::SERVICE_UNAVAILABLE, "the program that draws gave no answer".to_owned())
}

fn wrong_method() -> Refusal {
    Refusal(StatusCode::METHOD_NOT_ALLOWED, "expected another method".to_owned())
}

fn nothing_here() -> Refusal {
    Refusal(StatusCode::NOT_FOUND, "there is nothing here".to_owned())
}

fn json_answer(value: &impl Serialize) -> Answer {
    match serde_json::to_vec(value) {
        Ok(bytes) => typed("application/json", bytes.into()),
        Err(_) => with_status(StatusCode::INTERNAL_SERVER_ERROR, Answer::default()),
    }
}

fn typed(media_type: &'static str, bytes: Bytes) -> Answer {
    let mut answer = Answer::new(Full::new(bytes));
    answer.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static(media_type));
    answer
}

fn with_status(status: StatusCode, mut answer: Answer) -> Answer {
    *answer.status_mut() = status;
    answer
}

#[cfg(test)]
mod tests;
