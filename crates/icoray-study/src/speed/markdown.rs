//! Measurements as rows of `speed.csv` and as the tables of the README.

use super::benchmark::{Memory, Row, Setup};
use super::instructions::Counted;
use super::machine::Bandwidth;
use super::options::{Light, Options, Size, cores};
use icoray::Result;
use std::fmt::Write as _;

pub(super) struct Measured<'m> {
    pub options: &'m Options,
    pub rows: &'m [Row],
    pub setups: &'m [Setup],
    /// Memory of a frame, by grid and light.
    pub memory: &'m [Memory],
    pub bandwidths: &'m [Bandwidth],
    /// `None` if not requested.
    pub counted: Option<Result<Counted>>,
}

/// Seconds with three decimals, or two from 0.1 s on.
fn seconds(s: f64) -> String {
    let digits = if s < 0.0995 { 3 } else { 2 };
    format!("{s:.digits$}")
}

/// 1234567 as 1,234,567.
fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let mut grouped = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

/// A table's row: `first`, and the other cells.
fn line(first: &str, cells: impl Iterator<Item = String>) -> String {
    cells.fold(format!("| {first} |"), |line, cell| format!("{line} {cell} |")) + "\n"
}

fn title(name: &str) -> &str {
    match name {
        "thin" => "thin shell",
        "walk" => "walk alone",
        other => other,
    }
}

impl Measured<'_> {
    pub fn markdown(&self) -> String {
        let mut text = self.frames();
        text += &self.rates();
        text += &self.tables();
        text
    }

    fn names(&self, with_walk: bool) -> Vec<&'static str> {
        let mut names: Vec<&'static str> = Vec::new();
        for case in self.rows.iter().map(|row| row.setting.case) {
            if (case.integrates || with_walk) && !names.contains(&case.name) {
                names.push(case.name);
            }
        }
        names
    }

    fn sizes(&self) -> Vec<Size> {
        let mut sizes: Vec<Size> = self.rows.iter().map(|row| row.size).collect();
        sizes.dedup();
        sizes
    }

    fn grid(&self, size: Size) -> String {
        let cells = self.rows.iter().find(|row| row.size == size).map_or(0, |row| row.cells);
        format!("{} cells × {} layers", grouped(cells), size.layers)
    }

    /// The rows of a scene: without light and tolerance where nothing is integrated.
    fn find(&self, size: Size, light: Light, tolerance: f64, name: &str) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |Row { size: of, setting, .. }| {
            let is_of = setting.tolerance == tolerance || !setting.case.integrates;
            *of == size && setting.case.name == name && setting.light == light && is_of
        })
    }

    fn head(first: &str, names: &[&str]) -> String {
        let titles = names.iter().map(|name| title(name).to_owned());
        line(first, titles) + "|---|" + &"---|".repeat(names.len()) + "\n"
    }

    /// Seconds of frames, by grid, light and tolerance.
    fn frames(&self) -> String {
        let options = self.options;
        let mut text = format!(
            "Seconds for a frame of a new field on {}, the least of {}; {} × {} pixels, 16 knots, {}, `{}`:\n\n",
            cores(&options.threads),
            options.frames,
            options.pixels(),
            options.pixels(),
            options.precision,
            options.method
        );
        let names = self.names(false);
        text += &Self::head("`icoray-study speed`", &names);
        for size in self.sizes() {
            for &light in &options.lights {
                for &tolerance in &options.tolerance {
                    let times = names.iter().map(|name| {
                        let rows = self.find(size, light, tolerance, name);
                        rows.map(|row| seconds(row.least_s())).collect::<Vec<_>>().join(", ")
                    });
                    text += &line(&format!("{}, {light}, tolerance {tolerance:e}", self.grid(size)), times);
                }
            }
        }
        text
    }

    /// Frusta per second on the first number of threads, unlit, at the first tolerance.
    fn rates(&self) -> String {
        let (options, names) = (self.options, self.names(true));
        let (Some(threads), Some(tolerance)) = (options.threads.first(), options.tolerance.first().copied()) else {
            return String::new();
        };
        let mut text = format!(
            "\nThroughput of rays on {}, unlit, tolerance {tolerance:e}: millions of frusta per second that rays cross and read; bytes \
             of tables and values that they read, also from caches, in percent of the memory bandwidth ({}). \"Walk alone\" \
             interpolates in all frusta without integration:\n\n",
            cores(&[*threads]),
            bandwidth_line(self.bandwidths)
        );
        text += &Self::head("millions of frusta/s crossed, read; of bandwidth", &names);
        for size in self.sizes() {
            let rates = names.iter().map(|name| {
                let mut rows = self.find(size, Light::Unlit, tolerance, name);
                let row = rows.find(|row| row.report.threads == *threads);
                row.map_or_else(String::new, |row| {
                    let [crossed, read] = row.rates().map(|rate| format!("{:.1}", 1e-6 * rate));
                    format!("{crossed}, {read}; {:.0} %", percent(row, self.bandwidths))
                })
            });
            text += &line(&self.grid(size), rates);
        }
        text += &self.scalar(&names, tolerance);
        text += &self.instructions(&names);
        text
    }

    /// Share of scalar code, at the first number of threads and this tolerance.
    fn scalar(&self, names: &[&str], tolerance: f64) -> String {
        let mut text = String::new();
        for (size, light) in
            self.sizes().into_iter().flat_map(|size| self.options.lights.iter().map(move |l| (size, *l)))
        {
            let shares = names.iter().map(|name| {
                let row = self.find(size, light, tolerance, name).next();
                row.map_or_else(String::new, |row| format!("{:.2} %", row.scalar_percent()))
            });
            text += &line(&format!("{}, {light}: pieces left to scalar code, of frusta read", self.grid(size)), shares);
        }
        text
    }

    fn instructions(&self, names: &[&str]) -> String {
        let counted = match &self.counted {
            None => return String::new(),
            Some(Err(why)) => return format!("\n{why}.\n"),
            Some(Ok(counted)) => counted,
        };
        let mut text = String::new();
        for light in &self.options.lights {
            let cells = names.iter().map(|name| {
                let found = counted.per_frustum.iter().find(|of| of.light == *light && of.transfer == *name);
                found.map_or_else(String::new, |of| format!("{:.0}", of.instructions))
            });
            text += &line(&format!("{light}: instructions per frustum that is read"), cells);
        }
        let (size, tool) = (counted.size, counted.tool);
        let _ = writeln!(
            text,
            "\nInstructions are those of whole frames, n = {} with {} layers, 192 × 192 pixels, counted by {tool}.",
            size.level, size.layers
        );
        text
    }

    /// Seconds and memory of grids.
    fn tables(&self) -> String {
        let mut text = format!(
            "\nSeconds in which tables are checked and derived on {}, bytes of derived tables, and the peak memory of a frame \
             beyond the model's arrays, its picture included, with its share of the field and the figure of the plan \
             (`icoray plan`) before it is drawn:\n\n",
            cores(&self.options.threads)
        );
        let lights = &self.options.lights;
        let heads = lights.iter().map(|light| format!("{light} frame, MiB (of the field; planned)"));
        text += &line("n | cells | seconds | bytes per cell | per triangle", heads);
        let _ = writeln!(text, "|---|---|---|---|---|{}", "---|".repeat(lights.len()));
        for setup in self.setups {
            let (level, cells, times) = (setup.level, grouped(setup.cells), setup.times());
            let [per_cell, per_triangle] =
                [setup.cells, setup.triangles].map(|count| setup.derived_bytes as f64 / count as f64);
            let first = format!("{level} | {cells} | {times} | {per_cell:.1} | {per_triangle:.1}");
            let frames = lights.iter().map(|light| {
                let memory = self.memory.iter().find(|of| of.size.level == setup.level && of.light == *light);
                memory.map_or_else(String::new, |memory| {
                    let field = 4.0 * (setup.cells * memory.size.layers) as f64;
                    let [measured, planned] = [memory.measured, memory.planned].map(|bytes| bytes as f64);
                    let [mebi, planned] = [measured, planned].map(|bytes| bytes / f64::from(1 << 20));
                    format!("{mebi:.1} ({:.0} %; {planned:.1})", 100.0 * measured / field)
                })
            });
            text += &line(&first, frames);
        }
        text
    }
}

