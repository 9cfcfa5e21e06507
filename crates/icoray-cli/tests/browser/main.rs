//! The page of `icoray view` in Chromium without a window, which WebDriver steers as hands do. Screenshots are left in
//! `target/browser`.

#[expect(dead_code, reason = "the tests of the command use the rest")]
#[path = "../../../icoray-dataset/tests/dataset/made.rs"]
mod made;
#[expect(dead_code, reason = "the tests of the command use the rest")]
#[path = "../cli/run.rs"]
mod run;
#[expect(dead_code, reason = "the tests of the command use the rest")]
#[path = "../cli/viewer.rs"]
mod viewer;

mod browser;
mod ends;
mod hands;
mod hostile;
mod input;
mod keyboard;
mod looks;
mod page;
mod saving;
mod stage;
mod together;
#[expect(dead_code, reason = "the tests of the command use the rest")]
#[path = "../../../icoray-netcdf/tests/files/written.rs"]
mod written;
