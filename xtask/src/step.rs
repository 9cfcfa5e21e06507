//! Steps with progress: `[2/5] building the library ... 12.3 s`.
//!
//! A terminal also shows the last line that a command printed and the seconds so far.

use std::io::{self, BufRead, BufReader, IsTerminal, Read, Write};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use crate::error::{Error, last_lines};

/// Prints a line. A closed pipe (`| head`) is ignored, where `println!` would panic.
pub fn print_line(line: &str) {
    let _ = writeln!(io::stdout(), "{line}");
}

/// Prints a line to standard error; a closed pipe is ignored.
pub fn print_error(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// A numbered sequence of steps.
pub struct Steps {
    total: usize,
    pub started: Instant,
    /// The titles of the steps so far, with their seconds.
    pub times: Vec<(String, f64)>,
}

impl Steps {
    /// Begins a sequence of `total` steps.
    pub fn new(total: usize) -> Self {
        Self { total, started: Instant::now(), times: Vec::new() }
    }

    /// Runs the next step; prints its title before and its time after it.
    pub fn run<T>(&mut self, title: &str, work: impl FnOnce(&mut Step) -> Result<T, Error>) -> Result<T, Error> {
        let mut step = Step {
            heading: format!("[{}/{}] {title}", self.times.len() + 1, self.total),
            started: Instant::now(),
            line_open: true,
            terminal: io::stdout().is_terminal(),
        };
        print(&format!("{} ...", step.heading));
        let result = work(&mut step);
        let seconds = step.started.elapsed().as_secs_f64();
        step.close(&format!("{}{seconds:.1} s", if result.is_ok() { "" } else { "failed after " }));
        self.times.push((title.to_owned(), seconds));
        result
    }
}

/// A step under way.
pub struct Step {
    heading: String,
    started: Instant,
    /// Whether the cursor is still on the line of the heading.
    line_open: bool,
    terminal: bool,
}

impl Step {
    /// Runs a command without its output, which the error has if the command fails. A terminal shows the latest line.
    pub fn quiet(&mut self, command: impl Into<Command>) -> Result<(), Error> {
        let mut command = command.into();
        let mut output = String::new();
        let status = lines_of(&mut command, |line| match line {
            Some(Line::Output(line) | Line::Error(line)) => output += &(line + "\n"),
            None => self.refresh(output.lines().next_back().unwrap_or_default()),
        })?;
        if status.success() { Ok(()) } else { Err(failure(&command, status, &output)) }
    }

    /// Runs a command and prints its output as it comes; returns the lines of the standard output. Calls `poll` a few
    /// times per second and at the end.
    pub fn echoed(&mut self, command: impl Into<Command>, mut poll: impl FnMut()) -> Result<Vec<String>, Error> {
        let mut command = command.into();
        self.break_line();
        let (mut lines, mut errors) = (Vec::new(), Vec::new());
        let status = lines_of(&mut command, |line| match line {
            Some(Line::Output(line)) => {
                print_line(&line);
                lines.push(line);
            }
            Some(Line::Error(line)) => {
                print_error(&line);
                errors.push(line);
            }
            None => poll(),
        })?;
        poll();
        if status.success() {
            return Ok(lines);
        }
        Err(failure(&command, status, &last_lines(&errors.join("\n"), 5).join("\n")))
    }

    /// Prints a line within the step.
    pub fn note(&mut self, line: &str) {
        self.break_line();
        print_line(line);
    }

    /// Rewrites the line of the heading with the time so far and the latest line of the command.
    fn refresh(&self, activity: &str) {
        if self.terminal && self.line_open {
            let seconds = self.started.elapsed().as_secs();
            let line = format!("{} ... {seconds} s  {}", self.heading, activity.trim());
            // A line that wraps could not be rewritten, and any terminal has 80 columns. Colours are left out: their
            // control characters would count as columns and might be cut in half.
            let line: String = line.chars().filter(|c| !c.is_control()).take(79).collect();
            print(&format!("\r\x1b[K{line}"));
        }
    }

    fn break_line(&mut self) {
        if self.line_open {
            print_line(&self.rewound());
            self.line_open = false;
        }
    }

    fn close(&self, outcome: &str) {
        let start = if self.line_open { self.rewound() } else { format!("{} ...", self.heading) };
        print_line(&format!("{start} {outcome}"));
    }

    /// The text that moves a terminal's cursor behind the heading, and removes what follows.
    fn rewound(&self) -> String {
        if self.terminal { format!("\r\x1b[K{} ...", self.heading) } else { String::new() }
    }
}

fn print(text: &str) {
    let mut stdout = io::stdout();
    let _ = stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush());
}

