//! A running `icoray view`, and the requests of a page.

use crate::run::{Folder, icoray};
use icoray_test_support::{PageAnswer, PageClient};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

/// A command that serves a page, ended when it is dropped.
pub struct Viewer {
    child: Option<Child>,
    pub page: PageClient,
}

pub trait Json {
    fn json(&self) -> Value;
}

impl Json for PageAnswer {
    fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&self.body)))
    }
}

impl Folder {
    /// The page of `made.nc`.
    pub fn view(&self, more: &[&str]) -> Viewer {
        Viewer::start(icoray(self.path()).args(["view", "made.nc"]).args(more))
    }
}

impl Viewer {
    pub fn start(command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("view      ").unwrap_or_else(|| panic!("{line}"));
        let mut viewer = Viewer::at(address);
        viewer.child = Some(child);
        viewer
    }

    /// The page of a command that runs already.
    pub fn at(address: &str) -> Self {
        Viewer { child: None, page: PageClient::at(address) }
    }

    /// The command that serves the page, which goes on.
    pub fn into_child(mut self) -> Child {
        self.child.take().unwrap()
    }

    pub fn get(&self, path: &str) -> PageAnswer {
        self.page.ask(&format!("GET {path}"), "").unwrap()
    }

    pub fn post(&self, path: &str, body: &str) -> PageAnswer {
        self.page.ask(&format!("POST {path}"), body).unwrap()
    }

    /// Changes the scene, and returns its revision.
    pub fn change(&self, body: &str) -> u64 {
        self.post("/api/change", body).json()["revision"].as_u64().unwrap()
    }

    /// Facts and pixels of the first picture of a revision or a later one that `is_wanted`.
    pub fn first(&self, revision: u64, is_wanted: impl Fn(&Value) -> bool) -> (Value, image::RgbaImage) {
        let mut after = 0;
        loop {
            let answer = self.get(&format!("/api/frame?after={after}"));
            assert_eq!(answer.status, 200);
            let (facts, png) = answer.picture().unwrap();
            let facts: Value = serde_json::from_slice(facts).unwrap();
            assert!(facts["failure"].is_null(), "{facts}");
            let picture = image::load_from_memory(png).unwrap().into_rgba8();
            assert!(picture.width() == facts["width"]);
            if facts["revision"].as_u64() >= Some(revision) && is_wanted(&facts) {
                return (facts, picture);
            }
            after = facts["number"].as_u64().unwrap();
        }
    }

    /// The facts of the first picture at rest of a revision.
    pub fn at_rest(&self, revision: u64) -> Value {
        self.first(revision, |facts| facts["pending"] == false && facts["is_moving"] == false).0
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        if let Some(child) = &mut self.child {
            child.kill().unwrap();
            child.wait().unwrap();
        }
    }
}
