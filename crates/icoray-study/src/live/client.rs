//! A client of the page's server.

use icoray::{Error, ErrorKind, Result};
use icoray_test_support::PageClient;
use serde_json::Value;

/// A client of a page.
pub(super) struct Client {
    page: PageClient,
    /// Number of the last picture.
    last: u64,
}

fn unexpected(what: impl std::fmt::Display) -> Error {
    Error::new(ErrorKind::Io, format!("the page's server: {what}"))
}

impl Client {
    pub fn new(address: &str) -> Self {
        Client { page: PageClient::at(address), last: 0 }
    }

    /// Turns the camera and asks for pictures of a size; returns the scene's revision.
    pub fn set(&mut self, lon: Option<f64>, size: [u32; 2], is_moving: bool) -> Result<u64> {
        let changes: Vec<Value> =
            lon.iter().map(|lon| serde_json::json!({ "path": ["camera", "lon"], "value": lon })).collect();
        let body = serde_json::json!({ "changes": changes, "size": size, "is_moving": is_moving }).to_string();
        let answer = self.page.ask("POST /api/change", &body).map_err(unexpected)?;
        let answer: Value = serde_json::from_slice(&answer.body).map_err(unexpected)?;
        answer["revision"].as_u64().ok_or_else(|| unexpected(answer))
    }

    /// Waits for a picture of a revision or a later one, at rest if need be; returns how many pixels apart its rays are
    /// and its quality in words.
    pub fn picture_of(&mut self, revision: u64, is_at_rest: bool) -> Result<(f64, String)> {
        loop {
            let answer = self.page.ask(&format!("GET /api/frame?after={}", self.last), "").map_err(unexpected)?;
            let Some((facts, _)) = answer.picture() else { continue };
            let facts: Value = serde_json::from_slice(facts).map_err(unexpected)?;
            if let Some(why) = facts["failure"].as_str() {
                return Err(unexpected(why));
            }
            self.last = facts["number"].as_u64().unwrap_or(self.last);
            let is_final = facts["pending"] == false && facts["is_moving"] == false;
            if facts["revision"].as_u64() >= Some(revision) && (is_final || !is_at_rest) {
                let quality = facts["quality"].as_str().unwrap_or_default();
                return Ok((pixel_step(quality), quality.to_owned()));
            }
        }
    }
}

/// The first number in the part on pixels: "one of 4 x 4 pixels traced".
fn pixel_step(quality: &str) -> f64 {
    let pixels = quality.rsplit(", ").next().unwrap_or_default();
    pixels.split(' ').find_map(|word| word.parse().ok()).unwrap_or(1.0)
}
