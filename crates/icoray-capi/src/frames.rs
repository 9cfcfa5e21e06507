//! Exported: whether a step is drawn, drawing it, and what that cost.

use crate::borrow::{argument, check_struct, text};
use crate::boundary::{Failure, Outcome};
use crate::handle::{icoray_ctx, with, with_all};
use crate::types::{icoray_frame_report, icoray_status};
use icoray_core::output::Stamp;
use std::ffi::c_char;

fn finite(time_s: f64) -> Outcome<()> {
    if time_s.is_finite() {
        Ok(())
    } else {
        Err(argument(format!("time_s: {time_s}, expected a finite number")))
    }
}

/// Sets *wants to 1 if icoray_execute may draw a picture at this step, else to 0, so that a model can skip a costly
/// diagnostic. It reads no field: for a view that is due and has a condition (`when`) the answer is 1, and
/// icoray_execute decides. A time of a scene (`at_times`) is due at the first icoray_execute at or after that time.
/// The call is local; between two calls of icoray_execute or icoray_wait the answer is the same on all ranks that
/// have the same scene.
///
/// # Safety
/// `ctx` is open; `wants` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_wants(
    ctx: *mut icoray_ctx,
    step: i64,
    time_s: f64,
    wants: *mut i32,
) -> icoray_status {
    // SAFETY: passed on; a NULL name stands for any field.
    unsafe { wanted(ctx, None, step, time_s, wants) }
}

/// Sets *wants to 1 if icoray_execute may read the field `name` at this step, for a picture or for a condition, else
/// to 0.
///
/// # Safety
/// `ctx` is open; `name` is NULL or a string; `wants` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_wants_field(
    ctx: *mut icoray_ctx,
    name: *const c_char,
    step: i64,
    time_s: f64,
    wants: *mut i32,
) -> icoray_status {
    // SAFETY: passed on.
    unsafe { wanted(ctx, Some(name), step, time_s, wants) }
}

/// # Safety
/// As icoray_wants_field.
unsafe fn wanted(
    ctx: *mut icoray_ctx,
    name: Option<*const c_char>,
    step: i64,
    time_s: f64,
    wants: *mut i32,
) -> icoray_status {
    // SAFETY: NULL or can be written; a model that does not look at the status computes nothing.
    if let Some(wants) = unsafe { wants.as_mut() } {
        *wants = 0;
    }
    // SAFETY: passed on.
    unsafe {
        with(ctx, |context| {
            // SAFETY: passed on.
            let name = name.map(|name| text(name, "name")).transpose()?;
            finite(time_s)?;
            // SAFETY: as above.
            let wants = wants.as_mut().ok_or_else(|| Failure::null("wants"))?;
            *wants = context.wants(name, &Stamp { step, time_s, date: None }).into();
            Ok(())
        })
    }
}

/// Renders all pictures that are due at this step from the fields as they are now. A thread then writes each picture,
/// its map of errors if the scene has one (output.error), and a line of report.csv. A model calls this at each step,
/// or at least at those for which icoray_wants answers 1.
///
/// - `step`: the model's step; views with `every` or `at_steps` refer to it.
/// - `time_s`: model time in seconds; views with `at_times` refer to it.
/// - `iso_datetime`: "YYYY-MM-DD_hh:mm:ss", or with a T in between; may be NULL unless an output name of the scene
///   contains a date.
///
/// A scene with several [[views]] draws those whose trigger (`every`, `at_steps`, `at_times`; without any, each step)
/// and conditions (`when`) hold. If one of several pictures fails, the others are drawn nevertheless; status and
/// message are those of the first failure, with step and view, and the log has all of them.
///
/// A picture that could not be written is reported by the next call of icoray_execute (which has rendered its own
/// frame nevertheless), icoray_wait or icoray_close. Call icoray_wait or icoray_close before the program ends: frames
/// that are not on disk by then are lost.
///
/// Collective over the communicator of icoray_open, at each step, drawn or not: ranks exchange some hundred bytes,
/// and each renders its tiles or its part of the grid. Rank 0 gathers and writes the picture. Conditions use the
/// values of all ranks. A failure on one rank is the status of all ranks, with that rank's number in the message;
/// ranks with different steps, scenes or fields get ICORAY_ERR_MPI.
///
/// # Safety
/// `ctx` is open; all borrowed tables and arrays are alive and unchanged until the call returns; `iso_datetime` is
/// NULL or a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_execute(
    ctx: *mut icoray_ctx,
    step: i64,
    time_s: f64,
    iso_datetime: *const c_char,
) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with_all(ctx, |context| {
            let stamp = || {
                let date = if iso_datetime.is_null() {
                    None
                } else {
                    Some(text(iso_datetime, "iso_datetime")?.to_string())
                };
                finite(time_s)?;
                Ok(Stamp { step, time_s, date })
            };
            context.execute(stamp())
        })
    }
}

/// Waits until all frames are on disk. If frames have failed since the last call that returned a failure, status and
/// message are those of the first one; the log has all of them. Collective over the communicator of icoray_open.
///
/// # Safety
/// `ctx` is open.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_wait(ctx: *mut icoray_ctx) -> icoray_status {
    // SAFETY: passed on.
    unsafe { with_all(ctx, |context| context.wait()) }
}

/// Fills *report with cost and error of the last rendered frame. The caller sets report->struct_size before the call.
/// The call is local and reports on this rank.
///
/// # Safety
/// `ctx` is open; `report` is NULL or points to a writable icoray_frame_report.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_report(
    ctx: *mut icoray_ctx,
    report: *mut icoray_frame_report,
) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, |context| {
            check_struct(report.cast_const())?;
            report.write(context.report()?);
            Ok(())
        })
    }
}
