//! When enough has failed: how failures are logged, counted and answered.

use crate::borrow::argument;
use crate::boundary::{Failure, Outcome};
use crate::log::{Level, Log};
use crate::types::{ICORAY_DISABLE, ICORAY_IGNORE, ICORAY_WARN, icoray_config, icoray_status};

/// Failed frames in a row that switch a context off, where the config names no number.
const DISABLE_AFTER: u64 = 3;

/// What failures of frames lead to.
pub(crate) struct Policy {
    is_logged: bool,
    /// Failures in a row that switch off; `None` never does.
    most: Option<u64>,
    in_a_row: u64,
    /// The last failure before the context was switched off.
    off: Option<String>,
}

impl Policy {
    /// Where several ranks draw one picture, rank 0's decides for all, since only rank 0 hears what becomes of files; that of
    /// the others, which are no `judge`, never switches off.
    pub fn new(config: &icoray_config, is_judge: bool) -> Outcome<Self> {
        let after = config.disable_after;
        if after < 0 {
            return Err(argument(format!("icoray_config.disable_after: {after}, expected 0 or more")));
        }
        let most = match config.on_error {
            ICORAY_WARN | ICORAY_IGNORE => None,
            ICORAY_DISABLE if after == 0 => Some(DISABLE_AFTER),
            ICORAY_DISABLE => Some(after as u64),
            other => {
                return Err(argument(format!(
                    "icoray_config.on_error: {other}, expected ICORAY_WARN (0), ICORAY_IGNORE (1) or ICORAY_DISABLE (2)"
                )));
            }
        };
        let most = most.filter(|_| is_judge);
        Ok(Policy { is_logged: config.on_error != ICORAY_IGNORE, most, in_a_row: 0, off: None })
    }

    pub fn is_on(&self) -> bool {
        self.off.is_none()
    }

    /// Refuses where the context has switched itself off.
    pub fn refuse_if_off(&self) -> Outcome<()> {
        let Some(last) = &self.off else { return Ok(()) };
        let message =
            format!("icoray is off after {} failures in a row; the last was: {last}", self.in_a_row);
        Err(Failure::new(icoray_status::ICORAY_ERR_DISABLED, message))
    }

    pub fn succeeded(&mut self) {
        if self.is_on() {
            self.in_a_row = 0;
        }
    }

    /// Tells the log of a failure, where failures are logged. That the context is off was logged when it went off.
    pub fn log_failure(&self, failure: &Failure, log: &Log) {
        if self.is_logged && failure.status != icoray_status::ICORAY_ERR_DISABLED {
            log.say(Level::Warn, &failure.message);
        }
    }

    /// A frame failed. A picture that is not to be modified is the user's choice, and does not count.
    pub fn failed(&mut self, failure: &Failure, log: &Log) {
        if !self.is_on() || failure.status == icoray_status::ICORAY_ERR_EXISTS {
            return;
        }
        self.in_a_row += 1;
        if self.most.is_some_and(|most| self.in_a_row >= most) {
            log.say(Level::Error, &format!("{} failures in a row: icoray is switched off", self.in_a_row));
            self.off = Some(failure.message.clone());
        }
    }
}
