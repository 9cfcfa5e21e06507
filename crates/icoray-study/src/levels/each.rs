//! Each level of detail of three fields: its time, its errors, and its picture.

use super::Options;
use crate::picture::write_pixels;
use crate::results::{Table, progress, replace_section, say, timed};
use crate::scenes::{Dataset, StudyScene, all, data_directory, multi_scale, select};
use icoray::{Field, Frame, Grid, Layers, Precision, Renderer, Result, Scene};
use icoray_progress::Bar;
use icoray_reference::comparison::Comparison;
use icoray_reference::sphere::{Sphere, multi_scale as multi_scale_field};
use std::io::Write;

/// Number of levels in the pictures, with the model's grid.
const LEVELS: u32 = 6;
/// Tolerances on the model's grid, for comparison.
const TOLERANCES: [f64; 3] = [1e-1, 1e-2, 1e-4];
/// The logarithms of errors that are black and white in the pictures.
const SHADES: [f64; 2] = [-5.0, 0.0];
const COLUMNS: &str = "scene,drawn,s,half_differ,999_differ,most_differ,half_report,most_report,within_percent";

/// Draws the levels of all three fields; prints and writes a table, and pictures.
pub(super) fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let mut study = Study {
        options,
        finest: Renderer::new(options.threads)?,
        table: Table::create(options.out.join("each_level.csv"), COLUMNS)?,
        markdown: "| scene | drawn | s | difference of half of the pixels | of 99.9 % | largest | error reported by half | largest | reported within 1e-2 |\n\
                   |---|---|---|---|---|---|---|---|---|\n"
            .to_owned(),
        bar: progress(3 * (LEVELS as usize + TOLERANCES.len()), "pictures"),
        out,
    };
    say!(study.out, "{}", study.table.heading())?;
    let size = options.sizes[0];
    let sphere = study.finest.run(|| Sphere::new(size.level, size.layers, [1.0, 1.15], multi_scale_field))?;
    for &(name, opacity) in &multi_scale::TRANSFERS[..2] {
        let volume = multi_scale::volume("f", &multi_scale::knots(16, opacity));
        let scene = multi_scale::view(options.pixels, &volume)?;
        study.draw(&format!("{size} {name}"), &scene, &sphere.grid()?, &sphere.layers, &sphere.field()?)?;
    }
    let theta = select(all(options.pixels)?, &["jw_theta".to_owned()], |scene: &StudyScene| &scene.name)?;
    let data = data_directory(options.data.as_deref());
    let finest = Renderer::new(options.threads)?;
    let is_there = Dataset::Theta.with(false, &data, &finest, |grid, layers, field| {
        study.draw("theta of MPAS", &theta[0].scene, grid, layers, field)
    })?;
    if !is_there {
        say!(study.out, "theta of MPAS is left out: no file in {}", data.display())?;
    }
    replace_section(options.readme.as_deref(), "levels --each", &study.markdown)
}

struct Study<'s> {
    options: &'s Options,
    finest: Renderer,
    table: Table,
    markdown: String,
    bar: Bar,
    out: &'s mut dyn Write,
}

/// A picture of a scene, compared with the true one.
struct Drawn {
    seconds: f64,
    frame: Frame,
    differences: Vec<f64>,
}

impl Drawn {
    fn difference(&self, part: f64) -> f64 {
        quantile(&self.differences, part)
    }

    fn reported(&self, part: f64) -> f64 {
        quantile(&self.errors(), part)
    }

    fn errors(&self) -> Vec<f64> {
        self.frame.error.iter().map(|error| f64::from(*error)).collect()
    }
}

/// The value at a part of the sorted values of pixels.
fn quantile(values: &[f64], part: f64) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * part).round() as usize]
}

