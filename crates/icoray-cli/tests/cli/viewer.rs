//! A running `icoray view`, and the requests of a page.

use crate::run::{Folder, icoray};
use icoray_test_support::PATIENCE;
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};

/// A command that serves a page, ended when it is dropped.
pub struct Viewer {
    child: Option<Child>,
    pub host: String,
    pub token: String,
}

pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&self.body)))
    }

    /// The facts of a picture, and its PNG.
    fn picture(&self) -> (Value, &[u8]) {
        let (length, rest) = self.body.split_first_chunk().unwrap();
        let (facts, png) = rest.split_at(u32::from_le_bytes(*length) as usize);
        (serde_json::from_slice(facts).unwrap(), png)
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
        let (host, token) = address.strip_prefix("http://").and_then(|rest| rest.split_once("/#")).unwrap();
        Viewer { child: None, host: host.to_owned(), token: token.to_owned() }
    }

    /// The command that serves the page, which goes on.
    pub fn into_child(mut self) -> Child {
        self.child.take().unwrap()
    }

    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    pub fn ask_with(&self, token: &str, request: &str, body: &str) -> Answer {
        let mut stream = self.connect();
        let (host, length) = (&self.host, body.len());
        let head = format!(
            "{request} HTTP/1.1\r\nHost: {host}\r\nAuthorization: Bearer {token}\r\nContent-Length: {length}\r\n\
             Connection: close\r\n\r\n"
        );
        stream.write_all(head.as_bytes()).unwrap();
        stream.write_all(body.as_bytes()).unwrap();
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).unwrap();
        let split = bytes.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
        let head = String::from_utf8(bytes[..split].to_vec()).unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        Answer { status, head: head.to_ascii_lowercase(), body: bytes[split + 4..].to_vec() }
    }

    pub fn get(&self, path: &str) -> Answer {
        self.ask_with(&self.token, &format!("GET {path}"), "")
    }

    pub fn post(&self, path: &str, body: &str) -> Answer {
        self.ask_with(&self.token, &format!("POST {path}"), body)
    }

    /// Facts and pixels of the first picture of a revision or a later one that `is_wanted`.
    pub fn first(&self, revision: u64, is_wanted: impl Fn(&Value) -> bool) -> (Value, image::RgbaImage) {
        let mut after = 0;
        loop {
            let answer = self.get(&format!("/api/frame?after={after}"));
            assert_eq!(answer.status, 200);
            let (facts, png) = answer.picture();
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
