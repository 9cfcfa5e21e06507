//! Progress: a line on a terminal. Elsewhere stderr is empty, at which `Folder::prints` looks in all tests.

use crate::made::Made;
use crate::run::{Folder, has};
use icoray_test_support::{Need, runs, skip};
use std::path::Path;
use std::process::{Command, Stdio};

/// A command line on a terminal of its own.
fn on_terminal(folder: &Path, line: &str) -> Command {
    let mut script = Command::new("script");
    script.args(["-q", "-e", "-c", line, "/dev/null"]).current_dir(folder).stdin(Stdio::null());
    script.env("HDF5_USE_FILE_LOCKING", "FALSE").env("TERM", "xterm").env_remove("NO_COLOR");
    script
}

/// What `icoray` prints on a terminal.
fn printed(folder: &Path, words: &str) -> String {
    let line = format!("{} {words}", env!("CARGO_BIN_EXE_icoray"));
    let output = on_terminal(folder, &line).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}");
    text
}

#[test]
fn a_terminal_sees_the_stages_and_the_pictures() {
    let folder = Folder::of(&Made::history());
    if !runs(&mut on_terminal(folder.path(), "true")) {
        return skip(Need::Terminal);
    }
    let text = printed(folder.path(), "render made.nc --time all --size 400x300");
    has(&text, &["reading made.nc", "drawing picture 1 of 3", "drawing picture 3 of 3", " left"]);
    has(&text, &["picture   theta_2013-10-27_00.00.00_000002.png"]);
    let text = printed(folder.path(), "info made.nc --ranges");
    has(&text, &["reading made.nc", "reading vorticity", "passes the check"]);
    let text = printed(folder.path(), "plan made.nc");
    has(&text, &["reading made.nc", "left out: "]);
}
