//! VTK's virtual environment, its processes, the files that they read and their output.

use super::Options;
use crate::results::{io_error, read_text, say, write_file};
use icoray::{Error, ErrorKind, Result, Scene};
use icoray_reference::sphere::Sphere;
use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Packages from PyPI.
const PACKAGES: [&str; 2] = ["vtk==9.7.2", "numpy"];
const SCRIPT: &str = include_str!("draw.py");

/// Exit code of `timeout` where it has ended the process.
const TIMED_OUT: i32 = 124;

fn failed(what: impl std::fmt::Display) -> Error {
    Error::new(ErrorKind::Io, what.to_string())
}

/// A Python with VTK.
pub(super) struct Environment {
    python: PathBuf,
    script: PathBuf,
}

/// Output of a process, or else the reason of its failure.
pub(super) type Outcome = std::result::Result<ProcessOutput, String>;

/// Names and numbers that a process printed.
pub(super) struct ProcessOutput(String);

impl ProcessOutput {
    pub fn number(&self, name: &str) -> Result<f64> {
        let of_line = |line: &str| line.strip_prefix(name)?.trim().parse().ok();
        self.0.lines().find_map(of_line).ok_or_else(|| failed(format!("VTK's process printed no {name}")))
    }
}

impl Environment {
    /// The environment in `directory`, created if it does not exist.
    pub fn new(python: &Path, directory: &Path, out: &mut dyn Write) -> Result<Self> {
        let inner = directory.join("bin").join("python");
        let has_vtk = || Command::new(&inner).args(["-c", "import vtk, numpy"]).output();
        if !has_vtk().is_ok_and(|tried| tried.status.success()) {
            say!(out, "installing {} in {}", PACKAGES.join(", "), directory.display())?;
            run(Command::new(python).args(["-m", "venv"]).arg(directory))?;
            run(Command::new(&inner).args(["-m", "pip", "install", "--quiet"]).args(PACKAGES))?;
        }
        let script = directory.join("draw.py");
        write_file(&script, SCRIPT)?;
        Ok(Environment { python: inner, script })
    }

    /// Renders the model in `directory` with one of VTK's renderers, in its own process.
    pub fn draw(&self, directory: &Path, renderer: &str, options: &Options, picture: &Path) -> Result<Outcome> {
        let bytes = (options.memory * f64::from(1 << 30)) as u64;
        let log = directory.join(format!("{renderer}.log"));
        let output = std::fs::File::create(&log).map_err(|e| io_error(&log, e))?;
        let errors = output.try_clone().map_err(|e| io_error(&log, e))?;
        let mut command = Command::new("timeout");
        command.arg(options.patience.to_string()).arg(&self.python).arg(&self.script).arg(directory).arg(renderer);
        command.args([options.threads as u64, options.frames.max(1) as u64, bytes].map(|n| n.to_string()));
        // Off screen: VTK would look for a display first.
        command.arg(picture).env("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow");
        let status = command.stdin(Stdio::null()).stdout(output).stderr(errors).status();
        let status = status.map_err(|e| failed(format!("{command:?}: {e}")))?;
        if status.code() == Some(TIMED_OUT) {
            return Ok(Err(format!("not done after {} s", options.patience)));
        }
        let text = read_text(&log)?;
        if status.success() {
            return Ok(Ok(ProcessOutput(text)));
        }
        let last = text.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("no output");
        let memory = options.memory;
        Ok(Err(format!("{status} with at most {memory} GiB of memory: {last}")))
    }
}

fn run(command: &mut Command) -> Result<()> {
    let ended = command.output().map_err(|e| failed(format!("{command:?}: {e}")))?;
    if ended.status.success() {
        return Ok(());
    }
    let output = String::from_utf8_lossy(&ended.stderr);
    Err(failed(format!("{command:?}: {}: {}", ended.status, output.trim())))
}

/// Writes `scene.txt`, a line of numbers behind a name; `directions.f64`, `triangles.i32` and `values.f32`,
/// little-endian.
pub(super) fn write_model(directory: &Path, scene: &Scene, sphere: &Sphere) -> Result<()> {
    let put = |name: &str, bytes: Vec<u8>| write_file(&directory.join(name), bytes);
    let grid = sphere.grid()?;
    let directions = (0..grid.cells() as u32).flat_map(|cell| grid.direction(cell).to_array());
    put("directions.f64", directions.flat_map(f64::to_le_bytes).collect())?;
    let triangles = sphere.mesh.corner_cell.iter().map(|cell| cell - sphere.mesh.tables().index_base);
    put("triangles.i32", triangles.flat_map(i32::to_le_bytes).collect())?;
    put("values.f32", sphere.values.iter().flat_map(|v| v.to_le_bytes()).collect())?;
    put("scene.txt", text(scene, sphere.layers.radius_m()).into_bytes())
}

fn text(scene: &Scene, radii: &[f64]) -> String {
    let mut text = String::new();
    let mut line = |name: &str, numbers: &[f64]| {
        let numbers: Vec<_> = numbers.iter().map(|n| format!("{n:e}")).collect();
        let _ = writeln!(text, "{name} {}", numbers.join(" "));
    };
    let ([forward, _, up], half_height) = scene.camera.frame();
    line("size", &[scene.width, scene.height].map(f64::from));
    line("eye", &scene.camera.eye());
    line("forward", &forward);
    line("up", &up);
    line("half_height", &[half_height]);
    line("radii", radii);
    let unit = scene.volumes[0].transfer.unit_length.unwrap_or(radii[radii.len() - 1] - radii[0]);
    for knot in &scene.volumes[0].transfer.knots {
        let [red, green, blue] = knot.color;
        line("knot", &[knot.value, red, green, blue, knot.extinction / unit]);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn output_of_a_process_is_found_by_name_and_missing_numbers_are_errors() {
        let output = ProcessOutput("a warning\nwedges 97280\nfirst_s 1.5\n".into());
        assert_eq!(output.number("wedges").unwrap(), 97280.0);
        assert_eq!(output.number("first_s").unwrap(), 1.5);
        assert!(output.number("memory").unwrap_err().to_string().contains("memory"));
    }
}
