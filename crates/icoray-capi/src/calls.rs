//! The exported functions.
#![expect(non_camel_case_types, reason = "the names are C's")]

use crate::borrow::{self, Versioned, check_size, sized, text};
use crate::boundary::{Failure, Outcome, guarded, last_message, status};
use crate::context::Context;
use crate::types::{
    icoray_array, icoray_config, icoray_frame_report, icoray_grid, icoray_layers, icoray_status,
};
use icoray_core::output::Stamp;
use std::ffi::c_char;
use std::ptr;

/// An open context.
pub struct icoray_ctx(Context);

macro_rules! versioned {
    ($($name:ident),*) => {$(
        impl Versioned for $name {
            const NAME: &'static str = stringify!($name);
        }
    )*};
}
versioned!(icoray_config, icoray_grid, icoray_layers, icoray_array, icoray_frame_report);

/// Runs a call on a context: refuses NULL and a poisoned one, keeps the message, poisons on a bug of our own.
///
/// # Safety
/// `ctx` is NULL or comes from icoray_open_serial, is open, and no other thread uses it now.
unsafe fn with(ctx: *mut icoray_ctx, call: impl FnOnce(&mut Context) -> Outcome<()>) -> icoray_status {
    // SAFETY: the caller promises an open context of its own.
    let Some(icoray_ctx(context)) = (unsafe { ctx.as_mut() }) else {
        return status(&guarded(|| Err(Failure::null("ctx"))));
    };
    let outcome = guarded(|| {
        if context.poisoned {
            let message = format!("the context failed before and takes no more calls ({})", context.message);
            return Err(Failure::new(icoray_status::ICORAY_ERR_INTERNAL, message));
        }
        call(context)
    });
    if let Err(failure) = &outcome
        && !context.poisoned
    {
        context.message.clone_from(&failure.message);
        context.poisoned = failure.status == icoray_status::ICORAY_ERR_INTERNAL;
    }
    status(&outcome)
}

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
            None
        } else {
            // SAFETY: passed on.
            Some(unsafe { text(config.output_dir, "icoray_config.output_dir")? })
        };
        let context = Context::new(config.threads, output_dir)?;
        // SAFETY: as above.
        unsafe { ctx.write(Box::into_raw(Box::new(icoray_ctx(context)))) };
        Ok(())
    }))
}

/// Hands over the grid's tables, which are checked whole; they are borrowed until icoray_close or the next
/// icoray_grid_set. On failure the grid before, if any, stays.
///
/// # Safety
/// `ctx` is open; `grid` is NULL or filled in as the header says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_grid_set(ctx: *mut icoray_ctx, grid: *const icoray_grid) -> icoray_status {
    // SAFETY: passed on.
    unsafe { with(ctx, |context| context.set_grid(borrow::tables(sized(grid)?)?)) }
}

/// Hands over the layers' radii, which are copied.
///
/// # Safety
/// `ctx` is open; `layers` is NULL or filled in as the header says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_layers_set(
    ctx: *mut icoray_ctx,
    layers: *const icoray_layers,
) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, |context| {
            let layers = sized(layers)?;
            context.set_layers(borrow::radii(layers.radius_m, layers.count)?, layers.planet_radius_m)
        })
    }
}

/// Hands over a field under a name that scenes use; a field of that name before is replaced. The array is not read
/// now but at each icoray_execute that needs it, so it can be handed over once and change from step to step.
///
/// # Safety
/// `ctx` is open; `name` is NULL or a string; `array` is NULL or filled in as the header says, and its data live until
/// the field is replaced or the context closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_field_set(
    ctx: *mut icoray_ctx,
    name: *const c_char,
    array: *const icoray_array,
) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, |context| {
            let (name, array) = (text(name, "name")?, sized(array)?);
            borrow::field(array)
                .map_err(|f| Failure::new(f.status, format!("field {name:?}: {}", f.message)))?;
            context.set_field(name, array);
            Ok(())
        })
    }
}

/// Reads the scene from a TOML file. On failure the scene before, if any, stays.
///
/// # Safety
/// `ctx` is open; `path` is NULL or a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_scene_load(ctx: *mut icoray_ctx, path: *const c_char) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, |context| {
            let path = text(path, "path")?;
            let unread =
                |e| Failure::new(icoray_status::ICORAY_ERR_IO, format!("{path}: cannot read the scene: {e}"));
            let scene = std::fs::read_to_string(path).map_err(unread)?;
            context.set_scene(&scene).map_err(|f| Failure::new(f.status, format!("{path}: {}", f.message)))
        })
    }
}

/// Reads the scene from TOML text.
///
/// # Safety
/// `ctx` is open; `toml` is NULL or a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_scene_text(ctx: *mut icoray_ctx, toml: *const c_char) -> icoray_status {
    // SAFETY: passed on.
    unsafe { with(ctx, |context| context.set_scene(text(toml, "toml")?)) }
}

