//! A running model with viewers: its pictures, their changes and questions, on one process and over ranks.

mod bounds;
mod hostile;
mod model;
mod steered;
mod viewer;

use std::fs;
use std::path::{Path, PathBuf};

const SCENE: &str = "# A scene.\nfield = \"f\"\nexaggeration = 40\nimage = { width = 40, height = 30 }\n\
    camera = { lon = 20, lat = 35, distance = 3.2, fov = 45 } # from here\n\
    [transfer]\nmap = \"viridis\"\nrange = [-1.5, 1.5]\nopacity = [[-1.5, 0.8], [0, 0.1], [1.5, 0.9]]\n\
    [output]\nfile = \"frame_{step}.png\"\n";
/// A page whose viewers' pictures may take any time: other programs take theirs too.
const LIVE: &str = "[live]\ntime_budget_ms = 1e9\n";

fn pixels(png: &[u8]) -> Vec<u8> {
    image::load_from_memory(png).unwrap().into_rgba8().into_raw()
}

fn drawn(directory: &Path, step: u32) -> Vec<u8> {
    pixels(&fs::read(directory.join(format!("frame_{step}.png"))).unwrap())
}

/// Writes a scene and gives the path.
fn written(directory: &Path, name: &str, scene: &str) -> PathBuf {
    let path = directory.join(name);
    fs::write(&path, scene).unwrap();
    path
}
