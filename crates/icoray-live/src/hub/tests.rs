//! The order of requests, and the requests that are dropped.

use super::*;
use crate::session::{ChangeRequest, PictureSize, Start, plain_reader};

fn hub() -> Hub {
    let text = "field = \"q\"\nimage = { width = 1000, height = 500 }\n".to_owned();
    let start = Start { text, time: 0, times: 1, size: PictureSize::default() };
    Hub::new(Session::new(start, plain_reader()).unwrap())
}

fn change(hub: &Hub, json: &str) -> u64 {
    let request: ChangeRequest = serde_json::from_str(json).unwrap();
    hub.change(|session| session.change(&request)).unwrap()
}

fn draw(hub: &Hub) -> DrawRequest {
    match hub.next() {
        Some(Request::Draw(request)) => *request,
        other => panic!("{other:?}"),
    }
}

const TURN: &str = r#"{"changes":[{"path":["camera","lon"],"value":3}],"is_moving":true}"#;
const REST: &str = r#"{"is_moving":false}"#;

#[test]
fn a_picture_comes_coarse_first_and_then_at_rest() {
    let hub = hub();
    let first = draw(&hub);
    assert_eq!((first.is_final, first.scene.width, first.scene.time_budget_ms), (false, 640, Some(MOVING_MS)));
    assert!(hub.drawn(&first, 0.08));
    let second = draw(&hub);
    assert_eq!((second.is_final, second.scene.width, second.scene.time_budget_ms), (true, 1000, None));
    assert!(hub.drawn(&second, 0.01));
    // Quick pictures are drawn at rest.
    change(&hub, r#"{"changes":[{"path":["camera","lon"],"value":7}]}"#);
    assert!(draw(&hub).is_final);
}

#[test]
fn pictures_at_rest_are_given_up_for_newer_ones_and_coarse_ones_are_not() {
    let hub = hub();
    let coarse = draw(&hub);
    let revision = change(&hub, TURN);
    assert!(!hub.stop.load(Relaxed), "a user who keeps moving would never see a picture");
    assert!(hub.drawn(&coarse, 0.08));
    // Only the newest of several changes is drawn.
    change(&hub, TURN);
    assert_eq!(change(&hub, TURN), revision + 2);
    let moving = draw(&hub);
    assert_eq!((moving.revision, moving.is_moving), (revision + 2, true));
    assert!(hub.drawn(&moving, 0.08));
    change(&hub, REST);
    assert!(hub.drawn(&draw(&hub), 0.08));
    let rest = draw(&hub);
    assert!(rest.is_final);
    change(&hub, TURN);
    assert!(hub.stop.load(Relaxed), "the picture is out of date");
    assert!(!hub.drawn(&rest, 3.0));
    let next = draw(&hub);
    assert!(!next.is_final && !hub.stop.load(Relaxed));
}

#[test]
fn a_hand_that_holds_still_sees_the_picture_refined() {
    let hub = hub();
    change(&hub, TURN);
    let moving = draw(&hub);
    assert!(moving.is_moving && hub.drawn(&moving, 0.08));
    let rest = draw(&hub);
    assert!(rest.is_final && !rest.is_moving);
    // It goes on, and all of it is one step back.
    change(&hub, TURN);
    assert!(draw(&hub).is_moving);
    change(&hub, REST);
    hub.change(|session| session.step(true)).unwrap();
    assert!(!hub.look(|session| session.text().contains("lon")));
}

#[test]
fn questions_come_first_are_limited_and_end_with_the_program() {
    let hub = hub();
    let mut answers = Vec::new();
    for _ in 0..MAX_QUESTIONS {
        let (reply, answer) = oneshot::channel();
        assert!(hub.ask(Question::Picture { time: None, reply: Reply(reply) }));
        answers.push(answer);
    }
    assert!(!hub.ask(Question::Picture { time: None, reply: Reply(oneshot::channel().0) }));
    assert!(matches!(hub.next(), Some(Request::Answer { question: Question::Picture { .. }, .. })));
    hub.end();
    assert!(hub.next().is_none());
    assert!(answers.iter_mut().all(|answer| answer.try_recv().is_err()), "the requests end");
    assert!(!hub.ask(Question::Picture { time: None, reply: Reply(oneshot::channel().0) }));
}

#[test]
fn a_program_that_draws_by_itself_takes_each_change_once() {
    let hub = hub();
    let taken = hub.take();
    assert!(taken.change.is_none() && taken.questions.is_empty());
    change(&hub, TURN);
    let revision = change(&hub, r#"{"changes":[{"path":["camera","lat"],"value":4}],"is_moving":true}"#);
    assert!(hub.ask(Question::Picture { time: None, reply: Reply(oneshot::channel().0) }));
    let taken = hub.take();
    let new = taken.change.unwrap();
    assert_eq!((new.revision, taken.questions.len()), (revision, 1));
    assert!(new.text.contains("lon = 3") && !new.before.contains("lon"), "{new:?}");
    assert_eq!(new.keys(), ["camera"]);
    change(&hub, REST);
    let taken = hub.take();
    assert!(taken.change.is_none() && taken.questions.is_empty());
}
