//! The opaque handle of a context, and its locking.

use crate::boundary::{Failure, Outcome, caught, guarded, last_refusal, refused_by, status};
use crate::context::Context;
use crate::message::fitted;
use crate::types::icoray_status;
use std::cell::RefCell;
use std::ptr;
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

thread_local! {
    /// Addresses of the contexts of which this thread is in a call.
    static ENTERED: RefCell<Vec<usize>> = const { RefCell::new(Vec::new()) };
}

/// A locked context.
pub struct Entry<'a> {
    pub(crate) context: MutexGuard<'a, Context>,
}

impl Drop for Entry<'_> {
    fn drop(&mut self) {
        // Calls return in the opposite order.
        let _ = ENTERED.try_with(|entered| entered.borrow_mut().pop());
    }
}

/// An open context.
#[expect(non_camel_case_types, reason = "the name is C's")]
pub struct icoray_ctx {
    /// Id of the process that opened it.
    process: u32,
    context: Mutex<Context>,
    /// Whether some calls are collective over several ranks.
    is_shared: bool,
    /// Message of the last failure; it can be read during a call.
    message: Mutex<String>,
}

impl icoray_ctx {
    pub(crate) fn new(context: Context) -> Self {
        icoray_ctx {
            process: std::process::id(),
            is_shared: context.is_shared(),
            context: Mutex::new(context),
            message: Mutex::new(String::new()),
        }
    }

    /// The message of the last failed call, or of this thread's if that was refused entry.
    pub(crate) fn message(&self) -> String {
        last_refusal(ptr::from_ref(self).addr()).unwrap_or_else(|| {
            let none = || String::new();
            if self.is_forked() { none() } else { self.message.lock().map_or_else(|_| none(), |m| m.clone()) }
        })
    }

    /// Runs a call; stores the message of its failure and passes it to `on_failure`.
    pub(crate) fn run<T>(
        &self,
        context: &mut Context,
        on_failure: impl FnOnce(&mut Context, &Failure),
        call: impl FnOnce(&mut Context) -> Outcome<T>,
    ) -> Outcome<T> {
        caught(|| call(context)).inspect_err(|failure| {
            on_failure(context, failure);
            let mut message = self.message.lock().unwrap_or_else(PoisonError::into_inner);
            *message = fitted(&failure.message).into_owned();
        })
    }

    /// Whether this process is a fork of the one that opened the context. Checked before locking: a lock that another
    /// thread held during the fork is never released.
    pub fn is_forked(&self) -> bool {
        self.process != std::process::id()
    }

    /// Locks the context; fails if another call holds it.
    pub(crate) fn enter(&self) -> Outcome<Entry<'_>> {
        self.enter_by(|context| match context.try_lock() {
            Ok(context) => Some(context),
            // A panic is caught while the lock is held, and poisons the context itself.
            Err(TryLockError::Poisoned(context)) => Some(context.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        })
    }

    /// As [`Self::enter`] for collective calls: waits for a call of another thread, as failing on this rank alone would
    /// block the others.
    pub(crate) fn enter_with_others(&self) -> Outcome<Entry<'_>> {
        let is_within = || ENTERED.try_with(|entered| entered.borrow().contains(&ptr::from_ref(self).addr()));
        if !self.is_shared || self.is_forked() || is_within().unwrap_or(true) {
            return self.enter();
        }
        self.enter_by(|context| Some(context.lock().unwrap_or_else(PoisonError::into_inner)))
    }

    fn enter_by<'a>(
        &'a self,
        lock: impl FnOnce(&'a Mutex<Context>) -> Option<MutexGuard<'a, Context>>,
    ) -> Outcome<Entry<'a>> {
        if self.is_forked() {
            let message = format!(
                "the context was opened by process {}, of which this one ({}) was forked; open one here",
                self.process,
                std::process::id()
            );
            return Err(Failure::new(icoray_status::ICORAY_ERR_FORKED, message));
        }
        let Some(context) = lock(&self.context) else {
            let message = "another call on this context has not returned yet (from another thread, or from this \
                           one's log callback)";
            return Err(Failure::new(icoray_status::ICORAY_ERR_BUSY, message));
        };
        let _ = ENTERED.try_with(|entered| entered.borrow_mut().push(ptr::from_ref(self).addr()));
        Ok(Entry { context })
    }
}

