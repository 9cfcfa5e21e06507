//! Frames per second of the live view, and the time from a movement to its picture, as a page on this machine sees
//! them.
//!
//! The page's server and the renderer run as in `icoray view`; a client turns the globe, waits for the picture of each
//! turn and sends the next, as a page does during a drag. At its end it waits for the picture at rest.

use crate::results::{progress, replace_section, say};
use crate::scenes::multi_scale::HEADLIGHT;
use crate::speed::{self, Size};
use icoray::{Error, ErrorKind, Renderer, Result, Scene};
use icoray_live::{Description, LiveView, NamedScene, Options as LiveOptions, PictureSize, Request};
use icoray_reference::sphere::{Sphere, multi_scale};
use icoray_test_support::PageClient;
use serde_json::Value;
use std::io::Write;
use std::path::PathBuf;
use std::thread;
use std::time::Instant;

/// Options of the measurement.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Bisections of the icosahedron x layers, one size after another.
    #[arg(long, value_delimiter = ',', value_parser = speed::size, default_value = "5x26,7x26,8x26,9x26")]
    pub sizes: Vec<Size>,
    /// Rendering threads; 0 is the number of processors.
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
    /// Turns of three degrees.
    #[arg(long, default_value_t = 100)]
    pub turns: usize,
    /// A file in which the table takes the place of that between its lines `<!-- icoray-study live -->` and
    /// `<!-- end -->`.
    #[arg(long)]
    pub readme: Option<PathBuf>,
}

/// Sizes of pictures, pixels: while a hand moves, and at rest.
const MOVING: [u32; 2] = [640, 480];
const REST: [u32; 2] = [900, 675];

const HEAD: &str = "| grid | light | frames per second | movement to picture ms, median | 95 % | coarsest of the frames | at rest s |\n\
                    |---|---|---|---|---|---|---|";

struct Seen {
    /// Seconds from each movement to its picture, in rising order.
    waits_s: Vec<f64>,
    all_s: f64,
    /// In words, of the frame with the fewest rays.
    coarsest: String,
    rest_s: f64,
}

