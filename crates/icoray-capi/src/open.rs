//! Exported: opening and closing of contexts, and the last error.

use crate::borrow::{name, sized};
use crate::boundary::{Failure, Outcome, caught, guarded, last_message, refused_by, status};
use crate::context::Context;
use crate::handle::{CallKind, icoray_ctx};
use crate::message::floor_char_boundary;
use crate::ranks;
use crate::types::{icoray_config, icoray_status};
use icoray_core::{Ranks, Team};
use std::ffi::c_char;
use std::ptr;

/// Returns the library's version, "major.minor.patch": a string that is never NULL and never freed.
#[unsafe(no_mangle)]
pub extern "C" fn icoray_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// Opens a context for one process, without MPI, and stores it in *ctx; icoray_close closes it. On failure *ctx is
/// NULL, and icoray_last_error(NULL, ...) returns the message. ICORAY_ERR_IO if pictures could not be written in
/// output_dir, or if it is missing and could not be created.
///
/// In a job of several MPI ranks each process with such a context draws pictures of its own; rank 0 logs a warning,
/// once.
///
/// # Safety
/// `config` is NULL or points to an initialised icoray_config; `ctx` is NULL or points to a writable pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_open_serial(config: *const icoray_config, ctx: *mut *mut icoray_ctx) -> icoray_status {
    status(&guarded(|| {
        // SAFETY: passed on; `ctx` can be written where it was cleared.
        unsafe {
            cleared(ctx)?;
            ctx.write(Box::into_raw(opened_alone(config)?));
        }
        Ok(())
    }))
}

/// Opens a context over the ranks of an MPI communicator, which render each picture together. The picture is written
/// at rank 0, to the output_dir of rank 0's config. Either every rank has the whole grid and field, or each has its
/// part of both, or each has the whole grid and some columns of the field; the latter two are declared by
/// icoray_part_set.
///
/// fortran_comm is MPI_Comm_c2f(comm). It is duplicated, and the duplicate is freed by icoray_close. The model
/// initialises MPI before, at any thread level, and finalises it after icoray_close.
///
/// icoray_open, icoray_part_set, icoray_scene_load, icoray_scene_text, icoray_execute, icoray_wait and icoray_close are
/// collective: all ranks call them in the same order, also after failed calls, and get the same status. All other calls
/// are local, and their failures differ from rank to rank: the next icoray_execute that needs a refused input has the
/// status on all ranks. icoray_wants is local with the same answer on all ranks. MPI is called only inside collective
/// calls, on their thread, and with async_render in every call on the thread that opened the context.
///
/// With async_render (the same on all ranks) icoray_execute copies the fields and returns; a thread of each rank
/// renders. MPI is called on the model's thread: each call on the context transfers the messages of the threads, for
/// half a millisecond at most, and never blocks. Only icoray_wait, icoray_close, and an icoray_execute that draws while
/// the previous frame is not finished wait until that frame is finished on all ranks.
///
/// Ranks of a node share memory for data that all of them need. The environment variable ICORAY_NODE_RANKS limits how
/// many ranks share it; with 1, none do.
///
/// On failure *ctx is NULL, and icoray_last_error(NULL, ...) returns the message: ICORAY_ERR_UNSUPPORTED if the
/// library was built without MPI or for another MPI, ICORAY_ERR_MPI if MPI is not initialised or fails, ICORAY_ERR_IO
/// if rank 0 could not write pictures in its output_dir.
///
/// # Safety
/// `config` is NULL or points to an initialised icoray_config; `ctx` is NULL or points to a writable pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_open(
    config: *const icoray_config,
    fortran_comm: i32,
    ctx: *mut *mut icoray_ctx,
) -> icoray_status {
    status(&guarded(|| {
        // SAFETY: passed on; `ctx` can be written, as all ranks have agreed.
        unsafe { ctx.write(Box::into_raw(opened(config, || ranks::of_communicator(fortran_comm), cleared(ctx))?)) };
        Ok(())
    }))
}

impl icoray_ctx {
    /// Opens a context over the ranks of a `team` that a binding has made, which is collective, or for one process.
    ///
    /// # Errors
    /// As icoray_open and icoray_open_serial.
    ///
    /// # Safety
    /// The strings of `config` live until the call returns; its log callback may be called with its log_user.
    pub unsafe fn open(config: &icoray_config, team: Option<Team>) -> Result<Box<Self>, Failure> {
        // SAFETY: passed on.
        guarded(|| unsafe {
            match team {
                Some(team) => opened(config, || Ok(Ranks::new(team)), Ok(())),
                None => opened_alone(config),
            }
        })
    }

    /// Closes the context as icoray_close does. No other call may follow, unless this one fails as another call has not
    /// returned yet. It must not be dropped in a forked process, where its threads are not.
    ///
    /// # Errors
    /// As icoray_close.
    pub fn close(&self) -> Result<(), Failure> {
        // Waiting for threads that are not here would never end.
        if self.is_forked() { Ok(()) } else { self.call(CallKind::Close, Context::finish) }
    }
}

