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

/// Whether icoray_execute may draw a picture of this step: *wants becomes 1 or 0. For a model to ask before it computes a
/// costly diagnostic. Takes no time and reads no field: where it is a view's turn and the view has a condition (`when`) the
/// answer is 1, and icoray_execute draws it or not. Times of a scene (`at_times`) are reached by the first step that
/// icoray_execute is called for at them or later. Not collective; between two calls of icoray_execute or icoray_wait the answer is the same on
/// all ranks that have the same scene.
///
/// # Safety
/// `ctx` is open; `wants` is NULL or can be written.
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

/// As icoray_wants, for one field: *wants becomes 1 where icoray_execute may read the field `name` at this step, for a
/// picture or for a condition on it.
///
/// # Safety
/// `ctx` is open; `name` is NULL or a string; `wants` is NULL or can be written.
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

/// Renders the scene from the fields as they are now; a thread writes the picture, the map of its errors where the scene
/// names one (output.error), and a line of report.csv. Of a scene of several views ([[views]]) it draws all pictures that are
/// due, one after the other, each under its own name: those whose turn it is (`every`, `at_steps`, `at_times`; a scene without
/// any is drawn at each step) and whose conditions hold (`when`: a field that several of them read is read once). It is called
/// for each step, or at least for those that icoray_wants says 1 of; others are left out.
/// iso_datetime ("YYYY-MM-DD_hh:mm:ss" or with a T between) may be NULL unless an output name of the scene has a date.
///
/// Where one of several pictures fails the others are drawn all the same: the status and message are the first failure's,
/// with step and view, and the log has all of them.
///
/// A picture that could not be written, which shows after the call, is told by the next call of icoray_execute (which has
/// drawn its own frame all the same), icoray_wait or icoray_close. One of the two comes before the program ends: frames
/// that are not on disk by then are lost.
///
/// Collective over the communicator of icoray_open, for each step, drawn or not: ranks tell each other that they are ready
/// (a few bytes), each draws its tiles or its part of the grid, and the picture is at rank 0, whose context writes it, with
/// what is kept of a series of pictures. Conditions are on the values of all ranks, each once, and decided alike on all. Of
/// columns that are spread over ranks the fields are put together once for each picture. What fails on one rank is the
/// status of all, with that rank's number in the message; ranks with different steps, scenes or fields are
/// ICORAY_ERR_MPI.
///
/// # Safety
/// `ctx` is open; all borrowed tables and arrays are alive and unchanged until the call returns; `iso_datetime` is NULL
/// or a string.
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

/// Waits until all frames are on disk. Where any failed since a call last told of one, the status and message are the first
/// one's; the log has all of them. Collective over the communicator of icoray_open.
///
/// # Safety
/// `ctx` is open.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_wait(ctx: *mut icoray_ctx) -> icoray_status {
    // SAFETY: passed on.
    unsafe { with_all(ctx, |context| context.wait()) }
}

/// What the last frame cost and how exact it is, or the frames of the last call that drew any. report->struct_size is set before the call. Of this rank alone, not
/// collective.
///
/// # Safety
/// `ctx` is open; `report` is NULL or points to an icoray_frame_report that can be written.
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
