//! The program ends while a page is open.

use crate::browser::Browser;
use crate::made::Made;
use crate::page::{SMALL, Shown};
use crate::run::Folder;
use std::net::TcpListener;
use std::process;

/// A free port below those that systems give to programs that ask for any, so that no other test takes it meanwhile.
fn free_port() -> u16 {
    let mut ports = (20_000..32_000).cycle().skip(process::id() as usize % 12_000).take(12_000);
    ports.find(|port| TcpListener::bind(("127.0.0.1", *port)).is_ok()).expect("a free port")
}

#[test]
fn a_page_shows_that_the_program_has_ended() {
    let Some(browser) = Browser::start() else { return };
    let (folder, port) = (Folder::of(&Made::history()), free_port().to_string());
    let viewer = folder.view(&["--port", &port]);
    browser.resize(SMALL, false);
    browser.open(&viewer);
    browser.is_quiet();
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
    let viewer = folder.view(&["--port", &port]);
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
    let Some(Shown { browser, viewer, .. }) = &Shown::begin(SMALL, false, "") else { return };
    browser.go(&format!("http://{}/#0123", viewer.page.host));
    browser.until_text("#alert", "This address lacks its token.");
    browser.shot("no-token");
    assert!(browser.log().iter().all(|line| line.contains("401")));
    // The right address, in the same window.
    browser.go(&viewer.address());
    browser.until_text("#title", "made.nc");
    browser.open(viewer);
    // It is not left in the address, and a reload finds it.
    assert_eq!(browser.js("return location.hash;"), "");
    browser.wait(browser.client().refresh());
    browser.until("a picture", "const { store } = await import('/store.js'); return store.frame !== null;");
    browser.is_quiet();
}
