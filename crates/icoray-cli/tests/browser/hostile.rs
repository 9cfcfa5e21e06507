//! Files with markup in names and texts, and requests of foreign pages.

use crate::browser::Browser;
use crate::made::Made;
use crate::page::Shown;
use crate::run::{Folder, icoray};
use crate::viewer::{Json, Viewer};
use netcdf::Options;

const FILE: &str = "<img src=x onerror=document.title=1>.nc";
const FIELD: &str = "theta<img src=x onerror=document.title=1>";
const UNITS: &str = "<img src=x onerror=alert()>";

#[test]
fn markup_in_a_file_is_text() {
    let Some(browser) = Browser::start() else { return };
    let folder = Folder::new();
    let mut made = Made::history();
    let theta = made.variable("theta");
    theta.name = FIELD;
    theta.attributes = vec![("units", UNITS.into()), ("long_name", FIELD.into())];
    made.write_to(&folder.at(FILE), Options::_64BIT_OFFSET);
    let viewer = Viewer::start(icoray(folder.path()).args(["view", FILE, "--field", FIELD]));
    browser.open(&viewer);
    browser.until_text("#title", FILE);
    browser.until_text("#facts", FIELD);
    browser.until_text("#panel-colours", FIELD);
    browser.click_at(browser.place([0.5, 0.5]), 1);
    browser.until_text("#panel-probe", UNITS);
    browser.click("#tab-files");
    browser.until_text("#scene-text", FIELD);
    browser.click("#tab-scene");
    browser.shot("hostile");
    assert_eq!(browser.js("return document.querySelectorAll('img, #panel script, #main script').length;"), 0);
    assert!(browser.js("return document.title;").as_str().unwrap().starts_with(FILE));
    browser.is_quiet();
}

#[test]
fn pages_of_others_get_nothing() {
    let Some(Shown { browser, viewer, .. }) = &Shown::start() else { return };
    let before = browser.text();
    // Another program's page, which even knows the token.
    let other_folder = Folder::of(&Made::history());
    let other = other_folder.view(&[]);
    let asks = |address: &str| {
        browser.go(address);
        let call = |path: &str, options: &str| {
            let headers = format!("headers: {{ Authorization: 'Bearer {}' }}", viewer.page.token);
            let body = format!(
                "return fetch('http://{}{path}', {{ {headers}, {options} }}).then((answer) => answer.text())
                   .catch((error) => error.name);",
                viewer.page.host
            );
            browser.js(&body)
        };
        assert_eq!(call("/api/scene", ""), "TypeError", "{address}");
        assert_eq!(call("/api/undo", "method: 'POST'"), "TypeError", "{address}");
        // Without a look at the answer; the browser then drops the token.
        let body = r#"method: 'POST', mode: 'no-cors', body: '{"changes":[{"path":["camera","lon"],"value":99}]}'"#;
        call("/api/change", body);
        assert!(!browser.log().is_empty(), "{address}");
    };
    asks(&format!("http://{}/", other.page.host));
    asks("data:text/html,<title>x</title>");
    asks("about:blank");
    // Nor do they show it in a frame of theirs.
    browser.js(&format!(
        "const frame = document.createElement('iframe'); frame.src = '{}'; document.body.append(frame);
         await new Promise((done) => {{ frame.onload = done; }});",
        viewer.address()
    ));
    browser.wait(browser.client().enter_frame(0));
    assert_eq!(browser.js("return location.href;"), "chrome-error://chromewebdata/");
    assert_eq!(viewer.get("/api/scene").json()["text"], *before);
}
