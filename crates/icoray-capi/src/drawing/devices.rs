//! Log lines on the device that renders, each once.

use crate::log::{Level, Log};
use icoray_core::FrameReport;
use icoray_core::output::Stamp;
use std::collections::BTreeSet;

/// Lines that were logged about devices.
#[derive(Debug, Default)]
pub(super) struct DeviceLog {
    /// Whether the scene asks for a GPU: then rendering on the CPU is a warning.
    pub is_asked: bool,
    /// Whether a device has rendered a frame.
    was_there: bool,
    logged: BTreeSet<String>,
}

impl DeviceLog {
    /// Logs the device of a frame, or the reason why the CPU rendered it, if that was not logged before.
    pub fn log_frame(&mut self, stamp: &Stamp, report: &FrameReport, log: &Log) {
        let is_missed = self.is_asked || self.was_there;
        self.was_there |= report.device.name.is_some();
        let device = report.device.name.iter().map(|device| (Level::Info, format!("drawn on {device}")));
        let level = if is_missed { Level::Warn } else { Level::Info };
        let part = if report.device.name.is_some() { "in part " } else { "" };
        let cpu = report.device.left_to_cpu.iter();
        let cpu = cpu.map(|reason| (level, format!("drawn {part}on the CPU: {reason}")));
        for (level, line) in device.chain(cpu) {
            if self.logged.insert(line.clone()) {
                log.say(level, &format!("step {}: {line}", stamp.step));
            }
        }
    }
}