pub(super) const COLUMNS: &str = "-level,-layers,-cells,-pixels,threads,transfer,light,tolerance,-method,-precision,\
    -frames,frame_least_s,frame_median_s,prepare_s,render_s,-rays,-columns,-frusta_crossed,-frusta_read,\
    -scalar_pieces,frusta_crossed_per_s,frusta_read_per_s,bytes_read,bandwidth_percent,-field_bytes,-derived_bytes";

pub(super) fn bandwidth_line(all: &[Bandwidth]) -> String {
    let of = |b: &Bandwidth| format!("{:.1} GB/s on {}", 1e-9 * b.bytes_per_s, cores(&[b.threads]));
    format!("memory is read in order at {}", all.iter().map(of).collect::<Vec<_>>().join(", "))
}

/// Bytes per second that rays read, in percent of the memory bandwidth of as many threads.
fn percent(row: &Row, all: &[Bandwidth]) -> f64 {
    let max = all.iter().find(|b| b.threads == row.report.threads).map_or(f64::NAN, |b| b.bytes_per_s);
    100.0 * row.bytes as f64 / row.report.timing.render_s / max
}

pub(super) fn cells(row: &Row, options: &Options, bandwidths: &[Bandwidth]) -> Vec<String> {
    let (setting, timing, counts) = (&row.setting, &row.report.timing, &row.report.counts);
    let method = if setting.case.integrates { options.method.as_str() } else { "none" };
    let mut cells = vec![row.size.level.to_string(), row.size.layers.to_string(), row.cells.to_string()];
    cells.extend([options.pixels().to_string(), row.report.threads.to_string()]);
    cells.extend([setting.case.name.to_owned(), setting.light.to_string()]);
    cells.extend([format!("{:e}", setting.tolerance), method.to_owned(), options.precision.clone()]);
    cells.push(row.seconds.len().to_string());
    let seconds = [row.least_s(), row.median_s(), timing.prepare_s, timing.render_s];
    cells.extend(seconds.map(|s| format!("{s:.6}")));
    cells
        .extend([counts.rays, counts.columns, row.crossed, counts.frusta, counts.scalar_pieces].map(|n| n.to_string()));
    cells.extend(row.rates().map(|rate| format!("{rate:.4e}")));
    cells.extend([row.bytes.to_string(), format!("{:.2}", percent(row, bandwidths))]);
    cells.extend([row.field_bytes, row.report.bytes_derived].map(|n| n.to_string()));
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_people_read_them() {
        assert_eq!([7, 1234, 655_362].map(grouped), ["7", "1,234", "655,362"]);
        assert_eq!([0.0123, 0.0996, 3.456].map(seconds), ["0.012", "0.10", "3.46"]);
    }
}
