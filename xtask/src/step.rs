//! Steps with progress: `[2/5] building the library ... 12.3 s`.
//!
//! A terminal also shows the last line that a command printed and the seconds so far.

use std::io::{self, BufRead, BufReader, Write};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::error::{BRIEF, Error};

/// A terminal's line: the step, the seconds so far, and the latest line of its command.
const LINE: &str = "{prefix} {elapsed} {wide_msg}";

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
    pub fn new(total: usize) -> Self {
        Self { total, begun: 0, started: Instant::now(), times: Vec::new() }
    }

    /// Runs the next step; prints its title before and its time after it.
    pub fn run<T>(&mut self, title: &str, work: impl FnOnce(&mut Step) -> Result<T, Error>) -> Result<T, Error> {
        let mut step = self.begin(title);
        let result = work(&mut step);
        let seconds = step.seconds();
        self.end(step, title, result.is_ok(), seconds);
        result
    }

    pub fn begin(&mut self, title: &str) -> Step {
        self.begin_on(title, ProgressDrawTarget::stdout())
    }

    /// Begins the next step beside others, to which it leaves the terminal's line.
    pub fn beside(&mut self, title: &str) -> Step {
        self.begin_on(title, ProgressDrawTarget::hidden())
    }

    fn begin_on(&mut self, title: &str, target: ProgressDrawTarget) -> Step {
        self.begun += 1;
        let style = ProgressStyle::with_template(LINE).unwrap_or_else(|_| ProgressStyle::default_spinner());
        let bar = ProgressBar::with_draw_target(None, target).with_style(style);
        bar.set_prefix(format!("[{}/{}] {title} ...", self.begun, self.total));
        if bar.is_hidden() {
            print_line(&bar.prefix());
        } else {
            bar.enable_steady_tick(Duration::from_millis(250));
        }
        Step { bar, started: Instant::now() }
    }

    /// Ends a step, and prints the seconds that it took.
    pub fn end(&mut self, step: Step, title: &str, has_succeeded: bool, seconds: f64) {
        step.bar.finish_and_clear();
        let how = if has_succeeded { "" } else { "failed after " };
        print_line(&format!("{} {how}{seconds:.1} s", step.bar.prefix()));
        self.times.push((title.to_owned(), seconds));
    }
}

/// A step under way.
pub struct Step {
    bar: ProgressBar,
    started: Instant,
}

impl Step {
    /// Runs a command without its output, which the error has if the command fails. A terminal shows the latest line.
    pub fn quiet(&mut self, command: impl Into<Command>) -> Result<(), Error> {
        let (lines, outcome) = lines_of(command.into(), |line| self.bar.set_message(line.to_owned()));
        outcome.map_err(Error::with(&lines))
    }

    /// Runs a command, prints its output as it comes, and returns lines and outcome. Calls `poll` after each line.
    pub fn echoed(&mut self, command: impl Into<Command>, mut poll: impl FnMut()) -> (Vec<String>, Result<(), Error>) {
        let (lines, outcome) = lines_of(command.into(), |line| {
            self.bar.suspend(|| {
                print_line(line);
                poll();
            });
        });
        let outcome = outcome.map_err(Error::with(&lines[lines.len().saturating_sub(BRIEF)..]));
        (lines, outcome)
    }

    /// Prints a line within the step.
    pub fn note(&self, line: &str) {
        self.bar.suspend(|| print_line(line));
    }

    pub fn seconds(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}

/// Runs a command; passes each line of its output, both streams in order, to `take`. Returns the lines, and a sentence
/// on its failure.
pub fn lines_of(mut command: Command, mut take: impl FnMut(&str)) -> (Vec<String>, Result<(), String>) {
    let name = command.get_program().display().to_string();
    let words = command.get_args().map(|word| format!(" {}", word.display())).collect::<String>();
    let mut lines = Vec::new();
    let run = || {
        // One pipe for both streams keeps the order of their lines.
        let (reader, writer) = io::pipe()?;
        let mut child = command.stdin(Stdio::null()).stdout(writer.try_clone()?).stderr(writer).spawn()?;
        // The command holds the ends that the child has too: reading would never end.
        drop(command);
        for line in BufReader::new(reader).split(b'\n') {
            let line = String::from_utf8_lossy(&line?).trim_end_matches('\r').to_owned();
            take(&line);
            lines.push(line);
        }
        child.wait()
    };
    let outcome = match run() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`{name}{words}` ended with {status}")),
        Err(cause) => Err(format!("{name}: {cause}")),
    };
    (lines, outcome)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step() -> Step {
        Steps::new(1).beside("testing")
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
        let error = step().echoed(shell("echo one; echo bad >&2; exit 1"), || {}).1.unwrap_err();
        assert!(error.brief().ends_with("exit status: 1\n    one\n    bad"), "{error}");
        let error = step().quiet(shell("kill -SEGV $$")).unwrap_err().to_string();
        assert!(error.contains(" ended with signal: 11"), "{error}");
        let error = step().quiet(Command::new("/nonexistent/program")).unwrap_err();
        assert!(error.to_string().starts_with("/nonexistent/program: "), "{error}");
    }

    #[test]
    fn lines_are_returned_as_they_come() {
        let mut polls = 0;
        let (lines, outcome) = step().echoed(shell("echo one; echo two >&2; printf three"), || polls += 1);
        assert!(outcome.is_ok() && lines == ["one", "two", "three"] && polls == 3, "{lines:?}");
    }

    #[test]
    fn titles_and_seconds_of_all_steps_are_kept() {
        let mut steps = Steps::new(2);
        assert_eq!(steps.run("first", |_| Ok(1)), Ok(1));
        assert!(steps.run("second", |_| Err::<(), _>(Error("no".into()))).is_err());
        let titles: Vec<_> = steps.times.iter().map(|(title, _)| title.as_str()).collect();
        assert_eq!(titles, ["first", "second"]);
        assert!(steps.times.iter().all(|(_, seconds)| *seconds >= 0.0));
    }
}
