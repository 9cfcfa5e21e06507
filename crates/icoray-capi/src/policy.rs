//! The config's options of the writer, and its `on_error`: how failed frames are logged and counted, and when the
//! context is disabled.

use crate::borrow::config_error;
use crate::boundary::{Failure, Outcome};
use crate::log::{Level, Log};
use crate::types::{
    ICORAY_BLOCK, ICORAY_DISABLE, ICORAY_DROP_OLDEST, ICORAY_IGNORE, ICORAY_NEVER_MODIFY, ICORAY_OVERWRITE,
    ICORAY_WARN, icoray_config, icoray_status,
};
use icoray_core::output::{Existing, WhenFull, WriterOptions};

/// Default number of failures in a row that disable a context.
const DISABLE_AFTER: u64 = 3;

/// Default length of the writer's queue.
const QUEUE: usize = 2;

pub(crate) fn writer_options(config: &icoray_config, output_dir: &str) -> Outcome<WriterOptions> {
    let existing = match config.existing {
        ICORAY_NEVER_MODIFY => Existing::NeverModify,
        ICORAY_OVERWRITE => Existing::Overwrite,
        other => {
            return Err(config_error("existing", other, "ICORAY_NEVER_MODIFY (0) or ICORAY_OVERWRITE (1)"));
        }
    };
    let when_full = match config.when_full {
        ICORAY_BLOCK => WhenFull::Block,
        ICORAY_DROP_OLDEST => WhenFull::DropOldest,
        other => return Err(config_error("when_full", other, "ICORAY_BLOCK (0) or ICORAY_DROP_OLDEST (1)")),
    };
    let queue = match config.writer_queue {
        0 => QUEUE,
        n @ 1..=1024 => n as usize,
        other => return Err(config_error("writer_queue", other, "0 to 1024")),
    };
    Ok(WriterOptions { existing, when_full, queue, ..WriterOptions::new(output_dir) })
}

/// Counts failures of frames.
pub(crate) struct Policy {
    is_logged: bool,
    /// Number of failures in a row that disable; `None` for never.
    max_failures: Option<u64>,
    in_a_row: u64,
    /// Message of the failure that disabled the context.
    last_failure: Option<String>,
}

impl Policy {
    /// With several ranks only rank 0 decides, as it alone has the outcomes of files; the policy of other ranks never
    /// disables.
    pub fn new(config: &icoray_config, decides: bool) -> Outcome<Self> {
        let after = config.disable_after;
        if after < 0 {
            return Err(config_error("disable_after", after, "0 or more"));
        }
        let max_failures = match config.on_error {
            ICORAY_WARN | ICORAY_IGNORE => None,
            ICORAY_DISABLE if after == 0 => Some(DISABLE_AFTER),
            ICORAY_DISABLE => Some(after as u64),
            other => {
                let expected = "ICORAY_WARN (0), ICORAY_IGNORE (1) or ICORAY_DISABLE (2)";
                return Err(config_error("on_error", other, expected));
            }
        };
        let (max_failures, is_logged) = (max_failures.filter(|_| decides), config.on_error != ICORAY_IGNORE);
        Ok(Policy { is_logged, max_failures, in_a_row: 0, last_failure: None })
    }

    pub fn is_on(&self) -> bool {
        self.last_failure.is_none()
    }

    /// Fails if the context is disabled.
    pub fn refuse_if_disabled(&self) -> Outcome<()> {
        let Some(last) = &self.last_failure else { return Ok(()) };
        let message = format!("icoray is off after {} failures in a row; the last was: {last}", self.in_a_row);
        Err(Failure::new(icoray_status::ICORAY_ERR_DISABLED, message))
    }

    pub fn succeeded(&mut self) {
        if self.is_on() {
            self.in_a_row = 0;
        }
    }

    /// Logs a failure unless the config ignores failures. That the context is disabled was logged when it happened.
    pub fn log_failure(&self, failure: &Failure, log: &Log) {
        if self.is_logged && failure.status != icoray_status::ICORAY_ERR_DISABLED {
            log.say(Level::Warn, &failure.message);
        }
    }

    /// Counts a failed frame. Existing files that must not be modified do not count.
    pub fn failed(&mut self, failure: &Failure, log: &Log) {
        if !self.is_on() || failure.status == icoray_status::ICORAY_ERR_EXISTS {
            return;
        }
        self.in_a_row += 1;
        if self.max_failures.is_some_and(|max_failures| self.in_a_row >= max_failures) {
            log.say(Level::Error, &format!("{} failures in a row: icoray is switched off", self.in_a_row));
            self.last_failure = Some(failure.message.clone());
        }
    }
}
