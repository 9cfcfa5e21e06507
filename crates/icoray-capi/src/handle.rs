//! What a model holds: an opaque handle, and who may enter it.

use crate::boundary::{Failure, Outcome, caught, guarded, status};
use crate::context::Context;
use crate::types::icoray_status;
use std::sync::{Mutex, MutexGuard, TryLockError};

/// An open context.
#[expect(non_camel_case_types, reason = "the name is C's")]
pub struct icoray_ctx {
    /// The process that opened it and has its threads.
    process: u32,
    context: Mutex<Context>,
}

impl icoray_ctx {
    pub fn new(context: Context) -> Self {
        icoray_ctx { process: std::process::id(), context: Mutex::new(context) }
    }

    /// Whether a fork came between. Asked before any lock is touched: one that another thread held while forking would be
    /// held for ever.
    pub fn is_forked(&self) -> bool {
        self.process != std::process::id()
    }

    /// The context, for one caller at a time.
    pub fn enter(&self) -> Outcome<MutexGuard<'_, Context>> {
        if self.is_forked() {
            let message = format!(
                "the context was opened by process {}, of which this one ({}) was forked; open one here",
                self.process,
                std::process::id()
            );
            return Err(Failure::new(icoray_status::ICORAY_ERR_FORKED, message));
        }
        match self.context.try_lock() {
            Ok(context) => Ok(context),
            // A panic is caught while the lock is held, and poisons the context itself.
            Err(TryLockError::Poisoned(context)) => Ok(context.into_inner()),
            Err(TryLockError::WouldBlock) => {
                let message = "another call on this context has not returned yet (from another thread, or from this \
                               one's log callback)";
                Err(Failure::new(icoray_status::ICORAY_ERR_BUSY, message))
            }
        }
    }
}

/// Runs a call on a context: refuses NULL, a forked, a busy and a poisoned one, keeps the message, poisons on a bug of our
/// own.
///
/// # Safety
/// `ctx` is NULL or comes from icoray_open_serial and is open.
pub(crate) unsafe fn with(
    ctx: *const icoray_ctx,
    call: impl FnOnce(&mut Context) -> Outcome<()>,
) -> icoray_status {
    status(&guarded(|| {
        // SAFETY: the caller promises an open context.
        let ctx = unsafe { ctx.as_ref() }.ok_or_else(|| Failure::null("ctx"))?;
        let mut context = ctx.enter()?;
        context.refuse_if_poisoned()?;
        let outcome = caught(|| call(&mut context));
        if let Err(failure) = &outcome {
            context.remember(failure);
        }
        outcome
    }))
}
