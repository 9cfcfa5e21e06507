//! Frames of two builds of this program, in turn.
//!
//! Both programs run beside each other, each with its own grid and field, and render a frame on request.

use super::instructions::Tool;
use super::options::{Options, Setting, Size, cores};
use crate::results::{in_turn, say};
use icoray::{Error, ErrorKind, Result};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};

/// What a bare run renders.
pub(super) struct BareRun<'s> {
    pub size: Size,
    pub setting: &'s Setting,
    pub pixels: u32,
    pub threads: usize,
    pub frames: usize,
}

impl BareRun<'_> {
    /// The command line behind the program's name.
    pub fn arguments(&self, options: &Options) -> Vec<String> {
        let BareRun { size, setting, pixels, threads, frames } = self;
        let Setting { case, light, tolerance } = setting;
        let Options { method, precision, heights, .. } = options;
        let line = format!(
            "speed --bare --pixels {pixels} --threads {threads} --sizes {size} --transfers {} --lights {light} \
             --tolerance {tolerance} --method {method} --precision {precision} --heights {heights} --frames {frames}",
            case.name
        );
        let hollow = options.hollow.then_some("--hollow");
        line.split_whitespace().chain(hollow).map(str::to_owned).collect()
    }
}

/// Prints least seconds of both builds, their ratio, the median ratio of pairs, and instructions per frustum.
pub(super) fn compare(
    options: &Options,
    settings: &[Setting],
    counter: Option<&Tool>,
    other: &Path,
    out: &mut dyn Write,
) -> Result<()> {
    let this = super::instructions::program()?;
    let programs = [other, this.as_path()];
    say!(out, "least seconds of {} frames in turn: {}, this build\n", options.frames, other.display())?;
    say!(out, "| grid, cores | scene | other, s | this, s | other / this | median of pairs |")?;
    say!(out, "| --- | --- | ---: | ---: | ---: | ---: |")?;
    for size in options.sizes() {
        for setting in settings {
            for &threads in &options.threads {
                let run = BareRun { size, setting, pixels: options.pixels(), threads, frames: options.frames.max(1) };
                let [other, this, pairs] = seconds(programs, &run, options)?;
                let row = format!("{size}, {} | {}", cores(&[threads]), setting.name());
                say!(out, "| {row} | {other:.4} | {this:.4} | {:.3} | {pairs:.3} |", other / this)?;
            }
        }
    }
    let Some(counter) = counter else { return Ok(()) };
    let count = |program: &Path| counter.count_all(program, options, settings);
    let [other, this] = [count(other)?, count(&this)?];
    say!(out, "\n| instructions per frustum, {}, by {} | other | this | other / this |", other.size, other.tool)?;
    say!(out, "| --- | ---: | ---: | ---: |")?;
    for (other, this) in other.per_frustum.iter().zip(&this.per_frustum) {
        let [a, b] = [other.instructions, this.instructions];
        say!(out, "| {} {} | {a:.1} | {b:.1} | {:.3} |", other.transfer, other.light, a / b)?;
    }
    Ok(())
}

/// Least seconds of each program, and the median ratio of a frame of the first to the next frame of the second.
fn seconds(programs: [&Path; 2], run: &BareRun, options: &Options) -> Result<[f64; 3]> {
    let arguments = run.arguments(options);
    let mut builds = [Build::start(programs[0], &arguments)?, Build::start(programs[1], &arguments)?];
    in_turn(run.frames, |which| builds[which].frame())
}

/// A program that renders a frame for each line of its input.
struct Build {
    name: String,
    child: Child,
    output: BufReader<ChildStdout>,
}

impl Build {
    fn start(program: &Path, arguments: &[String]) -> Result<Self> {
        let name = program.display().to_string();
        let mut command = Command::new(program);
        command.args(arguments).arg("--paced").stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().map_err(|e| Error::new(ErrorKind::Io, format!("{name}: {e}")))?;
        let output = BufReader::new(child.stdout.take().expect("its output is a pipe"));
        Ok(Build { name, child, output })
    }

    /// Renders a frame; returns its seconds.
    fn frame(&mut self) -> Result<f64> {
        let input = self.child.stdin.as_mut().expect("its input is a pipe");
        let mut line = String::new();
        let answer = writeln!(input).and_then(|()| self.output.read_line(&mut line));
        let seconds = line.strip_prefix("seconds ").and_then(|text| text.trim().parse().ok());
        seconds.filter(|_| answer.is_ok()).ok_or_else(|| {
            let what = "expected a build whose `icoray-study speed` has `--against`";
            Error::new(ErrorKind::Io, format!("{}: rendered no frame on request; {what}", self.name))
        })
    }
}

impl Drop for Build {
    fn drop(&mut self) {
        // It may have ended by an error already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
