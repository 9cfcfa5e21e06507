//! Exported: queries of the steps to draw, drawing, and the report of a frame.

use crate::borrow::{argument, check_struct, text};
use crate::boundary::{Failure, Outcome};
use crate::context::Context;
use crate::handle::CallKind::{Answer, Collective, Local};
use crate::handle::{icoray_ctx, with};
use crate::types::{icoray_frame_report, icoray_status};
use icoray_core::output::Stamp;
use std::ffi::c_char;

fn finite(time_s: f64) -> Outcome<()> {
    if time_s.is_finite() { Ok(()) } else { Err(argument(format!("time_s: {time_s}, expected a finite number"))) }
}

/// The stamp of a step; a blank date is none.
pub(crate) fn stamp(step: i64, time_s: f64, date: Option<&str>) -> Outcome<Stamp> {
    finite(time_s)?;
    let date = date.map(str::trim).filter(|date| !date.is_empty()).map(str::to_owned);
    Ok(Stamp { step, time_s, date })
}

/// Sets *wants to 1 if icoray_execute may draw a picture at this step, else to 0, so that a model can skip a costly
/// diagnostic. It reads no field: for a view that is due and has a condition (`when`) the answer is 1, and
/// icoray_execute decides. A time of a scene (`at_times`) is due at the first icoray_execute at or after that time.
///
/// The call is local and without communication. On all ranks of icoray_open that give the same step and time_s the
/// answer is the same, also after calls that failed on some of them: it depends only on the arguments and on state that
/// collective calls change (the scene, the last icoray_execute, whether the context is switched off). All ranks
/// therefore reach or skip `if (wants) icoray_execute` together. With a time_s that is not finite (ICORAY_ERR_ARGUMENT)
/// *wants is the answer for the step alone; after other failures it is 0.
///
/// # Safety
/// `ctx` is open; `wants` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_wants(ctx: *mut icoray_ctx, step: i64, time_s: f64, wants: *mut i32) -> icoray_status {
    // SAFETY: passed on; a NULL name stands for any field.
    unsafe { answer(ctx, None, step, time_s, wants) }
}

/// Sets *wants to 1 if icoray_execute may read the field `name` at this step, for a picture or for a condition, else
/// to 0: to compute that field only where it is needed. Whether icoray_execute is called is decided by icoray_wants.
/// Where viewers of a page ([live]) have chosen other fields, these are wanted before a picture shows them.
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
    unsafe { answer(ctx, Some(name), step, time_s, wants) }
}

/// Sets `wants` to whether a field, or any, may be read at this step. Fails for a time that is not finite.
pub(crate) fn wanted(
    context: &mut Context,
    field: Option<&str>,
    step: i64,
    time_s: f64,
    wants: &mut bool,
) -> Outcome<()> {
    let is_time = finite(time_s);
    // No time of a scene is reached by NaN, so that the step decides.
    let time_s = if is_time.is_ok() { time_s } else { f64::NAN };
    *wants = context.wants(field, &Stamp { step, time_s, date: None });
    is_time
}

/// Writes the answer of [`wanted`]; `name` is that of the field, if one is asked for.
///
/// # Safety
/// As icoray_wants_field.
unsafe fn answer(
    ctx: *mut icoray_ctx,
    name: Option<*const c_char>,
    step: i64,
    time_s: f64,
    wants: *mut i32,
) -> icoray_status {
    // SAFETY: NULL or can be written.
    let mut wants = unsafe { wants.as_mut() };
    let mut is_wanted = false;
    // SAFETY: passed on.
    let status = unsafe {
        with(ctx, Answer, |context| {
            // SAFETY: passed on.
            let name = name.map(|name| text(name, "name")).transpose()?;
            let answered = wanted(context, name, step, time_s, &mut is_wanted);
            if wants.is_none() { Err(Failure::null("wants")) } else { answered }
        })
    };
    if let Some(wants) = &mut wants {
        **wants = is_wanted.into();
    }
    status
}

/// Renders all pictures that are due at this step from the fields as they are now. A thread then writes each picture,
/// its map of errors if the scene has one (output.error), and a line of report.csv. A model calls this at each step,
/// or at least at those for which icoray_wants answers 1.
///
/// - `step`: the model's step; views with `every` or `at_steps` refer to it.
/// - `time_s`: model time in seconds; views with `at_times` refer to it.
/// - `iso_datetime`: "YYYY-MM-DD_hh:mm:ss", or with a T in between; may be NULL or blank unless an output name of the
///   scene contains a date. With a date, pictures for which the scene has no output.file are named by date and step
///   ("theta_2026-11-21_06.00.00_000042.png"), so that a restarted run, whose steps may begin again, draws new files.
///   A date of another form counts as none there.
///
/// A scene with several [[views]] draws those whose trigger (`every`, `at_steps`, `at_times`; without any, each step)
/// and conditions (`when`) hold. If one of several pictures fails, the others are drawn nevertheless; status and
/// message are those of the first failure, with step and view, and the log has all of them.
///
/// A picture that could not be written is reported by the next call of icoray_execute (which has rendered its own
/// frame nevertheless), icoray_wait or icoray_close. Call icoray_wait or icoray_close before the program ends: frames
/// that are not on disk by then are lost.
///
/// Collective over the communicator of icoray_open, at each step for which it is called, drawn or not: ranks exchange
/// some hundred bytes, and each renders its tiles or its part of the grid. Rank 0 gathers and writes the picture.
/// Conditions use the values of all ranks. A failure on one rank is the status of all ranks, with that rank's number in
/// the message; ranks with different steps or fields get ICORAY_ERR_MPI.
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
        with(ctx, Collective, |context| {
            let date = if iso_datetime.is_null() { Ok(None) } else { text(iso_datetime, "iso_datetime").map(Some) };
            context.execute(date.and_then(|date| stamp(step, time_s, date)))
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
    unsafe { with(ctx, Collective, |context| context.wait()) }
}

/// Fills *report with cost and error of the last rendered frame. The caller sets report->struct_size before the call.
/// The call is local and reports on this rank.
///
/// # Safety
/// `ctx` is open; `report` is NULL or points to a writable icoray_frame_report.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_report(ctx: *mut icoray_ctx, report: *mut icoray_frame_report) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, Local, |context| {
            check_struct(report.cast_const())?;
            report.write(context.drawing.report()?);
            Ok(())
        })
    }
}
