//! Scenes in which ray casting is easily slow, each beside a scene that should cost about as much.
//!
//! Frames of both alternate: the least seconds of each are reported, and the median ratio of pairs.

use crate::results::{Table, in_turn, io_error, progress, replace_section, say, timed};
use crate::scenes::multi_scale::{self, HEADLIGHT, RANGE, TRANSFERS, volume};
use crate::scenes::select;
use crate::speed::{self, Size};
use icoray::output::write_picture;
use icoray::{Fields, Renderer, Result};
use icoray_reference::sphere::{self, Sphere};
use std::io::Write;
use std::path::PathBuf;

/// Options of the measurement.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Width and height of the pictures; one scene has twice that.
    #[arg(long, default_value_t = 512)]
    pub pixels: u32,
    /// Number of threads.
    #[arg(long, value_parser = speed::count, default_value = "1")]
    pub threads: usize,
    /// Pairs of frames.
    #[arg(long, default_value_t = 5)]
    pub frames: usize,
    /// Bisections of the icosahedron x layers for all scenes, in place of their own.
    #[arg(long, value_parser = speed::size)]
    pub size: Option<Size>,
    /// Names of scenes, or beginnings of names and `*`; all by default.
    #[arg(long, value_delimiter = ',')]
    pub scenes: Vec<String>,
    /// Directory of corners.csv and of the pictures.
    #[arg(long, default_value = "out/corners")]
    pub out: PathBuf,
    /// A file in which the table takes the place of that between its lines `<!-- icoray-study corners -->` and `<!--
    /// end -->`.
    #[arg(long)]
    pub readme: Option<PathBuf>,
}

const COLUMNS: &str = "scene,size,seconds,base,base_size,base_seconds,ratio,aim";

/// A scene, the one beside it, and the aim: the largest ratio of both, or seconds.
struct Corner {
    name: &'static str,
    case: Case,
    base_name: &'static str,
    base: Case,
    aim: &'static str,
}

#[derive(Debug, Clone)]
struct Case {
    size: Size,
    pixels: u32,
    scene: String,
}

/// Measures all scenes, prints a line for each and writes table and pictures.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let renderer = Renderer::new(options.threads)?;
    let corners = select(corners(options), &options.scenes, |corner| corner.name)?;
    let mut table = Table::create(options.out.join("corners.csv"), COLUMNS)?;
    let mut markdown = "| scene | n × layers | s | beside | n × layers | s | ratio | aim |\n".to_owned();
    markdown += "|---|---|---|---|---|---|---|---|\n";
    say!(out, "{}", table.heading())?;
    let bar = progress(corners.len(), "scenes");
    for Corner { name, case, base_name, base, aim } in &corners {
        bar.set_message(*name);
        let [seconds, base_seconds, ratio] = measure([case, base], name, &renderer, options)?;
        let [size, base_size] = [case, base].map(|case| case.size.to_string());
        let [name, base_name, aim] = [name, base_name, aim].map(|text| text.replace('_', " "));
        let row = [name, size, seconds, base_name, base_size, base_seconds, ratio, aim];
        markdown += &format!("| {} |\n", row.join(" | "));
        table.print(&row, &bar, out)?;
    }
    replace_section(options.readme.as_deref(), "corners", &markdown)
}

/// Writes the pictures of both cases; returns their least seconds, and the median of their ratios.
fn measure(cases: [&Case; 2], name: &str, renderer: &Renderer, options: &Options) -> Result<[String; 3]> {
    let [sphere, base] = cases.map(|Case { size, .. }| {
        renderer.run(|| Sphere::new(size.level, size.layers, [1.0, 1.15], sphere::multi_scale))
    });
    let spheres = [sphere?, base?];
    let grids = [spheres[0].grid()?, spheres[1].grid()?];
    let [scene, base] = cases.map(|case| multi_scale::view(case.pixels, &case.scene));
    let scenes = [scene?, base?];
    let figures = in_turn(options.frames, |which| {
        // New fields, from which nothing derived is cached.
        let sphere = &spheres[which];
        let fields = Fields::new([("f", sphere.field()?), ("g", sphere.field()?)]);
        let (seconds, frame) = timed(renderer, &scenes[which], &grids[which], &sphere.layers, fields)?;
        let path = options.out.join(format!("{name}_{}{}.png", cases[0].size, ["", "_base"][which]));
        write_picture(&path, &frame).map_err(|e| io_error(&path, e))?;
        Ok(seconds)
    })?;
    Ok(figures.map(|number| format!("{number:.3}")))
}

