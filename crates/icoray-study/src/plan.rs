//! Gain and overhead of each saving of the plan.
//!
//! One saving is switched off at a time. Frames with and without it alternate, each with a new field, as in a running
//! model; the minimum of their seconds counts.

use crate::results::{Table, in_turn, progress, say, threads};
use crate::scenes::multi_scale::{self, HEADLIGHT, TRANSFERS};
use crate::scenes::select;
use crate::speed::{PACKED, bytes_read};
use glam::DVec3;
use icoray::{FrameReport, Grid, Lights, Renderer, Result, Savings, Scene};
use icoray_reference::sphere::{self, Sphere};
use std::io::Write;
use std::path::PathBuf;

/// Options of the measurement.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Bisections of the icosahedron.
    #[arg(long, default_value_t = 7)]
    pub level: u32,
    /// Layers.
    #[arg(long, default_value_t = 26)]
    pub layers: usize,
    /// Width and height of the picture.
    #[arg(long, default_value_t = 512)]
    pub size: u32,
    /// Threads.
    #[arg(long, default_value_t = 1)]
    pub threads: usize,
    /// Frames with each saving and without it, of which the fastest counts.
    #[arg(long, default_value_t = 5)]
    pub frames: usize,
    /// Scenes by name; all where none is given.
    #[arg(long, value_delimiter = ',')]
    pub scenes: Vec<String>,
    /// Directory for plan.csv.
    #[arg(long, default_value = "study/plan")]
    pub out: PathBuf,
}

const ALL: Savings = Savings::ALL;

/// All savings but one, by the name of that.
const WITHOUT: [(&str, Savings); 8] = [
    ("leaps", Savings { empty_space: false, ..ALL }),
    ("layers", Savings { layers: false, ..ALL }),
    ("ends", Savings { ends: false, ..ALL }),
    ("gradients", Savings { gradients: false, ..ALL }),
    ("packing", Savings { packing: false, ..ALL }),
    ("lanes", Savings { lanes: false, ..ALL }),
    ("tiles", Savings { tiles: false, ..ALL }),
    ("reuse", Savings { reuse: false, ..ALL }),
];

const COLUMNS: &str = "scene,saving,seconds_with,seconds_without,saved_percent,bytes_read_with,bytes_read_without,\
    bytes_derived_with,bytes_derived_without";

/// Bytes that rays read, and those of derived data.
fn bytes(report: &FrameReport, is_packed: bool) -> [u64; 2] {
    let gradient = match (report.quality.lights, is_packed) {
        (Lights::Off, _) => 0,
        (_, true) => PACKED,
        (_, false) => 12,
    };
    [bytes_read(&report.counts, false, gradient), report.bytes_derived as u64]
}

/// Renders, prints a line for each scene and saving, and writes them to `plan.csv`.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let cases = select(CASES.into(), &options.scenes, |case| case.0)?;
    let mut csv = Table::create(options.out.join("plan.csv"), COLUMNS)?;
    let renderer = |savings| Ok(Renderer::new(options.threads)?.with_savings(savings));
    let all = renderer(ALL)?;
    let without = WITHOUT.iter().map(|(_, savings)| renderer(*savings)).collect::<Result<Vec<_>>>()?;
    say!(
        out,
        "level {} x {} layers, {} x {} pixels, {}, least of {} frames\n{}",
        options.level,
        options.layers,
        options.size,
        options.size,
        threads(all.threads()),
        options.frames.max(1),
        csv.heading()
    )?;
    let bar = progress(cases.len() * WITHOUT.len(), "plan");
    for (name, field, scene) in cases {
        bar.set_message(name);
        let sphere = Sphere::new(options.level, options.layers, [1.0, 1.15], field)?;
        let (grid, scene) = (all.run(|| sphere.grid())?, scene(options.size)?);
        for ((saving, _), without) in WITHOUT.iter().zip(&without) {
            let mut cells = vec![name.to_owned(), (*saving).to_owned()];
            cells.extend(measure([&all, without], saving, &scene, &grid, &sphere, options.frames)?);
            csv.print(&cells, &bar, out)?;
        }
    }
    Ok(())
}

