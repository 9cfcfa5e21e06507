//! Gain and overhead of each saving of the plan.
//!
//! One saving is switched off at a time. Frames with and without it alternate, each with a new field, as in a running
//! model; the minimum of their seconds counts.

use crate::results::{Table, progress, say, threads};
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

/// All savings but one.
struct Without {
    saving: &'static str,
    savings: Savings,
}

const ALL: Savings = Savings::ALL;

const WITHOUT: [Without; 8] = [
    Without { saving: "leaps", savings: Savings { empty_space: false, ..ALL } },
    Without { saving: "layers", savings: Savings { layers: false, ..ALL } },
    Without { saving: "ends", savings: Savings { ends: false, ..ALL } },
    Without { saving: "gradients", savings: Savings { gradients: false, ..ALL } },
    Without { saving: "packing", savings: Savings { packing: false, ..ALL } },
    Without { saving: "lanes", savings: Savings { lanes: false, ..ALL } },
    Without { saving: "tiles", savings: Savings { tiles: false, ..ALL } },
    Without { saving: "reuse", savings: Savings { reuse: false, ..ALL } },
];

struct Cost {
    /// Minimum seconds of a frame, with preparation.
    seconds: f64,
    /// Bytes that rays read.
    read: u64,
    /// Bytes of derived data.
    derived: u64,
}

impl Cost {
    /// Of frames with the same data.
    fn of(reports: &[FrameReport], is_packed: bool) -> Self {
        let seconds = reports.iter().map(|report| report.timing.prepare_s + report.timing.render_s);
        let last = &reports[reports.len() - 1];
        let gradient = match (last.quality.lights, is_packed) {
            (Lights::Off, _) => 0,
            (_, true) => PACKED,
            (_, false) => 12,
        };
        Cost {
            seconds: seconds.fold(f64::INFINITY, f64::min),
            read: bytes_read(&last.counts, false, gradient),
            derived: last.bytes_derived as u64,
        }
    }
}

struct Row<'r> {
    scene: &'r str,
    saving: &'r str,
    with: Cost,
    without: Cost,
}

impl Row<'_> {
    const HEAD: &'static str = "scene,saving,seconds_with,seconds_without,saved_percent,bytes_read_with,bytes_read_without,\
        bytes_derived_with,bytes_derived_without";

    /// Percents of the seconds without the saving.
    fn saved_percent(&self) -> f64 {
        100.0 * (1.0 - self.with.seconds / self.without.seconds)
    }

    fn cells(&self) -> Vec<String> {
        let Row { scene, saving, with, without } = self;
        let mut cells = vec![(*scene).to_owned(), (*saving).to_owned()];
        cells.extend([with.seconds, without.seconds].map(|s| format!("{s:.6}")));
        cells.push(format!("{:.2}", self.saved_percent()));
        cells.extend([with.read, without.read, with.derived, without.derived].map(|n| n.to_string()));
        cells
    }
}

/// Renders, prints a line for each scene and saving, and writes them to `plan.csv`.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let cases = select(CASES.into(), &options.scenes, |case| case.name)?;
    let mut csv = Table::create(options.out.join("plan.csv"), Row::HEAD, Row::HEAD)?;
    let renderers = Renderers::new(options.threads)?;
    say!(
        out,
        "level {} x {} layers, {} x {} pixels, {}, least of {} frames\n{}",
        options.level,
        options.layers,
        options.size,
        options.size,
        threads(renderers.all.threads()),
        options.frames.max(1),
        csv.heading()
    )?;
    let bar = progress(cases.len(), "plan");
    for case in &cases {
        bar.set_message(case.name);
        let sphere = Sphere::new(options.level, options.layers, [1.0, 1.15], case.field)?;
        let grid = renderers.all.run(|| sphere.grid())?;
        let scene = (case.scene)(options.size)?;
        let rows = renderers.measure(case, &scene, &grid, &sphere, options.frames.max(1))?;
        for row in rows {
            let line = csv.row(&row.cells())?;
            bar.suspend(|| say!(out, "{line}"))?;
        }
        bar.inc(1);
    }
    Ok(())
}

/// A renderer with all savings, and one without each, in the order of [`WITHOUT`].
struct Renderers {
    all: Renderer,
    without: Vec<Renderer>,
}

impl Renderers {
    fn new(threads: usize) -> Result<Self> {
        let renderer = |savings| Ok(Renderer::new(threads)?.with_savings(savings));
        let without = WITHOUT.iter().map(|without| renderer(without.savings));
        Ok(Renderers { all: renderer(ALL)?, without: without.collect::<Result<_>>()? })
    }

    /// A row for each saving.
    fn measure<'r>(
        &self,
        case: &'r Case,
        scene: &Scene,
        grid: &Grid,
        sphere: &Sphere,
        frames: usize,
    ) -> Result<Vec<Row<'r>>> {
        let mut rows: Vec<Row> = Vec::new();
        for (Without { saving, .. }, renderer) in WITHOUT.iter().zip(&self.without) {
            let (mut with, mut without) = (Vec::new(), Vec::new());
            // The first frames allocate memory.
            for frame in 0..=frames {
                let field = sphere.field()?;
                let all = self.all.render(scene, grid, &sphere.layers, &field)?;
                // Reuse takes effect in the second frame of a field.
                let all = match *saving {
                    "reuse" => self.all.render(scene, grid, &sphere.layers, &field)?,
                    _ => all,
                };
                let reduced = renderer.render(scene, grid, &sphere.layers, &sphere.field()?)?;
                if frame > 0 {
                    with.push(all.report);
                    without.push(reduced.report);
                }
            }
            let (with, without) = (Cost::of(&with, true), Cost::of(&without, *saving != "packing"));
            rows.push(Row { scene: case.name, saving, with, without });
        }
        Ok(rows)
    }
}

#[derive(Debug)]
struct Case {
    pub name: &'static str,
    pub field: fn(DVec3) -> f64,
    pub scene: fn(u32) -> Result<Scene>,
}

const CASES: [Case; 9] = [
    case("dense", sphere::multi_scale, |size| of_speed(size, 0, "")),
    case("lobes", sphere::multi_scale, |size| of_speed(size, 1, "")),
    case("thin", sphere::multi_scale, |size| of_speed(size, 2, "")),
    case("opaque", sphere::multi_scale, |size| of_speed(size, 3, "")),
    case("dense, lit", sphere::multi_scale, |size| of_speed(size, 0, HEADLIGHT)),
    case("lobes, lit", sphere::multi_scale, |size| of_speed(size, 1, HEADLIGHT)),
    case("cloud", cloud, |size| of_cloud(size, "")),
    case("cloud, lit", cloud, |size| of_cloud(size, HEADLIGHT)),
    case("low cloud", low_cloud, |size| of_cloud(size, "")),
];

const fn case(name: &'static str, field: fn(DVec3) -> f64, scene: fn(u32) -> Result<Scene>) -> Case {
    Case { name, field, scene }
}

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
            let at = Row::HEAD.split(',').position(|name| name == column).unwrap();
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
