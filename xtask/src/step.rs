//! Steps with progress: `[2/5] building the library ... 12.3 s`.
//!
//! A terminal also shows the last line that a command printed and the seconds so far.

use std::io::{self, BufRead, BufReader, IsTerminal, Write};
use std::process::{Command, Stdio};
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
    begun: usize,
    pub started: Instant,
    /// The titles of the steps so far, with their seconds.
    pub times: Vec<(String, f64)>,
}

impl Steps {
    /// Begins a sequence of `total` steps.
    pub fn new(total: usize) -> Self {
        Self { total, begun: 0, started: Instant::now(), times: Vec::new() }
    }

    /// Runs the next step; prints its title before and its time after it.
    pub fn run<T>(&mut self, title: &str, work: impl FnOnce(&mut Step) -> Result<T, Error>) -> Result<T, Error> {
        let mut step = self.begin(title);
        let result = work(&mut step);
        let seconds = step.seconds();
        self.end(step, title, (result.is_ok(), seconds));
        result
    }

    /// Begins the next step, and prints its title.
    pub fn begin(&mut self, title: &str) -> Step {
        self.begun += 1;
        let heading = format!("[{}/{}] {title}", self.begun, self.total);
        print(&format!("{heading} ..."));
        Step { heading, started: Instant::now(), line_open: true, terminal: io::stdout().is_terminal() }
    }

    /// Ends a step, and prints the seconds that it took.
    pub fn end(&mut self, step: Step, title: &str, (has_succeeded, seconds): (bool, f64)) {
        step.close(&format!("{}{seconds:.1} s", if has_succeeded { "" } else { "failed after " }));
        self.times.push((title.to_owned(), seconds));
    }
}

/// Runs a command without its output, which the error has if the command fails.
pub fn silent(command: impl Into<Command>) -> Result<(), Error> {
    silent_but(command.into(), |_| {})
}

/// The same, with a function that is called as [`lines_of`] does.
fn silent_but(command: Command, take: impl FnMut(Option<&str>)) -> Result<(), Error> {
    let (outcome, lines) = lines_of(command, take)?;
    outcome.map_err(|sentence| Error::Detailed { sentence, details: lines.join("\n") })
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
        let mut latest = String::new();
        silent_but(command.into(), |line| match line {
            Some(line) => line.clone_into(&mut latest),
            None => self.refresh(&latest),
        })
    }

    /// Runs a command, prints its output as it comes, and returns the lines. Calls `poll` a few times per second and at
    /// the end.
    pub fn echoed(&mut self, command: impl Into<Command>, mut poll: impl FnMut()) -> Result<Vec<String>, Error> {
        self.break_line();
        let (outcome, lines) = lines_of(command.into(), |line| line.map_or_else(&mut poll, print_line))?;
        poll();
        let details = || last_lines(&lines.join("\n"), 5).join("\n");
        outcome.map_err(|sentence| Error::Detailed { sentence, details: details() }).map(|()| lines)
    }

    /// Prints a line within the step.
    pub fn note(&mut self, line: &str) {
        self.break_line();
        print_line(line);
    }

    /// The time so far.
    pub fn seconds(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Leaves the terminal's line to other steps, beside which this one goes on.
    pub fn stand_aside(mut self) -> Self {
        self.break_line();
        self.terminal = false;
        self
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

/// Runs a command; passes each line of its output to `take`, and `None` a few times per second while it runs. Returns
/// the lines, and a sentence on its failure.
fn lines_of(
    mut command: Command,
    mut take: impl FnMut(Option<&str>),
) -> Result<(Result<(), String>, Vec<String>), Error> {
    let name = command.get_program().display().to_string();
    let words = command.get_args().map(|word| format!(" {}", word.display())).collect::<String>();
    // One pipe for both streams keeps the order of their lines.
    let spawn = || {
        let (reader, writer) = io::pipe()?;
        let child = command.stdin(Stdio::null()).stdout(writer.try_clone()?).stderr(writer).spawn()?;
        // The command holds the ends that the child has too: reading would never end.
        drop(command);
        Ok((child, reader))
    };
    let (mut child, reader) = spawn().map_err(Error::while_doing::<io::Error>(&name))?;
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
        let mut lines = BufReader::new(reader).split(b'\n').map_while(Result::ok);
        lines.try_for_each(|line| sender.send(String::from_utf8_lossy(&line).trim_end_matches('\r').to_owned()))
    });
    let mut lines = Vec::new();
    let pause = Duration::from_millis(250);
    let mut refreshed = Instant::now();
    loop {
        match receiver.recv_timeout(pause) {
            Ok(line) => {
                take(Some(&line));
                lines.push(line);
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        if refreshed.elapsed() >= pause {
            take(None);
            refreshed = Instant::now();
        }
    }
    let status = child.wait().map_err(Error::while_doing(&name))?;
    let outcome = if status.success() { Ok(()) } else { Err(format!("`{name}{words}` ended with {status}")) };
    Ok((outcome, lines))
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
        assert!(error.brief().ends_with("exit status: 1\n    one\n    bad"), "{error}");
        let error = step().quiet(Command::new("/nonexistent/program")).unwrap_err();
        assert!(error.to_string().starts_with("/nonexistent/program: "), "{error}");
    }

    #[test]
    fn lines_are_returned_as_they_come() {
        let mut polls = 0;
        let lines = step().echoed(shell("echo one; echo two >&2; printf three"), || polls += 1).unwrap();
        assert_eq!(lines, ["one", "two", "three"]);
        assert!(polls >= 1);
    }

    #[test]
    fn titles_and_seconds_of_all_steps_are_kept() {
        let mut steps = Steps::new(2);
        assert_eq!(steps.run("first", |_| Ok(1)), Ok(1));
        assert!(steps.run("second", |_| Err::<(), _>(Error::Failed("no".into()))).is_err());
        let titles: Vec<_> = steps.times.iter().map(|(title, _)| title.as_str()).collect();
        assert_eq!(titles, ["first", "second"]);
        assert!(steps.times.iter().all(|(_, seconds)| *seconds >= 0.0));
    }
}