impl Study<'_> {
    /// Draws a scene on all levels, and on the grid itself with several tolerances.
    fn draw(&mut self, name: &str, scene: &Scene, grid: &Grid, layers: &Layers, field: &Field) -> Result<()> {
        let scene = Scene { lighting: None, antialias: false, tolerance: 1e-3, ..scene.clone() };
        let truth = Scene { precision: Precision::F64, tolerance: 1e-7, ..scene.clone() };
        let truth = timed(&self.finest, &truth, grid, layers, field)?.1;
        let measure = |renderer: &Renderer, scene: &Scene| {
            timed(renderer, scene, grid, layers, field)?;
            let (mut seconds, mut frame) = timed(renderer, scene, grid, layers, field)?;
            for _ in 1..self.options.frames {
                let again = timed(renderer, scene, grid, layers, field)?;
                (seconds, frame) = (seconds.min(again.0), again.1);
            }
            let differences = Comparison::new(&frame.pixels, &truth.pixels).pixel_errors;
            Ok::<Drawn, icoray::Error>(Drawn { seconds, frame, differences })
        };
        let mut levels = Vec::new();
        for level in 0..LEVELS {
            let drawn = measure(&Renderer::new(self.options.threads)?.on_level(level), &scene)?;
            if drawn.frame.report.quality.level != level {
                break;
            }
            levels.push(drawn);
        }
        let mut tolerances = Vec::new();
        for tolerance in TOLERANCES {
            tolerances.push(measure(&self.finest, &Scene { tolerance, ..scene.clone() })?);
        }
        for (level, drawn) in levels.iter().enumerate() {
            self.print(name, &format!("level {level}"), drawn)?;
        }
        for (tolerance, drawn) in TOLERANCES.iter().zip(&tolerances) {
            self.print(name, &format!("tolerance {tolerance:e}"), drawn)?;
        }
        let file = name.replace(' ', "_");
        let sheet = Sheet { side: [scene.width, scene.height], levels: &levels };
        write_pixels(&self.options.out.join(format!("{file}.png")), sheet.size(), sheet.pixels())
    }

    fn print(&mut self, name: &str, kind: &str, drawn: &Drawn) -> Result<()> {
        let within = drawn.errors().iter().filter(|error| **error <= 1e-2).count();
        let number = |value: f64| format!("{value:.1e}");
        let row = vec![
            name.to_owned(),
            kind.to_owned(),
            format!("{:.3}", drawn.seconds),
            number(drawn.difference(0.5)),
            number(drawn.difference(0.999)),
            number(drawn.difference(1.0)),
            number(drawn.reported(0.5)),
            number(drawn.reported(1.0)),
            format!("{:.0} %", 100.0 * within as f64 / drawn.differences.len() as f64),
        ];
        self.markdown += &format!("| {} |\n", row.join(" | "));
        self.table.print(&row, &self.bar, self.out)
    }
}

/// The pictures of all levels side by side, over their differences from the true picture and over their reported
/// errors, from black for 1e-5 to white for 1.
struct Sheet<'s> {
    side: [u32; 2],
    levels: &'s [Drawn],
}

impl Sheet<'_> {
    fn size(&self) -> [u32; 2] {
        let [width, height] = self.side;
        [width * self.levels.len() as u32, 3 * height]
    }

    fn pixels(&self) -> Vec<[f32; 4]> {
        let [width, height] = self.side.map(|side| side as usize);
        let shade = |error: f64| {
            let shade = (error.log10() - SHADES[0]) / (SHADES[1] - SHADES[0]);
            [shade.clamp(0.0, 1.0) as f32; 3]
        };
        let pixel = |at: usize| {
            let (row, column) = (at / (width * self.levels.len()), at % (width * self.levels.len()));
            let (drawn, pixel) = (&self.levels[column / width], row % height * width + column % width);
            let [r, g, b] = match row / height {
                0 => [0, 1, 2].map(|k| drawn.frame.pixels[pixel][k]),
                1 => shade(drawn.differences[pixel]),
                _ => shade(f64::from(drawn.frame.error[pixel])),
            };
            [r, g, b, 1.0]
        };
        (0..3 * height * width * self.levels.len()).map(pixel).collect()
    }
}