/// How a call relates to other calls on the context and to those of other ranks.
#[derive(Debug, Clone, Copy)]
pub(crate) enum CallKind {
    /// Of this rank alone; refused while another call on the context has not returned.
    Local,
    /// Of this rank alone, after a wait for frames in the background by the function of this name. The wait is
    /// collective, also after failures on some ranks.
    AfterFrames(&'static str),
    /// Its answer is equal on all ranks without communication: fails only after errors that all ranks have agreed on.
    Answer,
    /// Collective: a rank with a poisoned context takes part in the agreement, so that no rank waits for it.
    Collective,
    /// The last one, which is collective and of poisoned contexts too.
    Close,
}

impl icoray_ctx {
    /// Runs a call on a context: refuses a forked, busy or poisoned one, stores the message of a failure, and poisons
    /// the context after an internal error.
    pub(crate) fn call<T>(&self, kind: CallKind, call: impl FnOnce(&mut Context) -> Outcome<T>) -> Outcome<T> {
        let mut is_refused = false;
        let outcome = guarded(|| {
            let entered = if let CallKind::Local = kind { self.enter() } else { self.enter_with_others() };
            let mut entry = entered.inspect_err(|_| is_refused = true)?;
            let context = &mut entry.context;
            // Every call does, so that frames in the background complete.
            context.drawing.pump();
            match kind {
                CallKind::AfterFrames(name) => {
                    let finished = self.run(context, Context::failed_for_all, |context| context.finish_frames(name));
                    context.refuse_if_poisoned()?;
                    finished?;
                }
                CallKind::Answer => context.refuse_if_over()?,
                CallKind::Close => {}
                CallKind::Collective if context.is_shared() => {}
                CallKind::Local | CallKind::Collective => context.refuse_if_poisoned()?,
            }
            let is_of_all = matches!(kind, CallKind::Collective | CallKind::Close);
            self.run(context, if is_of_all { Context::failed_for_all } else { Context::failed }, call)
        });
        if is_refused {
            refused_by(ptr::from_ref(self).addr());
        }
        outcome
    }
}

/// [`icoray_ctx::call`] for C; refuses NULL.
///
/// # Safety
/// `ctx` is NULL or comes from icoray_open or icoray_open_serial and is open.
pub(crate) unsafe fn with(
    ctx: *const icoray_ctx,
    kind: CallKind,
    call: impl FnOnce(&mut Context) -> Outcome<()>,
) -> icoray_status {
    // SAFETY: the caller promises NULL or an open context.
    let ctx = unsafe { ctx.as_ref() };
    status(&ctx.map_or_else(|| guarded(|| Err(Failure::null("ctx"))), |ctx| ctx.call(kind, call)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::tests::{config, loud, message};
    use crate::frames::{icoray_execute, icoray_report, icoray_wait, icoray_wants};
    use crate::inputs::{
        icoray_field_describe, icoray_field_set, icoray_field_set_ndarray, icoray_grid_set, icoray_layers_set,
        icoray_part_set, icoray_scene_field, icoray_scene_load, icoray_scene_text,
    };
    use crate::open::{icoray_close, icoray_open_serial};
    use crate::types::{icoray_config, icoray_frame_report};
    use icoray_status::*;
    use std::ptr;

    fn opened(config: &icoray_config) -> *mut icoray_ctx {
        let mut ctx = ptr::null_mut();
        // SAFETY: a live config and a live pointer.
        assert_eq!(unsafe { icoray_open_serial(config, &mut ctx) }, ICORAY_OK);
        ctx
    }

    fn closed(mut ctx: *mut icoray_ctx) {
        // SAFETY: an open context.
        assert_eq!(unsafe { icoray_close(&mut ctx) }, ICORAY_OK);
        assert!(ctx.is_null());
    }

    #[test]
    fn a_context_that_failed_inside_takes_no_more_calls() {
        loud();
        let (ctx, other) = (opened(&config()), opened(&config()));
        let mut report = icoray_frame_report { struct_size: size_of::<icoray_frame_report>(), ..Default::default() };
        let mut wants = 7;
        // SAFETY: every pointer is NULL, where that is refused, or to a live local; the contexts are open.
        unsafe {
            let internal = || Err(Failure::new(ICORAY_ERR_INTERNAL, "internal error: a broken promise"));
            assert_eq!(with(ctx, CallKind::Local, |_| internal()), ICORAY_ERR_INTERNAL);
            assert_eq!(message(ctx), "internal error: a broken promise");

            assert_eq!(with(ctx, CallKind::Local, |_| Ok(())), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_grid_set(ctx, ptr::null()), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_part_set(ctx, ptr::null()), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_layers_set(ctx, ptr::null()), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_field_set(ctx, ptr::null(), ptr::null()), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_field_set_ndarray(ctx, ptr::null(), ptr::null()), ICORAY_ERR_INTERNAL);
            let described = icoray_field_describe(ctx, ptr::null(), ptr::null(), ptr::null());
            assert_eq!(described, ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_scene_load(ctx, ptr::null()), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_scene_text(ctx, ptr::null()), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_scene_field(ctx, 0, ptr::null_mut(), 0), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_wants(ctx, 0, 0.0, &mut wants), ICORAY_ERR_INTERNAL);
            assert_eq!(wants, 0);
            assert_eq!(icoray_execute(ctx, 0, 0.0, ptr::null()), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_wait(ctx), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_report(ctx, &mut report), ICORAY_ERR_INTERNAL);
            let first = "internal error: a broken promise";
            assert_eq!(message(ctx), first, "the first failure is the one to know");
            assert!(message(ptr::null()).contains("accepts no more calls"));

            assert_eq!(icoray_scene_text(other, ptr::null()), ICORAY_ERR_NULL, "another context goes on");
        }
        closed(ctx);
        closed(other);
    }

    #[test]
    fn a_panic_poisons_its_context() {
        loud();
        let ctx = opened(&config());
        // SAFETY: an open context.
        unsafe {
            assert_eq!(with(ctx, CallKind::Local, |_| panic!("out of bounds")), ICORAY_ERR_INTERNAL);
            assert_eq!(message(ctx), "internal error: out of bounds");
            assert_eq!(icoray_scene_text(ctx, c"".as_ptr()), ICORAY_ERR_INTERNAL);
        }
        closed(ctx);
    }

    #[test]
    fn the_message_of_a_call_that_is_refused_entry_is_its_threads() {
        loud();
        let ctx = opened(&config());
        // SAFETY: an open context, entered again from within a call, as a log callback would.
        unsafe {
            let within = with(ctx, CallKind::Local, |_| {
                assert_eq!(icoray_scene_text(ctx, c"".as_ptr()), ICORAY_ERR_BUSY);
                Ok(())
            });
            assert_eq!(within, ICORAY_OK);
            assert!(message(ctx).contains("has not returned"), "{}", message(ctx));
            let shared = &*ctx;
            std::thread::scope(|other| {
                let message = other.spawn(|| shared.message()).join();
                assert_eq!(message.unwrap(), "", "the context itself has not failed");
            });
        }
        closed(ctx);
    }
}
