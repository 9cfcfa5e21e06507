//! Instructions per frustum, counted by perf or, without access to hardware counters, by valgrind.
//!
//! The study runs itself on a small grid with one frame and with none; the difference is a frame with its preparation.
//! Valgrind supports AVX2 at most.

use super::options::{Light, Options, Setting, Size};
use super::pairs::BareRun;
use icoray::{Error, ErrorKind, Result};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A tool that counts instructions.
pub(super) struct Tool {
    name: &'static str,
    /// The words of its command before the program's.
    words: &'static str,
    /// Parses the number of instructions from its line in stderr.
    count: fn(&str) -> Option<u64>,
}

static PERF: Tool = Tool {
    name: "perf",
    words: "perf stat -x , -e instructions:u --",
    count: |line| line.split_once(',').filter(|(_, rest)| rest.contains("instructions"))?.0.parse().ok(),
};

static VALGRIND: Tool = Tool {
    name: "valgrind, which has AVX2 at most",
    words: "valgrind --tool=callgrind --callgrind-out-file=/dev/null",
    count: |line| line.split_once("Collected :")?.1.split_whitespace().next()?.parse().ok(),
};

/// Instructions per frustum that was read.
pub(super) struct Counted {
    pub tool: &'static str,
    pub size: Size,
    pub per_frustum: Vec<PerFrustum>,
}

pub(super) struct PerFrustum {
    pub light: Light,
    pub transfer: &'static str,
    pub instructions: f64,
}

impl Tool {
    fn command(&self, program: &Path) -> Command {
        let mut words = self.words.split(' ');
        let mut command = Command::new(words.next().unwrap_or_default());
        command.args(words).arg(program);
        command
    }

    fn count(&self, output: &str) -> Option<u64> {
        output.lines().find_map(self.count)
    }

    /// The first tool that counts a run of this program with `--version`; an error where none does.
    pub fn find() -> Result<&'static Self> {
        let program = program()?;
        let counts = |tool: &&Tool| {
            let output = tool.command(&program).arg("--version").output();
            output.is_ok_and(|output| tool.count(&String::from_utf8_lossy(&output.stderr)).is_some())
        };
        let found = [&PERF, &VALGRIND].into_iter().find(counts);
        let context = "instructions are not counted: neither `perf stat` nor valgrind counts here";
        found.ok_or_else(|| Error::new(ErrorKind::Unsupported, context))
    }

    /// Counts in a build of this program, for each transfer function and light, at the first tolerance.
    pub fn count_all(&self, program: &Path, options: &Options, settings: &[Setting]) -> Result<Counted> {
        let first = options.tolerance.first();
        let is_counted = |setting: &&Setting| !setting.case.integrates || Some(&setting.tolerance) == first;
        let settings: Vec<_> = settings.iter().filter(is_counted).collect();
        let mut counted = Counted { tool: self.name, size: options.counted, per_frustum: Vec::new() };
        let Some(any) = settings.first() else { return Ok(counted) };
        let [none, _] = self.run(program, options, any, 0)?;
        // Counts are not affected by runs in parallel.
        let per_frustum = settings.par_iter().map(|setting| {
            let [one, frusta] = self.run(program, options, setting, 1)?;
            let instructions = one.saturating_sub(none) as f64 / frusta.max(1) as f64;
            Ok(PerFrustum { light: setting.light, transfer: setting.case.name, instructions })
        });
        counted.per_frustum = per_frustum.collect::<Result<_>>()?;
        Ok(counted)
    }

    /// Instructions of the whole program, and frusta of a frame.
    fn run(&self, program: &Path, options: &Options, setting: &Setting, frames: usize) -> Result<[u64; 2]> {
        let run = BareRun { size: options.counted, setting, pixels: 192, threads: 1, frames };
        let mut command = self.command(program);
        command.args(run.arguments(options));
        let output = command.output();
        let failed = |what: String| Error::new(ErrorKind::Io, format!("{command:?}: {what}"));
        let Output { stdout, stderr, status } = output.map_err(|e| failed(e.to_string()))?;
        let [stdout, stderr] = [stdout, stderr].map(|output| String::from_utf8_lossy(&output).into_owned());
        let frusta = stdout.lines().find_map(|line| line.strip_prefix("frusta ")?.parse().ok());
        match (self.count(&stderr), frusta) {
            (Some(count), Some(frusta)) if status.success() => Ok([count, frusta]),
            _ => Err(failed(format!("{status}: {}", stderr.trim()))),
        }
    }
}

pub(super) fn program() -> Result<PathBuf> {
    std::env::current_exe().map_err(|e| Error::new(ErrorKind::Io, format!("this program: {e}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_found_in_the_output_of_tools() {
        let perf = "a warning\n123456,,instructions:u,99,100.00,,\n";
        assert_eq!(PERF.count(perf), Some(123_456));
        assert_eq!(PERF.count("<not supported>,,instructions:u,0,100.00,,\n"), None);
        let valgrind = "==7== Events    : Ir\n==7== Collected : 5082613\n==7==\n";
        assert_eq!(VALGRIND.count(valgrind), Some(5_082_613));
        assert_eq!(VALGRIND.count("==7== Events    : Ir\n"), None);
    }
}
