//! Answers to requests.

use super::*;
use crate::session::{PictureSize, Start, plain_reader};
use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer};
use std::future::Future;
use std::task::{Context, Waker};

#[test]
fn parameters_are_unescaped() {
    for (query, expected) in [
        ("field=theta", Some("theta")),
        ("a=1&field=t%20e%C3%A4+x", Some("t eä x")),
        ("field=%zz%", Some("%zz%")),
        ("fields=1", None),
        ("", None),
    ] {
        assert_eq!(parameter(query, "field").as_deref(), expected, "{query}");
    }
    assert_eq!(number::<u64>("after=7", "after").ok(), Some(7));
    assert!(number::<u64>("after=x", "after").is_err() && number::<u64>("", "after").is_err());
}

/// A picture of a colour.
fn frame(color: &str) -> Frame {
    let mesh = IcosahedralMesh::new(1).unwrap();
    let (grid, layers) = (Grid::new(mesh.tables()).unwrap(), Layers::from_heights(&[0.0, 1e4], 6.371e6).unwrap());
    let values = vec![0.5f32; 2 * grid.cells()];
    let field = Field::level_fastest(&values, 2, Location::Center).unwrap();
    let text = format!("field = 'q'\nbackground = '{color}'\nimage = {{ width = 8, height = 6 }}\n");
    Renderer::new(1).unwrap().render(&Scene::parse(&text).unwrap(), &grid, &layers, &field).unwrap()
}

/// A saved picture is the one at rest that is shown, or that is on its way: the program is not asked for another.
#[test]
fn a_picture_that_is_there_is_not_drawn_again() {
    let start = Start { text: "field = 'q'".to_owned(), time: 1, times: 2, size: PictureSize::Scene };
    let hub = Arc::new(Hub::new(Session::new(start, plain_reader()).unwrap()));
    let (description, token) = (Arc::default(), String::new());
    let api = Api { hub: hub.clone(), description, token, is_framed: false };
    api.description().times = vec![String::new(); 2];
    let draw = |color: &str| {
        let Some(crate::hub::Request::Draw(request)) = hub.next() else { panic!("something else") };
        assert!(hub.drawn(&request, 1.0));
        hub.pictures.send_replace(Some(Arc::new(Picture::new(1, frame(color), &request, 1.0))));
    };
    draw("red");
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
    let _entered = runtime.enter();
    let mut saved = Box::pin(api.picture("format=png&time=1"));
    let mut context = Context::from_waker(Waker::noop());
    assert!(saved.as_mut().poll(&mut context).is_pending(), "the coarse picture is not saved");
    assert!(hub.take().questions.is_empty());
    draw("blue");
    let answer = runtime.block_on(saved).unwrap_or_else(|Refusal(_, why)| panic!("{why}"));
    let body = runtime.block_on(answer.into_body().collect()).unwrap().to_bytes();
    assert_eq!(body, png_bytes(&frame("blue")).unwrap());
    // That of another time is drawn for it.
    assert!(Box::pin(api.picture("format=png&time=0")).as_mut().poll(&mut context).is_pending());
    assert_eq!(hub.take().questions.len(), 1);
}
