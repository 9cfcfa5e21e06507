//! The program ends while a page is open.

use crate::made::Made;
use crate::page::Shown;
use crate::run::Folder;
use std::net::TcpListener;

#[test]
fn a_page_shows_that_the_program_has_ended() {
    let Some(Shown { browser, viewer, folder: first }) = Shown::start() else { return };
    browser.is_quiet();
    let port = viewer.host.rsplit_once(':').unwrap().1.to_owned();
    browser.click("#play");
    drop(viewer);
    browser.until_text("#alert", "The program that serves this page has ended.");
    browser.until("a faint picture", "return document.body.classList.contains('is-gone');");
    browser.shot("ended");
    // The last picture stays, and the mouse and keys do no harm.
    let [from, goal] = [[0.5, 0.5], [0.6, 0.5]].map(|place| browser.place(place));
    browser.drag(from, goal);
    browser.click("#tab-scene");
    browser.press(&["Escape", "Ctrl z"]);
    let is_network = |line: &String| line.starts_with("\"network\"");
    let log = browser.log();
    assert!(log.iter().all(is_network), "{log:?}");

    // Another program at the same port has another token.
    let free = TcpListener::bind(format!("127.0.0.1:{port}"));
    drop(free.expect("nobody else takes the port within milliseconds"));
    let viewer = first.view(&["--port", &port]);
    browser.until_text("#alert", "Open the whole address that icoray printed");
    let log = browser.log();
    assert!(log.iter().all(is_network), "{log:?}");
    // Its own address, in the same window.
    browser.go(&viewer.address());
    browser.until("a bright picture", "return !document.body.classList.contains('is-gone');");
    browser.open(&viewer);
    browser.is_quiet();
}

#[test]
fn an_address_without_its_token_shows_an_error() {
    let Some(browser) = crate::browser::Browser::start() else { return };
    let folder = Folder::of(&Made::history());
    let viewer = folder.view(&[]);
    browser.go(&format!("http://{}/#0123", viewer.host));
    browser.until_text("#alert", "This address lacks its token.");
    browser.shot("no-token");
    assert!(browser.log().iter().all(|line| line.contains("401")));
    // The right address, in the same window.
    browser.go(&viewer.address());
    browser.until_text("#title", "made.nc");
    browser.open(&viewer);
    // It is not left in the address, and a reload finds it.
    assert_eq!(browser.js("return location.hash;"), "");
    browser.wait(browser.client().refresh());
    browser.until("a picture", "const { store } = await import('/store.js'); return store.frame !== null;");
    browser.is_quiet();
}
