//! Options of the writer from icoray_config.

use crate::borrow::config_error;
use crate::boundary::Outcome;
use crate::types::{ICORAY_BLOCK, ICORAY_DROP_OLDEST, ICORAY_NEVER_MODIFY, ICORAY_OVERWRITE, icoray_config};
use icoray_core::output::{Existing, WhenFull, WriterOptions};

/// Default length of the writer's queue.
const QUEUE: usize = 2;

/// Converts the options of the writer.
pub(super) fn of_writer(config: &icoray_config, output_dir: &str) -> Outcome<WriterOptions> {
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