/// Renders the scene from the fields as they are now and writes the picture, the map of its errors where the scene names
/// one (output.error), and a line of report.csv. iso_datetime ("YYYY-MM-DD_hh:mm:ss" or with a T between) may be NULL
/// unless an output name of the scene has a date.
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
        with(ctx, |context| {
            let date = if iso_datetime.is_null() {
                None
            } else {
                Some(text(iso_datetime, "iso_datetime")?.to_string())
            };
            if !time_s.is_finite() {
                let message = format!("time_s: {time_s}, expected a finite number");
                return Err(Failure::new(icoray_status::ICORAY_ERR_ARGUMENT, message));
            }
            context.execute(&Stamp { step, time_s, date }, |array| borrow::field(array))
        })
    }
}

/// What the last frame cost and how exact it is. report->struct_size is set before the call.
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
            if report.is_null() {
                return Err(Failure::null("report"));
            }
            check_size::<icoray_frame_report>(report.cast::<usize>().read())?;
            report.write(context.report()?);
            Ok(())
        })
    }
}

/// Copies the last failed call's message into buf, cut to len - 1 bytes and ended by NUL. With ctx NULL: that of this
/// thread's last failed call, of any context or none.
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
    let message = unsafe { ctx.as_ref() }.map_or_else(last_message, |c| c.0.message.clone());
    let cut = message.floor_char_boundary(len - 1);
    // SAFETY: cut + 1 <= len bytes fit; the message is ours and does not overlap.
    unsafe {
        ptr::copy_nonoverlapping(message.as_ptr(), buf.cast(), cut);
        buf.add(cut).write(0);
    }
    icoray_status::ICORAY_OK
}

/// Closes the context, sets *ctx to NULL and gives every borrowed array back; a NULL *ctx is fine.
///
/// # Safety
/// `ctx` is NULL or points to NULL or to an open context that no other thread uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_close(ctx: *mut *mut icoray_ctx) -> icoray_status {
    status(&guarded(|| {
        if ctx.is_null() {
            return Err(Failure::null("ctx"));
        }
        // SAFETY: not NULL; the caller promises a pointer there.
        let owned = unsafe { ctx.replace(ptr::null_mut()) };
        if !owned.is_null() {
            // SAFETY: it came out of Box::into_raw in icoray_open_serial, and *ctx no longer has it.
            drop(unsafe { Box::from_raw(owned) });
        }
        Ok(())
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::CStr;

    fn message(ctx: *const icoray_ctx) -> String {
        let mut buf = [0; 256];
        // SAFETY: NULL or open, and a buffer of the length given.
        let status = unsafe { icoray_last_error(ctx, buf.as_mut_ptr(), buf.len()) };
        assert_eq!(status, icoray_status::ICORAY_OK);
        // SAFETY: icoray_last_error ends it with NUL.
        unsafe { CStr::from_ptr(buf.as_ptr()) }.to_str().unwrap().to_string()
    }

    #[test]
    fn a_context_that_failed_inside_takes_no_more_calls() {
        use icoray_status::*;
        crate::boundary::tests::loud();
        let config =
            icoray_config { struct_size: size_of::<icoray_config>(), output_dir: ptr::null(), threads: 1 };
        let mut ctx = ptr::null_mut();
        let mut other = ptr::null_mut();
        let mut report =
            icoray_frame_report { struct_size: size_of::<icoray_frame_report>(), ..Default::default() };
        // SAFETY: every pointer is NULL, where that is refused, or to a live local; the contexts are open until closed.
        unsafe {
            assert_eq!(icoray_open_serial(&config, &mut ctx), ICORAY_OK);
            assert_eq!(icoray_open_serial(&config, &mut other), ICORAY_OK);
            let internal = || Err(Failure::new(ICORAY_ERR_INTERNAL, "internal error: a broken promise"));
            assert_eq!(with(ctx, |_| internal()), ICORAY_ERR_INTERNAL);
            assert_eq!(message(ctx), "internal error: a broken promise");

            assert_eq!(with(ctx, |_| Ok(())), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_grid_set(ctx, ptr::null()), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_layers_set(ctx, ptr::null()), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_field_set(ctx, ptr::null(), ptr::null()), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_scene_load(ctx, ptr::null()), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_scene_text(ctx, ptr::null()), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_execute(ctx, 0, 0.0, ptr::null()), ICORAY_ERR_INTERNAL);
            assert_eq!(icoray_report(ctx, &mut report), ICORAY_ERR_INTERNAL);
            assert_eq!(
                message(ctx),
                "internal error: a broken promise",
                "the first failure is the one to know"
            );
            assert!(message(ptr::null()).contains("takes no more calls"));

            assert_eq!(icoray_scene_text(other, ptr::null()), ICORAY_ERR_NULL, "another context goes on");
            assert_eq!(icoray_close(&mut ctx), ICORAY_OK);
            assert!(ctx.is_null());
            assert_eq!(icoray_close(&mut other), ICORAY_OK);
        }
    }
}
