//! A model that draws a step on request.

use super::viewer::Viewer;
use super::{drawn, written};
use icoray_tests::native::{command, compile_c, mpi_library};
use icoray_tests::ranks::FIRST;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::thread;
use tempfile::TempDir;

/// A program that draws a step on request.
pub struct Model {
    child: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
    log: Option<thread::JoinHandle<String>>,
    pub step: u32,
}

impl Model {
    pub fn start(run: &mut Command) -> Self {
        let mut child = run.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let output = BufReader::new(child.stdout.take().unwrap());
        let mut errors = child.stderr.take().unwrap();
        let log = thread::spawn(move || {
            let mut log = String::new();
            errors.read_to_string(&mut log).unwrap();
            log
        });
        Model { input: child.stdin.take(), output, log: Some(log), child, step: 0 }
    }

    /// Draws the next step and returns its number.
    pub fn draw(&mut self) -> u32 {
        self.input.as_mut().unwrap().write_all(b"\n").unwrap();
        let mut line = String::new();
        self.output.read_line(&mut line).unwrap();
        if line.trim() != format!("step {}", self.step) {
            panic!("{line}\n{}", self.log());
        }
        self.step += 1;
        self.step - 1
    }

    /// Draws steps until a question is answered.
    pub fn draw_until<T>(&mut self, question: thread::JoinHandle<T>) -> T {
        while !question.is_finished() {
            assert!(self.step < 2000, "nobody answers");
            self.draw();
        }
        question.join().unwrap()
    }

    /// Ends its input and returns its log.
    fn log(&mut self) -> String {
        drop(self.input.take());
        self.log.take().map(|log| log.join().unwrap()).unwrap_or_default()
    }

    /// Ends it; returns its log.
    pub fn end(mut self) -> String {
        let log = self.log();
        let mut rest = String::new();
        self.output.read_to_string(&mut rest).unwrap();
        assert!(self.child.wait().unwrap().success() && rest.contains(", 0 failed"), "{rest}\n{log}");
        log
    }
}

/// A lone model that is watched, once it has drawn its first step.
pub struct Watched {
    pub folder: TempDir,
    /// Where it draws.
    pub to: PathBuf,
    pub model: Model,
    pub viewer: Viewer,
}

impl Watched {
    /// A model of a scene that `run` starts, with a directory and the scene's file.
    pub fn run(scene: &str, run: impl Fn(&Path, &Path) -> Command) -> Self {
        let folder = TempDir::new().unwrap();
        let scene = written(folder.path(), "scene.toml", scene);
        let to = folder.path().join("watched");
        let mut model = Model::start(&mut run(&to, &scene));
        model.draw();
        Watched { viewer: Viewer::of(&to), folder, to, model }
    }

    /// A model of a way of `live.c`.
    pub fn start(way: &str, scene: &str) -> Self {
        Self::run(scene, one_process(way))
    }
}

/// Makes commands that run a way of `live.c`, from a directory and the scene's file.
pub fn one_process(way: &str) -> impl Fn(&Path, &Path) -> Command {
    let program = compile_c(&["live", "host_common", "check"]);
    move |to, scene| with_arguments(command(&program, to.parent().unwrap()), to, scene, way)
}

/// The same over ranks.
pub fn over_ranks(ranks: usize, way: &str) -> impl Fn(&Path, &Path) -> Command {
    let program = FIRST.compile(mpi_library(), "mpi_live");
    move |to, scene| with_arguments(FIRST.on_ranks(ranks, &program, to.parent().unwrap()), to, scene, way)
}

fn with_arguments(mut command: Command, to: &Path, scene: &Path, way: &str) -> Command {
    command.arg(to).arg(scene).arg(way);
    command
}

/// The picture of a step of a model without viewers.
pub fn drawn_alone(
    run: impl Fn(&Path, &Path) -> Command,
    folder: &Path,
    name: &str,
    scene: &str,
    step: u32,
) -> Vec<u8> {
    let scene = written(folder, &format!("{name}.toml"), scene);
    let to = folder.join(name);
    let mut model = Model::start(&mut run(&to, &scene));
    while model.draw() < step {}
    assert!(!to.join("live.url").exists());
    model.end();
    drawn(&to, step)
}
