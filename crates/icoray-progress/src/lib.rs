//! Progress of icoray's programs: one line on stderr where that is a terminal, and nothing elsewhere.
//!
//! A [`Progress`] is the line of a command that goes through stages; [`steps`] is a bar over a known number of steps.
#![forbid(unsafe_code)]

use icoray_grid::printable;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::Arc;
use std::time::Duration;

pub use indicatif::ProgressBar as Bar;

/// A stage without steps: only its duration is shown.
const STAGE: &str = "{spinner} {msg} ({elapsed})";
/// Parts of the whole that are finished.
const PARTS: &str = "{spinner} {msg} {bar:30} {percent:>3} %, {eta} left";
/// Steps of a known number.
const STEPS: &str = "{prefix}: {bar:30} {pos}/{len}, {eta} left, now {msg}";
/// Positions of the bar for each picture: a picture's tiles move it by parts of this.
const PER_PICTURE: u64 = 1000;
/// How often a line is drawn while nothing is reported.
const TICK: Duration = Duration::from_millis(120);

/// A style of one of the templates above.
fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// A bar over `length` steps that shows the step in its message.
pub fn steps(length: usize, name: &str) -> Bar {
    ProgressBar::new(length as u64).with_style(style(STEPS)).with_prefix(name.to_owned())
}

/// A command's line.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A line on stderr, hidden where stderr is no terminal.
    pub fn new() -> Self {
        Self::on(ProgressDrawTarget::stderr())
    }

    /// A line that is never shown.
    pub fn hidden() -> Self {
        Self::on(ProgressDrawTarget::hidden())
    }

    fn on(target: ProgressDrawTarget) -> Self {
        let bar = ProgressBar::with_draw_target(None, target).with_style(style(STAGE));
        if !bar.is_hidden() {
            bar.enable_steady_tick(TICK);
        }
        Progress { bar }
    }

    /// Shows what is being done.
    pub fn stage(&self, what: impl AsRef<str>) {
        self.bar.set_message(printable(what.as_ref()).into_owned());
    }

    /// Shows what is waited for, without a bar.
    pub fn wait(&self, what: impl AsRef<str>) {
        self.bar.set_style(style(STAGE));
        self.stage(what);
    }

    /// Goes on with a bar over so many pictures.
    pub fn pictures(&self, count: usize) {
        self.bar.set_style(style(PARTS));
        self.bar.set_length(PER_PICTURE * count as u64);
        self.bar.set_position(0);
        self.bar.reset_eta();
    }

    /// Takes back `count` of the pictures.
    pub fn fewer_pictures(&self, count: u64) {
        let length = self.bar.length().unwrap_or(0);
        self.bar.set_length(length.saturating_sub(PER_PICTURE * count));
    }

    /// Shows that `drawn` pictures are finished.
    pub fn drawn(&self, drawn: usize) {
        self.bar.set_position(PER_PICTURE * drawn as u64);
    }

    /// A function for the renderer to call after each tile: it moves the bar within the current picture.
    pub fn tiles(&self) -> Arc<dyn Fn(usize, usize) + Send + Sync> {
        let bar = self.bar.clone();
        Arc::new(move |finished, total| {
            let before = bar.position() / PER_PICTURE * PER_PICTURE;
            // The last tile of a picture is not the picture.
            let part = (PER_PICTURE - 1) * finished as u64 / total.max(1) as u64;
            bar.set_position(before + part);
        })
    }

    /// Runs `work`, which prints, while the line is out of the way.
    pub fn suspend<T>(&self, work: impl FnOnce() -> T) -> T {
        self.bar.suspend(work)
    }

    /// Takes the line away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Default for Progress {
    fn default() -> Self {
        Self::new()
    }
}

/// A line that is left is taken away, so that the sentence of an error has a line of its own.
impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_move_the_bar_within_their_picture() {
        let progress = Progress::hidden();
        progress.pictures(3);
        let tiles = progress.tiles();
        let mut seen = Vec::new();
        for picture in 1..=2 {
            for tile in 1..=4 {
                tiles(tile, 4);
                seen.push(progress.bar.position());
            }
            progress.drawn(picture);
        }
        assert_eq!(seen, [249, 499, 749, 999, 1249, 1499, 1749, 1999]);
        assert_eq!((progress.bar.position(), progress.bar.length()), (2000, Some(3000)));
        progress.fewer_pictures(1);
        assert_eq!(progress.bar.length(), Some(2000));
    }

    #[test]
    fn a_stage_has_no_control_characters() {
        let progress = Progress::hidden();
        progress.stage("reading a\u{1b}[2J.nc");
        assert_eq!(progress.bar.message(), r"reading a\u{1b}[2J.nc");
        progress.wait(String::from("watching b\n"));
        assert_eq!(progress.bar.message(), r"watching b\n");
    }

    #[test]
    fn templates_are_understood() {
        for template in [STAGE, PARTS, STEPS] {
            ProgressStyle::with_template(template).unwrap();
        }
    }
}