/// The columns from `seconds_with` on.
fn measure(
    renderers: [&Renderer; 2],
    saving: &str,
    scene: &Scene,
    grid: &Grid,
    sphere: &Sphere,
    frames: usize,
) -> Result<Vec<String>> {
    let mut last = [FrameReport::default(), FrameReport::default()];
    let mut draw = |which: usize| {
        let field = sphere.field()?;
        let draw = || Ok(renderers[which].render(scene, grid, &sphere.layers, &field)?.report);
        let mut report: FrameReport = draw()?;
        if saving == "reuse" && which == 0 {
            // It takes effect in the second frame of a field.
            report = draw()?;
        }
        let seconds = report.timing.prepare_s + report.timing.render_s;
        last[which] = report;
        Ok(seconds)
    };
    // The first frames allocate memory.
    in_turn(1, &mut draw)?;
    let [with_s, without_s, _] = in_turn(frames, draw)?;
    let mut cells = [with_s, without_s].map(|s| format!("{s:.6}")).to_vec();
    cells.push(format!("{:.2}", 100.0 * (1.0 - with_s / without_s)));
    let [read, derived] = bytes(&last[0], true);
    let [read_without, derived_without] = bytes(&last[1], saving != "packing");
    cells.extend([read, read_without, derived, derived_without].map(|n| n.to_string()));
    Ok(cells)
}

/// Name, field, and scene of so many pixels in width and height.
type Case = (&'static str, fn(DVec3) -> f64, fn(u32) -> Result<Scene>);

const CASES: [Case; 9] = [
    ("dense", sphere::multi_scale, |size| of_speed(size, 0, "")),
    ("lobes", sphere::multi_scale, |size| of_speed(size, 1, "")),
    ("thin", sphere::multi_scale, |size| of_speed(size, 2, "")),
    ("opaque", sphere::multi_scale, |size| of_speed(size, 3, "")),
    ("dense, lit", sphere::multi_scale, |size| of_speed(size, 0, HEADLIGHT)),
    ("lobes, lit", sphere::multi_scale, |size| of_speed(size, 1, HEADLIGHT)),
    ("cloud", cloud, |size| of_cloud(size, "")),
    ("cloud, lit", cloud, |size| of_cloud(size, HEADLIGHT)),
    ("low cloud", low_cloud, |size| of_cloud(size, "")),
];

/// One of the scenes of `icoray-study speed`.
fn of_speed(size: u32, number: usize, light: &str) -> Result<Scene> {
    multi_scale::scene(size, TRANSFERS[number].1, "", light)
}

/// Cloud water: zero between clouds.
fn cloud(p: DVec3) -> f64 {
    (2.0 * sphere::multi_scale(p) - 1.0).max(0.0)
}

/// Clouds in the lowest third of the shell.
fn low_cloud(p: DVec3) -> f64 {
    if p.length() < 1.05 { cloud(p) } else { 0.0 }
}

fn of_cloud(size: u32, light: &str) -> Result<Scene> {
    let knots = "{ value = 0, color = \"white\", extinction = 0 }, { value = 1, color = \"white\", extinction = 200 }";
    multi_scale::globe("cloud water", size, "", &format!("knots = [ {knots} ]\n{light}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line for each scene and saving, on paper and in the table; rays read less where something is clear.
    #[test]
    fn each_saving_has_its_line() {
        let directory = tempfile::tempdir().unwrap();
        let options = Options {
            level: 4,
            layers: 12,
            size: 48,
            threads: 1,
            frames: 1,
            scenes: vec!["thin".into(), "dense, lit".into(), "low cloud".into()],
            out: directory.path().into(),
        };
        let mut out = Vec::new();
        run(&options, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert_eq!(text.lines().count(), 2 + 3 * WITHOUT.len(), "{text}");
        let mut table = csv::Reader::from_path(directory.path().join("plan.csv")).unwrap();
        let rows: Vec<_> = table.records().map(|row| row.unwrap()).collect();
        let number = |scene: &str, saving: &str, column: &str| -> f64 {
            let at = COLUMNS.split(',').position(|name| name == column).unwrap();
            let row = rows.iter().find(|row| row[0] == *scene && row[1] == *saving).unwrap();
            row[at].parse().unwrap()
        };
        let saved = |scene: &str, saving: &str, what: &str| {
            number(scene, saving, &format!("{what}_without")) - number(scene, saving, &format!("{what}_with"))
        };
        assert!(saved("thin", "leaps", "bytes_read") > 0.0);
        assert!(saved("low cloud", "layers", "bytes_read") > 0.0);
        assert!(saved("low cloud", "leaps", "bytes_read") > saved("low cloud", "layers", "bytes_read"));
        assert_eq!(saved("dense, lit", "leaps", "bytes_read"), 0.0, "nothing is clear");
        assert_eq!(saved("dense, lit", "packing", "bytes_derived"), (4 * 2562 * 12) as f64);
        assert!(rows.iter().all(|row| row[2].parse::<f64>().unwrap() > 0.0));
    }
}