fn corners(options: &Options) -> Vec<Corner> {
    let pixels = options.pixels;
    let on = |level, layers, scene: &str| Case {
        size: options.size.unwrap_or(Size { level, layers }),
        pixels,
        scene: scene.to_owned(),
    };
    let corner = |name, case, base_name, base, aim| Corner { name, case, base_name, base, aim };
    let lit = |scene: &str| format!("{scene}{HEADLIGHT}\n");
    let [dense, lobes, other] = [("f", TRANSFERS[0].1), ("f", multi_scale::lobes), ("g", multi_scale::lobes)]
        .map(|(field, opacity)| volume(field, &multi_scale::knots(16, opacity)));
    let both = format!("{lobes}{other}");
    let (dense_lit, isosurfaces) = (lit(&dense), lit(ISOSURFACES));
    let hollow = |level| on(level, 20, &format!("core = \"transparent\"\n{dense}"));
    let bent = |count| on(5, 20, &volume("f", &multi_scale::knots(count, |value| 0.5 + 0.4 * (99.0 * value).sin())));
    let straight = |parts| on(5, 20, &volume("f", &zigzag(15, parts)));
    let large = Case { pixels: 2 * pixels, ..on(5, 20, &dense) };
    vec![
        corner("layer", on(5, 20, LAYER), "dense volume", on(5, 20, &dense), "0.03 s"),
        corner("layer", on(6, 40, LAYER), "dense volume", on(6, 40, &dense), "0.05 s"),
        corner("layer_below_320", on(5, 320, LAYER), "layer", on(5, 20, LAYER), "1"),
        corner("isosurfaces", on(5, 20, &isosurfaces), "dense lit volume", on(5, 20, &dense_lit), "0.10 s"),
        corner("isosurfaces", on(6, 40, &isosurfaces), "dense lit volume", on(6, 40, &dense_lit), "0.15 s"),
        corner("four_times_the_pixels", large, "pixels", on(5, 20, &dense), "3"),
        corner("hollow", hollow(6), "hollow", hollow(5), "1.3"),
        corner("hollow", hollow(7), "hollow", hollow(6), "1.3"),
        corner("991_knots_on_15_lines", straight(66), "16 knots", straight(1), "1.1"),
        corner("256_knots", bent(256), "16 knots", bent(16), "2"),
        corner("1,024_knots", bent(1024), "16 knots", bent(16), "2"),
        corner("two_volumes", on(5, 20, &both), "one", on(5, 20, &lobes), "1.6"),
        corner("two_lit_volumes", on(5, 20, &lit(&both)), "one lit", on(5, 20, &lit(&lobes)), "2"),
    ]
}

/// An opaque layer below all others.
const LAYER: &str =
    "[[surfaces]]\nlayer = \"bottom\"\nfield = \"f\"\ntransfer = { map = \"viridis\", range = [-1, 1] }\n";

const ISOSURFACES: &str = "[[isosurfaces]]\nfield = \"f\"\nvalues = [-0.3, 0.4]\ncolors = [\"teal\", \"gold\"]\n";

/// The text of knots on `lines` lines, each in so many parts, of extinctions that rise and fall.
fn zigzag(lines: u32, parts: u32) -> String {
    let knot = |i| {
        let place = f64::from(i) / f64::from(parts);
        let value = RANGE[0] + (RANGE[1] - RANGE[0]) * place / f64::from(lines);
        let extinction = 1.0 - (place.rem_euclid(2.0) - 1.0).abs();
        format!("  {{ value = {value}, color = \"white\", extinction = {extinction} }},\n")
    };
    (0..=lines * parts).map(knot).collect()
}
