//! Exported: opening, closing, and what went wrong.

use crate::borrow::{sized, text};
use crate::boundary::{Failure, guarded, last_message, refused_by, status};
use crate::context::Context;
use crate::handle::icoray_ctx;
use crate::types::{icoray_config, icoray_status};
use std::ffi::c_char;
use std::ptr;

/// The library's version, "major.minor.patch"; never NULL, never freed.
#[unsafe(no_mangle)]
pub extern "C" fn icoray_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// Opens a context without MPI. On failure *ctx is NULL and icoray_last_error(NULL, ...) has the message.
///
/// # Safety
/// `config` is NULL or a filled-in icoray_config; `ctx` is NULL or points to a pointer that can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_open_serial(
    config: *const icoray_config,
    ctx: *mut *mut icoray_ctx,
) -> icoray_status {
    status(&guarded(|| {
        if ctx.is_null() {
            return Err(Failure::null("ctx"));
        }
        // SAFETY: not NULL; the caller promises that it can be written.
        unsafe { ctx.write(ptr::null_mut()) };
        // SAFETY: passed on.
        let config = unsafe { sized(config)? };
        let output_dir = if config.output_dir.is_null() {
            ""
        } else {
            // SAFETY: passed on.
            unsafe { text(config.output_dir, "icoray_config.output_dir")? }
        };
        let context = Context::new(config, output_dir)?;
        // The new context may lie where a closed one did.
        refused_by(0);
        // SAFETY: as above.
        unsafe { ctx.write(Box::into_raw(Box::new(icoray_ctx::new(context)))) };
        Ok(())
    }))
}

/// Copies the last failed call's message into buf, cut to len - 1 bytes and ended by NUL: that of the context, or of this
/// thread's last failed call where the context did not let that in (ICORAY_ERR_BUSY, ICORAY_ERR_FORKED). With ctx NULL: that
/// of this thread's last failed call, of any context or none. May be called while a call on the context is under way.
///
/// # Safety
/// `ctx` is NULL or open; `buf` is NULL or has room for `len` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_last_error(
    ctx: *const icoray_ctx,
    buf: *mut c_char,
    len: usize,
) -> icoray_status {
    if buf.is_null() {
        return icoray_status::ICORAY_ERR_NULL;
    }
    // Not even the NUL would fit.
    if len == 0 {
        return icoray_status::ICORAY_ERR_ARGUMENT;
    }
    // SAFETY: the caller promises NULL or an open context.
    let message = unsafe { ctx.as_ref() }.map_or_else(last_message, icoray_ctx::message);
    let cut = message.floor_char_boundary(len - 1);
    // SAFETY: cut + 1 <= len bytes fit; the message is ours and does not overlap.
    unsafe {
        ptr::copy_nonoverlapping(message.as_ptr(), buf.cast(), cut);
        buf.add(cut).write(0);
    }
    icoray_status::ICORAY_OK
}

/// Finishes what icoray_execute has begun, closes the context, sets *ctx to NULL and gives every borrowed array back; a
/// NULL *ctx is fine. A status other than ICORAY_OK and ICORAY_ERR_BUSY, with its message in icoray_last_error(NULL,
/// ...), is that of a frame that failed and that no call has told of; the context is closed all the same. After a fork
/// the child's copy is let go without a word.
///
/// # Safety
/// `ctx` is NULL or points to NULL or to an open context that no other thread uses afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_close(ctx: *mut *mut icoray_ctx) -> icoray_status {
    let mut refused = 0;
    let outcome = guarded(|| {
        if ctx.is_null() {
            return Err(Failure::null("ctx"));
        }
        // SAFETY: not NULL; the caller promises a pointer there.
        let open = unsafe { ctx.read() };
        // SAFETY: NULL or an open context.
        let Some(handle) = (unsafe { open.as_ref() }) else {
            return Ok(());
        };
        if handle.is_forked() {
            // Its threads are not here, and waiting for them would never end.
            // SAFETY: as above.
            unsafe { ctx.write(ptr::null_mut()) };
            return Ok(());
        }
        let outcome = match handle.enter() {
            // Closed all the same, so a panic goes no further than this; the log hears of a failure as of any other.
            Ok(mut context) => handle.run(&mut context, Context::finish),
            Err(busy) => {
                refused = open.addr();
                return Err(busy);
            }
        };
        // SAFETY: as above.
        unsafe { ctx.write(ptr::null_mut()) };
        // SAFETY: it came out of Box::into_raw in icoray_open_serial, and *ctx no longer has it.
        drop(unsafe { Box::from_raw(open) });
        outcome
    });
    if refused != 0 {
        refused_by(refused);
    }
    status(&outcome)
}
