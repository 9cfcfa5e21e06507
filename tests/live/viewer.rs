//! A viewer of a model's page.

use super::pixels;
use icoray_test_support::PATIENCE;
use icoray_tests::native::text;
use serde_json::Value;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::{fs, thread};

/// An answer of the page's server.
pub struct Answer {
    pub status: u16,
    pub body: Vec<u8>,
}

/// What a viewer has: the address of a model's page.
#[derive(Clone)]
pub struct Viewer {
    pub host: String,
    pub token: String,
}

impl Viewer {
    pub fn of(directory: &Path) -> Self {
        let file = directory.join("live.url");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600, "others may not read the token");
        let address = fs::read_to_string(file).unwrap();
        let (host, token) = address.trim().strip_prefix("http://").unwrap().split_once("/#").unwrap();
        Viewer { host: host.to_owned(), token: token.to_owned() }
    }

    pub fn ask(&self, request: &str, body: &str) -> Answer {
        let Viewer { host, token } = self;
        let mut stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let length = body.len();
        write!(
            stream,
            "{request} HTTP/1.1\r\nHost: {host}\r\nAuthorization: Bearer {token}\r\nContent-Length: {length}\r\n\
             Connection: close\r\n\r\n{body}"
        )
        .unwrap();
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).unwrap();
        let split = bytes.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
        let head = text(&bytes[..split]);
        Answer { status: head.split(' ').nth(1).unwrap().parse().unwrap(), body: bytes[split + 4..].to_vec() }
    }

    pub fn get(&self, path: &str) -> Answer {
        self.ask(&format!("GET {path}"), "")
    }

    /// A question, which the model answers when it draws.
    pub fn asks(&self, path: &'static str) -> thread::JoinHandle<Answer> {
        let viewer = self.clone();
        thread::spawn(move || viewer.get(path))
    }

    pub fn set(&self, changes: &str) -> Answer {
        self.ask("POST /api/change", &format!("{{\"changes\":[{changes}]}}"))
    }

    /// Facts and pixels of the next picture after one.
    pub fn picture(&self, after: u64) -> (Value, Vec<u8>) {
        let answer = self.get(&format!("/api/frame?after={after}"));
        assert_eq!(answer.status, 200);
        let (length, rest) = answer.body.split_first_chunk().unwrap();
        let (facts, png) = rest.split_at(u32::from_le_bytes(*length) as usize);
        let pixels = if png.is_empty() { Vec::new() } else { pixels(png) };
        (serde_json::from_slice(facts).unwrap(), pixels)
    }
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|e| panic!("{e}: {}", text(&self.body)))
    }
}