/// A line that a command prints.
enum Line {
    /// To standard output.
    Output(String),
    /// To standard error.
    Error(String),
}

/// Runs a command; passes each line that it prints to `take`, and `None` a few times per second while it runs.
fn lines_of(command: &mut Command, mut take: impl FnMut(Option<Line>)) -> Result<ExitStatus, Error> {
    let mut child = command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(Error::while_doing(name(command)))?;
    let (sender, receiver) = mpsc::channel();
    if let Some((stdout, stderr)) = child.stdout.take().zip(child.stderr.take()) {
        send_lines(stdout, Line::Output, sender.clone());
        // The channel closes when the last reader ends.
        send_lines(stderr, Line::Error, sender);
    }
    let pause = Duration::from_millis(250);
    let mut refreshed = Instant::now();
    loop {
        match receiver.recv_timeout(pause) {
            Ok(line) => take(Some(line)),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        if refreshed.elapsed() >= pause {
            take(None);
            refreshed = Instant::now();
        }
    }
    child.wait().map_err(Error::while_doing(name(command)))
}

/// Reads a pipe in a thread of its own, so that a command never stalls on a full pipe while the other is read.
fn send_lines(pipe: impl Read + Send + 'static, kind: fn(String) -> Line, sender: mpsc::Sender<Line>) {
    thread::spawn(move || {
        let mut pipe = BufReader::new(pipe);
        let mut line = Vec::new();
        while matches!(pipe.read_until(b'\n', &mut line), Ok(1..)) {
            let text = String::from_utf8_lossy(&line);
            if sender.send(kind(text.trim_end_matches(['\r', '\n']).to_owned())).is_err() {
                break;
            }
            line.clear();
        }
    });
}

fn name(command: &Command) -> String {
    command.get_program().display().to_string()
}

/// The error of a command that failed: the command, and all that it printed.
fn failure(command: &Command, status: ExitStatus, output: &str) -> Error {
    let words = command.get_args().map(|word| format!(" {}", word.display())).collect::<String>();
    let sentence = format!("`{}{words}` ended with {status}", name(command));
    Error::Detailed { sentence, details: output.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step() -> Step {
        Step { heading: "[1/1] testing".into(), started: Instant::now(), line_open: false, terminal: false }
    }

    fn shell(script: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn a_failure_has_the_command_and_its_output() {
        let error = step().quiet(shell("echo one; echo two >&2; exit 3")).unwrap_err().to_string();
        assert!(error.starts_with("`sh -c echo one; ") && error.contains("exit status: 3\n"), "{error}");
        assert!(error.contains("\none") && error.contains("\ntwo"), "{error}");
        let error = step().echoed(shell("echo one; echo bad >&2; exit 1"), || {}).unwrap_err();
        assert!(error.brief().ends_with("exit status: 1\n    bad"), "{error}");
        let error = step().quiet(Command::new("/nonexistent/program")).unwrap_err();
        assert!(error.to_string().starts_with("/nonexistent/program: "), "{error}");
    }

    #[test]
    fn lines_are_returned_as_they_come() {
        let mut polls = 0;
        let lines = step().echoed(shell("echo one; printf two; echo three >&2"), || polls += 1).unwrap();
        assert_eq!(lines, ["one", "two"]);
        assert!(polls >= 1);
        // A lot of output on both pipes does not stall.
        let script = "for i in $(seq 5000); do printf '%040d\n' $i; printf '%040d\n' $i >&2; done";
        assert_eq!(step().quiet(shell(script)), Ok(()));
    }

    #[test]
    fn titles_and_seconds_of_all_steps_are_kept() {
        let mut steps = Steps::new(2);
        assert_eq!(steps.run("first", |_| Ok(1)), Ok(1));
        assert!(steps.run("second", |_| Err::<(), _>(Error::Failed("no".into()))).is_err());
        let titles: Vec<_> = steps.times.iter().map(|(title, _)| title.as_str()).collect();
        assert_eq!(titles, ["first", "second"]);
        assert!(steps.times.iter().all(|(_, seconds)| (0.0..60.0).contains(seconds)));
    }
}
