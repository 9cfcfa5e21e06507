//! Instructions per frustum, counted by perf or, where a machine's counters are not to be had, by valgrind.
//!
//! The study runs itself on a small grid with one frame and with none: the difference is a frame, with all that is done
//! before its rays. Valgrind has AVX2 at most.

use super::case::{Light, Setting};
use super::{Options, Size};
use icoray::{Error, ErrorKind, Result};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tool {
    Perf,
    Valgrind,
}

impl Tool {
    const ALL: [Self; 2] = [Tool::Perf, Tool::Valgrind];

    pub fn name(self) -> &'static str {
        match self {
            Tool::Perf => "perf",
            Tool::Valgrind => "valgrind, which has AVX2 at most",
        }
    }

    /// Runs a program under it.
    fn command(self, program: &Path) -> Command {
        let mut command = match self {
            Tool::Perf => Command::new("perf"),
            Tool::Valgrind => Command::new("valgrind"),
        };
        match self {
            Tool::Perf => command.args(["stat", "-x", ",", "-e", "instructions:u", "--"]),
            Tool::Valgrind => command.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]),
        };
        command.arg(program);
        command
    }

    /// The number of instructions in what it wrote to stderr.
    fn count(self, said: &str) -> Option<u64> {
        said.lines().find_map(|line| match self {
            Tool::Perf => {
                line.split_once(',').filter(|(_, rest)| rest.contains("instructions"))?.0.parse().ok()
            }
            Tool::Valgrind => line.split_once("Collected :")?.1.split_whitespace().next()?.parse().ok(),
        })
    }
}

/// A tool that is there and counts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counter(Tool);

/// Instructions per frustum that was read.
#[derive(Debug, Clone)]
pub(super) struct Counted {
    pub tool: Tool,
    pub size: Size,
    /// By light and transfer function.
    pub per_frustum: Vec<(Light, &'static str, f64)>,
}

impl Counter {
    /// The first one that counts what this program does to say its version.
    ///
    /// # Errors
    /// [`ErrorKind::Unsupported`] where there is none.
    pub fn find() -> Result<Self> {
        let program = program()?;
        let counts = |tool: &Tool| {
            let output = tool.command(&program).arg("--version").output();
            output.is_ok_and(|output| tool.count(&String::from_utf8_lossy(&output.stderr)).is_some())
        };
        let found = Tool::ALL.into_iter().find(counts).map(Counter);
        let context = "instructions are not counted: neither `perf stat` nor valgrind counts here";
        found.ok_or_else(|| Error::new(ErrorKind::Unsupported, context))
    }

    /// Counts those of each transfer function and light, at the first tolerance.
    pub fn count_all(self, options: &Options, settings: &[Setting]) -> Result<Counted> {
        let first = options.tolerance.first();
        let asked = |setting: &&Setting| !setting.case.integrates || Some(&setting.tolerance) == first;
        let asked: Vec<_> = settings.iter().filter(asked).collect();
        let Some(any) = asked.first() else {
            return Ok(Counted { tool: self.0, size: options.counted, per_frustum: Vec::new() });
        };
        let [none, _] = self.run(options, any, 0)?;
        // Counts do not mind each other.
        let per_frustum = asked.par_iter().map(|setting| {
            let [one, frusta] = self.run(options, setting, 1)?;
            let per_frustum = one.saturating_sub(none) as f64 / frusta.max(1) as f64;
            Ok((setting.light, setting.case.name, per_frustum))
        });
        Ok(Counted { tool: self.0, size: options.counted, per_frustum: per_frustum.collect::<Result<_>>()? })
    }

    /// Instructions of the whole program, and frusta of a frame.
    fn run(self, options: &Options, setting: &Setting, frames: usize) -> Result<[u64; 2]> {
        let mut command = self.0.command(&program()?);
        let [size, tolerance] = [options.counted.to_string(), setting.tolerance.to_string()];
        let (frames, light) = (frames.to_string(), setting.light.name());
        command.args(["speed", "--bare", "--pixels", "192", "--threads", "1", "--sizes", &size]);
        command.args(["--transfers", setting.case.name, "--lights", light, "--tolerance", &tolerance]);
        command.args(["--method", &options.method, "--precision", &options.precision, "--frames", &frames]);
        let output = command.output();
        let failed = |what: String| Error::new(ErrorKind::Io, format!("{command:?}: {what}"));
        let Output { stdout, stderr, status } = output.map_err(|e| failed(e.to_string()))?;
        let [stdout, stderr] = [stdout, stderr].map(|said| String::from_utf8_lossy(&said).into_owned());
        let frusta = stdout.lines().find_map(|line| line.strip_prefix("frusta ")?.parse().ok());
        match (self.0.count(&stderr), frusta) {
            (Some(count), Some(frusta)) if status.success() => Ok([count, frusta]),
            _ => Err(failed(format!("{status}: {}", stderr.trim()))),
        }
    }
}

fn program() -> Result<PathBuf> {
    std::env::current_exe().map_err(|e| Error::new(ErrorKind::Io, format!("this program: {e}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_found_in_what_tools_say() {
        let perf = "a warning\n123456,,instructions:u,99,100.00,,\n";
        assert_eq!(Tool::Perf.count(perf), Some(123_456));
        assert_eq!(Tool::Perf.count("<not supported>,,instructions:u,0,100.00,,\n"), None);
        let valgrind = "==7== Events    : Ir\n==7== Collected : 5082613\n==7==\n";
        assert_eq!(Tool::Valgrind.count(valgrind), Some(5_082_613));
        assert_eq!(Tool::Valgrind.count("==7== Events    : Ir\n"), None);
    }
}
