//! What was measured as the tables of the README.

use super::case::Light;
use super::instructions::Counted;
use super::machine::Bandwidth;
use super::setup::Setup;
use super::stage::Row;
use super::{Options, Size, table};
use icoray::Result;
use std::fmt::Write as _;

/// All that was measured.
pub(super) struct Measured<'m> {
    pub options: &'m Options,
    pub rows: &'m [Row],
    pub setups: &'m [Setup],
    /// The most memory that a frame took, by grid and light.
    pub memory: &'m [(Size, Light, u64)],
    pub bandwidths: &'m [Bandwidth],
    /// `None` where nobody asked.
    pub counted: Option<Result<Counted>>,
}

/// Digits for seconds: three that mean something.
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

    /// Names of transfer functions, in the order in which they were asked for.
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

    fn head(text: &mut String, first: &str, names: &[&str]) {
        let names: Vec<&str> = names.iter().map(|name| title(name)).collect();
        let _ = writeln!(text, "| {first} | {} |\n|---|{}", names.join(" | "), "---|".repeat(names.len()));
    }

    /// Seconds of frames, by grid, light and tolerance.
    fn frames(&self) -> String {
        let options = self.options;
        let mut text = format!(
            "Seconds for a frame of a new field on {}, the least of {}; {} × {} pixels, 16 knots, {}, `{}`:\n\n",
            table::cores(&options.threads),
            options.frames,
            options.pixels(),
            options.pixels(),
            options.precision,
            options.method
        );
        let names = self.names(false);
        Self::head(&mut text, "`icoray-study speed`", &names);
        for size in self.sizes() {
            for light in &options.lights {
                for tolerance in &options.tolerance {
                    let _ = write!(text, "| {}, {light}, tolerance {tolerance:e} |", self.grid(size));
                    for name in &names {
                        let is_asked = |row: &&Row| {
                            let setting = &row.setting;
                            let is_scene = setting.light == *light && setting.tolerance == *tolerance;
                            row.size == size && setting.case.name == *name && is_scene
                        };
                        let times: Vec<_> =
                            self.rows.iter().filter(is_asked).map(|row| seconds(row.least_s())).collect();
                        let _ = write!(text, " {} |", times.join(", "));
                    }
                    text.push('\n');
                }
            }
        }
        text
    }

    /// What rays do in a second, on the first number of threads, unlit, at the first tolerance.
    fn rates(&self) -> String {
        let (options, names) = (self.options, self.names(true));
        let (Some(threads), Some(tolerance)) = (options.threads.first(), options.tolerance.first()) else {
            return String::new();
        };
        let mut text = format!(
            "\nWhat rays do in a second on {}, unlit, tolerance {tolerance:e}: millions of frusta that they cross, and of these read; bytes of \
             tables and values that they read, from wherever they are served, in percent of what memory gives ({}). Where rays walk \
             alone they interpolate in all frusta, and nothing is integrated:\n\n",
            table::cores(&[*threads]),
            table::bandwidths(self.bandwidths)
        );
        Self::head(&mut text, "millions of frusta/s crossed, read; of memory's", &names);
        for size in self.sizes() {
            let _ = write!(text, "| {} |", self.grid(size));
            for name in &names {
                let is_asked = |row: &&Row| {
                    let setting = &row.setting;
                    let is_scene = setting.light == Light::Unlit
                        && (setting.tolerance == *tolerance || !setting.case.integrates);
                    row.size == size && row.threads == *threads && setting.case.name == *name && is_scene
                };
                let cell = self.rows.iter().find(is_asked).map(|row| {
                    let [crossed, read] = row.rates().map(|rate| format!("{:.1}", 1e-6 * rate));
                    format!("{crossed}, {read}; {:.0} %", table::percent(row, self.bandwidths))
                });
                let _ = write!(text, " {} |", cell.unwrap_or_default());
            }
            text.push('\n');
        }
        text += &self.instructions(&names);
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
            let _ = write!(text, "| {light}: instructions per frustum that is read |");
            for name in names {
                let found = counted.per_frustum.iter().find(|of| of.0 == *light && of.1 == *name);
                let _ = write!(text, " {} |", found.map_or_else(String::new, |of| format!("{:.0}", of.2)));
            }
            text.push('\n');
        }
        let (size, tool) = (counted.size, counted.tool.name());
        let _ = writeln!(
            text,
            "\nInstructions are those of whole frames, n = {} with {} layers, 192 × 192 pixels, counted by {tool}.",
            size.level, size.layers
        );
        text
    }

    /// What grids cost.
    fn tables(&self) -> String {
        let mut text = format!(
            "\nSeconds in which tables are checked and derived on {}, what is kept of them beside the model's own, and the most memory that a \
             frame takes beyond the model's arrays, its picture included, with what that is of the field:\n\n\
             | n | cells | seconds | bytes per cell | per triangle |",
            table::cores(&self.options.threads)
        );
        for light in &self.options.lights {
            let _ = write!(text, " {light} frame, MiB |");
        }
        let _ = writeln!(text, "\n|---|---|---|---|---|{}", "---|".repeat(self.options.lights.len()));
        for setup in self.setups {
            let _ = write!(
                text,
                "| {} | {} | {} | {:.1} | {:.1} |",
                setup.level,
                grouped(setup.cells),
                setup.times(),
                setup.per_cell(),
                setup.per_triangle()
            );
            for light in &self.options.lights {
                let of = self.memory.iter().find(|of| of.0.level == setup.level && of.1 == *light);
                let cell = of.map(|(size, _, bytes)| {
                    let field = 4.0 * (setup.cells * size.layers) as f64;
                    let (mebi, percent) = (*bytes as f64 / f64::from(1 << 20), 100.0 * *bytes as f64 / field);
                    format!("{mebi:.1} ({percent:.0} %)")
                });
                let _ = write!(text, " {} |", cell.unwrap_or_default());
            }
            text.push('\n');
        }
        text
    }
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
