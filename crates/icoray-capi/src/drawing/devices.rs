//! What the log hears of who draws: each thing once.

use crate::log::{Level, Log};
use icoray_core::FrameReport;
use icoray_core::output::Stamp;
use std::collections::BTreeSet;

/// Devices that draw frames, or why the CPU does.
#[derive(Debug, Default)]
pub(super) struct Devices {
    /// Whether the scene asks for a GPU by name, so that one is missed.
    pub is_asked: bool,
    /// Whether one has drawn.
    was_there: bool,
    told: BTreeSet<String>,
}

impl Devices {
    /// Tells the log of a frame that was drawn on another device than those before, or left to the CPU for another reason.
    pub fn tell(&mut self, stamp: &Stamp, report: &FrameReport, log: &Log) {
        let is_missed = self.is_asked || self.was_there;
        self.was_there |= report.device.is_some();
        let device = report.device.iter().map(|device| (Level::Info, format!("drawn on {device}")));
        let level = if is_missed { Level::Warn } else { Level::Info };
        let part = if report.device.is_some() { "in part " } else { "" };
        let cpu = report.left_to_cpu.iter();
        let cpu = cpu.map(|reason| (level, format!("drawn {part}on the CPU: {reason}")));
        for (level, line) in device.chain(cpu) {
            if self.told.insert(line.clone()) {
                log.say(level, &format!("step {}: {line}", stamp.step));
            }
        }
    }
}
