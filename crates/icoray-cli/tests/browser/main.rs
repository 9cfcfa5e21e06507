//! The page of `icoray view` in Chromium without a window, which WebDriver controls with mouse and keys. Screenshots
//! are left in `target/browser`.

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
mod display;
mod ends;
mod hostile;
mod input;
mod keyboard;
mod looks;
mod mouse;
mod page;
mod saving;
mod together;
#[expect(dead_code, reason = "the tests of the command use the rest")]
#[path = "../../../icoray-netcdf/tests/files/written.rs"]
mod written;