/// Opens a context for one process.
///
/// # Safety
/// As icoray_open_serial.
unsafe fn opened_alone(config: *const icoray_config) -> Outcome<Box<icoray_ctx>> {
    let mut alone = Ranks::alone();
    let threads = ranks::share_of_processors(&mut alone)?;
    // SAFETY: passed on.
    let context = unsafe { configured(config, &alone, threads)? };
    ranks::warn_of_ranks(|message| context.drawing.warn(message));
    Ok(Box::new(icoray_ctx::new(context)))
}

/// Opens a context over ranks; `may_open` is the failure of this rank so far. Collective.
///
/// # Safety
/// As icoray_open.
unsafe fn opened(
    config: *const icoray_config,
    ranks: impl FnOnce() -> Outcome<Ranks>,
    may_open: Outcome<()>,
) -> Outcome<Box<icoray_ctx>> {
    let mut ranks = ranks()?;
    let threads = ranks::share_of_processors(&mut ranks);
    // The agreement sends a failure of this rank to the others.
    // SAFETY: passed on.
    let mine = caught(|| may_open.and_then(|()| unsafe { configured(config, &ranks, threads?) }));
    // Facts are not compared if this rank fails.
    let facts = mine.as_ref().map_or_else(|_| Vec::new(), Context::facts);
    let mut context = ranks::agree(&mut ranks, mine, "icoray_open", facts, &()).outcome?;
    context.join(ranks)?;
    Ok(Box::new(icoray_ctx::new(context)))
}

/// Sets *ctx to NULL.
///
/// # Safety
/// `ctx` is NULL or can be written.
unsafe fn cleared(ctx: *mut *mut icoray_ctx) -> Outcome<()> {
    if ctx.is_null() {
        return Err(Failure::null("ctx"));
    }
    // The new context may lie where a closed one did.
    refused_by(0);
    // SAFETY: not NULL; the caller promises that it can be written.
    unsafe { ctx.write(ptr::null_mut()) };
    Ok(())
}

/// # Safety
/// `config` is NULL or a filled-in icoray_config.
unsafe fn configured(config: *const icoray_config, ranks: &Ranks, threads: usize) -> Outcome<Context> {
    // SAFETY: passed on.
    let config = unsafe { sized(config)? };
    // SAFETY: passed on.
    let output_dir = unsafe { name(config.output_dir, "icoray_config.output_dir")? };
    Context::new(config, output_dir, ranks, threads)
}

/// Copies the message of the last failed call on the context into buf, truncated to len - 1 bytes and terminated by
/// NUL. Messages and lines of the log have at most 400 bytes: long names, paths and lists are shortened. If that call
/// was refused before it entered the context (ICORAY_ERR_BUSY, ICORAY_ERR_FORKED), or if ctx is NULL, it copies the
/// message of this thread's last failed call. It may be called while another call on the context is in progress.
///
/// # Safety
/// `ctx` is NULL or open; `buf` is NULL or has room for `len` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_last_error(ctx: *const icoray_ctx, buf: *mut c_char, len: usize) -> icoray_status {
    if buf.is_null() {
        return icoray_status::ICORAY_ERR_NULL;
    }
    // Not even the NUL would fit.
    if len == 0 {
        return icoray_status::ICORAY_ERR_ARGUMENT;
    }
    // SAFETY: the caller promises NULL or an open context.
    let message = unsafe { ctx.as_ref() }.map_or_else(last_message, icoray_ctx::message);
    let cut = floor_char_boundary(&message, len - 1);
    // SAFETY: cut + 1 <= len bytes fit; the message is ours and does not overlap.
    unsafe {
        ptr::copy_nonoverlapping(message.as_ptr(), buf.cast(), cut);
        buf.add(cut).write(0);
    }
    icoray_status::ICORAY_OK
}

/// Waits for all frames, closes the context, sets *ctx to NULL, and ends the borrow of all tables and arrays. A NULL
/// *ctx is allowed. In a forked child process it only discards the child's copy.
///
/// A status other than ICORAY_OK and ICORAY_ERR_BUSY is that of a frame that failed and that no call has returned
/// yet, with its message in icoray_last_error(NULL, ...); the context is closed all the same.
///
/// Collective over the communicator of icoray_open. If some ranks call icoray_close while others are in another
/// collective call, all get ICORAY_ERR_MPI, and the others can only close, each by itself. After MPI_Finalize the
/// call is local and does not call MPI.
///
/// # Safety
/// `ctx` is NULL, or points to NULL or to an open context that no other thread uses from now on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_close(ctx: *mut *mut icoray_ctx) -> icoray_status {
    if ctx.is_null() {
        return status(&guarded::<()>(|| Err(Failure::null("ctx"))));
    }
    // SAFETY: not NULL; the caller promises a pointer there.
    let open = unsafe { ctx.read() };
    // SAFETY: NULL or an open context.
    let Some(handle) = (unsafe { open.as_ref() }) else { return icoray_status::ICORAY_OK };
    let status = status(&handle.close());
    if status == icoray_status::ICORAY_ERR_BUSY {
        return status;
    }
    // SAFETY: as above.
    unsafe { ctx.write(ptr::null_mut()) };
    if !handle.is_forked() {
        // SAFETY: it came out of Box::into_raw in icoray_open or icoray_open_serial, and *ctx no longer has it.
        let owned = unsafe { Box::from_raw(open) };
        // A panic goes no further than this.
        let _ = guarded(move || {
            drop(owned);
            Ok(())
        });
    }
    status
}
