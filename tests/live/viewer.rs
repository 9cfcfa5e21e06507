//! A viewer of a model's page.

use super::pixels;
use icoray_test_support::{PageAnswer, PageClient};
use icoray_tests::native::text;
use serde_json::Value;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::{fs, thread};

/// A viewer of a model's page.
#[derive(Clone)]
pub struct Viewer {
    pub page: PageClient,
}

impl Viewer {
    pub fn of(directory: &Path) -> Self {
        let file = directory.join("live.url");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600, "others may not read the token");
        Viewer { page: PageClient::at(&fs::read_to_string(file).unwrap()) }
    }

    pub fn ask(&self, request: &str, body: &str) -> PageAnswer {
        self.page.ask(request, body).unwrap()
    }

    pub fn get(&self, path: &str) -> PageAnswer {
        self.ask(&format!("GET {path}"), "")
    }

    /// A question, which the model answers when it draws.
    pub fn asks(&self, path: &'static str) -> thread::JoinHandle<PageAnswer> {
        let viewer = self.clone();
        thread::spawn(move || viewer.get(path))
    }

    pub fn set(&self, changes: &str) -> PageAnswer {
        self.ask("POST /api/change", &format!("{{\"changes\":[{changes}]}}"))
    }

    /// Facts and pixels of the next picture after one.
    pub fn picture(&self, after: u64) -> (Value, Vec<u8>) {
        let answer = self.get(&format!("/api/frame?after={after}"));
        assert_eq!(answer.status, 200);
        let (facts, png) = answer.picture().unwrap();
        let pixels = if png.is_empty() { Vec::new() } else { pixels(png) };
        (serde_json::from_slice(facts).unwrap(), pixels)
    }
}

/// The content of an answer.
pub trait Json {
    fn json(&self) -> Value;
}

impl Json for PageAnswer {
    fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|e| panic!("{e}: {}", text(&self.body)))
    }
}