/// Measures and prints a row per size and light.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let renderer = Renderer::new(options.threads)?;
    let bar = progress(2 * options.sizes.len(), "live");
    let mut text = format!(
        "{} x {} pixels within 80 ms while a hand moves, {} x {} at rest, {} threads:\n\n{HEAD}\n",
        MOVING[0],
        MOVING[1],
        REST[0],
        REST[1],
        renderer.threads()
    );
    for size in &options.sizes {
        let sphere = Sphere::new(size.level, size.layers, [1.0, 1.15], multi_scale)?;
        for (name, light) in [("unlit", ""), ("lit", HEADLIGHT)] {
            let seen = watched(&sphere, options, light)?;
            let of = |part: f64| 1e3 * seen.waits_s[(part * (seen.waits_s.len() - 1) as f64) as usize];
            let row = format!(
                "| {} cells × {} layers | {name} | {:.1} | {:.0} | {:.0} | {} | {:.2} |\n",
                sphere.mesh.cells(),
                size.layers,
                options.turns as f64 / seen.all_s,
                of(0.5),
                of(0.95),
                seen.coarsest,
                seen.rest_s
            );
            bar.suspend(|| say!(out, "{}", row.trim_end()))?;
            text.push_str(&row);
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    replace_section(options.readme.as_deref(), "live", &text)?;
    say!(out, "\n{text}")
}

/// The scene, without the size of its pictures.
fn scene(light: &str) -> String {
    format!(
        "field = \"multi-scale\"\ncamera = {{ lon = 30, lat = 25, distance = 3.2, fov = 45 }}\n[transfer]\n\
         map = \"viridis\"\nrange = [-1, 1]\nopacity = [[-1, 0.9], [-0.3, 0], [0.3, 0], [1, 0.9]]\n{light}\n"
    )
}

/// Serves the page of a sphere to one client.
fn watched(sphere: &Sphere, options: &Options, light: &str) -> Result<Seen> {
    let (grid, field) = (sphere.grid()?, sphere.field()?);
    let read = |text: &str| Ok(vec![NamedScene { name: String::new(), scene: Scene::parse(text)? }]);
    let live_options = LiveOptions { port: None, size: PictureSize::Viewer, is_framed: false };
    let live = LiveView::open(&live_options, Description::default(), scene(light), 0, Box::new(read))?;
    let renderer = Renderer::new(options.threads)?.with_levels().with_stop(live.stop());
    thread::scope(|scope| {
        let client = scope.spawn(|| {
            let seen = turn(Client { page: PageClient::at(&live.address()), last: 0 }, options.turns);
            live.end();
            seen
        });
        while let Some(request) = live.next() {
            if let Request::Draw(wanted) = request {
                // The client gets the reason for the missing picture.
                let _ = live.publish(&wanted, |scene| renderer.render(scene, &grid, &sphere.layers, &field));
            }
        }
        let stopped = || Error::new(ErrorKind::Internal, "the client has stopped");
        client.join().map_err(|_| stopped())?
    })
}

/// Turns the globe and waits for the picture of each turn, then for that at rest; after a first turn, whose picture at
/// rest makes the grid's levels of detail.
fn turn(mut client: Client, turns: usize) -> Result<Seen> {
    client.picture(None, REST, false)?;
    client.picture(Some(1.0), REST, false)?;
    let (mut waits_s, mut coarsest) = (Vec::new(), (0.0, String::new()));
    let start = Instant::now();
    for number in 0..turns {
        let sent = Instant::now();
        let (pixel_step, quality) = client.picture(Some(3.0 * number as f64 % 360.0), MOVING, true)?;
        waits_s.push(sent.elapsed().as_secs_f64());
        if pixel_step > coarsest.0 {
            coarsest = (pixel_step, quality);
        }
    }
    let all_s = start.elapsed().as_secs_f64();
    let sent = Instant::now();
    client.picture(None, REST, false)?;
    let rest_s = sent.elapsed().as_secs_f64();
    waits_s.sort_by(f64::total_cmp);
    Ok(Seen { waits_s, all_s, coarsest: coarsest.1, rest_s })
}

struct Client {
    page: PageClient,
    /// Number of the last picture.
    last: u64,
}

fn unexpected(what: impl std::fmt::Display) -> Error {
    Error::new(ErrorKind::Io, format!("the page's server: {what}"))
}

impl Client {
    /// Turns the camera, asks for pictures of a size and waits for one, at rest unless the camera is moving; returns how
    /// many pixels apart its rays are and its quality in words.
    fn picture(&mut self, lon: Option<f64>, size: [u32; 2], is_moving: bool) -> Result<(f64, String)> {
        let changes: Vec<Value> =
            lon.iter().map(|lon| serde_json::json!({ "path": ["camera", "lon"], "value": lon })).collect();
        let body = serde_json::json!({ "changes": changes, "size": size, "is_moving": is_moving }).to_string();
        let answer = self.page.ask("POST /api/change", &body).map_err(unexpected)?;
        let answer: Value = serde_json::from_slice(&answer.body).map_err(unexpected)?;
        let revision = answer["revision"].as_u64().ok_or_else(|| unexpected(answer))?;
        loop {
            let answer = self.page.ask(&format!("GET /api/frame?after={}", self.last), "").map_err(unexpected)?;
            let Some((facts, _)) = answer.picture() else { continue };
            let facts: Value = serde_json::from_slice(facts).map_err(unexpected)?;
            if let Some(why) = facts["failure"].as_str() {
                return Err(unexpected(why));
            }
            self.last = facts["number"].as_u64().unwrap_or(self.last);
            let is_final = facts["pending"] == false && facts["is_moving"] == false;
            if facts["revision"].as_u64() >= Some(revision) && (is_final || is_moving) {
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
